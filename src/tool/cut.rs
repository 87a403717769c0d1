//! A blade that comes down through the material to the table and lifts again.
use super::{HeadSpec, Motion, Press, PressSpec, Tool, Workpiece};
use crate::state::{ActionSpace, ToolShape};
use anyhow::ensure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A cutter: θ = (x, y, rotation), or (x, y) for one that is not turned, as RoboCook (Shi et al. 2023) parametrises it.
///
/// A press whose final height is always `lowest`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CutSpec {
    /// The blade; its edge at local −z cuts.
    pub head: HeadSpec,
    /// Bound of |x| and |y| \[m\].
    #[schemars(range(min = 0.0, max = 0.5))]
    pub reach: f64,
    /// Height at which the edge stops above the table \[m\].
    #[schemars(range(min = 0.0005, max = 0.1))]
    pub lowest: f64,
    /// Bound of |rotation| \[rad\]; with 0 the action has no rotation.
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub rotation: f64,
    /// Distance kept above the workpiece at the start and at the end \[m\].
    #[schemars(range(min = 0.001, max = 0.1))]
    pub clearance: f64,
    /// Share of the steps in which the blade comes down.
    #[schemars(range(min = 1, max = 100))]
    pub down: usize,
    /// Share of the steps in which it lifts.
    #[schemars(range(min = 1, max = 100))]
    pub lift: usize,
}

/// See [`CutSpec`].
#[derive(Clone, Debug)]
pub struct Cut {
    press: Press,
    shape: Arc<ToolShape>,
    lowest: f64,
}

/// Place of the height among a press's numbers.
const HEIGHT: usize = 2;

impl CutSpec {
    /// The cutter.
    ///
    /// # Errors
    /// When a size is impossible, or the head is no blade.
    pub fn build(self) -> anyhow::Result<Cut> {
        let Self { head, reach, lowest, rotation, clearance, down, lift } = self;
        let press = PressSpec { head, reach, lowest, rotation, clearance, down, lift }.build()?;
        let parts = press.shape().parts.clone();
        ensure!(
            parts.iter().all(|part| part.solid.blades().is_some()),
            "`head.solid` cannot cut: it must be a thin box, a tube, an assembly of thin boxes, or a mesh as thin as a knife"
        );
        Ok(Cut { press, shape: Arc::new(ToolShape { parts, cuts: true }), lowest })
    }
}

impl Tool for Cut {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.shape
    }

    fn space(&self, piece: &Workpiece) -> ActionSpace {
        let mut space = self.press.space(piece);
        space.names.remove(HEIGHT);
        space.low.remove(HEIGHT);
        space.high.remove(HEIGHT);
        space
    }

    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        assert!(theta.len() >= HEIGHT, "a cut takes two or three numbers, not {theta:?}");
        let mut pressed = theta.to_vec();
        pressed.insert(HEIGHT, self.lowest);
        self.press.motion(&pressed, piece, steps)
    }
}
