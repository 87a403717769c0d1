//! `pliant`: simulate, fit, compare, sweep, view.
use clap::Parser;
use pliant::compare::{self, CompareSpec, Comparison, Contender, RUNS};
use pliant::config::{self, conclude, to_stdout};
use pliant::data::{DatasetSpec, Info};
use pliant::model::formula;
use pliant::sweep::SweepSpec;
use pliant::table::Grid;
use pliant::view::{Playback, Prediction};
use pliant::watch::Watch;
use std::path::Path;
use std::process::ExitCode;
use verbs::{Cli, DataVerb, Root, Verb};

#[path = "main/verbs.rs"]
mod verbs;

/// Keeps what rollouts free at hand: the system's allocator returns and clears it page by page, up to a fifth of a training step.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

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
        Verb::Plan { config } => {
            let Some(loaded) = config.load::<CompareSpec>()? else { return Ok(()) };
            let mut tell = |step: &_| to_stdout(&(pliant::table::sentence(step) + "\n"));
            let journey = compare::plan(&loaded, watch, &mut tell)?;
            pliant::table::write_journey(&journey, &loaded.resolved.to_toml())?;
            to_stdout(&format!("plan.jsonl, report.html and the episodes are in {}\n", journey.folder.display()))?;
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
    to_stdout(&format!("rows, tables, report.html and gallery.html are in {}\n", comparison.folder.display()))
}
