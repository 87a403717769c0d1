//! `pliant`: simulate, fit, compare, sweep.
use anyhow::Context;
use clap::{Args, Parser, Subcommand, ValueEnum};
use pliant::compare::{CompareSpec, Comparison};
use pliant::config::{self, ConfigError, Loaded, Spec};
use pliant::data::DatasetSpec;
use pliant::sweep::SweepSpec;
use pliant::table::Grid;
use pliant::watch::Watch;
use std::path::PathBuf;
use std::process::ExitCode;

/// Structured world models of deformable things: written, learned and hybrid models under one planner.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Draw a dataset of random tool actions from the world.
    Simulate {
        #[command(flatten)]
        config: Config,
        /// Folder to write to; by default one named by the config's fingerprint.
        #[arg(long)]
        to: Option<PathBuf>,
    },
    /// Simulate and fit every model of a comparison, then print how well each predicts.
    Fit {
        #[command(flatten)]
        config: Config,
    },
    /// From nothing to the comparison table: simulate, fit, plan with every model, execute in the world.
    Compare {
        #[command(flatten)]
        config: Config,
        /// Print the rows as JSON lines instead of the table.
        #[arg(long)]
        json: bool,
    },
    /// Run a comparison for every point of a grid or list of changes.
    Sweep {
        #[command(flatten)]
        config: Config,
    },
    /// Print the JSON schema of a config file.
    Schema {
        /// Which kind of config.
        #[arg(default_value = "compare")]
        of: Root,
    },
}

#[derive(Args)]
struct Config {
    /// A TOML file.
    path: PathBuf,
    /// Changes to it: `key.path=value`, `+key=value`, `~key`.
    overrides: Vec<String>,
    /// Print the resolved config with where each value came from, and stop.
    #[arg(long)]
    cfg: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Root {
    Compare,
    Dataset,
    Sweep,
}

impl Config {
    /// The loaded config, or `None` after printing it where only that was asked.
    fn load<T: Spec>(&self) -> anyhow::Result<Option<Loaded<T>>> {
        let loaded = config::load(&self.path, &self.overrides)?;
        if self.cfg {
            print!("{}", loaded.resolved.annotated());
            return Ok(None);
        }
        Ok(Some(loaded))
    }
}

fn main() -> ExitCode {
    let watch = Watch::visible();
    let stop = watch.clone();
    // Without a handler Ctrl-C merely ends the run, which resumes from its last checkpoint all the same.
    let _ = ctrlc::set_handler(move || {
        if stop.stopped() {
            std::process::exit(130);
        }
        eprintln!("stopping after saving; press Ctrl-C again to stop at once");
        stop.stop();
    });
    match run(Cli::parse().verb, &watch) {
        Ok(()) if watch.stopped() => ExitCode::from(130),
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if watch.stopped() => {
            eprintln!("{error:#}");
            ExitCode::from(130)
        }
        Err(error) => {
            match error.downcast::<ConfigError>() {
                Ok(config) => eprint!("{}", config.graphical()),
                Err(error) => eprintln!("error: {error:#}"),
            }
            ExitCode::from(2)
        }
    }
}

fn run(verb: Verb, watch: &Watch) -> anyhow::Result<()> {
    match verb {
        Verb::Simulate { config, to } => {
            let Some(loaded) = config.load::<DatasetSpec>()? else { return Ok(()) };
            let folder = to.unwrap_or_else(|| pliant::compare::dataset_folder(&PathBuf::from("runs"), &loaded.spec));
            let dataset = pliant::data::simulate(&loaded.spec, &folder, watch)?;
            config::write_whole(&folder.join("config.toml"), loaded.resolved.to_toml().as_bytes())?;
            println!("{} episodes in {}", dataset.episodes.len(), folder.display());
        }
        Verb::Fit { config } => {
            let Some(loaded) = config.load::<CompareSpec>()? else { return Ok(()) };
            let (_, predictions) = pliant::compare::fit(&loaded.spec, watch)?;
            print!("{}", pliant::table::forecast(&predictions).to_text());
        }
        Verb::Compare { config, json } => {
            let Some(loaded) = config.load::<CompareSpec>()? else { return Ok(()) };
            let comparison = pliant::compare::compare(&loaded, &commit(), watch)?;
            let tables = pliant::table::write(&comparison, &loaded.resolved.to_toml())?;
            print(&comparison, &tables, json);
        }
        Verb::Sweep { config } => {
            let Some(loaded) = config.load::<SweepSpec>()? else { return Ok(()) };
            let outcome = pliant::sweep::run::<CompareSpec>(&loaded.spec, watch)?;
            println!("{} trials done in {}", outcome.done, outcome.folder.display());
            let failed: Vec<_> = outcome.failed.iter().map(|f| f.join("failure.json").display().to_string()).collect();
            anyhow::ensure!(failed.is_empty(), "{} trials failed, see {}", failed.len(), failed.join(", "));
        }
        Verb::Schema { of } => println!(
            "{}",
            match of {
                Root::Compare => config::schema::<CompareSpec>(),
                Root::Dataset => config::schema::<DatasetSpec>(),
                Root::Sweep => config::schema::<SweepSpec>(),
            }
        ),
    }
    Ok(())
}

fn print(comparison: &Comparison, tables: &[Grid], json: bool) {
    if json {
        print!("{}", pliant::compare::to_jsonl(&comparison.rows()));
        return;
    }
    tables.iter().for_each(|table| println!("{}", table.to_text()));
    println!("rows, tables and report.html are in {}", comparison.folder.display());
}

/// The commit of the checkout that runs, empty outside one.
fn commit() -> String {
    let git = |words: &[&str]| {
        let output = std::process::Command::new("git").args(words).output().context("git")?;
        anyhow::ensure!(output.status.success(), "not a checkout");
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    git(&["describe", "--always", "--dirty", "--exclude=*"]).unwrap_or_default()
}
