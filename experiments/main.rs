//! `experiments`: the claims of the paper, each with the command that tests it and the table it feeds.
use anyhow::Context;
use claim::Experiment;
use clap::{Parser, Subcommand};
use pliant::config::{conclude, to_stdout};
use pliant::watch::Watch;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

mod adjudge;
mod aggregation;
mod box_bath;
mod claim;
mod closed_loop;
mod collisions;
mod control_rate;
mod cpu;
mod distil;
mod disturbances;
mod edge_types;
mod endurance;
mod film;
mod formula;
mod generalise;
mod gradient_quality;
mod gradients;
mod hierarchy;
mod horizon;
mod hybrid;
mod identify;
mod letters;
mod lump;
mod materials;
mod menu;
mod metrics;
mod mpm_speed;
mod network_speed;
mod noise;
mod peer;
mod physics;
mod planners;
mod planning_speed;
mod policy;
mod quickstart;
mod radius;
mod random_graph;
mod recovery;
mod remembering;
mod rollouts;
mod rounding;
mod rounds;
mod samples;
mod scaling;
mod slopes;
mod speaking;
mod speed;
mod stack;
mod tasks;
mod tool_choice;
mod transfer;
mod world;

/// Keeps what rollouts free at hand: the system's allocator returns and clears it page by page, up to a fifth of a training step.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Every claim. A new one is one file here and one line.
const EXPERIMENTS: &[Experiment] = &[
    quickstart::CLAIM,
    edge_types::CLAIM,
    hybrid::CLAIM,
    generalise::CLAIM,
    samples::CLAIM,
    closed_loop::CLAIM,
    disturbances::CLAIM,
    letters::CLAIM,
    tasks::CLAIM,
    hierarchy::CLAIM,
    aggregation::CLAIM,
    rounds::CLAIM,
    radius::CLAIM,
    noise::CLAIM,
    horizon::CLAIM,
    menu::CLAIM,
    box_bath::CLAIM,
    world::CLAIM,
    rollouts::CLAIM,
    endurance::CLAIM,
    speed::CLAIM,
    network_speed::CLAIM,
    planning_speed::CLAIM,
    rounding::CLAIM,
    control_rate::CLAIM,
    scaling::CLAIM,
    metrics::CLAIM,
    formula::CLAIM,
    identify::CLAIM,
    distil::CLAIM,
    physics::CLAIM,
    gradient_quality::CLAIM,
    policy::CLAIM,
    planners::CLAIM,
    gradients::CLAIM,
    materials::CLAIM,
    tool_choice::CLAIM,
    mpm_speed::CLAIM,
];

/// The claims of the paper.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Print every claim, its command, its duration and its table.
    List,
    /// Check that every committed table is what its committed rows give.
    Check,
    /// Write every table that the committed rows give.
    Tables,
    /// Run one experiment by its name.
    #[command(external_subcommand)]
    Run(Vec<String>),
}

fn main() -> ExitCode {
    conclude(run(Cli::parse().verb, &Watch::listening()))
}

fn run(verb: Verb, watch: &Watch) -> anyhow::Result<()> {
    match verb {
        Verb::List => EXPERIMENTS.iter().try_for_each(|e| to_stdout(&format!("{e}\n")))?,
        Verb::Check => EXPERIMENTS.iter().try_for_each(|e| e.check(Path::new("paper")))?,
        Verb::Tables => EXPERIMENTS.iter().try_for_each(|e| e.tabulate(Path::new("paper")))?,
        Verb::Run(words) => {
            let (name, overrides) = words.split_first().context("which experiment? `experiments list` names them")?;
            let names = || EXPERIMENTS.iter().map(|e| e.name).collect::<Vec<_>>().join(", ");
            let found = EXPERIMENTS.iter().find(|e| e.name == name);
            let experiment =
                found.with_context(|| format!("no experiment is called {name:?}; there are {}", names()))?;
            let (flags, overrides): (Vec<_>, Vec<_>) = overrides.iter().cloned().partition(|w| w == "--smoke");
            let size = if flags.is_empty() { claim::Size::Paper } else { claim::Size::Smoke };
            let out = if flags.is_empty() { PathBuf::from("paper") } else { PathBuf::from("runs/smoke") };
            let grid = experiment.run(size, &overrides, &out, watch)?;
            to_stdout(&grid.to_text())?;
        }
    }
    Ok(())
}
