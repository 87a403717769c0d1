//! Claim: at RoboCook's size (300 particles of dough, 193 of tools, about 3 200 edges, 2 rounds, width 150) the graph network makes at
//! least 3 × as many particle steps a CPU second as RoboCook's kind of network written with sparse gathers in PyTorch, one rollout at a
//! time and 32, forward and with the gradient by the tool's motion; both in f32, and both in bfloat16.
//!
//! Command: `pip install torch==2.15.0`, then `cargo run --release --bin experiments -- planning_speed`, about three minutes; the
//! interpreter by `python=PATH`. Table: `paper/tables/planning_speed.tex`. Linux only: CPU time is read from `/proc`.
use crate::claim::{Experiment, Rows, Size, median, number, verdict};
use crate::cpu::cpu_seconds;
use crate::lump::{Spread, block};
use crate::peer::Peer;
use crate::speaking::speaking;
use anyhow::{Context, ensure};
use glam::DVec3;
use pliant::model::WorldModel;
use pliant::state::{Control, Part, Pose, Scene, Solid, ToolShape};
use pliant::table::Grid;
use pliant::tool::Motion;
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::sync::Arc;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "planning_speed",
    claim: "planning rollouts run at 3 × the speed of a sparse PyTorch network of RoboCook's size, forward and with gradients",
    duration: "about 3 minutes",
    rows: Rows::Beside(measure),
    table,
};

const WIDTH: usize = 150;
/// Directed edges into particles that the radius is chosen for.
const EDGES: usize = 3248;
/// Samples of each finger.
const SAMPLES: [usize; 2] = [97, 96];
const CLAIMED: f64 = 3.0;
/// Rollouts between two looks at a clock, which ticks every few milliseconds.
const TIMED: usize = 32;
/// Our network in f32, and with products in bfloat16.
const OURS: [&str; 2] = ["ours", "ours, bfloat16"];
const PASSES: [&str; 2] = ["forward", "gradient"];

fn measure(size: Size, peer: &Peer, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (batches, steps, rounds) = match size {
        Size::Paper => (&[1, 32][..], 4, 3),
        Size::Smoke => (&[2][..], 1, 1),
    };
    let bench = Bench::new()?;
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut rows = Vec::new();
    for round in 0..rounds {
        for &batch in batches {
            watch.go_on(|| "stopped between two measurements; nothing is kept of them".into())?;
            let motions: Vec<Motion> = (0..batch).map(|k| bench.motion(k, steps)).collect();
            let ours =
                || OURS.iter().zip(&bench.models).map(|(title, model)| bench.ours(title, model.as_ref(), &motions));
            let mut made = alone.install(|| ours().collect::<anyhow::Result<Vec<_>>>())?;
            // A rehearsal needs no interpreter.
            if size == Size::Paper {
                made.extend(bench.theirs(&motions, peer)?);
            }
            rows.extend(made.into_iter().map(|mut row| {
                (row["batch"], row["round"], row["edges"]) = (json!(batch), json!(round), json!(bench.edges.len()));
                row
            }));
        }
    }
    Ok(rows)
}

/// Two fingers beside a block of dough.
struct Bench {
    /// One in each precision, in the order of [`OURS`], with the same weights.
    models: Vec<Box<dyn WorldModel>>,
    scene: Scene,
    /// (receiver, sender) of the edges at the start, tool samples being numbered behind the particles.
    edges: Vec<(usize, usize)>,
}

impl Bench {
    fn new() -> anyhow::Result<Self> {
        let solid = Solid::Cuboid { half: DVec3::new(0.006, 0.03, 0.025) };
        let finger = |side: f64, count: usize| {
            let mut surface = solid.surface(0.005);
            // The samples that face the dough.
            surface.sort_by(|a, b| (side * a.position.x).total_cmp(&(side * b.position.x)));
            surface.truncate(count);
            Part { solid: solid.clone(), surface }
        };
        let shape = ToolShape::from(vec![finger(-1.0, SAMPLES[0]), finger(1.0, SAMPLES[1])]);
        let particles = block(10, 0.005, 0.001, 0.02);
        let scene = Scene::open(particles, Arc::new(shape), poses(0.0).to_vec(), 0.1);
        let mut pairs = distances(&scene);
        ensure!(pairs.len() > EDGES, "fewer pairs than edges");
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let radius = pairs[EDGES].0;
        let edges = pairs[..EDGES].iter().map(|(_, edge)| *edge).collect();
        let in_precision = |precision: &&str| {
            let words = [("width", WIDTH.to_string()), ("precision", (*precision).to_owned())];
            let words = words.map(|(key, value)| format!("dynamics.laws.0.{key}={value}"));
            speaking(&["particle", "tool"], radius, &words, b"planning")
        };
        let models = ["single", "bfloat16"].iter().map(in_precision).collect::<anyhow::Result<_>>()?;
        Ok(Self { models, scene, edges })
    }

    /// Fingers that close, the farther the greater `k`.
    fn motion(&self, k: usize, steps: usize) -> Motion {
        let way = |t: usize| poses((0.5 + k as f64 / 64.0) * t as f64 / 15.0).to_vec();
        Motion { start: way(0), controls: (1..=steps).map(|t| Control { poses: way(t) }).collect() }
    }

    fn ours(&self, title: &str, model: &dyn WorldModel, motions: &[Motion]) -> anyhow::Result<Value> {
        let work = self.work(motions);
        let forward = || model.rollouts(&self.scene, motions);
        let gradient = || {
            motions.iter().try_for_each(|motion| {
                let scene = Scene { poses: motion.start.clone(), ..self.scene.clone() };
                model.gradient(&scene, &motion.controls, &Spread).map(|_| ())
            })
        };
        let rollouts = forward();
        let moved = rollouts[0].last().context("a rollout has a start")?;
        ensure!(moved.is_finite() && moved.positions != self.scene.particles.positions, "nothing moves");
        gradient().context("the model has lost its adjoint")?;
        let repeats = repeats(motions);
        let forward = seconds(repeats, forward)?;
        let gradient = seconds(repeats, gradient)?;
        let weights = model.weights().len();
        Ok(json!({ "engine": "pliant", "variant": title, "weights": weights,
            "forward": work / forward, "gradient": work / gradient }))
    }

    fn theirs(&self, motions: &[Motion], peer: &Peer) -> anyhow::Result<Vec<Value>> {
        let rows = |points: &mut dyn Iterator<Item = DVec3>| points.map(|p| p.to_array()).collect::<Vec<_>>();
        let tool = rows(&mut self.scene.tool.surface_at(&self.scene.poses));
        let path = |motion: &Motion| -> Vec<Vec<[f64; 3]>> {
            let places = [&motion.start].into_iter().chain(motion.controls.iter().map(|control| &control.poses));
            places.map(|poses| rows(&mut poses.iter().map(|pose| pose.translation))).collect()
        };
        let (receivers, senders): (Vec<usize>, Vec<usize>) = self.edges.iter().copied().unzip();
        let scene = json!({
            "particles": rows(&mut self.scene.particles.positions.iter().copied()), "tool": tool, "fingers": SAMPLES,
            "receivers": receivers, "senders": senders, "paths": motions.iter().map(path).collect::<Vec<_>>(),
            "width": WIDTH, "rounds": 2, "repeats": repeats(motions),
        });
        let mut rows = peer.run("planning_rollout.py", &scene)?;
        for row in &mut rows {
            for pass in PASSES {
                row[pass] = json!(row[pass].as_f64().map(|seconds| self.work(motions) / seconds));
            }
        }
        Ok(rows)
    }

    /// Particle steps of these motions.
    fn work(&self, motions: &[Motion]) -> f64 {
        (self.scene.particles.len() * motions.iter().map(|motion| motion.controls.len()).sum::<usize>()) as f64
    }
}

/// How often all motions are rolled out together between two looks at a clock.
fn repeats(motions: &[Motion]) -> usize {
    TIMED.div_ceil(motions.len())
}

/// CPU time of a call on the mean of `repeats` \[s\]; as the peer's, of one that has been made before.
fn seconds<R>(repeats: usize, call: impl Fn() -> R) -> anyhow::Result<f64> {
    let clock = cpu_seconds()?;
    (0..repeats).for_each(|_| drop(std::hint::black_box(call())));
    Ok((cpu_seconds()? - clock) / repeats as f64)
}

/// The fingers after a fraction of their way.
fn poses(way: f64) -> [Pose; 2] {
    [-1.0, 1.0].map(|side| Pose { translation: DVec3::new(side * (0.062 - 0.02 * way), 0.0, 0.025), ..Pose::default() })
}

/// Every directed pair into a particle, with its distance \[m\].
fn distances(scene: &Scene) -> Vec<(f64, (usize, usize))> {
    let receivers = &scene.particles.positions;
    let senders: Vec<DVec3> = receivers.iter().copied().chain(scene.tool.surface_at(&scene.poses)).collect();
    let pairs = (0..receivers.len()).flat_map(|i| (0..senders.len()).map(move |j| (i, j))).filter(|(i, j)| i != j);
    pairs.map(|(i, j)| (receivers[i].distance(senders[j]), (i, j))).collect()
}

/// What numbers are called in the table, and in our rows and the peer's.
const NUMBERS: [(&str, &str, &str); 2] = [("f32", OURS[0], "float32"), ("bfloat16", OURS[1], "bfloat16")];

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let speed = |batch: &Value, variant: &str, pass: &str| {
        let same = rows.iter().filter(|row| row["batch"] == *batch && row["variant"] == variant);
        median(same.map(|row| number(row, pass)).collect())
    };
    let mut batches: Vec<Value> = Vec::new();
    for row in rows {
        if !batches.contains(&row["batch"]) {
            batches.push(row["batch"].clone());
        }
    }
    let cell = |speed: f64, digits: usize| if speed.is_finite() { format!("{speed:.digits$}") } else { "–".into() };
    let cases = batches.iter().flat_map(|batch| PASSES.map(|pass| (batch, pass)));
    let line = |(batch, pass): (&Value, &str), (numbers, ours, theirs): (&str, &str, &str)| {
        let (ours, theirs) = (speed(batch, ours, pass), speed(batch, theirs, pass));
        let speeds = [cell(1e-3 * ours, 1), cell(1e-3 * theirs, 1), cell(ours / theirs, 2)];
        [batch.to_string(), pass.to_owned(), numbers.to_owned()].into_iter().chain(speeds).collect()
    };
    let claim = |(numbers, ours, theirs): (&str, &str, &str)| {
        let ratio = |(batch, pass): (&Value, &str)| speed(batch, ours, pass) / speed(batch, theirs, pass);
        let least = cases.clone().map(ratio).fold(f64::NAN, f64::min);
        let verdict = verdict(least >= CLAIMED);
        format!("both in {numbers}: {least:.2} × PyTorch's speed at least (claim: {CLAIMED}; {verdict})")
    };
    let count = |variant: &str| {
        let row = rows.iter().find(|row| row["variant"] == variant);
        row.map_or(f64::NAN, |row| number(row, "weights"))
    };
    let rounds = rows.iter().map(|row| number(row, "round")).fold(f64::NAN, f64::max) + 1.0;
    let notes = [
        format!(
            "thousands of particle steps a second of one thread, medians of {rounds} rounds in which all take their turns; gradients are by \
             the tool's motion; what rounding to bfloat16 does to predictions is in the table of `rounding`"
        ),
        format!(
            "{} edges at the start; ours looks for neighbours in every step, the peer keeps those of the start; ours has {} weights, \
             the peer {} (published: 447 311)",
            rows.first().map_or(f64::NAN, |row| number(row, "edges")),
            count(OURS[0]),
            count("float32")
        ),
    ];
    let header = ["rollouts at a time", "pass", "numbers", "ours", "PyTorch, sparse", "÷"];
    Ok(Grid {
        title: "Planning rollouts at RoboCook's size".into(),
        header: header.map(String::from).to_vec(),
        rows: cases.clone().flat_map(|case| NUMBERS.map(|numbers| line(case, numbers))).collect(),
        notes: notes.into_iter().chain(NUMBERS.map(claim)).collect(),
    })
}
