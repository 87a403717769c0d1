//! How the messages that a node receives become one.
use super::input::Links;
use super::record::{Matrix, Record, entries, gradient, taken};
use dfdx::prelude::{Cpu, Tape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How the messages of one kind that a node receives become one; z is a message before its last, linear layer, w its window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Aggregation {
    /// `c Σⱼ wⱼ zⱼ`, c about one over the number of neighbours that count: pushes add up (Li et al. 2019, Sanchez-Gonzalez et
    /// al. 2020).
    #[default]
    Sum,
    /// `Σⱼ wⱼ zⱼ / (ε + Σⱼ wⱼ)`: how many neighbours there are is not felt, but for the last one's going.
    Mean,
    /// `max(0, maxⱼ wⱼ zⱼ)`, each component by itself.
    Max,
}

/// ε of the mean: a lone neighbour fades out over the last third of its way to the radius.
const EPSILON: f32 = 0.1;

impl Aggregation {
    /// Constant factor c of every message.
    pub(super) fn scale(self) -> f32 {
        match self {
            Self::Sum => 0.2,
            Self::Mean | Self::Max => 1.0,
        }
    }

    /// What multiplies each message before they are summed or compared, (E, 1), from the windows.
    pub(super) fn shares<T: Tape<f32, Cpu>>(self, record: &mut Record<T>, links: &Links, window: &Matrix) -> Matrix {
        match self {
            Self::Sum | Self::Max => window.clone(),
            Self::Mean => means(record, links, window),
        }
    }
}

/// `yₑ = wₑ / (ε + Σ w)`, the sum over all edges of the same receiver; edges are sorted by receiver.
fn means<T: Tape<f32, Cpu>>(record: &mut Record<T>, links: &Links, window: &Matrix) -> Matrix {
    let mut out = entries(window).to_vec();
    let mut totals = vec![0.0; out.len()];
    for own in runs(&links.receivers) {
        let total = EPSILON + out[own.clone()].iter().sum::<f32>();
        totals[own].fill(total);
    }
    out.iter_mut().zip(&totals).for_each(|(y, total)| *y /= total);
    let out = record.matrix(out, 1);
    if T::OWNS_TAPE {
        let (ghost, window, share, receivers) = (out.ghost(), window.clone(), out.clone(), links.receivers.clone());
        record.tape.add_backward_op(move |grads| {
            let at = taken!(grads, &ghost);
            let at_window = gradient(grads, &window)?;
            for own in runs(&receivers) {
                let felt: f32 = at[own.clone()].iter().zip(&entries(&share)[own.clone()]).map(|(g, y)| g * y).sum();
                for e in own {
                    at_window[e] += (at[e] - felt) / totals[e];
                }
            }
            Ok(())
        });
    }
    out
}

/// The edges of each receiver, one run after the other.
fn runs(receivers: &[u32]) -> impl Iterator<Item = Range<usize>> + '_ {
    receivers.chunk_by(|a, b| a == b).scan(0, |end, run| {
        let start = *end;
        *end += run.len();
        Some(start..*end)
    })
}

/// Which edge gave each component of each node's greatest message; none where zero is greater.
pub(super) struct Winners {
    edges: Vec<u32>,
    width: usize,
}

impl Winners {
    /// None yet, for `rows` nodes, where messages are compared at all.
    pub(super) fn of(aggregation: Aggregation, rows: usize, width: usize) -> Option<Self> {
        (aggregation == Aggregation::Max).then(|| Self { edges: vec![u32::MAX; rows * width], width })
    }

    /// Raises node `i`'s greatest message to edge `e`'s, `w z`, where that is greater.
    pub(super) fn meet(&mut self, (e, i): (usize, usize), w: f32, z: &[f32], greatest: &mut [f32]) {
        let own = &mut self.edges[i * self.width..][..self.width];
        for ((z, g), winner) in z.iter().zip(greatest).zip(own) {
            if w * z > *g {
                (*g, *winner) = (w * z, e as u32);
            }
        }
    }

    /// Of `at`, the derivative by node `i`'s greatest message, what edge `e` gave.
    pub(super) fn share<'a>(&'a self, (e, i): (usize, usize), at: &'a [f32]) -> impl Iterator<Item = f32> + 'a {
        let own = &self.edges[i * self.width..][..self.width];
        own.iter().zip(at).map(move |(winner, g)| if *winner == e as u32 { *g } else { 0.0 })
    }
}
