//! Claim: on one thread the network runs forward at least 5 × as fast as PyTorch as peers write it, 3 × as PyTorch with the first
//! layer split, 2 × as JAX with it split; forward and backward together 4 ×, 2.5 × and 2.5 ×; and 2 ×, both ways,
//! as PyTorch's compiler makes it at 2000 nodes and a width of 128.
//!
//! Command: `pip install torch==2.15.0 jax==0.10.2 safetensors==0.8.0`, then `cargo run --release --bin experiments --
//! network_speed`, about a quarter of an hour; the interpreter by `python=PATH`. Table: `paper/tables/network_speed.tex`. Linux only: CPU
//! time is read from `/proc`.
use crate::claim::{Experiment, Rows, Size, median, number, verdict_on};
use crate::peer::Peer;
use crate::random_graph::{ROUNDS, RandomGraph, products};
use anyhow::{Context, ensure};
use pliant::table::Grid;
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "network_speed",
    claim: "the network runs at 5 × PyTorch's speed, 3 × split, 2 × JAX's; trains at 4 ×, 2.5 ×, 2.5 ×; both at 2 × torch.compile's",
    duration: "about 15 minutes",
    rows: Rows::Beside(measure),
    table,
};

/// Nodes and edges.
const SIZES: &[(usize, usize)] = &[(500, 3000), (2000, 24_000), (10_000, 120_000)];
/// The one graph, nodes and width, that PyTorch's compiler gets: a run of it starts with a minute of compiling.
const COMPILED: (usize, usize) = (2000, 128);
/// A peer's variant, its title, and how many times faster than it we claim to be: forward, and forward and backward.
const PEERS: [(&str, &str, [f64; 2]); 4] = [
    ("torch written", "PyTorch", [5.0, 4.0]),
    ("torch split", "PyTorch, split", [3.0, 2.5]),
    ("jax split", "JAX, split", [2.0, 2.5]),
    ("torch compiled", "PyTorch, split, compiled", [2.0, 2.0]),
];
const PASSES: [(&str, &str); 2] = [("forward", "forward_ms"), ("forward and backward", "training_ms")];
/// Greatest difference of two engines' outputs, relative to their greatest number, at which they compute the same.
const SAME: f64 = 1e-4;

fn measure(size: Size, peer: &Peer, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (sizes, widths, rounds, seconds) = match size {
        Size::Paper => (SIZES, &[64, 128][..], 10, 0.2),
        Size::Smoke => (&[(20, 60)][..], &[8][..], 1, 1e-3),
    };
    let of = |&(nodes, edges)| widths.iter().map(move |&width| RandomGraph::new(nodes, edges, width));
    let graphs: Vec<_> = sizes.iter().flat_map(of).collect();
    // A rehearsal needs no interpreter.
    let peer = (size == Size::Paper).then_some(peer);
    let folder = std::env::temp_dir().join(format!("pliant-network-speed-{}", std::process::id()));
    let made = race(&graphs, &folder, (rounds, seconds), peer, watch);
    std::fs::remove_dir_all(&folder).with_context(|| format!("cannot remove {}", folder.display()))?;
    made
}

/// Rows of so many rounds, in each of which every engine passes every graph's messages for so many seconds \[s\].
fn race(
    graphs: &[RandomGraph],
    folder: &Path,
    (rounds, seconds): (usize, f64),
    peer: Option<&Peer>,
    watch: &Watch,
) -> anyhow::Result<Vec<Value>> {
    let place = |place: usize| folder.join(place.to_string());
    graphs.iter().enumerate().try_for_each(|(k, graph)| graph.save(&place(k)))?;
    let mut rows = Vec::new();
    let mut keep = |graph: &RandomGraph, round: usize, mut row: Value| {
        graph.label(&mut row);
        row["round"] = json!(round);
        rows.push(row);
    };
    for round in 0..rounds {
        for graph in graphs {
            watch.go_on(|| "stopped between two measurements; nothing is kept of them".into())?;
            keep(graph, round, graph.measure(seconds)?);
        }
        let Some(peer) = peer else { continue };
        for framework in ["torch", "jax"] {
            watch.go_on(|| "stopped between two measurements; nothing is kept of them".into())?;
            let job = |(k, graph)| json!({ "folder": place(k), "variants": variants(framework, graph) });
            let jobs: Vec<_> = graphs.iter().enumerate().map(job).collect();
            let scene = json!({ "framework": framework, "rounds": ROUNDS, "seconds": seconds, "graphs": jobs });
            let theirs = peer.run("message_passing.py", &scene)?;
            let asked: Vec<_> =
                graphs.iter().flat_map(|graph| variants(framework, graph).iter().map(move |_| graph)).collect();
            ensure!(theirs.len() == asked.len(), "the peer gave {} rows of {}", theirs.len(), asked.len());
            asked.into_iter().zip(theirs).for_each(|(graph, row)| keep(graph, round, row));
        }
    }
    Ok(rows)
}

/// Which ways of writing the network a framework runs on a graph.
fn variants(framework: &str, graph: &RandomGraph) -> &'static [&'static str] {
    match framework {
        "jax" => &["split"],
        _ if (graph.nodes, graph.width) == COMPILED => &["written", "split", "compiled"],
        _ => &["written", "split"],
    }
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let key = |row: &Value| ["nodes", "edges", "width"].map(|key| row[key].clone());
    let ours: Vec<&Value> = rows.iter().filter(|row| row["variant"] == "ours" && row["round"] == 0).collect();
    let middle = |of: &Value, variant: &str, pass: &str| {
        let same = rows.iter().filter(|row| row["variant"] == variant && key(row) == key(of));
        median(same.map(|row| number(row, pass)).collect())
    };
    let ratio = |of: &Value, variant: &str, pass: &str| middle(of, variant, pass) / middle(of, "ours", pass);
    let most = |key: &str| rows.iter().map(|row| number(row, key)).fold(f64::NAN, f64::max);
    let line = |of: &&Value| {
        let mut cells = key(of).map(|n| n.to_string()).to_vec();
        cells.extend(PASSES.map(|(_, pass)| format!("{:.1}", middle(of, "ours", pass))));
        cells.extend(PEERS.map(|(variant, ..)| {
            let [forward, both] = PASSES.map(|(_, pass)| ratio(of, variant, pass));
            if both.is_finite() { format!("{forward:.2} / {both:.2}") } else { "–".into() }
        }));
        cells
    };
    // Backwards there are two products for each one forwards: by the weights and by what they met.
    let peak = most("product_gflops");
    let bound = |of: &Value, pass: &str| products(of) / peak * 1e-6 * if pass == PASSES[0].1 { 1.0 } else { 3.0 };
    let claim = |title: &str, variant: &str, (pass, key): (&str, &str), least: f64| {
        let worst = ours.iter().map(|of| ratio(of, variant, key)).fold(f64::NAN, f64::min);
        let lines = ours.iter().filter(|of| ratio(of, variant, key) >= least).count();
        let verdict = verdict_on(worst, worst >= least);
        let beyond = ours.iter().filter(|of| middle(of, variant, key) < least * bound(of, key)).count();
        let of = ours.iter().filter(|of| ratio(of, variant, key).is_finite()).count();
        format!(
            "{title}, {pass}: {worst:.2} × our time at least (claim: {least}; {verdict}, reached on {lines} of {of} lines, out of \
             anybody's reach on {beyond})"
        )
    };
    let verdicts = PEERS.iter().flat_map(|(variant, title, claims)| {
        PASSES.iter().zip(claims).map(move |(pass, least)| claim(title, variant, *pass, *least))
    });
    let speed = |of: &&Value| products(of) / middle(of, "ours", "forward_ms") * 1e-6;
    let fastest = ours.iter().map(speed).fold(f64::NAN, f64::max);
    let gap = most("gap");
    let mut engines: Vec<&str> = rows.iter().filter_map(|row| row["engine"].as_str()).collect();
    engines.sort_unstable();
    engines.dedup();
    let mut notes = vec![
        format!(
            "CPU time of one thread, medians of rounds in which all take their turns, {} here; peers: how many times longer they \
             take, forward / forward and backward",
            most("round") + 1.0
        ),
        format!("{}; ours gives the derivatives of its inputs along with those of its weights", engines.join(", ")),
    ];
    notes.extend(verdicts);
    notes.push(
        "out of anybody's reach: the claim would not hold if all but the matrix products took no time and these ran at the \
         speed of PyTorch's matrix product here"
            .into(),
    );
    notes.push(format!(
        "outputs differ by {gap:.0e} of the greatest (claim: below {SAME:.0e}; {}), weights' derivatives by {:.0e}",
        verdict_on(gap, gap < SAME),
        most("gradient_gap")
    ));
    notes.push(format!(
        "our forward products: {fastest:.0} GFLOP/s at most, {:.0} % of PyTorch's matrix product here",
        1e2 * fastest / peak
    ));
    let header = ["nodes", "edges", "width", "forward [ms]", "and backward [ms]"].into_iter();
    Ok(Grid {
        title: "The network's speed beside PyTorch and JAX on one thread".into(),
        header: header.chain(PEERS.map(|(_, title, _)| title)).map(String::from).collect(),
        rows: ours.iter().map(line).collect(),
        notes,
    })
}
