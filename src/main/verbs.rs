//! What may be said on the command line.
use clap::{Args, Parser, Subcommand, ValueEnum};
use pliant::config::{self, Loaded, Spec, to_stdout};
use pliant::data::{LAYOUTS, Layout, RECORDINGS, Recording};
use pliant::model::formula::Range;
use std::path::PathBuf;

/// Structured world models of deformable things: written, learned and hybrid models under one planner.
#[derive(Parser)]
#[command(version)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

#[derive(Subcommand)]
pub(crate) enum Verb {
    /// Draw a dataset of random tool actions from the world.
    Simulate {
        #[command(flatten)]
        config: Config,
        /// Folder to write to; by default one named by the config's fingerprint.
        #[arg(long)]
        to: Option<PathBuf>,
    },
    /// Look into, check and convert folders of episodes.
    Data {
        #[command(subcommand)]
        verb: DataVerb,
    },
    /// Simulate and fit every model of a comparison, then print how well each predicts.
    Fit {
        #[command(flatten)]
        config: Config,
    },
    /// Fit one model to a folder of episodes, then print how well it predicts those held out.
    #[command(visible_alias = "identify")]
    Train(Alone),
    /// Read what a learned pair law says as formulas, and write the model that has them in its place.
    Distil(Alone),
    /// From nothing to the comparison table: simulate, fit, plan with every model, execute in the world.
    Compare {
        #[command(flatten)]
        config: Config,
        /// Print the rows as JSON lines instead of the table.
        #[arg(long)]
        json: bool,
    },
    /// Work at one goal action by action: the first model, planner, goal and seed of a comparison.
    Plan {
        #[command(flatten)]
        config: Config,
    },
    /// Run a comparison for every point of a grid or list of changes.
    Sweep {
        #[command(flatten)]
        config: Config,
    },
    /// Write one HTML page that plays an episode in a browser.
    View {
        /// An episode's `.npz`; the `dataset.toml` beside it tells the tool's shape.
        path: PathBuf,
        /// The page; by default beside the episode.
        #[arg(long)]
        to: Option<PathBuf>,
        /// Write a recording for the Rerun viewer instead; needs the Cargo feature `rerun`.
        #[arg(long, value_name = "FILE", conflicts_with = "to")]
        rrd: Option<PathBuf>,
        /// A model whose prediction is drawn over what happened: one of the comparison, or a TOML file, fitted to the folder.
        #[arg(long)]
        model: Option<String>,
        /// The comparison whose model it is.
        #[arg(long, value_name = "CONFIG", requires = "model")]
        compare: Option<PathBuf>,
        /// Changes to the comparison or to the model: `key.path=value`, `+key=value`, `~key`.
        #[arg(requires = "model")]
        overrides: Vec<String>,
    },
    /// Differentiate and simplify a formula as a law's config writes it, and count its operations.
    Formula {
        /// Such as `k/2.5 * max(0, d - r)^2.5`.
        #[arg(allow_hyphen_values = true)]
        text: String,
        /// The name to differentiate by.
        #[arg(long)]
        wrt: String,
        /// Where a name lies: `r=0..0.02`, `r=0..`, or `k=5e4` for a constant; any number where nothing is said.
        #[arg(long = "range")]
        ranges: Vec<Range>,
    },
    /// Print the JSON schema of a config file.
    Schema {
        /// Which kind of config.
        #[arg(default_value = "compare")]
        of: Root,
    },
}

#[derive(Subcommand)]
pub(crate) enum DataVerb {
    /// Counts, ranges, scales and a histogram of the motion.
    Info {
        /// The dataset's folder.
        folder: PathBuf,
        /// Print JSON instead of a page.
        #[arg(long)]
        json: bool,
    },
    /// Make a dataset of others' recordings.
    Import {
        /// A file or a folder of files.
        source: PathBuf,
        /// Folder to write to, a new one.
        #[arg(long)]
        to: PathBuf,
        /// What the files are.
        #[arg(long, value_parser = |name: &str| named(name, RECORDINGS, |one| one.name()))]
        format: &'static dyn Recording,
    },
    /// Write a dataset as another framework reads it.
    Export {
        /// The dataset's folder.
        folder: PathBuf,
        /// Folder to write to.
        #[arg(long)]
        to: PathBuf,
        /// What to write.
        #[arg(long, value_parser = |name: &str| named(name, LAYOUTS, |one| one.name()))]
        format: &'static dyn Layout,
    },
    /// Compare every file with its hash, read every episode, and compare the metadata with both.
    Check {
        /// The dataset's folder.
        folder: PathBuf,
    },
}

#[derive(Args)]
pub(crate) struct Config {
    /// A TOML file.
    pub(crate) path: PathBuf,
    /// Changes to it: `key.path=value`, `+key=value`, `~key`.
    pub(crate) overrides: Vec<String>,
    /// Print the resolved config with where each value came from, and stop.
    #[arg(long)]
    pub(crate) cfg: bool,
}

#[derive(Args)]
pub(crate) struct Alone {
    /// The model, a TOML file such as those of `configs/model`.
    pub(crate) model: PathBuf,
    /// The dataset's folder, simulated or imported.
    pub(crate) data: PathBuf,
    /// Changes to the model: `key.path=value`, `+key=value`, `~key`.
    pub(crate) overrides: Vec<String>,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Root {
    Compare,
    Dataset,
    Sweep,
}

impl Config {
    /// The loaded config, or `None` after printing it where only that was asked.
    pub(crate) fn load<T: Spec>(&self) -> anyhow::Result<Option<Loaded<T>>> {
        let loaded = config::load(&self.path, &self.overrides)?;
        if self.cfg {
            to_stdout(&loaded.resolved.annotated())?;
            return Ok(None);
        }
        Ok(Some(loaded))
    }
}

/// The one of that name, or a sentence with all names.
fn named<T: Copy>(name: &str, table: &[T], of: impl Fn(&T) -> &str) -> Result<T, String> {
    let names = || table.iter().map(&of).collect::<Vec<_>>().join(", ");
    table.iter().find(|one| of(one) == name).copied().ok_or_else(|| format!("there is {}", names()))
}
