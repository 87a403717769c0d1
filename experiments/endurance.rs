//! Claim: a thousand random actions of all tools leave every kind of material whole (and two hundred every other preset): nothing
//! explodes, nothing falls through the table, and what leaves the workspace is counted.
//!
//! Command: `cargo run --release --bin experiments -- endurance`, about 45 minutes; stopped, it goes on with the materials that it has
//! not finished, found under `runs/endurance`. Table: `paper/tables/endurance.tex`.
use crate::adjudge::adjudge;
use crate::claim::{Experiment, Rows, Size, number, read};
use anyhow::{Context, ensure};
use pliant::config;
use pliant::data::{DatasetSpec, random_action};
use pliant::state::stream;
use pliant::table::Grid;
use pliant::tool::{Tool, ToolSpec};
use pliant::watch::Watch;
use pliant::world::{SceneSpec, World};
use rand::Rng;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "endurance",
    claim: "a thousand random actions a kind of material: nothing explodes, falls through the table or leaves uncounted",
    duration: "about 45 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// Every material. The least height is half a radius into the table, where the particles of grains are their middles; what
/// takes longest comes last.
const CASES: &[Case] = &[
    ("beans", 200, "pile", &["scene.particles=40"], 0.00175),
    ("rice", 40, "pile", &["scene.particles=40"], 0.00075),
    ("granola", 40, "pile", &["scene.particles=40"], 0.0005),
    ("carrots", 40, "pile", &["scene.particles=40"], 0.002),
    ("candy", 40, "pile", &["scene.particles=40"], 0.002),
    ("wood", 200, "slide", &[], -0.0025),
    ("water", 200, "fluid_shake", &["scene.walls={x=[-0.08,0.08],y=[-0.08,0.08]}"], -0.0025),
    ("dough", 200, "dough", &[], -0.00125),
    ("play_doh", 40, "dough", &[], -0.00125),
    ("clay", 40, "dough", &[], -0.00125),
];
/// Actions on one start before the next is drawn.
const ACTIONS: usize = 5;
/// Control steps of an action.
const STEPS: usize = 15;
/// Half width of the workspace around the middle of the table \[m\].
const WORKSPACE: f64 = 0.25;
/// A particle faster than this has not been pushed but thrown \[m/s\]; tools move at 0.2 m/s, a fall of 20 cm ends at 2 m/s.
const THROWN: f64 = 2.0;

/// A material with the number of its episodes, a scene to put it in, what the scene changes, and the least height allowed \[m\].
type Case = (&'static str, u64, &'static str, &'static [&'static str], f64);

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (cases, most) = match size {
        Size::Paper => (CASES, u64::MAX),
        Size::Smoke => (&CASES[..1], 2),
    };
    cases.iter().map(|case| kept_or_made(case, most.min(case.1), watch)).collect()
}

/// The row of one material, made unless the same was made before.
fn kept_or_made(case: &Case, episodes: u64, watch: &Watch) -> anyhow::Result<Value> {
    let (material, _, scene, changes, least) = case;
    let tools = format!("tool=[{}]", config::stems("configs/tool".as_ref()).join(","));
    let own = [format!("scene={scene}"), format!("scene.material={material}"), tools];
    let changes: Vec<String> = own.into_iter().chain(changes.iter().map(|c| (*c).to_owned())).collect();
    let spec = config::load::<DatasetSpec>("configs/dataset/dough.toml".as_ref(), &changes)?.spec;
    let mark = config::fingerprint(&(&spec, episodes, ACTIONS, STEPS, WORKSPACE));
    let path = PathBuf::from(format!("runs/endurance/{material}-{mark}.json"));
    if !path.exists() {
        let row = endure(material, &spec, episodes, watch)?;
        config::write_whole(&path, row.to_string().as_bytes())?;
    }
    let row = serde_json::from_str::<Value>(&read(&path)?);
    let mut row = row.with_context(|| format!("{} holds no row; remove it", path.display()))?;
    (row["material"], row["scene"], row["least"]) = (json!(material), json!(scene), json!(least));
    Ok(row)
}

fn endure(material: &str, spec: &DatasetSpec, episodes: u64, watch: &Watch) -> anyhow::Result<Value> {
    let built = |(name, tool): (&String, &ToolSpec)| Ok((name.clone(), tool.clone().build()?));
    let tools = spec.tool.iter().map(built).collect::<anyhow::Result<Vec<_>>>()?;
    let bar = watch.stage(material, episodes);
    let clock = Instant::now();
    let worked = (0..episodes).into_par_iter().map(|k| {
        watch.go_on(|| "stopped; finished materials are kept, the same command goes on".into())?;
        let marks = Marks::of(&spec.scene, &tools, k);
        bar.inc(1);
        marks
    });
    let all = worked.try_reduce(Marks::default, |a, b| Ok(a.and(b)))?;
    bar.finish_and_clear();
    ensure!(all.actions > 0, "{material}: no action was executed");
    Ok(json!({ "tools": tools.len(), "actions": all.actions, "not_finite": all.not_finite,
        "lowest": all.lowest.0, "lowest_by": all.lowest.1, "fastest": all.fastest.0, "fastest_by": all.fastest.1,
        "left": all.left, "particles": all.particles, "least_volume": all.volume[0],
        "greatest_volume": all.volume[1], "seconds": clock.elapsed().as_secs_f64() }))
}

/// What happened to the particles of some episodes.
struct Marks {
    actions: usize,
    particles: usize,
    /// Actions after which a number was none.
    not_finite: usize,
    /// Particles that were outside of the workspace at an episode's end.
    left: usize,
    /// The least height of a particle, and the tool then in hand.
    lowest: (f64, String),
    /// The greatest speed of a particle, and the tool then in hand.
    fastest: (f64, String),
    /// Least and greatest share of the volume, at rest after an action.
    volume: [f64; 2],
}

impl Default for Marks {
    fn default() -> Self {
        let volume = [f64::INFINITY, f64::NEG_INFINITY];
        let (lowest, fastest) = ((f64::INFINITY, String::new()), (0.0, String::new()));
        Self { actions: 0, particles: 0, not_finite: 0, left: 0, lowest, fastest, volume }
    }
}

impl Marks {
    fn of(scene: &SceneSpec, tools: &[(String, Box<dyn Tool>)], episode: u64) -> anyhow::Result<Self> {
        let mut rng = stream(1, &[u64::from_le_bytes(*b"enduranc"), episode]);
        let mut world = World::new(scene, rng.random())?;
        let volume = world.volume();
        let mut marks = Self { particles: world.particles().len(), ..Self::default() };
        for action in 0..ACTIONS {
            let (name, tool) = &tools[(episode as usize * ACTIONS + action) % tools.len()];
            let (_, motion) = random_action(tool.as_ref(), &world.particles(), STEPS, &mut rng);
            let rollout = world.execute(tool.shape(), &motion);
            marks.actions += 1;
            if !rollout.iter().all(|state| state.is_finite()) {
                marks.not_finite += 1;
                return Ok(marks);
            }
            for state in &rollout {
                let lowest = state.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
                let fastest = state.velocities.iter().map(|v| v.length()).fold(0.0, f64::max);
                marks.lowest = lower(marks.lowest, (lowest, name.clone()));
                marks.fastest = higher(marks.fastest, (fastest, name.clone()));
            }
            let kept = world.volume() / volume;
            marks.volume = [marks.volume[0].min(kept), marks.volume[1].max(kept)];
        }
        let gone = |p: &&glam::DVec3| p.truncate().abs().max_element() > WORKSPACE;
        marks.left = world.particles().positions.iter().filter(gone).count();
        Ok(marks)
    }

    fn and(self, other: Self) -> Self {
        Self {
            actions: self.actions + other.actions,
            particles: self.particles + other.particles,
            not_finite: self.not_finite + other.not_finite,
            left: self.left + other.left,
            lowest: lower(self.lowest, other.lowest),
            fastest: higher(self.fastest, other.fastest),
            volume: [self.volume[0].min(other.volume[0]), self.volume[1].max(other.volume[1])],
        }
    }
}

fn lower<T>(a: (f64, T), b: (f64, T)) -> (f64, T) {
    if b.0 < a.0 { b } else { a }
}

fn higher<T>(a: (f64, T), b: (f64, T)) -> (f64, T) {
    if b.0 > a.0 { b } else { a }
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let whole = |row: &Value| {
        number(row, "not_finite") == 0.0
            && number(row, "lowest") >= number(row, "least")
            && number(row, "fastest") <= THROWN
    };
    let line = |row: &Value| {
        let mut cells = vec![row["material"].as_str().unwrap_or("–").to_owned()];
        cells.extend(["actions", "not_finite"].map(|key| format!("{}", number(row, key))));
        cells.extend(["lowest", "least"].map(|key| format!("{:.2}", 1e3 * number(row, key))));
        let by = row["fastest_by"].as_str().map_or(String::new(), |tool| format!(" ({tool})"));
        cells.push(format!("{:.2}{by}", number(row, "fastest")));
        cells.push(format!("{} of {}", number(row, "left"), number(row, "particles")));
        cells.push(format!("{:.3} … {:.3}", number(row, "least_volume"), number(row, "greatest_volume")));
        cells.push(if whole(row) { "yes" } else { "no" }.into());
        cells
    };
    let claims = rows.iter().map(|row| (row["material"].as_str().unwrap_or("–").to_owned(), Some(whole(row))));
    let header = [
        "material",
        "actions",
        "not finite",
        "lowest [mm]",
        "allowed [mm]",
        "fastest [m/s]",
        "left",
        "volume after",
        "holds",
    ];
    Ok(Grid {
        title: "Random actions of all tools on every material".into(),
        header: header.map(String::from).to_vec(),
        rows: rows.iter().map(line).collect(),
        notes: vec![
            format!(
                "{ACTIONS} actions on a start, then a new one; lowest: the lowest particle in any state, for grains its middle"
            ),
            format!(
                "fastest: over a control step, at most {THROWN} m/s allowed; left: particles beyond {WORKSPACE} m at the end of an episode"
            ),
            "volume: as a share of the start's, after each action".into(),
            adjudge("nothing explodes or falls through the table; what leaves is counted", claims),
        ],
    })
}
