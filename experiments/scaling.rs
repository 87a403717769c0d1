//! Claim: a step of the graph network costs the same an edge from 3 000 to 1 000 000 edges (within 1.3 ×), looking for neighbours is at
//! most a tenth of it, and 50 000 particles roll out in less than 4 GiB.
//!
//! Command: `cargo run --release --bin experiments -- scaling`, about a minute. Table: `paper/tables/scaling.tex`. Linux only: CPU time
//! and memory are read from `/proc`.
use crate::claim::{Experiment, Rows, Size, median, number, verdict};
use crate::cpu::cpu_seconds;
use crate::speaking::speaking;
use anyhow::{Context, ensure};
use glam::DVec3;
use pliant::graph::{GraphSpec, Nodes, Skeleton};
use pliant::state::{Control, Particles, Scene, ToolShape, stream};
use pliant::table::Grid;
use pliant::watch::Watch;
use rand::Rng;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "scaling",
    claim: "a step costs the same an edge from 3 000 to 1 000 000, and 50 000 particles roll out in 4 GiB",
    duration: "about a minute",
    rows: Rows::Measured(measure),
    table,
};

/// Particles along the edges of a block; with the radius below about 3 000 to 1 400 000 edges.
const BLOCKS: [[usize; 3]; 5] = [[6, 6, 4], [10, 10, 10], [20, 20, 20], [33, 33, 32], [40, 40, 32]];
/// Distance of neighbours, and how far the network hears \[m\].
const SPACING: f64 = 0.01;
const RADIUS: f64 = 0.02;
const KINDS: [&str; 2] = ["particle", "floor"];
const SHAKE: f64 = 0.001;
/// Control steps of a rollout.
const STEPS: usize = 3;
const SPREAD: f64 = 1.3;
const SEARCH: f64 = 0.1;
const GIBIBYTES: f64 = 4.0;
/// Fewest edges and particles that the claims speak of.
const EDGES: f64 = 2500.0;
const PARTICLES: f64 = 50_000.0;

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (blocks, rounds) = if size == Size::Paper { (&BLOCKS[..], 5) } else { (&BLOCKS[..1], 1) };
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut rows = Vec::new();
    for &block in blocks {
        for round in 0..rounds {
            watch.go_on(|| "stopped between two measurements; nothing is kept of them".into())?;
            let mut row = alone.install(|| stepped(block))?;
            row["round"] = json!(round);
            rows.push(row);
        }
    }
    Ok(rows)
}

/// A rollout of a block without a tool: time of a step and of its search for neighbours, and the most memory so far.
fn stepped([x, y, z]: [usize; 3]) -> anyhow::Result<Value> {
    let model = speaking(&KINDS, RADIUS, &[], b"scaling ")?;
    let mut rng = stream(1, &[u64::from_le_bytes(*b"block   ")]);
    let mut place = |n: usize| {
        let lattice = DVec3::new((n % x) as f64, (n / x % y) as f64, (n / x / y) as f64 + 0.5);
        SPACING * lattice + SHAKE * DVec3::from_array(rng.random::<[f64; 3]>())
    };
    let particles = Particles::at_rest((0..x * y * z).map(&mut place).collect());
    let none = Arc::new(ToolShape::from(Vec::new()));

    let policy: GraphSpec = serde_json::from_value(json!({ "kind": "radius", "radius": RADIUS, "edges": KINDS }))?;
    let policy = policy.build()?;
    let gather = || Nodes::gather(&particles, &Arc::new(Skeleton::default()), &[], &none, &[], &[], 0.1);
    let edges: usize = policy.connect(gather()).edges.iter().map(|set| set.len()).sum();
    let search = each(|| drop(policy.connect(gather())))?;

    let scene = Scene::open(particles.clone(), Arc::clone(&none), Vec::new(), 0.1);
    let controls = vec![Control::default(); STEPS];
    let rollout = model.rollout(&scene, &controls);
    let end = rollout.last().context("a rollout has a start")?;
    ensure!(end.is_finite() && end.positions != particles.positions, "nothing moves");
    let used = each(|| drop(model.rollout(&scene, &controls)))?;
    Ok(json!({ "particles": x * y * z, "edges": edges, "step_seconds": used / STEPS as f64, "search_seconds": search,
        "gibibytes": peak_memory()? }))
}

/// CPU time of a call, the mean over calls that last a fifth of a second in all \[s\].
fn each(call: impl Fn()) -> anyhow::Result<f64> {
    let clock = cpu_seconds()?;
    let (mut used, mut calls) = (0.0, 0);
    while used < 0.2 {
        call();
        calls += 1;
        used = cpu_seconds()? - clock;
    }
    Ok(used / f64::from(calls))
}

/// The most memory that this process has had at once \[GiB\].
fn peak_memory() -> anyhow::Result<f64> {
    let text =
        std::fs::read_to_string("/proc/self/status").context("cannot read /proc/self/status: memory needs Linux")?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok());
    Ok(kibibytes.context("/proc/self/status holds no VmHWM")? / f64::from(1 << 20))
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let mut sizes: Vec<f64> = rows.iter().map(|row| number(row, "particles")).collect();
    sizes.dedup();
    let middle = |size: f64, value: &dyn Fn(&Value) -> f64| {
        median(rows.iter().filter(|row| number(row, "particles") == size).map(value).collect())
    };
    let edges = |size: f64| middle(size, &|row| number(row, "edges"));
    let per_edge = |size: f64| middle(size, &|row| 1e9 * number(row, "step_seconds") / number(row, "edges"));
    let search = |size: f64| middle(size, &|row| number(row, "search_seconds") / number(row, "step_seconds"));
    let memory = |size: f64| {
        rows.iter()
            .filter(|row| number(row, "particles") == size)
            .map(|row| number(row, "gibibytes"))
            .fold(0.0, f64::max)
    };
    let line = |&size: &f64| {
        vec![
            size.to_string(),
            edges(size).to_string(),
            format!("{:.1}", middle(size, &|row| 1e3 * number(row, "step_seconds"))),
            format!("{:.0}", per_edge(size)),
            format!("{:.1}", 1e2 * search(size)),
            format!("{:.2}", memory(size)),
        ]
    };
    let judged: Vec<f64> = sizes.iter().copied().filter(|size| edges(*size) >= EDGES).collect();
    let costs = || judged.iter().map(|size| per_edge(*size));
    let spread = costs().fold(0.0, f64::max) / costs().fold(f64::INFINITY, f64::min);
    let most = sizes.iter().map(|size| search(*size)).fold(0.0, f64::max);
    let held = sizes.iter().filter(|size| **size >= PARTICLES).map(|size| memory(*size)).fold(f64::NAN, f64::max);
    let notes = vec![
        "CPU time of one thread, medians of rounds; search: drawing the graph, as a share of the step; memory: the most that the \
         process had by then"
            .to_owned(),
        format!("time an edge: {spread:.2} × from the least to the greatest (claim: {SPREAD}; {})", verdict(spread <= SPREAD)),
        format!("search: {:.1} % of a step at most (claim: {:.0} %; {})", 1e2 * most, 1e2 * SEARCH, verdict(most <= SEARCH)),
        format!("50 000 particles: {held:.2} GiB (claim: {GIBIBYTES}; {})", verdict(held < GIBIBYTES)),
    ];
    let header = ["particles", "edges", "a step [ms]", "an edge [ns]", "search [%]", "memory [GiB]"];
    Ok(Grid {
        title: "A step of the graph network over sizes".into(),
        header: header.map(String::from).to_vec(),
        rows: sizes.iter().map(line).collect(),
        notes,
    })
}
