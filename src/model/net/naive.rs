//! The same network in f64, written with nothing but dfdx's own operations, on concatenated rows and dense incidence matrices.
use super::input::{EDGE_FEATURES, NODE_FEATURES};
use super::{Aggregation, Architecture, Input, Network, Sharing};
use dfdx::prelude::*;
use std::collections::BTreeMap;

pub(super) type Plain = Tensor<(usize, usize), f64, Cpu>;
pub(super) type Taped = Tensor<(usize, usize), f64, Cpu, OwnedTape<f64, Cpu>>;

pub(super) struct Leaves {
    pub(super) weights: BTreeMap<String, Plain>,
    pub(super) nodes: Plain,
    pub(super) edges: Vec<(Plain, Plain)>,
}

impl Leaves {
    pub(super) fn of(network: &Network, input: &Input, device: &Cpu) -> Self {
        let matrix = |v: &[f32], columns: usize| -> Plain {
            device.tensor_from_vec(v.iter().map(|x| f64::from(*x)).collect(), (v.len() / columns, columns))
        };
        Self {
            weights: network.named().map(|(name, shape, v)| (name.to_owned(), matrix(v, shape.1))).collect(),
            nodes: matrix(&input.nodes, NODE_FEATURES),
            edges: input.edges.iter().map(|e| (matrix(&e.features, EDGE_FEATURES), matrix(&e.window, 1))).collect(),
        }
    }

    /// `self + step * d`.
    pub(super) fn along(&self, d: &Self, step: f64) -> Self {
        let moved = |x: &Plain, d: &Plain| x.clone() + d.clone() * step;
        Self {
            weights: self.weights.iter().map(|(name, w)| (name.clone(), moved(w, &d.weights[name]))).collect(),
            nodes: moved(&self.nodes, &d.nodes),
            edges: self.edges.iter().zip(&d.edges).map(|(x, d)| (moved(&x.0, &d.0), moved(&x.1, &d.1))).collect(),
        }
    }
}

fn traced(x: &Plain) -> Taped {
    x.clone().put_tape(OwnedTape::default())
}

fn activation(x: Taped) -> Taped {
    let root = (x.with_empty_tape().square() + 1.0).sqrt();
    (x + root) * 0.5 - f64::from(0.677_265_4_f32)
}

fn layer(leaves: &Leaves, name: &str, x: Taped) -> Taped {
    let rows = x.shape().0;
    let bias = traced(&leaves.weights[&format!("{name}.bias")]);
    let ones: Plain = x.device().tensor_from_vec(vec![1.0; rows], (rows, 1));
    x.matmul(traced(&leaves.weights[&format!("{name}.weight")])) + traced(&ones).matmul(bias)
}

fn beside(a: Taped, b: Taped) -> Taped {
    (a, b).concat_along(Axis::<1>)
}

/// A (rows, columns) matrix with ones where `at` says.
fn incidence(device: &Cpu, at: &[u32], columns: usize) -> Plain {
    let mut values = vec![0.0; at.len() * columns];
    at.iter().enumerate().for_each(|(row, &column)| values[row * columns + column as usize] = 1.0);
    device.tensor_from_vec(values, (at.len(), columns))
}

/// A column beside itself, `width` times.
fn spread(column: Taped, width: usize) -> Taped {
    let ones: Plain = column.device().tensor_from_vec(vec![1.0; width], (1, width));
    column.matmul(traced(&ones))
}

/// One row under itself, `rows` times.
fn stacked(row: &Plain, rows: usize) -> Taped {
    let ones: Plain = row.device().tensor_from_vec(vec![1.0; rows], (rows, 1));
    traced(&ones).matmul(traced(row))
}

fn normed(a: &Architecture, leaves: &Leaves, prefix: &str, x: Taped) -> Taped {
    if !a.layer_norm {
        return x;
    }
    let rows = x.shape().0;
    let [gain, shift] = ["gain", "shift"].map(|name| stacked(&leaves.weights[&format!("{prefix}norm.{name}")], rows));
    x.normalize::<Axis<1>>(1e-5) * (gain + 1.0) + shift
}

/// The greatest of each receiver's rows and zero, component by component, receiver after receiver.
fn greatest(rows: Taped, receivers: &[u32], count: usize) -> Taped {
    let (edges, width) = *rows.shape();
    let device = rows.device().clone();
    let none: Plain = device.tensor_from_vec(vec![0.0; count * edges], (count, edges));
    let given = rows.with_empty_tape();
    // Zero, with the tape of what was given.
    let mut all = traced(&none).matmul(rows);
    for i in 0..count as u32 {
        let own: Vec<u32> = (0..edges as u32).filter(|e| receivers[*e as usize] == i).collect();
        if !own.is_empty() {
            let picked = traced(&incidence(&device, &own, edges)).matmul(given.with_empty_tape());
            let most = picked.max::<(usize,), Axis<0>>().relu().reshape_like(&(1usize, width));
            let place: Plain = incidence(&device, &[i], count).permute();
            all = all + traced(&place).matmul(most);
        }
    }
    all
}

pub(super) fn run(a: &Architecture, leaves: &Leaves, input: &Input, device: &Cpu) -> Taped {
    let (count, receivers) = (leaves.nodes.shape().0, input.receivers);
    let mut h = layer(leaves, "node.last", activation(layer(leaves, "node.first", traced(&leaves.nodes))));
    let rows: Vec<u32> = (0..receivers as u32).collect();
    let pick = incidence(device, &rows, count);
    let put: Plain = pick.clone().permute();
    for round in 0..a.rounds {
        let prefix = if a.sharing == Sharing::Shared { String::new() } else { format!("round.{round}.") };
        let zeros: Plain = device.tensor_from_vec(vec![0.0; receivers * a.width], (receivers, a.width));
        let mut sum = traced(&zeros);
        let seen = normed(a, leaves, &prefix, h.with_empty_tape());
        for (place, (edges, (features, window))) in input.edges.iter().zip(&leaves.edges).enumerate() {
            if edges.links.is_empty() {
                continue;
            }
            let name = format!("{prefix}edge.{}", if a.shared_edges { "any" } else { &a.edges[place] });
            let to = incidence(device, &edges.links.receivers, count);
            let from = incidence(device, &edges.links.senders, count);
            let ends = beside(traced(&to).matmul(seen.with_empty_tape()), traced(&from).matmul(seen.with_empty_tape()));
            let mut read = beside(ends, traced(features));
            if a.shared_edges {
                let flags = vec![place as u32; edges.links.len()];
                read = beside(read, traced(&incidence(device, &flags, a.edges.len())));
            }
            let z = activation(layer(leaves, &format!("{name}.first"), read));
            let z = activation(layer(leaves, &format!("{name}.hidden"), z));
            let last = &leaves.weights[&format!("{name}.last.weight")];
            let gather: Plain = incidence(device, &edges.links.receivers, receivers).permute();
            let weighted = z * spread(traced(window), a.width);
            sum = sum
                + match a.aggregation {
                    Aggregation::Sum => traced(&gather).matmul(weighted.matmul(traced(last))) * 0.2,
                    Aggregation::Mean => {
                        let totals = traced(&gather).matmul(traced(window)) + 0.1;
                        traced(&gather).matmul(weighted.matmul(traced(last))) / spread(totals, a.width)
                    }
                    Aggregation::Max => greatest(weighted, &edges.links.receivers, receivers).matmul(traced(last)),
                };
        }
        let own = traced(&pick).matmul(seen);
        let inner = activation(layer(leaves, &format!("{prefix}update.first"), beside(own, sum)));
        h = h + traced(&put).matmul(layer(leaves, &format!("{prefix}update.last"), inner));
    }
    let particles: Vec<u32> = (0..input.particles as u32).collect();
    let own = traced(&incidence(device, &particles, count)).matmul(normed(a, leaves, "decoder.", h));
    layer(leaves, "decoder.last", activation(layer(leaves, "decoder.first", own)))
}
