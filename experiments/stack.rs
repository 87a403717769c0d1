//! Particles that bounce one on the other without loss: the order of the integrator, and the energy that it keeps.
use crate::lump::{away, under};
use crate::physics::{built, with};
use glam::DVec3;
use pliant::state::{Control, Particles};
use pliant::train::value;
use serde_json::{Value, json};

/// What keeps energy: no drag, no damping, no friction.
const LOSSLESS: [(&str, f64); 5] = [
    ("keep", 1.0),
    ("laws.contact.damping", 0.0),
    ("laws.contact.friction", 0.0),
    ("laws.floor.damping", 0.0),
    ("laws.floor.friction", 0.0),
];

/// Undamped contacts: particles that bounce one on the other on the floor.
pub(crate) fn stack(particles: &Value) -> anyhow::Result<Value> {
    let radius = ("laws.floor.radius", value(particles, "laws.contact.radius")?);
    let kinds = ["contact", "floor", "gravity"];
    with(particles, &kinds, &[&LOSSLESS[..], &[radius]].concat())
}

/// The stack after each of so many control steps of `interval` \[s\], of `substeps` each.
fn bounce(stack: &Value, interval: f64, steps: usize, substeps: usize) -> anyhow::Result<Vec<Particles>> {
    let radius = value(stack, "laws.contact.radius")?;
    let heights = (0..4).map(|n| DVec3::Z * radius * (0.97 + 1.96 * f64::from(n)));
    let mut scene = under(Particles::at_rest(heights.collect()), away());
    scene.particles.velocities[3].z = -0.002;
    scene.interval = interval;
    let mut model = stack.clone();
    model["substeps"] = json!(substeps);
    Ok(built(&model)?.rollout(&scene, &vec![Control { poses: vec![away()] }; steps]))
}

/// The slope of the logarithm of the error over that of the substep, of pairs (substep, error).
pub(crate) fn regression(points: &[(f64, f64)]) -> f64 {
    let points: Vec<_> = points.iter().map(|(h, error)| (h.ln(), error.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let (sxy, sxx) = points.iter().fold((0.0, 0.0), |(a, b), p| (a + (p.0 - x) * (p.1 - y), b + (p.0 - x).powi(2)));
    sxy / sxx
}

/// The order at which the balls come to where a substep 64 times smaller than the smallest takes them.
pub(crate) fn order(stack: &Value) -> anyhow::Result<f64> {
    let end = |n: usize| -> anyhow::Result<Particles> { Ok(bounce(stack, 0.1, 2, n)?.pop().unwrap_or_default()) };
    let truth = end(40 * 512)?;
    let point = |n: usize| -> anyhow::Result<(f64, f64)> {
        let far: f64 = end(40 * n)?.positions.iter().zip(&truth.positions).map(|(a, b)| a.distance_squared(*b)).sum();
        Ok((1.0 / n as f64, far.sqrt()))
    };
    Ok(regression(&[1, 2, 4, 8].map(point).into_iter().collect::<anyhow::Result<Vec<_>>>()?))
}

/// How far the stack's energy is ever from where it began, as a share of the most that ever moved.
pub(crate) fn drift(stack: &Value, steps: usize) -> anyhow::Result<f64> {
    let [radius, k, g] =
        ["laws.contact.radius", "laws.contact.stiffness", "laws.gravity.acceleration"].map(|at| value(stack, at));
    let (radius, k, g) = (radius?, k?, g?);
    let moving = |x: &Particles| 0.5 * x.velocities.iter().map(|v| v.length_squared()).sum::<f64>();
    let energy = |x: &Particles| {
        let overlaps =
            x.positions.windows(2).map(|w| 2.0 * radius - w[0].distance(w[1])).chain([radius - x.positions[0].z]);
        let elastic: f64 = overlaps.map(|overlap| 0.4 * k * overlap.max(0.0).powf(2.5)).sum();
        moving(x) + elastic + g * x.positions.iter().map(|x| x.z).sum::<f64>()
    };
    let states = bounce(stack, 1e-4, steps, 1)?;
    let most = states.iter().map(moving).fold(0.0, f64::max);
    Ok(states.iter().map(|x| (energy(x) - energy(&states[0])).abs()).fold(0.0, f64::max) / most)
}
