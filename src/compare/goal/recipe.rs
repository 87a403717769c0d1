//! What a given row of actions makes elsewhere.
use super::{Goal, GoalMaker, HIDDEN, Source, hidden};
use crate::metric::Matching;
use crate::state::stream;
use crate::world::{MaterialSpec, SceneSpec, World};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What several hidden actions make of another start, and perhaps of another material: no row is the particle of the same number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecipeSpec {
    /// The actions, in order.
    #[schemars(length(min = 1))]
    pub actions: Vec<ActionSpec>,
    /// What it is made of there; by default what the scene is made of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialSpec>,
    /// Added to the attempt's seed to draw the start there.
    pub seed: u64,
}

/// A hidden action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ActionSpec {
    /// Name of its tool, one of the dataset's.
    pub tool: String,
    /// θ as fractions \[0, 1\] of the tool's box, each drawn between the two numbers.
    pub action: Vec<[f64; 2]>,
}

/// See [`RecipeSpec`].
pub(crate) struct Recipe(RecipeSpec);

impl RecipeSpec {
    pub(crate) fn build(self) -> anyhow::Result<Recipe> {
        anyhow::ensure!(!self.actions.is_empty(), "goal.actions is empty; name at least one");
        Ok(Recipe(self))
    }
}

impl GoalMaker for Recipe {
    fn make(&self, source: &Source<'_>) -> anyhow::Result<Goal> {
        let RecipeSpec { actions, material, seed } = &self.0;
        let here = &source.dataset.scene;
        let scene = SceneSpec { material: material.clone().unwrap_or_else(|| here.material.clone()), ..here.clone() };
        let mut world = World::new(&scene, source.seed.wrapping_add(*seed))?;
        let mut rng = stream(source.seed, &[HIDDEN]);
        for ActionSpec { tool, action } in actions {
            hidden(tool, action, source, &mut world, &mut rng)?;
        }
        let points = world.particles().positions;
        Ok(Goal { points, matching: Matching::Unmatched, samplings: None })
    }
}
