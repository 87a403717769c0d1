//! The simulator as the model: the ceiling of planning.
use super::Dynamics;
use crate::state::{Control, Particles, Scene, Snapshot};
use crate::world::World;
use anyhow::Context;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The simulator itself; it needs nothing but a scene's snapshot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OracleSpec {}

/// Predicts by restoring the scene's snapshot and executing the controls: exact, and as dear as the simulator.
#[derive(Clone, Debug)]
pub struct Oracle;

impl OracleSpec {
    /// The model.
    ///
    /// # Errors
    /// Never.
    pub fn build(self) -> anyhow::Result<Oracle> {
        Ok(Oracle)
    }
}

fn start(scene: &Scene) -> anyhow::Result<World> {
    let snapshot = scene.snapshot.as_ref().context(
        "the oracle needs the simulator's own state, which this scene lacks: plan in a simulated world, or without the oracle",
    )?;
    World::restore(snapshot)
}

impl Dynamics for Oracle {
    type State = World;

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        start(scene).map(|_| ())
    }

    fn encode(&self, scene: &Scene) -> World {
        let mut world = start(scene).expect("an accepted scene has a sound snapshot");
        world.take(&scene.tool, &scene.poses);
        world
    }

    fn step(&self, state: &World, control: &Control) -> World {
        let mut next = state.clone();
        next.step(control);
        next
    }

    fn decode(&self, state: &World) -> Particles {
        state.particles()
    }

    fn snapshot(&self, state: &World) -> Option<Snapshot> {
        Some(state.snapshot())
    }
}
