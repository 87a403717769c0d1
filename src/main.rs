//! `pliant`: simulate, fit, compare, sweep, view.
use clap::{Args, Parser, Subcommand, ValueEnum};
use pliant::compare::{self, CompareSpec, Comparison, Contender, RUNS};
use pliant::config::{self, Loaded, Spec, conclude, to_stdout};
use pliant::data::{DatasetSpec, Info, LAYOUTS, Layout, RECORDINGS, Recording};
use pliant::model::formula::{self, Range};
use pliant::sweep::SweepSpec;
use pliant::table::Grid;
use pliant::view::{Playback, Prediction};
use pliant::watch::Watch;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Keeps what rollouts free at hand: the system's allocator returns and clears it page by page, up to a fifth of a training step.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

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
enum DataVerb {
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
struct Config {
    /// A TOML file.
    path: PathBuf,
    /// Changes to it: `key.path=value`, `+key=value`, `~key`.
    overrides: Vec<String>,
    /// Print the resolved config with where each value came from, and stop.
    #[arg(long)]
    cfg: bool,
}

#[derive(Args)]
struct Alone {
    /// The model, a TOML file such as those of `configs/model`.
    model: PathBuf,
    /// The dataset's folder, simulated or imported.
    data: PathBuf,
    /// Changes to the model: `key.path=value`, `+key=value`, `~key`.
    overrides: Vec<String>,
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
            to_stdout(&loaded.resolved.annotated())?;
            return Ok(None);
        }
        Ok(Some(loaded))
    }
}

fn main() -> ExitCode {
    let watch = Watch::listening();
    conclude(run(Cli::parse().verb, &watch))
}

fn run(verb: Verb, watch: &Watch) -> anyhow::Result<()> {
    match verb {
        Verb::Simulate { config, to } => {
            let Some(loaded) = config.load::<DatasetSpec>()? else { return Ok(()) };
            let folder = to.unwrap_or_else(|| compare::dataset_folder(RUNS.as_ref(), &loaded.spec));
            let dataset = pliant::data::simulate(&loaded.spec, &folder, watch)?;
            config::write_whole(&folder.join("config.toml"), loaded.resolved.to_toml().as_bytes())?;
            to_stdout(&format!("{} episodes in {}\n", dataset.episodes.len(), folder.display()))?;
        }
        Verb::Data { verb } => data(verb)?,
        Verb::Fit { config } => {
            let Some(loaded) = config.load::<CompareSpec>()? else { return Ok(()) };
            let (_, predictions) = compare::fit(&loaded.spec, watch)?;
            to_stdout(&pliant::table::forecast(&predictions).to_text())?;
        }
        Verb::Train(of) => fitted(&compare::train(&of.model, &of.overrides, &of.data, RUNS.as_ref(), watch)?)?,
        Verb::Distil(of) => {
            let (contender, front) = compare::distil(&of.model, &of.overrides, &of.data, RUNS.as_ref(), watch)?;
            to_stdout(&(pliant::table::formulas(&front).to_text() + "\n"))?;
            fitted(&contender)?;
        }
        Verb::Compare { config, json } => {
            let Some(loaded) = config.load::<CompareSpec>()? else { return Ok(()) };
            let comparison = compare::compare(&loaded, &compare::commit(), watch)?;
            let tables = pliant::table::write(&comparison, &loaded.resolved.to_toml())?;
            show(&comparison, &tables, json)?;
        }
        Verb::Sweep { config } => {
            let Some(loaded) = config.load::<SweepSpec>()? else { return Ok(()) };
            let outcome = pliant::sweep::run::<CompareSpec>(&loaded.spec, watch)?;
            to_stdout(&format!("{outcome}\n"))?;
            outcome.complete(watch)?;
        }
        Verb::View { path, to, rrd, model, compare, overrides } => {
            if rrd.is_some() {
                pliant::view::can_write_rrd()?;
            }
            let recording = Playback::open(&path)?;
            let predict = |model: &String| predict(&recording, model, compare.as_deref(), &overrides, watch);
            let prediction = model.as_ref().map(predict).transpose()?;
            let written = match rrd {
                Some(rrd) => recording.write_rrd(prediction.as_ref(), &rrd).map(|()| rrd)?,
                None => recording.write_page(prediction.as_ref(), to.as_deref())?,
            };
            to_stdout(&format!("{}\n", written.display()))?;
        }
        Verb::Formula { text, wrt, ranges } => to_stdout(&formula::explain(&text, &wrt, &ranges)?)?,
        Verb::Schema { of } => {
            let schema = match of {
                Root::Compare => config::schema::<CompareSpec>(),
                Root::Dataset => config::schema::<DatasetSpec>(),
                Root::Sweep => config::schema::<SweepSpec>(),
            };
            to_stdout(&(schema + "\n"))?;
        }
    }
    Ok(())
}

fn data(verb: DataVerb) -> anyhow::Result<()> {
    let text = match verb {
        DataVerb::Info { folder, json } => {
            let info = Info::of(&folder)?;
            if json { serde_json::to_string_pretty(&info)? + "\n" } else { info.to_text() }
        }
        DataVerb::Check { folder } => pliant::data::check(&folder)?.verdict()? + "\n",
        DataVerb::Import { source, to, format } => {
            let dataset = pliant::data::import(&source, format, &to)?;
            format!("{} episodes in {}\n", dataset.episodes.len(), to.display())
        }
        DataVerb::Export { folder, to, format } => {
            let parts = pliant::data::export(&folder, format, &to)?.map(|(name, count)| format!("{count} in {name}"));
            format!("{} of {}\n", parts.join(", "), to.display())
        }
    };
    to_stdout(&text)
}

/// The one of that name, or a sentence with all names.
fn named<T: Copy>(name: &str, table: &[T], of: impl Fn(&T) -> &str) -> Result<T, String> {
    let names = || table.iter().map(&of).collect::<Vec<_>>().join(", ");
    table.iter().find(|one| of(one) == name).copied().ok_or_else(|| format!("there is {}", names()))
}

/// A model of a comparison, or one of a file of its own, fitted to the folder that the recording lies in.
fn predict(
    recording: &Playback,
    model: &str,
    compare: Option<&Path>,
    overrides: &[String],
    watch: &Watch,
) -> anyhow::Result<Prediction> {
    Prediction::of(recording, || match compare {
        Some(config) => compare::fit_named(model, &config::load::<CompareSpec>(config, overrides)?.spec, watch),
        None => {
            let folder = recording.path.parent().unwrap_or_else(|| Path::new(""));
            compare::train(model.as_ref(), overrides, folder, RUNS.as_ref(), watch)
        }
    })
}

fn fitted(contender: &Contender) -> anyhow::Result<()> {
    to_stdout(&pliant::table::forecast(compare::Prediction::of(contender).as_slice()).to_text())?;
    contender.stages.iter().try_for_each(|(stage, at)| to_stdout(&format!("{stage}: {}\n", at.display())))
}

fn show(comparison: &Comparison, tables: &[Grid], json: bool) -> anyhow::Result<()> {
    if json {
        return to_stdout(&compare::to_jsonl(&comparison.rows()));
    }
    tables.iter().try_for_each(|table| to_stdout(&(table.to_text() + "\n")))?;
    to_stdout(&format!("rows, tables and report.html are in {}\n", comparison.folder.display()))
}
