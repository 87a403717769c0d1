//! Messages of one edge kind, aggregated at their receivers, as one operation.
use super::aggregation::{Aggregation, Winners};
use super::bfloat16::activate;
use super::ends::Ends;
use super::input::Links;
use super::part::Part;
use super::record::{Matrix, Record, Wanted, add_rows, entries, gradient, taken};
use super::squareplus::{slope, squareplus};
use dfdx::prelude::{Cpu, HasShape, Tape};
use std::sync::Arc;

/// Edges at a time: a block of both hidden layers stays in the first two caches.
const BLOCK: usize = 128;

/// The weights of an edge network up to its last hidden layer.
#[derive(Clone)]
pub(super) struct Weights {
    /// (W, W), the first layer's rows that meet the receiver.
    pub(super) receiver: Part,
    /// (W, W), those that meet the sender.
    pub(super) sender: Part,
    /// (features, W), those that meet the edge.
    pub(super) edge: Part,
    /// (1, W).
    pub(super) first_bias: Matrix,
    /// (1, W), what a flag for the kind adds where kinds share their weights.
    pub(super) flag: Option<Part>,
    /// (W, W).
    pub(super) hidden: Part,
    /// (1, W).
    pub(super) hidden_bias: Matrix,
}

/// One kind's edges as matrices.
#[derive(Clone)]
pub(super) struct EdgeInput {
    pub(super) links: Arc<Links>,
    pub(super) receivers: Arc<Ends>,
    pub(super) senders: Arc<Ends>,
    /// (E, features).
    pub(super) features: Matrix,
    /// (E, 1); behind [`Aggregation::shares`] what multiplies each message.
    pub(super) window: Matrix,
}

/// `Sᵢ = c Σⱼ wᵢⱼ zᵢⱼ`, or the greatest `wᵢⱼ zᵢⱼ`, with `z = σ(σ([hᵢ, hⱼ, fᵢⱼ] W₁ + b₁) W₂ + b₂)`, for the R nodes that receive any;
/// (M, W) → (R, W).
///
/// The edge network's last, linear layer is left to the caller: of sums `Σⱼ wᵢⱼ (zᵢⱼ W₃) = (Σⱼ wᵢⱼ zᵢⱼ) W₃` exactly, one product a
/// node instead of one an edge. Likewise `[hᵢ, hⱼ, f] W₁ = (h Wᵣ)ᵢ + (h Wₛ)ⱼ + f W_f`: two of three products are per node.
pub(super) fn message<T: Tape<f32, Cpu>>(
    record: &mut Record<T>,
    nodes: &Matrix,
    edges: &EdgeInput,
    weights: &Weights,
    aggregation: Aggregation,
) -> Matrix {
    let width = nodes.shape().1;
    let count = edges.links.len();
    let (receivers, senders) = (edges.receivers.len(), edges.senders.len());
    let mut bias = entries(&weights.first_bias).to_vec();
    weights.flag.iter().for_each(|flag| flag.multiply_add(&[1.0], &mut bias));
    let mut received = bias.repeat(receivers);
    weights.receiver.multiply_add(&edges.receivers.gather(entries(nodes), width), &mut received);
    let mut sent = vec![0.0; senders * width];
    weights.sender.multiply(&edges.senders.gather(entries(nodes), width), &mut sent);

    let mut products = vec![0.0; count.min(BLOCK) * width];
    // The hidden layers: of every edge where a way back needs them, else the first of a block and the second of one edge.
    let kept = if T::OWNS_TAPE { [count; 2] } else { [count.min(BLOCK), 1] };
    let mut halves = Vec::new();
    let [mut first, mut hidden] = kept.map(|rows| Vec::with_capacity(rows * width));
    let mut sums = vec![0.0; receivers * width];
    let (scale, mut winners) = (aggregation.scale(), Winners::of(aggregation, receivers, width));
    for start in (0..count).step_by(BLOCK) {
        let end = count.min(start + BLOCK);
        let products = &mut products[..(end - start) * width];
        weights.edge.multiply(edges.feature_rows(start, end), products);
        let affine = products.chunks_exact(width).zip(edges.places(start, end));
        let affine = affine.map(|(row, (i, j))| [row, &received[i * width..][..width], &sent[j * width..][..width]]);
        match weights.hidden.rounded() {
            Some(rounded) if !T::OWNS_TAPE => {
                halves.clear();
                activate(affine, &mut halves);
                rounded.multiply_rounded(&halves, products);
            }
            _ => {
                if !T::OWNS_TAPE {
                    first.clear();
                }
                for [x, p, q] in affine {
                    first.extend(x.iter().zip(p.iter().zip(q)).map(|(x, (p, q))| squareplus(x + p + q)));
                }
                weights.hidden.multiply(&first[first.len() - products.len()..], products);
            }
        }
        let bias = entries(&weights.hidden_bias);
        let window = &entries(&edges.window)[start..end];
        let rows = products.chunks_exact(width).zip(edges.places(start, end)).zip(window);
        for (e, ((row, (i, _)), w)) in (start..).zip(rows) {
            if !T::OWNS_TAPE {
                hidden.clear();
            }
            let before = hidden.len();
            hidden.extend(row.iter().zip(bias).map(|(x, b)| squareplus(x + b)));
            let (z, sum, w) = (&hidden[before..], &mut sums[i * width..][..width], scale * w);
            match &mut winners {
                None => z.iter().zip(sum).for_each(|(z, s)| *s += w * z),
                Some(winners) => winners.meet((e, i), w, z, sum),
            }
        }
    }
    let out = record.matrix(sums, width);
    if !T::OWNS_TAPE {
        return out;
    }
    let Record { tape, wanted, .. } = record;
    let (ghost, wanted) = (out.ghost(), *wanted);
    let (nodes, edges, weights) = (nodes.clone(), edges.clone(), weights.clone());
    tape.add_backward_op(move |grads| {
        let at = taken!(grads, &ghost);
        let inner = edges.features.shape().1;
        let (mut at_received, mut at_sent) = (vec![0.0; receivers * width], vec![0.0; senders * width]);
        let mut scratch = vec![0.0; 2 * count.min(BLOCK) * width];
        let mut given = Vec::with_capacity(width);
        for start in (0..count).step_by(BLOCK) {
            let end = count.min(start + BLOCK);
            let place = start * width..end * width;
            let (first, hidden) = (&first[place.clone()], &hidden[place]);
            let (outer, lower) = scratch[..2 * first.len()].split_at_mut(first.len());
            let window = &entries(&edges.window)[start..end];
            let at_window = &mut gradient(grads, &edges.window)?[start..end];
            let block = outer.chunks_exact_mut(width).zip(hidden.chunks_exact(width));
            let block = block.zip(edges.places(start, end)).zip(window.iter().zip(at_window));
            for (e, (((row, z), (i, _)), (w, at_w))) in (start..).zip(block) {
                let (sum, w) = (&at[i * width..][..width], scale * w);
                let sum = match &winners {
                    None => sum,
                    Some(winners) => {
                        given.clear();
                        given.extend(winners.share((e, i), sum));
                        &given
                    }
                };
                *at_w += scale * pull_row(sum, z, w, row);
            }
            if wanted == Wanted::InputsAndWeights {
                weights.hidden.learn(first, outer, grads)?;
                add_rows(outer, gradient(grads, &weights.hidden_bias)?);
            }
            weights.hidden.pull(outer, lower);
            let pairs = edges.places(start, end);
            for ((row, z), (i, j)) in lower.chunks_exact_mut(width).zip(first.chunks_exact(width)).zip(pairs) {
                let to = &mut at_received[i * width..][..width];
                let from = &mut at_sent[j * width..][..width];
                for (((d, z), p), q) in row.iter_mut().zip(z).zip(to).zip(from) {
                    *d *= slope(*z);
                    *p += *d;
                    *q += *d;
                }
            }
            weights.edge.pull_add(lower, &mut gradient(grads, &edges.features)?[start * inner..end * inner]);
            if wanted == Wanted::InputsAndWeights {
                weights.edge.learn(edges.feature_rows(start, end), lower, grads)?;
            }
        }
        let EdgeInput { receivers, senders, .. } = &edges;
        let at_nodes = gradient(grads, &nodes)?;
        receivers.scatter(at_nodes, width, |at| weights.receiver.pull_add(&at_received, at));
        senders.scatter(at_nodes, width, |at| weights.sender.pull_add(&at_sent, at));
        if wanted == Wanted::InputsAndWeights {
            let h = entries(&nodes);
            weights.receiver.learn(&receivers.gather(h, width), &at_received, grads)?;
            weights.sender.learn(&senders.gather(h, width), &at_sent, grads)?;
            let mut at_bias = vec![0.0; width];
            add_rows(&at_received, &mut at_bias);
            add_rows(&at_bias, gradient(grads, &weights.first_bias)?);
            weights.flag.iter().try_for_each(|flag| flag.learn(&[1.0], &at_bias, grads))?;
        }
        Ok(())
    });
    out
}

impl EdgeInput {
    /// Places of receiver and sender, among those of this kind, of the edges `start..end`.
    fn places(&self, start: usize, end: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.receivers.places(start..end).zip(self.senders.places(start..end))
    }

    fn feature_rows(&self, start: usize, end: usize) -> &[f32] {
        let inner = self.features.shape().1;
        &entries(&self.features)[start * inner..end * inner]
    }
}

/// `row = w g σ'`, σ' at the activations z; gives `g · z`, in eight lanes because a plain fold fixes the order of additions.
fn pull_row(g: &[f32], z: &[f32], w: f32, row: &mut [f32]) -> f32 {
    let mut lanes = [0.0f32; 8];
    let ([g8, z8], (row8, _)) = ([g, z].map(|x| x.as_chunks::<8>().0), row.as_chunks_mut::<8>());
    for ((row, g), z) in row8.iter_mut().zip(g8).zip(z8) {
        for k in 0..8 {
            lanes[k] += g[k] * z[k];
            row[k] = w * g[k] * slope(z[k]);
        }
    }
    let tail = 8 * g8.len()..;
    for ((d, g), z) in row[tail.clone()].iter_mut().zip(&g[tail.clone()]).zip(&z[tail]) {
        lanes[0] += g * z;
        *d = w * g * slope(*z);
    }
    lanes.iter().sum()
}
