//! A hook that comes down behind the material, pulls it, and lifts.
use super::head::Head;
use super::leg::{Leg, along};
use super::{HeadSpec, Motion, Tool, Workpiece, stroke};
use crate::state::{ActionSpace, Control, Pose, ToolShape};
use anyhow::ensure;
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A hook: θ = (r, rotation, depth).
///
/// Seen along u = (cos rotation, sin rotation) through `centre + r (−sin rotation, cos rotation)`, the hook comes down
/// `clearance` behind the far side of the workpiece's bounding box, pulls against u until its face is `depth` inside that box,
/// gives way by as much, and lifts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HookSpec {
    /// The hook; its face at local −x meets the material.
    pub head: HeadSpec,
    /// Height of its lower end above the table while it pulls \[m\].
    #[schemars(range(min = 0.0005, max = 0.1))]
    pub height: f64,
    /// Bound of |rotation| \[rad\].
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub rotation: f64,
    /// Bounds of the depth \[m\]; the upper one gives way to the piece's smaller width.
    pub depth: [f64; 2],
    /// Distance kept to the workpiece's bounding box at the start and at the end \[m\].
    #[schemars(range(min = 0.001, max = 0.1))]
    pub clearance: f64,
    /// Share of the steps in which the hook comes down.
    #[schemars(range(min = 1, max = 100))]
    pub down: usize,
    /// Share of the steps in which it pulls.
    #[schemars(range(min = 1, max = 100))]
    pub pull: usize,
    /// Share of the steps in which it gives way.
    #[schemars(range(min = 1, max = 100))]
    pub free: usize,
    /// Share of the steps in which it lifts.
    #[schemars(range(min = 1, max = 100))]
    pub lift: usize,
}

/// See [`HookSpec`].
#[derive(Clone, Debug)]
pub struct Hook {
    spec: HookSpec,
    head: Head,
}

impl HookSpec {
    /// The hook.
    ///
    /// # Errors
    /// When a size is impossible.
    pub fn build(self) -> anyhow::Result<Hook> {
        stroke::check(self.depth, self.clearance)?;
        ensure!(self.height > 0.0, "`height` must be positive, or the hook scrapes the table");
        let shares = [self.down, self.pull, self.free, self.lift];
        ensure!(shares.iter().all(|s| *s > 0), "`down`, `pull`, `free`, `lift` need at least one step each");
        Ok(Hook { head: self.head.clone().alone()?, spec: self })
    }
}

impl Tool for Hook {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.head.shape
    }

    fn space(&self, piece: &Workpiece) -> ActionSpace {
        stroke::across(piece, self.spec.rotation, self.spec.depth)
    }

    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let &[r, rotation, depth] = theta else { panic!("a hook takes three numbers, not {theta:?}") };
        let (sine, cosine) = rotation.sin_cos();
        let (behind, line) = (piece.reach(cosine, sine), piece.centre + r * DVec3::new(-sine, cosine, 0.0));
        let hook = |[face, end]: [f64; 2]| {
            let translation = line + (face + self.head.half.x) * DVec3::new(cosine, sine, 0.0);
            let translation = translation.with_z(end + self.head.half.z);
            vec![Pose { translation, rotation: DQuat::from_rotation_z(rotation) }]
        };
        let HookSpec { height, clearance, down, pull, free, lift, .. } = self.spec;
        let (out, above) = (behind + clearance, piece.extent.z + clearance);
        let legs = [
            Leg { share: down, to: [out, height] },
            Leg { share: pull, to: [behind - depth, height] },
            Leg { share: free, to: [out, height] },
            Leg { share: lift, to: [out, above] },
        ];
        let controls = along(steps, [out, above], &legs).into_iter().map(|at| Control { poses: hook(at) });
        Motion { start: hook([out, above]), controls: controls.collect() }
    }
}
