//! The tool as numbers: where each sample of its surface is at a step's end, how far it came, and which way it faces.
use super::{LatentModel, LatentState};
use crate::model::net::SAMPLE;
use crate::state::{Control, Pose, PoseGrad, SurfacePoint, Twist};
use glam::{DVec2, DVec3};

/// A sample, and the part that it belongs to at the step's end.
struct Sample<'a> {
    part: usize,
    pose: &'a Pose,
    twist: Twist,
    point: &'a SurfacePoint,
}

fn samples<'a>(state: &'a LatentState, control: &'a Control) -> impl Iterator<Item = Sample<'a>> {
    let poses = state.poses.iter().zip(&control.poses);
    let parts = state.start.tool.parts.iter().zip(poses).enumerate();
    parts.flat_map(|(part, (shape, (from, pose)))| {
        let twist = from.twist_to(pose, state.start.interval);
        shape.surface.iter().map(move |point| Sample { part, pose, twist, point })
    })
}

impl LatentModel {
    /// (P, 9): `[(p − middle)/extent, T (linear + angular × arm)/scale, n]` with `arm = R s`, `p = arm + t`.
    pub(super) fn samples(&self, state: &LatentState, control: &Control) -> (Vec<f32>, usize) {
        let (middle, interval) = (state.start.middle.extend(0.0), state.start.interval);
        let numbers = samples(state, control).flat_map(|Sample { pose, twist, point, .. }| {
            let arm = pose.rotation * point.position;
            let place = (arm + pose.translation - middle) / self.extent;
            let motion = interval / self.scale * (twist.linear + twist.angular.cross(arm));
            [place, motion, pose.rotation * point.normal]
        });
        (numbers.flat_map(|v| v.as_vec3().to_array()).collect(), SAMPLE)
    }

    /// `∂J/∂(poses before, poses after, middle)` from `∂J/∂samples`.
    pub(super) fn samples_vjp(
        &self,
        state: &LatentState,
        control: &Control,
        at: &[f32],
    ) -> (Vec<PoseGrad>, Vec<PoseGrad>, DVec2) {
        let parts = state.poses.len();
        let (mut poses, mut twists) = (vec![PoseGrad::default(); parts], vec![Twist::default(); parts]);
        let mut at_middle = DVec3::ZERO;
        for (Sample { part, pose, twist, point }, row) in samples(state, control).zip(at.chunks_exact(SAMPLE)) {
            let read = |k: usize| glam::Vec3::from_slice(&row[3 * k..]).as_dvec3();
            let (arm, normal) = (pose.rotation * point.position, pose.rotation * point.normal);
            let (at_place, at_velocity) = (read(0) / self.extent, state.start.interval / self.scale * read(1));
            let at_arm = at_place + at_velocity.cross(twist.angular);
            at_middle -= at_place;
            poses[part].translation += at_place;
            poses[part].rotation += arm.cross(at_arm) + normal.cross(read(2));
            twists[part].linear += at_velocity;
            twists[part].angular += arm.cross(at_velocity);
        }
        let ends = state.poses.iter().zip(&control.poses).zip(poses.iter().zip(&twists));
        let pulled =
            ends.map(|((from, to), (pose, twist))| from.toward_vjp(to, 1.0, pose, twist, state.start.interval));
        let (before, after) = pulled.unzip();
        (before, after, at_middle.truncate())
    }
}
