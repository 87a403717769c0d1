//! Rigid motions that lay one cloud over another.
use crate::state::rotation_between;
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What may be moved before shapes are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Freedom {
    /// Turns about the vertical and shifts along the table.
    #[default]
    Yaw,
    /// Every rotation and shift.
    Full,
}

/// `x ↦ R x + t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// R.
    pub rotation: DQuat,
    /// t \[m\].
    pub translation: DVec3,
}

impl Rigid {
    /// The cloud after the motion.
    pub fn apply(&self, points: &[DVec3]) -> Vec<DVec3> {
        points.iter().map(|p| self.rotation * p + self.translation).collect()
    }

    /// The motion that turns by `rotation` and takes the point `from` to `to` \[m\].
    pub(super) fn about(rotation: DQuat, from: DVec3, to: DVec3) -> Self {
        Self { rotation, translation: to - rotation * from }
    }

    /// This motion after `first`.
    pub(super) fn after(&self, first: &Self) -> Self {
        let rotation = (self.rotation * first.rotation).normalize();
        Self { rotation, translation: self.rotation * first.translation + self.translation }
    }
}

/// The motion of least `Σ |R aᵢ + t − bᵢ|²` over matched pairs (Kabsch 1976; in quaternions by Horn 1987, for the vertical axis alone
/// in closed form).
pub(super) fn kabsch(pairs: &[(DVec3, DVec3)], freedom: Freedom) -> Rigid {
    let mean = |side: fn(&(DVec3, DVec3)) -> DVec3| pairs.iter().map(side).sum::<DVec3>() / pairs.len().max(1) as f64;
    let (from, to) = (mean(|p| p.0), mean(|p| p.1));
    let centred = || pairs.iter().map(|(a, b)| (*a - from, *b - to));
    match freedom {
        Freedom::Yaw => {
            let (dot, cross) = centred().fold((0.0, 0.0), |(dot, cross), (a, b)| {
                (dot + a.truncate().dot(b.truncate()), cross + a.truncate().perp_dot(b.truncate()))
            });
            Rigid::about(DQuat::from_rotation_z(f64::atan2(cross, dot)), from, to.with_z(from.z))
        }
        Freedom::Full => Rigid::about(rotation_between(centred()), from, to),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::tests::cloud;

    fn pairs(rotation: DQuat, translation: DVec3) -> (Vec<DVec3>, Vec<(DVec3, DVec3)>) {
        let a = cloud(20, 1);
        let b = Rigid { rotation, translation }.apply(&a);
        (a.clone(), a.into_iter().zip(b).collect())
    }

    #[test]
    fn it_finds_the_motion_that_was_made() {
        for k in 0..12 {
            let turn = 0.5 * f64::from(k);
            let (flat, whole) =
                (DQuat::from_rotation_z(turn), DQuat::from_euler(glam::EulerRot::XYZ, turn, 1.0, -turn));
            let (sideways, anywhere) = (DVec3::new(0.3, -2.0, 0.0), DVec3::new(0.3, -2.0, 5.0));
            for (freedom, rotation, shift) in [(Freedom::Yaw, flat, sideways), (Freedom::Full, whole, anywhere)] {
                let (a, pairs) = pairs(rotation, shift);
                let found = kabsch(&pairs, freedom).apply(&a);
                let error = pairs.iter().zip(found).map(|((_, b), c)| b.distance(c)).fold(0.0, f64::max);
                assert!(error < 1e-12, "{freedom:?} {turn}: {error}");
            }
        }
    }

    #[test]
    fn no_small_motion_does_better() {
        let pairs: Vec<(DVec3, DVec3)> = cloud(20, 1).into_iter().zip(cloud(20, 2)).collect();
        let squares =
            |m: &Rigid| pairs.iter().map(|(a, b)| (m.rotation * *a + m.translation).distance_squared(*b)).sum::<f64>();
        for freedom in [Freedom::Yaw, Freedom::Full] {
            let best = kabsch(&pairs, freedom);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                for step in [-1e-3, 1e-3] {
                    let flat = freedom == Freedom::Yaw;
                    let turned = Rigid::about(DQuat::from_axis_angle(axis, step), DVec3::splat(0.5), DVec3::splat(0.5));
                    let shifted = Rigid { rotation: DQuat::IDENTITY, translation: axis * step };
                    assert!((flat && axis != DVec3::Z) || squares(&turned.after(&best)) > squares(&best), "{axis}");
                    assert!((flat && axis == DVec3::Z) || squares(&shifted.after(&best)) > squares(&best), "{axis}");
                }
            }
        }
    }
}
