//! Claim: both analytical models fall exactly, keep momentum, converge with the order of their integrator, and have exact gradients
//! through contact, flow and friction, also where laws remember; the particles keep energy.
//!
//! Command: `cargo run --release --bin experiments -- physics`, half a minute. Table: `paper/tables/physics.tex`. Linux only: CPU
//! time is read from `/proc`.
use crate::adjudge::adjudge;
use crate::claim::{Experiment, Rows, Size, median, number, verdict};
use crate::lump::{away, block, pressed, under};
use crate::remembering::remembering;
use crate::slopes::{RELATIVE, STEP, constants, gain, price, slopes};
use crate::stack::{drift, order, regression, stack};
use anyhow::Context;
use glam::DVec3;
use pliant::compare::ContenderSpec;
use pliant::config;
use pliant::model::mpm::{MpmModel, MpmSpec};
use pliant::model::{Dynamics, ModelSpec, WorldModel};
use pliant::state::{Control, Particles};
use pliant::table::Grid;
use pliant::train::replace;
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "physics",
    claim: "the analytical models fall exactly, keep energy and momentum, and have exact gradients through contact, flow and friction",
    duration: "half a minute",
    rows: Rows::Measured(measure),
    table,
};

const GRAVITY: f64 = 9.81;
/// The laws between particles, which keep momentum.
const INNER: [&str; 3] = ["contact", "cohesion", "viscosity"];
fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (steps, directions, rounds) = if size == Size::Paper { (10_000, 100, 5) } else { (100, 2, 1) };
    let particles = serde_json::to_value(shipped("analytic")?)?;
    let ModelSpec::Mpm(mpm) = shipped("mpm")? else { anyhow::bail!("configs/model/mpm.toml holds another model") };
    let lossless = MpmSpec { yield_stress: 1e9, viscosity: 0.0, gravity: 0.0, ..mpm.clone() };
    let mut rows = Vec::new();
    let cores = std::thread::available_parallelism()?.get();
    let mut add = |model: &str, what: &str, value: f64, low: f64, high: f64| {
        rows.push(json!({ "model": model, "what": what, "value": value, "low": low, "high": high, "load": load()?,
            "cores": cores }));
        let stopped = || "stopped between two measurements; nothing is kept of them".into();
        watch.go_on(stopped).map_err(anyhow::Error::from)
    };
    let falling = with(&particles, &["gravity"], &[("keep", 1.0), ("laws.gravity.acceleration", GRAVITY)])?;
    let substeps = particles["substeps"].as_u64().context("dynamics.substeps is no number")? as usize;
    let heavy = MpmModel::new(MpmSpec { gravity: GRAVITY, ..lossless.clone() })?;
    add("particles", "free fall, off by [m]", fall(&*built(&falling)?, 0.1 / substeps as f64), 0.0, 1e-12)?;
    add("mpm", "free fall, off by [m]", fall(&heavy, 0.1 / heavy.substeps(0.1) as f64), 0.0, 1e-12)?;
    add("particles", "order of the integrator", order(&stack(&particles)?)?, 0.85, 1.15)?;
    add("mpm", "order of the integrator, in free fall", order_in_fall(&lossless)?, 0.85, 1.15)?;
    let mut verlet = stack(&particles)?;
    verlet["integrator"] = json!("velocity_verlet");
    add("particles", "order of velocity Verlet", order(&verlet)?, 1.85, 2.15)?;
    add("particles", "energy over 10⁴ undamped steps, off by [1]", drift(&stack(&particles)?, steps)?, 0.0, 0.01)?;
    add("particles", "energy by velocity Verlet, off by [1]", drift(&verlet, steps)?, 0.0, 0.01)?;
    let still = built(&with(&particles, &INNER, &[("keep", 1.0), ("laws.contact.friction", 0.0)])?)?;
    let (p, l) = kept(&*still);
    add("particles", "linear momentum, off by [1]", p, 0.0, 1e-10)?;
    add("particles", "angular momentum, off by [1]", l, 0.0, 1e-10)?;
    let (p, l) = carried(MpmSpec { gravity: 0.0, ..mpm.clone() })?;
    add("mpm", "linear momentum, off by [1]", p, 0.0, 1e-10)?;
    add("mpm", "angular momentum, off by [1]", l, 0.0, 1e-10)?;
    let continuum = MpmModel::new(mpm)?;
    let models: [(&str, &dyn WorldModel); 2] = [("particles", &*built(&particles)?), ("mpm", &continuum)];
    for (name, model) in models {
        for (by, state, control) in [("state", 1.0, 0.0), ("control", 0.0, 1.0)] {
            let errors = slopes(model, directions, [state, control], STEP)?;
            let worst = errors.iter().copied().fold(0.0, f64::max);
            add(name, &format!("gradient by {by}, median error [1]"), median(errors), 0.0, 1e-4)?;
            add(name, &format!("gradient by {by}, greatest error [1]"), worst, 0.0, 1e-4)?;
        }
    }
    let errors = constants(&particles, directions, RELATIVE)?;
    let worst = errors.iter().copied().fold(0.0, f64::max);
    add("particles", "gradient by constants, median error [1]", median(errors), 0.0, 1e-4)?;
    add("particles", "gradient by constants, greatest error [1]", worst, 0.0, 1e-4)?;
    remembering(&particles, &serde_json::to_value(shipped("bonds")?)?, directions, &mut add)?;
    for (name, model) in models {
        add(name, "a gradient's CPU time [rollouts]", price(model, rounds)?, 0.0, 4.0)?;
        let (scene, controls) = pressed(6, 20, 0.014);
        let rollout = model.rollout(&scene, &controls);
        let broken = rollout.iter().filter(|x| !x.is_finite()).count();
        add(name, "pressed to a third: states not finite", broken as f64, 0.0, 0.0)?;
        add(name, "gain of two threads in 8 rollouts", gain(model, 4 * rounds)?, 1.7, f64::MAX)?;
    }
    Ok(rows)
}

/// Threads of all programs that want a core, over the last minute.
fn load() -> anyhow::Result<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").context("cannot read /proc/loadavg: the load needs Linux")?;
    let first = text.split_whitespace().next().and_then(|n| n.parse().ok());
    first.context("/proc/loadavg holds no number")
}

fn shipped(name: &str) -> anyhow::Result<ModelSpec> {
    Ok(config::load::<ContenderSpec>(format!("configs/model/{name}.toml").as_ref(), &[])?.spec.dynamics)
}

pub(crate) fn built(model: &Value) -> anyhow::Result<Box<dyn WorldModel>> {
    serde_json::from_value::<ModelSpec>(model.clone())?.build()
}

/// The model of these kinds of law alone, with constants changed.
pub(crate) fn with(model: &Value, kinds: &[&str], changes: &[(&str, f64)]) -> anyhow::Result<Value> {
    let mut model = model.clone();
    let laws = model["laws"].as_array_mut().context("the model has no laws")?;
    laws.retain(|law| kinds.iter().any(|kind| law["kind"] == *kind));
    replace(&model, changes.iter().copied())
}

/// How far thrown particles are from where semi-implicit Euler takes them in free fall, `x + t v − g t (t + h)/2` \[m\].
fn fall(model: &dyn WorldModel, h: f64) -> f64 {
    let mut start = block(4, 3.0, 0.0, 0.0);
    let throw = DVec3::new(0.3, -0.2, 0.5);
    start.velocities.fill(throw);
    let scene = under(start, away());
    let end = model.rollout(&scene, &vec![Control { poses: vec![away()] }; 4]).pop().unwrap_or_default();
    let t = 0.4;
    let shift = t * throw - 0.5 * GRAVITY * t * (t + h) * DVec3::Z;
    let gaps = end.positions.iter().zip(&scene.particles.positions).map(|(a, b)| a.distance(*b + shift));
    gaps.fold(0.0, f64::max)
}

/// The order at which points in free fall come to where continuous time takes them, over four Courant numbers.
fn order_in_fall(spec: &MpmSpec) -> anyhow::Result<f64> {
    let point = |courant: f64| -> anyhow::Result<(f64, f64)> {
        let model = MpmModel::new(MpmSpec { courant, gravity: GRAVITY, ..spec.clone() })?;
        Ok((0.1 / model.substeps(0.1) as f64, fall(&model, 0.0)))
    };
    Ok(regression(&[0.8, 0.4, 0.2, 0.1].map(point).into_iter().collect::<anyhow::Result<Vec<_>>>()?))
}

/// How far momentum and spin of a lump in the air are from what they were, as shares of all that moves.
pub(crate) fn kept(model: &dyn WorldModel) -> (f64, f64) {
    let scene = under(block(5, 1.0, 0.001, 0.1), away());
    let rollout = model.rollout(&scene, &vec![Control { poses: vec![away()] }; 3]);
    let momenta = |x: &Particles| {
        let rows = x.positions.iter().zip(&x.velocities);
        rows.fold((DVec3::ZERO, DVec3::ZERO), |(p, l), (x, v)| (p + *v, l + x.cross(*v)))
    };
    let [(p0, l0), (p1, l1)] = [momenta(&rollout[0]), momenta(&rollout[3])];
    let rows = || rollout[0].positions.iter().zip(&rollout[0].velocities);
    let (speed, turn) = rows().fold((0.0, 0.0), |(a, b), (x, v)| (a + v.length(), b + x.length() * v.length()));
    (p0.distance(p1) / speed, l0.distance(l1) / turn)
}

/// The same of the material point method, whose affine velocities carry spin too, as shares of the momentum and spin of the lump.
fn carried(spec: MpmSpec) -> anyhow::Result<(f64, f64)> {
    let cell = spec.cell;
    let model = MpmModel::new(spec)?;
    let mut lump = block(5, 1.0, 0.001, 0.1);
    let turning = lump.positions.iter().map(|x| DVec3::new(0.5, -0.3, 2.0).cross(*x - DVec3::Z));
    lump.velocities.iter_mut().zip(turning).for_each(|(v, turn)| *v += turn);
    let start = model.encode(&under(lump, away()));
    let control = Control { poses: vec![away()] };
    let end = (0..5).fold(start.clone(), |state, _| model.step(&state, &control));
    let [(p0, l0), (p1, l1)] = [start.momentum(cell), end.momentum(cell)];
    Ok((p0.distance(p1) / p0.length(), l0.distance(l1) / l0.length()))
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let line = |row: &Value| {
        let [value, low, high] = ["value", "low", "high"].map(|key| number(row, key));
        let bound = match (low, high) {
            (low, f64::MAX) => format!("≥ {low}"),
            (0.0, high) if high > 0.0 && high < 0.01 => format!("≤ {high:e}"),
            (0.0, high) => format!("≤ {high}"),
            (low, high) => format!("{low} to {high}"),
        };
        let text = |key: &str| row[key].as_str().unwrap_or("–").to_owned();
        let shown =
            if value == 0.0 || (0.01..1e3).contains(&value) { format!("{value:.2}") } else { format!("{value:.1e}") };
        let claim = verdict((low..=high).contains(&value));
        vec![text("model"), text("what"), shown, bound, claim.to_owned()]
    };
    let claims = rows.iter().map(|row| {
        let [model, what] = ["model", "what"].map(|key| row[key].as_str().unwrap_or("–"));
        let held = (number(row, "low")..=number(row, "high")).contains(&number(row, "value"));
        (format!("{model}, {what}"), Some(held))
    });
    let claims = adjudge("every line within its bound", claims);
    let most = |key: &str| rows.iter().map(|row| number(row, key)).fold(f64::NAN, f64::max);
    let (load, cores) = (most("load"), most("cores"));
    let header = ["model", "what", "measured", "bound", "claim"];
    Ok(Grid {
        title: "The analytical models against what must be true of them".into(),
        header: header.map(String::from).to_vec(),
        rows: rows.iter().map(line).collect(),
        notes: vec![
            "free fall: from the discrete solution of semi-implicit Euler; order: positions of four balls that bounce one on the other, by \
             regression over four substeps"
                .into(),
            "energy: of the same balls, at its greatest, over the most that was ever kinetic; of the material point method, whose transfers \
             damp what is finer than its grid, none is claimed"
                .into(),
            "momentum: without friction between particles, which have no spin to take up what it turns".into(),
            "gradients: of 100 random directions against central differences, through contact, flow and friction, as shares of the \
             difference or of their root mean square, whichever is more"
                .into(),
            "bonds: the model of that name with bonds so brittle that some break; springs: particles whose friction has a tangential spring; \
             differences of both over steps thirty times shorter, because what starts to slide within one bends the cost there"
                .into(),
            format!(
                "two threads: wall time of this machine, the best of several rounds, while up to {load:.0} threads of all programs wanted its \
                 {cores:.0} cores"
            ),
            claims,
        ],
    })
}
