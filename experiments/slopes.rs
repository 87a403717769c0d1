//! Gradients of the analytical models against central differences, what they cost, and what a second thread gains.
use crate::claim::median;
use crate::cpu::cpu_seconds;
use crate::lump::{Direction, Spread, pressed};
use crate::physics::built;
use anyhow::{Context, ensure};
use pliant::model::{Cost, WorldModel};
use pliant::state::stream;
use pliant::tool::Motion;
use pliant::train::{replace, value};
use rand::Rng;
use serde_json::Value;
use std::time::Instant;

/// Steps of differences: small against the lengths over which a contact changes, large against rounding.
pub(crate) const STEP: f64 = 2e-9;
/// The same of the logarithm of a constant.
pub(crate) const RELATIVE: f64 = 5e-7;

/// The errors of pairs (exact, difference), over the difference or the typical one, whichever is more.
fn errors(pairs: &[(f64, f64)]) -> Vec<f64> {
    let typical = (pairs.iter().map(|(_, d)| d * d).sum::<f64>() / pairs.len() as f64).sqrt();
    pairs.iter().map(|(exact, d)| (exact - d).abs() / d.abs().max(typical)).collect()
}

/// Errors of the gradient along random directions, by the scene's state, by its controls, or by both, against differences of this step.
pub(crate) fn slopes(
    model: &dyn WorldModel,
    directions: usize,
    [state, control]: [f64; 2],
    step: f64,
) -> anyhow::Result<Vec<f64>> {
    let problem = pressed(4, 5, 0.022);
    let gradient = model.gradient(&problem.0, &problem.1, &Spread).context("the model has lost its adjoint")?;
    let mut rng = stream(7, &[u64::from_le_bytes(*b"slopes\0\0")]);
    let pair = |_| {
        let direction = Direction::random(&mut rng, &problem, state, control);
        let cost = |h: f64| {
            let (scene, controls) = direction.moved(&problem, h);
            Spread.total(&model.rollout(&scene, &controls))
        };
        (direction.along(&gradient), (cost(step) - cost(-step)) / (2.0 * step))
    };
    Ok(errors(&(0..directions).map(pair).collect::<Vec<_>>()))
}

/// Errors of the derivatives along random directions in the logarithms of all constants, against differences of this step.
pub(crate) fn constants(model: &Value, directions: usize, step: f64) -> anyhow::Result<Vec<f64>> {
    let (scene, controls) = pressed(4, 5, 0.022);
    let at_model = built(model)?;
    let paths = at_model.constants();
    let gradient = at_model.constant_gradient(&scene, &controls, &Spread, controls.len());
    let gradient = gradient.context("the model has lost its adjoint")?.constants;
    let values = paths.iter().map(|path| value(model, path)).collect::<anyhow::Result<Vec<_>>>()?;
    let mut rng = stream(8, &[u64::from_le_bytes(*b"slopes\0\0")]);
    let pair = |_| -> anyhow::Result<(f64, f64)> {
        let along: Vec<f64> = paths.iter().map(|_| rng.random_range(-1.0..1.0)).collect();
        let cost = |h: f64| -> anyhow::Result<f64> {
            let moved = paths.iter().zip(&values).zip(&along).map(|((path, x), d)| (path.as_str(), x * (1.0 + h * d)));
            Ok(Spread.total(&built(&replace(model, moved)?)?.rollout(&scene, &controls)))
        };
        let exact = gradient.iter().zip(&values).zip(&along).map(|((g, x), d)| g * x * d).sum();
        Ok((exact, (cost(step)? - cost(-step)?) / (2.0 * step)))
    };
    Ok(errors(&(0..directions).map(pair).collect::<anyhow::Result<Vec<_>>>()?))
}

/// CPU time of a gradient over that of a rollout, the median of `rounds`.
pub(crate) fn price(model: &dyn WorldModel, rounds: usize) -> anyhow::Result<f64> {
    let (scene, controls) = pressed(6, 10, 0.02);
    let round = |_| -> anyhow::Result<f64> {
        let clock = cpu_seconds()?;
        let rollout = model.rollout(&scene, &controls);
        let forward = cpu_seconds()? - clock;
        let clock = cpu_seconds()?;
        let gradient = model.gradient(&scene, &controls, &Spread).context("the model has lost its adjoint")?;
        let both = cpu_seconds()? - clock;
        let apart = (gradient.cost - Spread.total(&rollout)).abs();
        ensure!(apart <= 1e-9 * gradient.cost, "the sweep's cost is another");
        Ok(both / forward)
    };
    Ok(median((0..rounds).map(round).collect::<anyhow::Result<Vec<_>>>()?))
}

/// Wall time of eight rollouts at once on one thread over that on two, each the best of `rounds` that take turns.
pub(crate) fn gain(model: &dyn WorldModel, rounds: usize) -> anyhow::Result<f64> {
    let (scene, controls) = pressed(6, 10, 0.02);
    let motions = vec![Motion { start: scene.poses.clone(), controls }; 8];
    let pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let (pools, mut best) = ([pool(1)?, pool(2)?], [f64::INFINITY; 2]);
    for _ in 0..rounds {
        for (pool, best) in pools.iter().zip(&mut best) {
            let clock = Instant::now();
            std::hint::black_box(pool.install(|| model.rollouts(&scene, &motions)));
            *best = best.min(clock.elapsed().as_secs_f64());
        }
    }
    Ok(best[0] / best[1])
}
