//! Claim: a law written as formulas in a config runs within one and a half times the time of the same law written in Rust, forward
//! and backward, and simplification saves at least 30 % of the operations of its derivative program.
//!
//! Command: `cargo run --release --bin experiments -- formula`, about ten seconds. Table: `paper/tables/formula.tex`.
use crate::claim::{Experiment, Rows, Size, number, verdict_on};
use anyhow::Context;
use glam::DVec3;
use pliant::compare::ContenderSpec;
use pliant::config;
use pliant::graph::{CellList, EDGE_KINDS, EdgeSet, Graph};
use pliant::model::ModelSpec;
use pliant::model::law::formula::Programs;
use pliant::model::law::{History, Law, LawSpec, View, ViewGrad};
use pliant::state::{Constants, Particles, ParticlesGrad, ToolShape, stream};
use pliant::table::Grid;
use pliant::watch::Watch;
use rand::Rng;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "formula",
    claim: "a law written as formulas runs within 1.5 × the time of the same law written in Rust; simplification saves ≥ 30 %",
    duration: "about 10 seconds",
    rows: Rows::Measured(measure),
    table,
};

/// Laws that both configs have, in the order of their lists; all but the last run over pairs, the last over particles.
const LAWS: [&str; 4] = ["contact", "cohesion", "viscosity", "floor"];

/// How many times the time of Rust is claimed at most, and the least saved \[%\].
const SLOWER: f64 = 1.5;
const SAVED: f64 = 30.0;

/// Distance of the lattice that particles are shaken from \[m\], as in dough.
const SPACING: f64 = 0.01;

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (edges, rounds) = match size {
        Size::Paper => (100_000, 100),
        Size::Smoke => (500, 1),
    };
    let (written, formulas) = (laws("analytic")?, laws("formula")?);
    let mut rows = Vec::new();
    for (place, name) in LAWS.iter().enumerate() {
        let LawSpec::Formula(spec) = &formulas[place] else { anyhow::bail!("the law {name} is no formula") };
        let programs = Programs::new(spec)?;
        let pair = [&written[place], &formulas[place]].map(|spec| spec.clone().build());
        let [hand, compiled] = pair;
        let (hand, compiled) = (hand?, compiled?);
        let scene = Edges::new(edges, hand.reach());
        // A law's adjoint is compiled when first asked for.
        scene.seconds(compiled.as_ref());
        let mut best = [[f64::INFINITY; 2]; 2];
        for _ in 0..rounds {
            watch.go_on(|| "stopped between two measurements; nothing is kept of them".into())?;
            // In turns, so that whatever else the machine does hits both.
            for (k, law) in [&hand, &compiled].into_iter().enumerate() {
                let (forward, backward) = scene.seconds(law.as_ref());
                best[0][k] = best[0][k].min(forward);
                best[1][k] = best[1][k].min(backward);
            }
        }
        for (pass, [hand, compiled]) in ["forward", "adjoint"].into_iter().zip(best) {
            let of = if pass == "forward" { programs.forward() } else { programs.adjoint() };
            let counts = of.operations;
            rows.push(
                json!({ "law": name, "pass": pass, "edges": scene.edges, "hand_ns": 1e9 * hand / scene.edges as f64,
                "formula_ns": 1e9 * compiled / scene.edges as f64, "written": counts.written, "shared": counts.shared,
                "simplified": counts.simplified, "rounds": rounds }),
            );
        }
    }
    Ok(rows)
}

fn laws(name: &str) -> anyhow::Result<Vec<LawSpec>> {
    let path = format!("configs/model/{name}.toml");
    let ModelSpec::Particles(spec) = config::load::<ContenderSpec>(path.as_ref(), &[])?.spec.dynamics else {
        anyhow::bail!("{path} holds no particle model")
    };
    let kept = |name: &str| spec.laws.iter().position(|law| called(law) == name).map(|place| spec.laws[place].clone());
    LAWS.iter().map(|law| kept(law).with_context(|| format!("{path} has no law {law}"))).collect()
}

fn called(law: &LawSpec) -> String {
    let law = serde_json::to_value(law).expect("specs are plain data");
    law["name"].as_str().or(law["kind"].as_str()).unwrap_or_default().to_owned()
}

/// Particles shaken from a lattice, and their edges within a reach and the skin of a neighbour list.
struct Edges {
    particles: Particles,
    graph: Graph,
    tool: ToolShape,
    cotangent: Vec<DVec3>,
    /// Pairs, or particles where the law has no reach.
    edges: usize,
}

impl Edges {
    fn new(edges: usize, reach: f64) -> Self {
        let mut rng = stream(3, &[u64::from_le_bytes(*b"formulas")]);
        let mut vector = || 2.0 * DVec3::from_array(rng.random::<[f64; 3]>()) - 1.0;
        // A lattice has at least three pairs a particle within the shortest reach.
        let count = if reach > 0.0 { edges / 2 } else { edges };
        let side = (count as f64).cbrt().ceil() as usize;
        let place = |n: usize| DVec3::new((n % side) as f64, (n / side % side) as f64, (n / side / side) as f64);
        let positions: Vec<DVec3> = if reach > 0.0 {
            (0..count).map(|n| SPACING * (place(n) + 0.1 * vector())).collect()
        } else {
            // A layer that half sinks into the floor.
            (0..count).map(|n| DVec3::new(SPACING * n as f64, 0.0, 0.0025 + 0.0025 * vector().z)).collect()
        };
        let mut set = EdgeSet { offsets: vec![0; count + 1], senders: Vec::new() };
        if reach > 0.0 {
            let near = reach + 0.1 * 0.0116;
            set = CellList::new(&positions, near).neighbours(&positions, near).only(|i, j| i < j);
            set.senders.truncate(edges);
            set.offsets.iter_mut().for_each(|end| *end = (*end).min(edges as u32));
        }
        let mut sets = vec![EdgeSet { offsets: vec![0; count + 1], senders: Vec::new() }; EDGE_KINDS.len()];
        let edges = if reach > 0.0 { set.len() } else { count };
        sets[0] = set;
        Self {
            particles: Particles { velocities: positions.iter().map(|_| 0.1 * vector()).collect(), positions },
            graph: Graph { edges: sets, ..Graph::default() },
            tool: ToolShape::from(Vec::new()),
            cotangent: (0..count).map(|_| vector()).collect(),
            edges,
        }
    }

    /// Wall time of one pass forward and one backward \[s\].
    fn seconds(&self, law: &dyn Law) -> (f64, f64) {
        let Self { particles, graph, tool, .. } = self;
        let view = View {
            particles,
            past: &[],
            body: &[],
            walls: &[],
            constants: &Constants::new(),
            graph,
            tool,
            poses: &[],
            twists: &[],
            interval: 0.1,
            history: History::NONE,
        };
        let mut out = vec![DVec3::ZERO; particles.len()];
        let clock = Instant::now();
        law.accelerate(&view, &mut out);
        let forward = clock.elapsed().as_secs_f64();
        let particles = ParticlesGrad::zero(particles.len());
        let mut grad = ViewGrad {
            particles,
            past: Vec::new(),
            poses: Vec::new(),
            twists: Vec::new(),
            history: Vec::new(),
            weights: &mut [],
        };
        let clock = Instant::now();
        law.accelerate_vjp(&view, &self.cotangent, &mut grad);
        (forward, clock.elapsed().as_secs_f64())
    }
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let text = |row: &Value, key: &str| row[key].as_str().unwrap_or("–").to_owned();
    let ratio = |row: &Value| number(row, "formula_ns") / number(row, "hand_ns");
    let saved = |row: &Value, from: &str| 100.0 * (1.0 - number(row, "simplified") / number(row, from));
    let line = |row: &Value| {
        let mut cells = vec![text(row, "law"), text(row, "pass")];
        cells.extend(["hand_ns", "formula_ns"].map(|key| format!("{:.1}", number(row, key))));
        cells.push(format!("{:.2}", ratio(row)));
        cells.extend(["written", "shared", "simplified"].map(|key| format!("{}", number(row, key))));
        cells.extend(["written", "shared"].map(|key| format!("{:.0}", saved(row, key))));
        cells
    };
    let worst = rows.iter().map(ratio).fold(f64::NEG_INFINITY, f64::max);
    let adjoint = || rows.iter().filter(|row| row["pass"] == "adjoint");
    let least = |from: &str| adjoint().map(|row| saved(row, from)).fold(f64::INFINITY, f64::min);
    let header = [
        "law",
        "pass",
        "Rust [ns]",
        "formula [ns]",
        "ratio",
        "written",
        "shared",
        "simplified",
        "saved [%]",
        "of shared [%]",
    ];
    Ok(Grid {
        title: "Laws as formulas beside the same laws in Rust, a pair (floor: a particle), and their operations".into(),
        header: header.map(String::from).to_vec(),
        rows: rows.iter().map(line).collect(),
        notes: vec![
            format!("largest ratio: {worst:.2} (claim: {SLOWER} at most; {}); best of all rounds, in turns, one thread", verdict_on(worst, worst <= SLOWER)),
            format!(
                "least saved in a derivative program: {:.0} % of the operations as written (claim: at least {SAVED}; {}), {:.0} % of those \
                 left when each repeated part is computed once",
                least("written"),
                verdict_on(least("written"), least("written") >= SAVED),
                least("shared")
            ),
            "operations are instructions for every pair; what depends on constants alone is computed once and not counted".into(),
        ],
    })
}
