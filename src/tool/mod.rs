//! Tools: a rigid shape, and the motion primitive that turns a few numbers into a path.
use crate::state::{ActionSpace, Control, ControlGrad, Particles, Pose, PoseGrad, ToolShape};
use glam::{DQuat, DVec3};
use std::sync::Arc;

mod cut;
mod grip;
mod head;
mod hook;
mod leg;
mod press;
mod push;
mod roll;
mod scoop;
mod shake;
mod solid;
mod stroke;
mod turn;
mod wait;

pub use cut::{Cut, CutSpec};
pub use grip::{Grip, GripSpec};
pub use head::HeadSpec;
pub use hook::{Hook, HookSpec};
pub use press::{Press, PressSpec};
pub use push::{Push, PushSpec};
pub use roll::{Roll, RollSpec};
pub use scoop::{Scoop, ScoopSpec};
pub use shake::{Shake, ShakeSpec};
pub use solid::{PieceSpec, SolidSpec};
pub use wait::{Wait, WaitSpec};

family! {
    /// A tool: geometry and the constants of one motion primitive.
    ToolSpec builds Box<dyn Tool> {
        Grip(GripSpec),
        Press(PressSpec),
        Roll(RollSpec),
        Cut(CutSpec),
        Push(PushSpec),
        Scoop(ScoopSpec),
        Hook(HookSpec),
        Shake(ShakeSpec),
        Wait(WaitSpec),
    }
}

/// What a tool's primitive needs to know of the material it is aimed at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workpiece {
    /// Middle of the particles' bounding box in the table plane (x, y), z = 0 \[m\].
    pub centre: DVec3,
    /// Half extents of that box in x and y, full height in z \[m\].
    pub extent: DVec3,
}

impl Workpiece {
    /// The bounding box of `particles`, standing on the table.
    pub fn around(particles: &Particles) -> Self {
        let (low, high) =
            particles.positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        Self { centre: middle.with_z(0.0), extent: half.with_z(high.z) }
    }

    /// `∂J/∂positions` from `∂J/∂(centre, extent)`: the outermost particles bear it, of equals the first.
    pub fn around_vjp(particles: &Particles, gradient: &Self) -> Vec<DVec3> {
        let positions = &particles.positions;
        let mut back = vec![DVec3::ZERO; positions.len()];
        let mut bear = |axis: usize, sign: f64, by: f64| {
            let outer = |best: usize, i: usize| {
                if sign * positions[i][axis] > sign * positions[best][axis] { i } else { best }
            };
            if let Some(outermost) = (0..positions.len()).reduce(outer) {
                back[outermost][axis] += by;
            }
        };
        for axis in 0..2 {
            bear(axis, 1.0, (gradient.centre[axis] + gradient.extent[axis]) / 2.0);
            bear(axis, -1.0, (gradient.centre[axis] - gradient.extent[axis]) / 2.0);
        }
        bear(2, 1.0, gradient.extent.z);
        back
    }

    /// How far the box reaches from its middle along (cosine, sine) in the table plane \[m\]; a little more where one of the two
    /// vanishes, so that it has a derivative everywhere.
    fn reach(&self, cosine: f64, sine: f64) -> f64 {
        // √(x² + (1 mm)²) bounds |x|.
        let above_abs = |x: f64| x.hypot(1e-3);
        above_abs(cosine * self.extent.x) + above_abs(sine * self.extent.y)
    }

    /// The smaller of its half extents in the table plane \[m\].
    fn narrow(&self) -> f64 {
        self.extent.x.min(self.extent.y)
    }
}

/// A path of rigid tool parts: where they start, and where they stand after each control step.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Start pose of each part, clear of the workpiece.
    pub start: Vec<Pose>,
    /// One control per step.
    pub controls: Vec<Control>,
}

/// A rigid tool and its motion primitive: θ in a box becomes a path.
pub trait Tool: Send + Sync {
    /// Geometry, shared by the world, models and perception.
    fn shape(&self) -> &Arc<ToolShape>;
    /// The box that θ lives in, for this workpiece.
    fn space(&self, piece: &Workpiece) -> ActionSpace;
    /// The path that θ describes, in `steps` control steps: from clear of the workpiece, through it, to clear of it again.
    fn motion(&self, theta: &[f64], piece: &Workpiece, steps: usize) -> Motion;

    /// `∂J/∂θ` from `∂J/∂(controls)` and `∂J/∂(start)`, by central differences of the path, which costs no rollout.
    fn motion_vjp(&self, theta: &[f64], piece: &Workpiece, start: &[PoseGrad], controls: &[ControlGrad]) -> Vec<f64> {
        let space = self.space(piece);
        (0..theta.len())
            .map(|i| {
                let h = 1e-5 * (space.high[i] - space.low[i]).max(1e-6);
                let nudge = |h: f64| {
                    let mut theta = theta.to_vec();
                    theta[i] += h;
                    self.motion(&theta, piece, controls.len())
                };
                work(&nudge(-h), &nudge(h), start, controls) / (2.0 * h)
            })
            .collect()
    }

    /// `∂J/∂(centre, extent)` of the workpiece, likewise, where θ lies at the fractions `unit` of the box that belongs to the piece.
    fn piece_vjp(&self, unit: &[f64], piece: &Workpiece, start: &[PoseGrad], controls: &[ControlGrad]) -> Workpiece {
        let at = |piece: Workpiece| self.motion(&self.space(&piece).at(unit), &piece, controls.len());
        let h = 1e-6;
        let slope = |by: &dyn Fn(f64) -> Workpiece| work(&at(by(-h)), &at(by(h)), start, controls) / (2.0 * h);
        let centre = |axis: DVec3| slope(&|h| Workpiece { centre: piece.centre + h * axis, ..*piece });
        let extent = |axis: DVec3| slope(&|h| Workpiece { extent: piece.extent + h * axis, ..*piece });
        Workpiece {
            centre: DVec3::new(centre(DVec3::X), centre(DVec3::Y), 0.0),
            extent: DVec3::AXES.map(extent).into(),
        }
    }
}

/// What the forces of a path do along the way from one path to another, to first order.
fn work(from: &Motion, to: &Motion, start: &[PoseGrad], controls: &[ControlGrad]) -> f64 {
    let work = |a: &[Pose], b: &[Pose], g: &[PoseGrad]| -> f64 {
        let turn = |a: &DQuat, b: &DQuat| (*b * a.inverse()).to_scaled_axis();
        a.iter()
            .zip(b)
            .zip(g)
            .map(|((a, b), g)| {
                (b.translation - a.translation).dot(g.translation) + turn(&a.rotation, &b.rotation).dot(g.rotation)
            })
            .sum()
    };
    let path = from.controls.iter().zip(&to.controls).zip(controls);
    let along: f64 = path.map(|((a, b), g)| work(&a.poses, &b.poses, &g.poses)).sum();
    along + work(&from.start, &to.start, start)
}
