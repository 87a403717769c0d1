//! Claim: the world steps a pushed pile at least three times as many particles a CPU second as MuJoCo does, its time a particle
//! grows by less than half from 500 to 5000, and datasets use both cores.
//!
//! Command: `pip install mujoco==4.0.0`, then `cargo run --release --bin experiments -- speed`, about ten minutes; the interpreter
//! by `python=PATH`. Table: `paper/tables/speed.tex`. Linux only: CPU time is read from `/proc`.
use crate::adjudge::{adjudge, at_most};
use crate::claim::{Experiment, Rows, Size, median, number, verdict_on};
use crate::cpu::cpu_seconds;
use crate::peer::Peer;
use anyhow::Context;
use glam::{DQuat, DVec3};
use pliant::config;
use pliant::data::{DatasetSpec, simulate};
use pliant::state::{Control, Part, Pose, Solid, ToolShape};
use pliant::table::Grid;
use pliant::watch::Watch;
use pliant::world::World;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Instant;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "speed",
    claim: "a pushed pile runs at 3 × MuJoCo's speed, time a particle grows < 1.5 × to 5000, two cores give ≥ 1.8 ×",
    duration: "about 10 minutes",
    rows: Rows::Beside(measure),
    table,
};

/// How many times MuJoCo's speed is claimed, how much a particle's time may grow, and what two cores give.
const FASTER: f64 = 3.0;
const GROWTH: f64 = 1.5;
const GAIN: f64 = 1.8;
/// Radius of a ball \[m\].
const RADIUS: f64 = 0.005;
/// Speed of the board \[m/s\].
const SPEED: f64 = 0.2;
/// Physics steps a control step of 50 ms: 2 ms each.
const CHUNK: usize = 25;

/// Numbers of balls, how often they are pushed in a round (a second of the fewest says little), and the peer's solvers that take
/// their turn with us; its Newton takes minutes beyond the first, and the last is for our own growth.
const COUNTS: &[(usize, usize, &[&str])] =
    &[(500, 6, &["Newton", "CG"]), (1000, 3, &["CG"]), (2000, 1, &["CG"]), (5000, 1, &[])];

fn measure(size: Size, peer: &Peer, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (counts, controls, rounds) = match size {
        Size::Paper => (COUNTS, 20, 3),
        Size::Smoke => (&[(12, 1, &[][..]), (24, 1, &[][..])][..], 2, 1),
    };
    let mut rows = Vec::new();
    for round in 0..rounds {
        let pushes = counts.iter().flat_map(|(count, times, solvers)| std::iter::repeat_n((count, solvers), *times));
        for (count, solvers) in pushes {
            watch.go_on(|| "stopped between two measurements; nothing is kept of them".into())?;
            let scene = Push::of(*count, controls)?;
            let pushed = [vec![scene.ours()?], scene.theirs(peer, solvers)?].concat();
            rows.extend(pushed.into_iter().map(|mut row| {
                let seconds = number(&row, "cpu_seconds");
                row["particle_steps_per_second"] = json!((count * controls * CHUNK) as f64 / seconds);
                (row["what"], row["particles"], row["round"]) = (json!("push"), json!(count), json!(round));
                row
            }));
        }
        for threads in [1, 2] {
            let (episodes, seconds) = dataset(threads, 4 * controls, watch)?;
            rows.push(json!({ "what": "dataset", "threads": threads, "episodes": episodes, "seconds": seconds, "round": round }));
        }
    }
    Ok(rows)
}

/// Balls on a table, and a board that comes along it.
struct Push {
    world: World,
    half: DVec3,
    start: DVec3,
    interval: f64,
    controls: usize,
}

impl Push {
    fn of(count: usize, controls: usize) -> anyhow::Result<Self> {
        let scene = load(&[format!("scene.particles={count}"), width(count)])?.scene;
        let half = DVec3::new(0.005, side(count) / 2.0 + 0.05, 0.03);
        let start = DVec3::new(-side(count) / 2.0 - 0.04, 0.0, half.z + 0.001);
        Ok(Self { world: World::new(&scene, 1)?, half, start, interval: scene.interval, controls })
    }

    fn ours(&self) -> anyhow::Result<Value> {
        let at = |step: usize| {
            let translation = self.start + SPEED * self.interval * step as f64 * DVec3::X;
            vec![Pose { translation, rotation: DQuat::IDENTITY }]
        };
        let board = Part { solid: Solid::Cuboid { half: self.half }, surface: Vec::new() };
        let mut world = self.world.clone();
        world.take(&Arc::new(ToolShape::from(vec![board])), &at(0));
        let before = world.all_positions();
        let clock = cpu_seconds()?;
        (1..=self.controls).for_each(|step| world.step(&Control { poses: at(step) }));
        let used = cpu_seconds()? - clock;
        let after = world.all_positions();
        let moved = before.iter().zip(&after).map(|(a, b)| (b - a).x).sum::<f64>() / before.len() as f64;
        let mut row = json!({ "engine": "pliant", "cpu_seconds": used, "moved": moved });
        judge(&mut row, &after);
        Ok(row)
    }

    fn theirs(&self, peer: &Peer, solvers: &[&str]) -> anyhow::Result<Vec<Value>> {
        if solvers.is_empty() {
            return Ok(Vec::new());
        }
        let positions: Vec<_> = self.world.all_positions().iter().map(DVec3::to_array).collect();
        let scene = json!({ "positions": positions, "radius": RADIUS, "density": 1400.0, "friction": 0.15,
            "board": { "half": self.half.to_array(), "start": self.start.to_array() }, "speed": SPEED, "dt": 0.002,
            "steps": self.controls * CHUNK, "chunk": CHUNK, "solvers": solvers });
        let mut rows = peer.run("mujoco_push.py", &scene)?;
        for row in &mut rows {
            let positions = row.as_object_mut().and_then(|row| row.remove("positions")).unwrap_or_default();
            let positions: Vec<[f64; 3]> = serde_json::from_value(positions).context("the peer gave no positions")?;
            judge(row, &positions.into_iter().map(DVec3::from).collect::<Vec<_>>());
        }
        Ok(rows)
    }
}

/// Adds how well a solver kept the balls apart: `overlap`, how deep they are in one another and in the table, the mean over all
/// balls of what each has, as a share of the radius; and `touching`, how many of those and of the table each is nearer to than 1 %.
fn judge(row: &mut Value, positions: &[DVec3]) {
    let (mut overlap, mut touching) = (0.0, 0);
    for (i, a) in positions.iter().enumerate() {
        let others = positions.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, b)| 2.0 * RADIUS - a.distance(*b));
        for depth in others.chain([RADIUS - a.z]) {
            overlap += depth.max(0.0);
            touching += usize::from(depth > -0.01 * RADIUS);
        }
    }
    let count = positions.len() as f64;
    (row["overlap"], row["touching"]) = (json!(overlap / (RADIUS * count)), json!(touching as f64 / count));
}

/// Number of episodes made by this many threads, and how long that took \[s\].
fn dataset(threads: usize, episodes: usize, watch: &Watch) -> anyhow::Result<(usize, f64)> {
    let spec = config::load::<DatasetSpec>("configs/dataset/smoke.toml".as_ref(), &[format!("episodes={episodes}")])?;
    let folder = std::env::temp_dir().join(format!("pliant-speed-{}-{threads}", std::process::id()));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let start = Instant::now();
    let made = pool.install(|| simulate(&spec.spec, &folder, watch));
    let seconds = start.elapsed().as_secs_f64();
    std::fs::remove_dir_all(&folder).with_context(|| format!("cannot remove {}", folder.display()))?;
    Ok((made?.episodes.len(), seconds))
}

fn load(changes: &[String]) -> anyhow::Result<DatasetSpec> {
    let fixed = [
        "scene.material=candy".to_owned(),
        format!("scene.material.grain.radius=[{RADIUS},{RADIUS}]"),
        "scene.interval=0.05".into(),
        format!("scene.solver.steps={CHUNK}"),
        // One solution a step, as the peer's, where the shipped pile has four in a step five times as long.
        "scene.solver.substeps=1".into(),
        "scene.solver.sweeps=1".into(),
        "scene.material.rolling=0".into(),
    ];
    let changes: Vec<String> = fixed.into_iter().chain(changes.iter().cloned()).collect();
    Ok(config::load::<DatasetSpec>("configs/dataset/pile_push.toml".as_ref(), &changes)?.spec)
}

/// Side of the square that `count` balls in three layers stand on \[m\].
fn side(count: usize) -> f64 {
    2.2 * RADIUS * (count as f64 / 3.0).sqrt().ceil()
}

fn width(count: usize) -> String {
    let side = side(count);
    format!("scene.start={{kind=block,x=[{side},{side}],y=[{side},{side}],z=[0.03,0.03],turn=[0.0,0.0]}}")
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let pushes = || rows.iter().filter(|row| row["what"] == "push");
    // The best round of each: what else ran on the machine only ever slows.
    let best = |count: f64, ours: bool| {
        let mine = pushes().filter(|row| number(row, "particles") == count && (row["engine"] == "pliant") == ours);
        mine.max_by(|a, b| number(a, "particle_steps_per_second").total_cmp(&number(b, "particle_steps_per_second")))
    };
    let mut counts: Vec<f64> = pushes().map(|row| number(row, "particles")).collect();
    counts.sort_by(f64::total_cmp);
    counts.dedup();
    let thousands = |row: Option<&Value>| {
        row.map_or("–".into(), |row| format!("{:.1}", number(row, "particle_steps_per_second") / 1e3))
    };
    let percent = |row: Option<&Value>| row.map_or("–".into(), |row| format!("{:.1}", 1e2 * number(row, "overlap")));
    let lines = counts.iter().map(|&count| {
        let (ours, peer) = (best(count, true), best(count, false));
        let ratio = ours
            .zip(peer)
            .map(|(a, b)| number(a, "particle_steps_per_second") / number(b, "particle_steps_per_second"));
        let engine = peer.and_then(|row| row["engine"].as_str()).unwrap_or("–").to_owned();
        vec![
            format!("{count}"),
            thousands(ours),
            engine,
            thousands(peer),
            ratio.map_or("–".into(), |r| format!("{r:.2}")),
            percent(ours),
            percent(peer),
        ]
    });
    let header = ["balls", "ours [k/s]", "fastest peer", "peer [k/s]", "ratio", "overlap [%]", "peer's [%]"];
    let cost = |count: Option<&f64>| {
        count.and_then(|c| best(*c, true)).map(|row| 1.0 / number(row, "particle_steps_per_second"))
    };
    let ends = || counts.last().zip(counts.first());
    let growth = ends().and_then(|(l, s)| Some(cost(Some(l))? / cost(Some(s))?)).unwrap_or(f64::NAN);
    let touching = |count: &f64| best(*count, true).map(|row| number(row, "touching"));
    let denser = ends().and_then(|(l, s)| Some(touching(l)? / touching(s)?)).unwrap_or(f64::NAN);
    // Of each round by itself, as the machine's pace drifts from round to round.
    let made = |threads: f64| {
        let made = rows.iter().filter(move |row| row["what"] == "dataset" && number(row, "threads") == threads);
        made.map(|row| number(row, "seconds"))
    };
    let gains: Vec<f64> = made(1.0).zip(made(2.0)).map(|(one, two)| one / two).collect();
    let gain = median(gains.clone());
    let pace = |row: &Value| number(row, "particle_steps_per_second");
    let faster = counts.iter().filter_map(|&count| {
        let ratio = pace(best(count, true)?) / pace(best(count, false)?);
        Some((format!("{count} balls"), at_most(FASTER, ratio)))
    });
    let claim = adjudge(&format!("{FASTER} × MuJoCo's speed"), faster);
    Ok(Grid {
        title: "Speed of the world: balls pushed by a board, thousands of particle steps a CPU second".into(),
        header: header.map(String::from).to_vec(),
        rows: lines.collect(),
        notes: vec![
            "best of all rounds, same balls, board and steps of 2 ms in the same run; the peer's fastest solver".into(),
            "overlap: of a ball with others and the table at the end, as a share of its radius".into(),
            format!(
                "time a particle step at the largest over the smallest: {growth:.2} (claim: {GROWTH} at most; {})",
                verdict_on(growth, growth <= GROWTH)
            ),
            format!("of that, a ball of the largest touches more than one of the smallest: {denser:.2} times"),
            format!(
                "a dataset on one core over two: {gain:.2}, the median of {} rounds (claim: at least {GAIN}; {})",
                gains.len(),
                verdict_on(gain, gain >= GAIN)
            ),
            claim,
        ],
    })
}
