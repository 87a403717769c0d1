//! Makes a dataset: random actions of each tool from random starts.
use super::dataset::{DatasetSpec, SPEC, episode_path, read_episodes, read_spec, tools};
use super::sums::write_sums;
use super::{Dataset, Episode, Metadata};
use crate::config::{hold, write_whole};
use crate::state::{Particles, stream};
use crate::tool::{Motion, Tool, Workpiece};
use crate::watch::Watch;
use crate::world::World;
use anyhow::{Context, ensure};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::path::Path;

/// Fills `folder` with the episodes of `spec`, in parallel, and reads them back.
///
/// Episodes that are there already are kept; each file is written whole, so a killed run goes on where it stopped, and the
/// bytes depend on `spec` alone.
///
/// # Errors
/// When the spec is impossible, the folder was made from another spec, a file cannot be written, the world fails, or `watch`
/// asks to stop.
pub fn simulate(spec: &DatasetSpec, folder: &Path, watch: &Watch) -> anyhow::Result<Dataset> {
    spec.check()?;
    let shapes = tools(spec)?;
    claim(spec, folder)?;
    let _held = hold(folder)?;
    let missing: Vec<usize> =
        (0..spec.episodes).into_par_iter().filter(|k| Episode::read(&episode_path(folder, *k), "").is_err()).collect();
    let bar = watch.stage("simulate episodes", spec.episodes as u64);
    bar.set_position((spec.episodes - missing.len()) as u64);
    // What an earlier run made would count as done in no time.
    bar.reset_eta();
    let make = |k: usize| -> anyhow::Result<()> {
        if !watch.stopped() {
            record(spec, k).and_then(|episode| episode.write(&episode_path(folder, k)))?;
            bar.inc(1);
        }
        Ok(())
    };
    missing.into_par_iter().try_for_each(make)?;
    bar.finish_and_clear();
    watch.go_on(|| {
        format!("stopped with the episodes in {} unfinished; the same command goes on there", folder.display())
    })?;
    let episodes = read_episodes(folder, spec)?;
    let metadata = Metadata::describe(spec, &episodes)?;
    metadata.write(folder)?;
    write_sums(folder, &metadata.files())?;
    sweep(folder)?;
    Ok(Dataset { episodes, tools: shapes, metadata })
}

/// Episode `k` of `spec`, the same whether made alone or among many; positions are float32 numbers.
///
/// # Errors
/// When the tool or the world cannot be built, or the world produces a number that is not finite.
pub fn record(spec: &DatasetSpec, k: usize) -> anyhow::Result<Episode> {
    let mut rng = stream(spec.seed, &[u64::from_le_bytes(*b"episodes"), k as u64]);
    let mut world = World::new(&spec.scene_of(k)?, rng.random())?;
    let names = || spec.tool.keys();
    for _ in 0..rng.random_range(0..=spec.before) {
        let name = names().nth(rng.random_range(0..spec.tool.len())).expect("a number below their count");
        let tool = spec.tool[name].clone().build()?;
        let (_, motion) = random_action(tool.as_ref(), &world.particles(), spec.steps, &mut rng);
        world.execute(tool.shape(), &motion);
    }
    let name = spec.tool_of(k).to_owned();
    let tool = spec.tool[&name].clone().build()?;
    let (theta, motion) = random_action(tool.as_ref(), &world.particles(), spec.steps, &mut rng);
    let interval = world.interval();
    let rollout = world.execute(tool.shape(), &motion);
    ensure!(
        rollout.iter().all(Particles::is_finite),
        "the world failed in episode {k}, after `{name}` {theta:?}; choose other material constants or another seed"
    );
    let rounded = |x: &Particles| x.positions.iter().map(|p| p.as_vec3().as_dvec3()).collect();
    let states = super::episode::states(rollout.iter().map(rounded).collect(), interval);
    let body = world.pieces().into_iter().map(|piece| piece as u32).collect();
    let (walls, controls) = (world.walls().into(), motion.controls);
    let (start, constants) = (motion.start, spec.constants_of(k).into());
    Ok(Episode { tool: name, theta, interval, start, controls, states, body, walls, constants })
}

/// A uniformly random action of `tool` on `particles`, in `steps` control steps: θ and its path.
pub fn random_action(tool: &dyn Tool, particles: &Particles, steps: usize, rng: &mut ChaCha8Rng) -> (Vec<f64>, Motion) {
    let piece = Workpiece::around(particles);
    let space = tool.space(&piece);
    let unit: Vec<f64> = (0..space.dimension()).map(|_| rng.random()).collect();
    let mut theta = space.at(&unit);
    // Rounding may carry the upper end a bit too far.
    space.clamp(&mut theta);
    let motion = tool.motion(&theta, &piece, steps);
    (theta, motion)
}

/// Makes `folder` the place of `spec`, unless another spec was there first.
fn claim(spec: &DatasetSpec, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let text = toml_edit::ser::to_string_pretty(spec).context("the dataset's spec cannot be written as TOML")?;
    match read_spec(folder)? {
        Some(there) if there == *spec => return Ok(()),
        // Another split of the same episodes.
        Some(there) => ensure!(
            DatasetSpec { split: spec.split.clone(), ..there } == *spec,
            "{} was made from another spec; remove the folder or simulate into another one",
            folder.display()
        ),
        None => {
            let strange =
                std::fs::read_dir(folder)?.flatten().any(|e| e.path().extension().is_some_and(|x| x == "npz"));
            ensure!(!strange, "{} holds .npz files but no {SPEC}; simulate into another folder", folder.display());
        }
    }
    write_whole(&folder.join(SPEC), text.as_bytes())
}

/// Removes what a killed run left half written.
fn sweep(folder: &Path) -> anyhow::Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))? {
        let entry = entry?;
        let path = entry.path();
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(".episode_") && name.ends_with(".tmp") {
            std::fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
        }
    }
    Ok(())
}
