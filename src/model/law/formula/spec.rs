//! The config of a law written as formulas.
use super::Formula;
use super::pairs::Pairs;
use super::plane::Plane;
use super::programs::Programs;
use super::touch::Touched;
use crate::model::law::Law;
use crate::model::law::compliant::positive;
use anyhow::{Context, ensure};
use glam::DVec3;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of a law in formulas: the acceleration of a particle that meets something is `N n + T v_t/|v_t|`, with
/// `N = −d(energy)/dr + normal_force` and `T = tangential_force`, all per unit mass of the particle.
///
/// | name | what it is |
/// |---|---|
/// | `r` | distance of the two centres, or of the centre from the surface, negative inside \[m\] |
/// | `overlap` | reach − r, above zero \[m\] |
/// | `vn` | separating speed v·n of the relative velocity v \[m/s\]; not in `energy` |
/// | `vt` | sliding speed of v_t = v − (v·n) n \[m/s\]; not in `energy` |
/// | `normal` | N \[m/s²\]; only in `tangential_force` |
/// | `reach` | the reach \[m\] |
///
/// and every constant, by its own name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FormulaSpec {
    /// What the law is called where its constants are named; `formula` where this is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What the particle meets.
    pub between: Between,
    /// Where the wall stands; only where the particle meets a wall.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall: Option<Wall>,
    /// Distance r at and beyond which nothing acts \[m\]: a number, or a formula of the constants.
    pub reach: Reach,
    /// Potential energy over the particle's mass \[m²/s²\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<String>,
    /// Acceleration along the normal, positive where it pushes apart \[m/s²\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_force: Option<String>,
    /// Acceleration along the sliding velocity, negative where it holds back \[m/s²\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential_force: Option<String>,
    /// Constants of the formulas, each in its own unit.
    #[serde(default)]
    pub constants: IndexMap<String, f64>,
}

/// What a particle meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Between {
    /// Another particle, which gets the opposite acceleration.
    Particles,
    /// The table z = 0.
    Floor,
    /// A plane.
    Wall,
    /// A part of the tool, by its signed distance.
    Tool,
}

/// The plane `n·x = offset`; particles are on the side that n points to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Normal n, of any length \[1\].
    pub normal: [f64; 3],
    /// Distance of the plane from the origin along n \[m\].
    pub offset: f64,
}

/// A distance as a number \[m\] or as a formula of constants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Reach {
    /// A number.
    Number(f64),
    /// A formula.
    Formula(String),
}

impl FormulaSpec {
    pub(crate) fn build(self) -> anyhow::Result<Formula> {
        let named = self.name.clone().unwrap_or_else(|| "formula".to_owned());
        let law = self.law().with_context(|| format!("the law {named:?}"))?;
        Ok(Formula(law))
    }

    fn law(self) -> anyhow::Result<Box<dyn Law>> {
        ensure!(
            (self.between == Between::Wall) == self.wall.is_some(),
            "`wall` is given exactly where `between` is \"wall\"; write wall = {{ normal = [1.0, 0.0, 0.0], offset = -0.1 }} there \
             and nowhere else"
        );
        let programs = Programs::new(&self)?;
        Ok(match (self.between, self.wall) {
            (Between::Particles, _) => Box::new(Pairs(programs)),
            (Between::Tool, _) => Box::new(Touched(programs)),
            (Between::Floor | Between::Wall, None) => Box::new(Plane::new(programs, DVec3::Z, 0.0)),
            (_, Some(Wall { normal, offset })) => {
                let normal = DVec3::from_array(normal);
                positive("formula", "the length of wall.normal", normal.length())?;
                ensure!(offset.is_finite(), "wall.offset must be finite, got {offset}");
                Box::new(Plane::new(programs, normal.normalize(), offset))
            }
        })
    }
}
