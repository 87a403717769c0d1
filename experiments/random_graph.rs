//! A random graph and a random network over it, in memory for us and as files for others.
use crate::claim::number;
use crate::cpu::cpu_seconds;
use anyhow::Context;
use npyz::{AutoSerialize, WriterBuilder};
use pliant::model::net::{Aggregation, Architecture, Edges, Input, Links, Network, Sharing};
use pliant::state::stream;
use rand::Rng;
use serde_json::{Value, json};
use std::fs::File;
use std::hint::black_box;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

/// Rounds of message passing.
pub(crate) const ROUNDS: usize = 2;
/// Numbers a node and numbers an edge.
const FEATURES: usize = 10;

/// Particles joined at random, what the network makes of them, and what is pulled back through it.
pub(crate) struct RandomGraph {
    pub(crate) nodes: usize,
    edges: usize,
    pub(crate) width: usize,
    network: Network,
    input: Input,
    at_output: Vec<f32>,
}

impl RandomGraph {
    /// Features in ±1 and windows below 1; weights as they start, shaken so that none of them is zero.
    pub(crate) fn new(nodes: usize, edges: usize, width: usize) -> Self {
        let mut rng = stream(1, &[u64::from_le_bytes(*b"netspeed"), nodes as u64, edges as u64, width as u64]);
        let mut draw =
            |count: usize, size: f32| -> Vec<f32> { (0..count).map(|_| rng.random_range(-size..size)).collect() };
        let kinds = vec!["particle".to_owned()];
        let (sharing, aggregation) = (Sharing::PerRound, Aggregation::Sum);
        let architecture = Architecture {
            width,
            rounds: ROUNDS,
            sharing,
            aggregation,
            history: 1,
            bodies: 1,
            constants: Vec::new(),
            edges: kinds,
            shared_edges: false,
            layer_norm: false,
        };
        let mut network = Network::new(architecture, 1);
        let start = network.weights();
        let shaken: Vec<f32> = start.iter().zip(draw(start.len(), 0.1)).map(|(w, d)| w + d).collect();
        network.set_weights(&shaken);
        let features = draw(edges * FEATURES, 1.0);
        let window = draw(edges, 1.0).iter().map(|w| w.abs()).collect();
        let (of_nodes, at_output) = (draw(nodes * FEATURES, 1.0), draw(3 * nodes, 1.0));
        let mut ends = || -> Vec<u32> { (0..edges).map(|_| rng.random_range(0..nodes as u32)).collect() };
        let (mut receivers, senders) = (ends(), ends());
        receivers.sort_unstable();
        let links = Arc::new(Links { receivers, senders });
        let input = Input {
            particles: nodes,
            receivers: nodes,
            nodes: of_nodes,
            edges: vec![Edges { links, features, window }],
        };
        Self { nodes, edges, width, network, input, at_output }
    }

    /// Our row: CPU milliseconds of a call forward, and of one forward and backward.
    pub(crate) fn measure(&self, seconds: f64) -> anyhow::Result<Value> {
        let forward = self.milliseconds(seconds, |input| drop(black_box(self.network.forward(input))))?;
        let training = self.milliseconds(seconds, |input| drop(black_box(self.pull(input))))?;
        Ok(json!({ "engine": "pliant", "variant": "ours", "forward_ms": forward, "training_ms": training }))
    }

    /// Adds to a row which graph it is of.
    pub(crate) fn label(&self, row: &mut Value) {
        (row["nodes"], row["edges"], row["width"]) = (json!(self.nodes), json!(self.edges), json!(self.width));
    }

    /// Writes graph, weights and our own results below `folder`, for `peers/message_passing.py`.
    pub(crate) fn save(&self, folder: &Path) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let Edges { links, features, window } = &self.input.edges[0];
        write(folder, "nodes", Some(FEATURES), &self.input.nodes)?;
        write(folder, "features", Some(FEATURES), features)?;
        write(folder, "window", None, window)?;
        for (name, ends) in [("receivers", &links.receivers), ("senders", &links.senders)] {
            write(folder, name, None, &ends.iter().map(|&end| i64::from(end)).collect::<Vec<_>>())?;
        }
        write(folder, "cotangent", Some(3), &self.at_output)?;
        write(folder, "output", Some(3), &self.network.forward(self.input.clone()))?;
        self.network.save(&folder.join("weights.safetensors"))?;
        // A gradient has the names and shapes of what it is the gradient of.
        let mut gradient = self.network.clone();
        gradient.set_weights(&self.pull(self.input.clone()));
        gradient.save(&folder.join("gradient.safetensors"))
    }

    /// `∂J/∂weights`; the network gives the derivatives of its inputs with it.
    fn pull(&self, input: Input) -> Vec<f32> {
        let mut gradient = vec![0.0; self.network.architecture().weight_count()];
        black_box(self.network.pull(input, &self.at_output, &mut gradient));
        gradient
    }

    /// The mean over calls that last so many seconds in all, after one that does not count.
    fn milliseconds(&self, seconds: f64, call: impl Fn(Input)) -> anyhow::Result<f64> {
        call(self.input.clone());
        let (mut used, mut calls) = (0.0, 0);
        while calls == 0 || used < seconds {
            let input = self.input.clone();
            let clock = cpu_seconds()?;
            call(input);
            used += cpu_seconds()? - clock;
            calls += 1;
        }
        Ok(1e3 * used / f64::from(calls))
    }
}

/// Floating-point operations of the matrix products of a row's forward pass, in the order of factors that needs the fewest.
pub(crate) fn products(row: &Value) -> f64 {
    let [n, e, w] = ["nodes", "edges", "width"].map(|key| number(row, key));
    let features = FEATURES as f64;
    let round = n * 6.0 * w * w + e * (features * w + w * w);
    2.0 * (n * (features * w + w * w) + ROUNDS as f64 * round + n * (w * w + 3.0 * w))
}

fn write<T: AutoSerialize + Copy>(
    folder: &Path,
    name: &str,
    columns: Option<usize>,
    values: &[T],
) -> anyhow::Result<()> {
    let path = folder.join(name).with_extension("npy");
    let shape: Vec<u64> = match columns {
        Some(columns) => vec![(values.len() / columns) as u64, columns as u64],
        None => vec![values.len() as u64],
    };
    let file = File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
    let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
    let mut array = options.writer(BufWriter::new(file)).begin_nd()?;
    array.extend(values.iter().copied())?;
    Ok(array.finish()?)
}
