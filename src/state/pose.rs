//! Rigid poses, how they move between two instants, and the exact derivatives of both.
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// A rigid motion: `x ↦ R x + t`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Translation t \[m\].
    pub translation: DVec3,
    /// Rotation R, a unit quaternion.
    pub rotation: DQuat,
}

/// `∂J/∂pose` in the world frame: the derivative along `t + δt` and along `exp(δr) R`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseGrad {
    /// `∂J/∂t` \[1/m\].
    pub translation: DVec3,
    /// `∂J/∂r` \[1/rad\].
    pub rotation: DVec3,
}

/// Velocity of a rigid part in the world frame; a point x of a part at t moves at `linear + angular × (x − t)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Velocity of the part's origin \[m/s\].
    pub linear: DVec3,
    /// Angular velocity \[rad/s\].
    pub angular: DVec3,
}

impl AddAssign for PoseGrad {
    fn add_assign(&mut self, other: Self) {
        self.translation += other.translation;
        self.rotation += other.rotation;
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY }
    }
}

impl Pose {
    /// The world position of the point `local` of the part.
    pub fn apply(&self, local: DVec3) -> DVec3 {
        self.rotation * local + self.translation
    }

    /// The part's coordinates of the world point `world`.
    pub fn inverse_apply(&self, world: DVec3) -> DVec3 {
        self.rotation.inverse() * (world - self.translation)
    }

    /// The constant twist that carries `self` to `next` in `interval` seconds.
    pub fn twist_to(&self, next: &Pose, interval: f64) -> Twist {
        let turn = (next.rotation * self.rotation.inverse()).to_scaled_axis();
        Twist { linear: (next.translation - self.translation) / interval, angular: turn / interval }
    }

    /// The pose a fraction `s` ∈ \[0, 1\] of the way to `next`: straight line, constant turn rate.
    pub fn toward(&self, next: &Pose, s: f64) -> Pose {
        let turn = (next.rotation * self.rotation.inverse()).to_scaled_axis();
        Pose {
            translation: self.translation.lerp(next.translation, s),
            rotation: (DQuat::from_scaled_axis(s * turn) * self.rotation).normalize(),
        }
    }

    /// Pulls `∂J/∂toward(s)` and `∂J/∂twist` back to (self, next).
    ///
    /// With φ = log(R₁R₀⁻¹): `δφ = J⁻¹(φ) δr₁ − J⁻ᵀ(φ) δr₀` and `δr(s) = s J(sφ) δφ + exp(sφ) δr₀`, J the left Jacobian
    /// of SO(3) (Solà, Deray & Atchuthan 2018, eqs. 143–146; J_r(φ) = J(φ)ᵀ).
    pub fn toward_vjp(&self, next: &Pose, s: f64, at: &PoseGrad, twist: &Twist, interval: f64) -> (PoseGrad, PoseGrad) {
        let turn = (next.rotation * self.rotation.inverse()).to_scaled_axis();
        let inverse = left_jacobian_inverse(turn);
        let by_turn = s * (left_jacobian(s * turn).transpose() * at.rotation) + twist.angular / interval;
        let carried = DQuat::from_scaled_axis(s * turn).inverse() * at.rotation;
        let slide = twist.linear / interval;
        let from = PoseGrad { translation: (1.0 - s) * at.translation - slide, rotation: carried - inverse * by_turn };
        let to = PoseGrad { translation: s * at.translation + slide, rotation: inverse.transpose() * by_turn };
        (from, to)
    }
}

fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

/// `J(φ) = I + (1 − cos θ)/θ² [φ] + (θ − sin θ)/θ³ [φ]²`.
fn left_jacobian(turn: DVec3) -> DMat3 {
    let (angle, cross) = (turn.length(), cross_matrix(turn));
    let (a, b) = if angle < 1e-4 {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / (angle * angle * angle))
    };
    DMat3::IDENTITY + a * cross + b * (cross * cross)
}

/// `J⁻¹(φ) = I − ½ [φ] + (1/θ² − (1 + cos θ)/(2 θ sin θ)) [φ]²`.
fn left_jacobian_inverse(turn: DVec3) -> DMat3 {
    let (angle, cross) = (turn.length(), cross_matrix(turn));
    let c = if angle < 1e-3 {
        1.0 / 12.0 + angle * angle / 720.0
    } else {
        1.0 / (angle * angle) - (1.0 + angle.cos()) / (2.0 * angle * angle.sin())
    };
    DMat3::IDENTITY - 0.5 * cross + c * (cross * cross)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nudge(pose: &Pose, axis: usize, h: f64) -> Pose {
        let mut d = [0.0; 6];
        d[axis] = h;
        Pose {
            translation: pose.translation + DVec3::new(d[0], d[1], d[2]),
            rotation: DQuat::from_scaled_axis(DVec3::new(d[3], d[4], d[5])) * pose.rotation,
        }
    }

    #[test]
    fn derivatives_of_the_path_agree_with_central_differences() {
        let from = Pose {
            translation: DVec3::new(0.1, -0.2, 0.3),
            rotation: DQuat::from_scaled_axis(DVec3::new(0.3, 0.1, -0.5)),
        };
        let to = Pose {
            translation: DVec3::new(-0.3, 0.1, 0.2),
            rotation: DQuat::from_scaled_axis(DVec3::new(-0.4, 0.7, 0.2)),
        };
        let (point, s, interval) = (DVec3::new(0.4, 0.3, -0.2), 0.3, 0.1);
        let weight = DVec3::new(1.0, -2.0, 0.5);
        let spin = DVec3::new(0.02, 0.05, -0.03);
        let cost = |a: &Pose, b: &Pose| {
            let twist = a.twist_to(b, interval);
            weight.dot(a.toward(b, s).apply(point)) + spin.dot(twist.angular) + spin.dot(twist.linear)
        };
        let pose = from.toward(&to, s);
        let at = PoseGrad { translation: weight, rotation: (pose.rotation * point).cross(weight) };
        let (g0, g1) = from.toward_vjp(&to, s, &at, &Twist { linear: spin, angular: spin }, interval);
        for axis in 0..6 {
            let h = 1e-6;
            let d0 = (cost(&nudge(&from, axis, h), &to) - cost(&nudge(&from, axis, -h), &to)) / (2.0 * h);
            let d1 = (cost(&from, &nudge(&to, axis, h)) - cost(&from, &nudge(&to, axis, -h))) / (2.0 * h);
            let read = |g: &PoseGrad| if axis < 3 { g.translation[axis] } else { g.rotation[axis - 3] };
            assert!((read(&g0) - d0).abs() < 1e-7 * (1.0 + d0.abs()), "from {axis}: {} vs {d0}", read(&g0));
            assert!((read(&g1) - d1).abs() < 1e-7 * (1.0 + d1.abs()), "to {axis}: {} vs {d1}", read(&g1));
        }
    }
}
