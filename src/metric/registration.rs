//! The rigid motion under which two clouds are nearest.
use super::nearest::nearest;
use super::rigid::{Freedom, Rigid, kabsch};
use super::{ShapeLoss, is_finite};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Rotations about the vertical to start from.
const YAWS: usize = 16;
/// Iterations of every start, and of those that did best after that, and how many these are.
const FIRST: usize = 6;
const THEN: usize = 60;
const BEST: usize = 4;

/// The motion of `points` toward `goal` that minimises `loss`: iterated closest points from many rotations with the middles laid over
/// each other, then `descend`. `None` when a cloud is empty or not finite.
pub(super) fn register(points: &[DVec3], goal: &[DVec3], freedom: Freedom, loss: &dyn ShapeLoss) -> Option<Rigid> {
    if points.is_empty() || goal.is_empty() || !is_finite(points) || !is_finite(goal) {
        return None;
    }
    let middle = |points: &[DVec3]| points.iter().sum::<DVec3>() / points.len() as f64;
    let (from, to) = (middle(points), middle(goal));
    let to = if freedom == Freedom::Yaw { to.with_z(from.z) } else { to };
    let begin: Vec<Rigid> = starts(freedom).into_iter().map(|rotation| Rigid::about(rotation, from, to)).collect();
    let improve = |begin: Vec<Rigid>, iterations| -> Vec<(f64, Rigid)> {
        let mut found: Vec<_> =
            begin.into_par_iter().map(|motion| closest_points(points, goal, motion, freedom, iterations)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    };
    let best = improve(begin, FIRST).into_iter().take(BEST).map(|(_, motion)| motion).collect();
    let (_, motion) = *improve(best, THEN).first()?;
    Some(descend(points, goal, motion, freedom, loss))
}

fn starts(freedom: Freedom) -> Vec<DQuat> {
    let up: &[DQuat] = match freedom {
        Freedom::Yaw => &[DQuat::IDENTITY],
        // Every face of a cube up.
        Freedom::Full => &[
            DQuat::IDENTITY,
            DQuat::from_rotation_x(FRAC_PI_2),
            DQuat::from_rotation_x(-FRAC_PI_2),
            DQuat::from_rotation_y(FRAC_PI_2),
            DQuat::from_rotation_y(-FRAC_PI_2),
            DQuat::from_rotation_x(PI),
        ],
    };
    let yaw = |k: usize| DQuat::from_rotation_z(TAU * k as f64 / YAWS as f64);
    up.iter().flat_map(|up| (0..YAWS).map(move |k| yaw(k) * *up)).collect()
}

/// Iterated closest points (Besl & McKay 1992) in both directions: pairs every point with its nearest, moves by [`kabsch`], until the
/// mean square distance of the pairs, which comes back with the motion, no longer falls.
fn closest_points(
    points: &[DVec3],
    goal: &[DVec3],
    mut motion: Rigid,
    freedom: Freedom,
    iterations: usize,
) -> (f64, Rigid) {
    let mut least = f64::INFINITY;
    for _ in 0..iterations {
        let moved = motion.apply(points);
        let there = nearest(&moved, goal).into_iter().zip(&moved).map(|(n, p)| (*p, goal[n.row]));
        let back = nearest(goal, &moved).into_iter().zip(goal).map(|(n, q)| (moved[n.row], *q));
        let pairs: Vec<(DVec3, DVec3)> = there.chain(back).collect();
        let square = pairs.iter().map(|(p, q)| p.distance_squared(*q)).sum::<f64>() / pairs.len() as f64;
        if square >= least * (1.0 - 1e-12) {
            break;
        }
        least = square;
        motion = kabsch(&pairs, freedom).after(&motion);
    }
    (least, motion)
}

/// Steps at most, and the length of the loss's gradient at which they end.
const STEPS: usize = 60;
const FLAT: f64 = 1e-9;

/// Minimises the loss itself over the motion, starting near: the quasi-Newton method of Broyden, Fletcher, Goldfarb and Shanno (1970)
/// over small turns about the cloud's middle, in units of its size, and shifts.
fn descend(points: &[DVec3], goal: &[DVec3], mut motion: Rigid, freedom: Freedom, loss: &dyn ShapeLoss) -> Rigid {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let size = points.iter().map(|p| p.distance(middle)).sum::<f64>() / points.len() as f64;
    if size == 0.0 {
        return motion;
    }
    let free = |turn: DVec3, shift: DVec3| match freedom {
        Freedom::Yaw => [turn.with_x(0.0).with_y(0.0), shift.with_z(0.0)],
        Freedom::Full => [turn, shift],
    };
    let slope = |motion: &Rigid| {
        let (moved, centre) = (motion.apply(points), motion.rotation * middle + motion.translation);
        let pulls = loss.gradient(&moved, goal);
        let turn = moved.iter().zip(&pulls).map(|(p, g)| (*p - centre).cross(*g)).sum::<DVec3>() / size;
        free(turn, pulls.into_iter().sum())
    };
    let stepped = |motion: &Rigid, [turn, shift]: Step| {
        let centre = motion.rotation * middle + motion.translation;
        Rigid::about(DQuat::from_scaled_axis(turn / size), centre, centre + shift).after(motion)
    };
    let (mut value, mut gradient) = (loss.value(&motion.apply(points), goal), slope(&motion));
    // The inverse of the second derivative: a step along the slope of a hundredth of the size to begin with.
    let mut memory: Vec<(Step, Step)> = Vec::new();
    for _ in 0..STEPS {
        if dot(gradient, gradient).sqrt() <= FLAT || value <= 1e-12 * size {
            break;
        }
        let mut step = direction(&memory, gradient, 0.01 * size);
        if dot(step, gradient) >= 0.0 {
            memory.clear();
            step = direction(&memory, gradient, 0.01 * size);
        }
        let slant = dot(step, gradient);
        let found = (0..30).map(|k| 0.5_f64.powi(k)).find_map(|scale| {
            let next = stepped(&motion, step.map(|s| s * scale));
            let lower = loss.value(&next.apply(points), goal);
            (lower <= value + 1e-4 * scale * slant).then_some((scale, next, lower))
        });
        let Some((scale, next, lower)) = found else { break };
        let steeper = slope(&next);
        let change = [steeper[0] - gradient[0], steeper[1] - gradient[1]];
        let step = step.map(|s| s * scale);
        if dot(step, change) > 0.0 {
            memory.push((step, change));
        }
        (motion, value, gradient) = (next, lower, steeper);
    }
    motion
}

/// A turn in units of the cloud's size \[m\] and a shift \[m\], or the slope along them.
type Step = [DVec3; 2];

fn dot(a: Step, b: Step) -> f64 {
    a[0].dot(b[0]) + a[1].dot(b[1])
}

/// The quasi-Newton direction by the two loops of Nocedal (1980).
fn direction(memory: &[(Step, Step)], gradient: Step, first: f64) -> Step {
    let add = |a: Step, b: Step, scale: f64| [a[0] + scale * b[0], a[1] + scale * b[1]];
    let mut q = gradient;
    let mut alphas = Vec::new();
    for (s, y) in memory.iter().rev() {
        let alpha = dot(*s, q) / dot(*s, *y);
        q = add(q, *y, -alpha);
        alphas.push(alpha);
    }
    let scale = memory.last().map_or(first / dot(gradient, gradient).sqrt(), |(s, y)| dot(*s, *y) / dot(*y, *y));
    q = q.map(|v| v * scale);
    for ((s, y), alpha) in memory.iter().zip(alphas.into_iter().rev()) {
        q = add(q, *s, alpha - dot(*y, q) / dot(*s, *y));
    }
    q.map(|v| -v)
}
