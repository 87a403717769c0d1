//! Claim: every scene and every tool moves its material, a particle by a millimetre at least, with nothing a millimetre into the table and
//! no number that is none.
//!
//! Command: `cargo run --release --bin experiments -- world`, about two minutes. Table: `paper/tables/world.tex`; contact sheet:
//! `paper/figures/world.png`, five frames of each recorded action.
use crate::adjudge::adjudge;
use crate::claim::{Experiment, Rows, Size, number};
use crate::film::film;
use pliant::config::{self, write_whole};
use pliant::data::{DatasetSpec, Episode, record};
use pliant::table::{Grid, sheet};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "world",
    claim: "every scene and tool moves its material, and nothing falls through the table or stops being a number",
    duration: "about 2 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// What a particle must move by, and what the table may give \[m\].
const MILLIMETRE: f64 = 1e-3;

fn measure(size: Size, out: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let load = |name: &str, changes: &[String]| -> anyhow::Result<DatasetSpec> {
        let path = format!("configs/dataset/{name}.toml");
        Ok(config::load::<DatasetSpec>(path.as_ref(), changes)?.spec)
    };
    let scenes = ["dough", "rice_grip", "poke", "pile_push", "slide", "fluid_fall", "box_bath", "fluid_shake"];
    let mut wanted = Vec::new();
    for scene in scenes {
        wanted.push(("scene", scene.to_owned(), load(scene, &[])?));
    }
    for tool in config::stems("configs/tool".as_ref()) {
        let spec = load("dough", &[format!("tool=[{tool}]"), "before=0".into()])?;
        wanted.push(("tool", tool, spec));
    }
    wanted.truncate(match size {
        Size::Paper => wanted.len(),
        Size::Smoke => 2,
    });
    let bar = watch.stage("record", wanted.len() as u64);
    let (mut rows, mut strips) = (Vec::new(), Vec::new());
    for (what, name, spec) in wanted {
        watch.go_on(|| "stopped; the contact sheet is written once all is recorded".into())?;
        let clock = Instant::now();
        let episode = record(&spec, 0)?;
        rows.push(row(what, &name, &episode, clock.elapsed().as_secs_f64()));
        let tool = spec.tool[&episode.tool].clone().build()?;
        strips.push(film(&format!("{what} {name}: {}", episode.tool), &episode, tool.shape(), &episode.states));
        bar.inc(1);
    }
    bar.finish_and_clear();
    write_whole(&out.join("figures/world.png"), &sheet(&strips)?)?;
    Ok(rows)
}

fn row(what: &str, name: &str, episode: &Episode, seconds: f64) -> Value {
    let (first, last) = (&episode.states[0], episode.states.last().expect("a state after every control"));
    let moves = first.positions.iter().zip(&last.positions).map(|(a, b)| a.distance(*b));
    let lowest = episode.states.iter().flat_map(|x| &x.positions).map(|p| p.z).fold(f64::INFINITY, f64::min);
    json!({ "what": what, "name": name, "tool": episode.tool, "particles": first.len(), "steps": episode.horizon(),
        "farthest": moves.clone().fold(0.0, f64::max), "mean": moves.sum::<f64>() / first.len() as f64, "lowest": lowest,
        "finite": episode.states.iter().all(|x| x.is_finite()), "seconds": seconds })
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let text = |row: &Value, key: &str| row[key].as_str().unwrap_or("–").to_owned();
    let line = |row: &Value| {
        let mut cells = vec![text(row, "what"), text(row, "name"), text(row, "tool")];
        cells.push(format!("{}", number(row, "particles")));
        cells.extend(["mean", "farthest", "lowest"].map(|key| format!("{:.1}", 1e3 * number(row, key))));
        cells.push(if row["finite"] == true { "yes".into() } else { "no".into() });
        cells
    };
    let whole = |row: &Value| {
        number(row, "farthest") >= MILLIMETRE && number(row, "lowest") >= -MILLIMETRE && row["finite"] == true
    };
    let claims = rows.iter().map(|row| (text(row, "name"), Some(whole(row))));
    let header = ["what", "name", "tool", "particles", "moved [mm]", "farthest [mm]", "lowest [mm]", "finite"];
    Ok(Grid {
        title: "The world: one random action of every scene and tool".into(),
        header: header.map(String::from).to_vec(),
        rows: rows.iter().map(line).collect(),
        notes: vec![
            "the first episode of each dataset, and of dough with each tool; figures/world.png shows them".into(),
            adjudge("all moves, nothing lies a millimetre into the table, all is finite", claims),
        ],
    })
}
