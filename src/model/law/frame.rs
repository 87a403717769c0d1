//! The axes in which a network sees a scene: the world's, or ones that turn with the tool about the vertical.
use super::{View, ViewGrad};
use crate::state::{Particles, ParticlesGrad, Pose, PoseGrad, Twist, Wall};
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FrameSpec {
    /// The world's.
    #[default]
    World,
    /// The world's, turned about the vertical until y is the heading of the first tool part's own y axis: the law commutes with
    /// turns of the whole scene, and a tool looks alike whichever way it faces.
    Tool,
}

/// The turn from the frame to the world, `R_z(ψ)`, and how ψ follows the tool.
pub(super) struct Frame {
    turn: DQuat,
    /// `∂ψ/∂r` for the tangent r of the first part's rotation.
    slope: DVec3,
}

/// What a view holds, as the frame's axes show it.
pub(super) struct Seen {
    pub(super) particles: Particles,
    pub(super) past: Vec<Vec<DVec3>>,
    pub(super) walls: Vec<Wall>,
    pub(super) poses: Vec<Pose>,
    pub(super) twists: Vec<Twist>,
}

impl Frame {
    /// With u the first part's y axis in the world, `ψ = atan2(−u_x, u_y)` and
    /// `∂ψ/∂r = (−u_x u_z, −u_y u_z, u_x² + u_y²) / (u_x² + u_y²)`; no turn when there is no part, or it stands upright.
    pub(super) fn of(spec: FrameSpec, view: &View<'_>) -> Self {
        let still = Self { turn: DQuat::IDENTITY, slope: DVec3::ZERO };
        let (FrameSpec::Tool, Some(pose)) = (spec, view.poses.first()) else { return still };
        let u = pose.rotation * DVec3::Y;
        let flat = u.x * u.x + u.y * u.y;
        if flat < 1e-12 {
            return still;
        }
        let slope = DVec3::new(-u.x * u.z, -u.y * u.z, flat) / flat;
        Self { turn: DQuat::from_rotation_z((-u.x).atan2(u.y)), slope }
    }

    /// A vector of the frame in the world.
    pub(super) fn leave(&self, v: DVec3) -> DVec3 {
        self.turn * v
    }

    /// Adds rows of the frame, `unit` times, to vectors of the world.
    pub(super) fn add(&self, unit: f64, rows: &[f32], out: &mut [DVec3]) {
        for (a, row) in out.iter_mut().zip(rows.chunks_exact(3)) {
            *a += self.leave(unit * glam::Vec3::from_slice(row).as_dvec3());
        }
    }

    /// A vector of the world in the frame.
    pub(super) fn enter(&self, v: DVec3) -> DVec3 {
        self.turn.inverse() * v
    }

    /// The view's particles and tool in the frame.
    pub(super) fn see(&self, view: &View<'_>) -> Seen {
        let all = |list: &[DVec3]| list.iter().map(|v| self.enter(*v)).collect::<Vec<_>>();
        let pose = |p: &Pose| Pose {
            translation: self.enter(p.translation),
            rotation: (self.turn.inverse() * p.rotation).normalize(),
        };
        let twist = |t: &Twist| Twist { linear: self.enter(t.linear), angular: self.enter(t.angular) };
        Seen {
            particles: Particles {
                positions: all(&view.particles.positions),
                velocities: all(&view.particles.velocities),
            },
            past: view.past.iter().map(|velocities| all(velocities)).collect(),
            walls: view.walls.iter().map(|wall| Wall { normal: self.enter(wall.normal), ..*wall }).collect(),
            poses: view.poses.iter().map(pose).collect(),
            twists: view.twists.iter().map(twist).collect(),
        }
    }

    /// Adds to `grad` what `inner`, the gradient in the frame, is in the world, and what follows from the frame's own turn; `normals`
    /// is the gradient by the walls' normals in the frame.
    ///
    /// With output a, its cotangent ā and every input x with gradient x̄, all in the world:
    /// `∂J/∂ψ = Σ ā·(ẑ × a) − Σ x̄·(ẑ × x)`, where a rotation's tangent counts as `r̄·ẑ`.
    pub(super) fn pull(
        &self,
        view: &View<'_>,
        output: &[DVec3],
        at: &[DVec3],
        inner: &ViewGrad<'_>,
        normals: &[DVec3],
        grad: &mut ViewGrad<'_>,
    ) {
        let spin = |x: &DVec3, g: DVec3| g.dot(DVec3::Z.cross(*x));
        let mut by_turn: f64 = output.iter().zip(at).map(|(a, g)| spin(a, *g)).sum();
        let mut back = |x: &DVec3, g: &DVec3| {
            let g = self.leave(*g);
            by_turn -= spin(x, g);
            g
        };
        let ParticlesGrad { positions, velocities } = &inner.particles;
        for (i, (x, v)) in view.particles.positions.iter().zip(&view.particles.velocities).enumerate() {
            grad.particles.positions[i] += back(x, &positions[i]);
            grad.particles.velocities[i] += back(v, &velocities[i]);
        }
        for ((velocities, inner), own) in view.past.iter().zip(&inner.past).zip(&mut grad.past) {
            for ((v, g), own) in velocities.iter().zip(inner).zip(own) {
                *own += back(v, g);
            }
        }
        for (wall, normal) in view.walls.iter().zip(normals) {
            back(&wall.normal, normal);
        }
        for (k, (pose, twist)) in view.poses.iter().zip(view.twists).enumerate() {
            grad.poses[k].translation += back(&pose.translation, &inner.poses[k].translation);
            grad.twists[k].linear += back(&twist.linear, &inner.twists[k].linear);
            grad.twists[k].angular += back(&twist.angular, &inner.twists[k].angular);
        }
        for (own, PoseGrad { rotation, .. }) in grad.poses.iter_mut().zip(&inner.poses) {
            let rotation = self.leave(*rotation);
            own.rotation += rotation;
            by_turn -= rotation.z;
        }
        if let Some(first) = grad.poses.first_mut() {
            first.rotation += by_turn * self.slope;
        }
    }
}
