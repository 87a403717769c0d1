//! A blade that slides under the material, lifts it, carries it and slips out again.
use super::head::Head;
use super::leg::{Leg, along};
use super::{HeadSpec, Motion, Tool, Workpiece, stroke};
use crate::state::{ActionSpace, Control, Pose, ToolShape};
use anyhow::ensure;
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A spatula: θ = (rotation, depth, x, y).
///
/// The blade slides along u = (cos rotation, sin rotation) under the workpiece until its tip is `depth` inside the workpiece's
/// bounding box, lifts by `lift_height`, carries by (x, y), comes down and goes back to where it started. RoboCook (Shi et al.
/// 2023) scripts the spatulas' pick and place; a search needs the direction and depth of the pick too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScoopSpec {
    /// The blade; its tip at local +x goes under the material.
    pub head: HeadSpec,
    /// Height of the blade's lower side above the table while it slides \[m\].
    #[schemars(range(min = 0.0005, max = 0.1))]
    pub height: f64,
    /// Height by which it lifts \[m\].
    #[schemars(range(min = 0.0, max = 0.3))]
    pub lift_height: f64,
    /// Bound of |rotation| \[rad\].
    #[schemars(range(min = 0.0, max = std::f64::consts::PI))]
    pub rotation: f64,
    /// Bounds of the depth \[m\]; the upper one gives way to the piece's smaller width.
    pub depth: [f64; 2],
    /// Bound of |x| and |y|, how far it carries \[m\].
    #[schemars(range(min = 0.0, max = 0.5))]
    pub carry_reach: f64,
    /// Distance kept to the workpiece's bounding box at the start and at the end \[m\].
    #[schemars(range(min = 0.001, max = 0.1))]
    pub clearance: f64,
    /// Share of the steps in which the blade slides in.
    #[schemars(range(min = 1, max = 100))]
    pub slide: usize,
    /// Share of the steps in which it lifts.
    #[schemars(range(min = 1, max = 100))]
    pub lift: usize,
    /// Share of the steps in which it carries.
    #[schemars(range(min = 1, max = 100))]
    pub carry: usize,
    /// Share of the steps in which it comes down.
    #[schemars(range(min = 1, max = 100))]
    pub down: usize,
    /// Share of the steps in which it goes back.
    #[schemars(range(min = 1, max = 100))]
    pub back: usize,
}

/// See [`ScoopSpec`].
#[derive(Clone, Debug)]
pub struct Scoop {
    spec: ScoopSpec,
    head: Head,
}

impl ScoopSpec {
    /// The spatula.
    ///
    /// # Errors
    /// When a size is impossible.
    pub fn build(self) -> anyhow::Result<Scoop> {
        stroke::check(self.depth, self.clearance)?;
        ensure!(self.height > 0.0, "`height` must be positive, or the blade scrapes the table");
        ensure!(self.lift_height >= 0.0, "`lift_height` must not be negative");
        let shares = [self.slide, self.lift, self.carry, self.down, self.back];
        ensure!(shares.iter().all(|s| *s > 0), "`slide`, `lift`, `carry`, `down`, `back` need at least one step each");
        Ok(Scoop { head: self.head.clone().alone()?, spec: self })
    }
}

impl Tool for Scoop {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.head.shape
    }

    fn space(&self, piece: &Workpiece) -> ActionSpace {
        let ScoopSpec { rotation, depth: depth @ [least, _], carry_reach, .. } = self.spec;
        let deepest = stroke::deepest(piece, depth);
        ActionSpace {
            names: ["rotation", "depth", "x", "y"].map(String::from).to_vec(),
            low: vec![-rotation, least, -carry_reach, -carry_reach],
            high: vec![rotation, deepest, carry_reach, carry_reach],
        }
    }

    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion {
        let &[rotation, depth, x, y] = theta else { panic!("a scoop takes four numbers, not {theta:?}") };
        let (sine, cosine) = rotation.sin_cos();
        let before = -piece.reach(cosine, sine);
        let blade = |[tip, up, along_x, along_y]: [f64; 4]| {
            let forward = (tip - self.head.half.x) * DVec3::new(cosine, sine, 0.0);
            let height = self.spec.height + self.head.half.z + up;
            let translation = piece.centre + forward + DVec3::new(along_x, along_y, height);
            vec![Pose { translation, rotation: DQuat::from_rotation_z(rotation) }]
        };
        let ScoopSpec { lift_height: up, clearance, slide, lift, carry, down, back, .. } = self.spec;
        let (clear, under) = (before - clearance, before + depth);
        let legs = [
            Leg { share: slide, to: [under, 0.0, 0.0, 0.0] },
            Leg { share: lift, to: [under, up, 0.0, 0.0] },
            Leg { share: carry, to: [under, up, x, y] },
            Leg { share: down, to: [under, 0.0, x, y] },
            Leg { share: back, to: [clear, 0.0, 0.0, 0.0] },
        ];
        let controls = along(steps, [clear, 0.0, 0.0, 0.0], &legs).into_iter().map(|at| Control { poses: blade(at) });
        Motion { start: blade([clear, 0.0, 0.0, 0.0]), controls: controls.collect() }
    }
}
