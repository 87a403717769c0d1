//! A container that is shaken with what is in it.
use super::head::Head;
use super::{HeadSpec, Motion, Tool, Workpiece};
use crate::state::{ActionSpace, Control, Pose, ToolShape};
use anyhow::ensure;
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A shaken container: θ = (amplitude, direction).
///
/// Its middle stands on the origin and goes to `amplitude sin(2π swings t / H) (cos direction, sin direction)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShakeSpec {
    /// The container's walls, its floor at local z = 0.
    pub head: HeadSpec,
    /// Bounds of the amplitude \[m\].
    pub amplitude: [f64; 2],
    /// Bound of |direction| \[rad\].
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub direction: f64,
    /// How often it goes to and fro in the time of the action.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub swings: f64,
}

/// See [`ShakeSpec`].
#[derive(Clone, Debug)]
pub struct Shake {
    spec: ShakeSpec,
    head: Head,
}

impl ShakeSpec {
    /// The container.
    ///
    /// # Errors
    /// When a size is impossible.
    pub fn build(self) -> anyhow::Result<Shake> {
        let [low, high] = self.amplitude;
        ensure!(
            0.0 <= low && low <= high && high <= 1.0,
            "`amplitude` = [{low}, {high}] must be [low, high] with 0 ≤ low ≤ high ≤ 1 m"
        );
        ensure!(self.swings > 0.0 && self.swings <= 100.0, "`swings` is {}; it must lie in (0, 100]", self.swings);
        Ok(Shake { head: self.head.clone().alone()?, spec: self })
    }
}

impl Tool for Shake {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.head.shape
    }

    fn space(&self, _: &Workpiece) -> ActionSpace {
        let ShakeSpec { amplitude: [low, high], direction, .. } = self.spec;
        ActionSpace {
            names: vec!["amplitude".into(), "direction".into()],
            low: vec![low, -direction],
            high: vec![high, direction],
        }
    }

    fn motion(&self, theta: &[f64], _: &Workpiece, steps: usize) -> Motion {
        let &[amplitude, direction] = theta else { panic!("a shake takes two numbers, not {theta:?}") };
        let along = DVec3::new(direction.cos(), direction.sin(), 0.0);
        let pose = |step: usize| {
            let swing = (TAU * self.spec.swings * step as f64 / steps as f64).sin();
            vec![Pose { translation: amplitude * swing * along, rotation: DQuat::IDENTITY }]
        };
        Motion { start: pose(0), controls: (1..=steps).map(|step| Control { poses: pose(step) }).collect() }
    }
}
