//! Rows that are weighted sums of other rows: means, copies, neighbourhoods and changes of resolution, as one operation.
use super::record::{Matrix, Record, entries, gradient, taken};
use dfdx::prelude::{Cpu, HasShape, Tape};
use std::sync::Arc;

/// For each output row the input rows that it is made of, with their shares.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Mixing {
    /// Where each output row's terms begin, and where the last one's end.
    starts: Vec<u32>,
    sources: Vec<u32>,
    shares: Vec<f32>,
}

impl Mixing {
    /// Of one list of (input row, share) an output row.
    pub(crate) fn new<R: IntoIterator<Item = (usize, f32)>>(rows: impl IntoIterator<Item = R>) -> Self {
        let mut mixing = Self { starts: vec![0], ..Self::default() };
        for row in rows {
            for (source, share) in row {
                mixing.sources.push(source as u32);
                mixing.shares.push(share);
            }
            mixing.starts.push(mixing.sources.len() as u32);
        }
        mixing
    }

    /// One row, the mean of `count`.
    pub(crate) fn mean(count: usize) -> Self {
        Self::new([(0..count).map(|i| (i, 1.0 / count as f32))])
    }

    /// The first row, `count` times.
    pub(crate) fn copies(count: usize) -> Self {
        Self::new((0..count).map(|_| [(0, 1.0)]))
    }

    fn terms(&self) -> impl Iterator<Item = impl Iterator<Item = (usize, f32)> + '_> {
        self.starts.windows(2).map(|ends| {
            let place = ends[0] as usize..ends[1] as usize;
            self.sources[place.clone()]
                .iter()
                .zip(&self.shares[place])
                .map(|(&source, &share)| (source as usize, share))
        })
    }
}

/// `yᵢ = Σⱼ shareᵢⱼ xⱼ`, `beside` rows of y side by side in one row of the result: (n, c) → (rows / beside, beside · c).
pub(super) fn mix<T: Tape<f32, Cpu>>(
    record: &mut Record<T>,
    x: &Matrix,
    mixing: &Arc<Mixing>,
    beside: usize,
) -> Matrix {
    let (columns, given) = (x.shape().1, entries(x));
    let mut out = vec![0.0; (mixing.starts.len() - 1) * columns];
    for (row, terms) in out.chunks_exact_mut(columns).zip(mixing.terms()) {
        for (source, share) in terms {
            let from = &given[source * columns..][..columns];
            row.iter_mut().zip(from).for_each(|(y, x)| *y += share * x);
        }
    }
    let out = record.matrix(out, beside * columns);
    if T::OWNS_TAPE {
        let (ghost, x, mixing) = (out.ghost(), x.clone(), Arc::clone(mixing));
        record.tape.add_backward_op(move |grads| {
            let at = taken!(grads, &ghost);
            let at_x = gradient(grads, &x)?;
            for (row, terms) in at.chunks_exact(columns).zip(mixing.terms()) {
                for (source, share) in terms {
                    let to = &mut at_x[source * columns..][..columns];
                    to.iter_mut().zip(row).for_each(|(x, y)| *x += share * y);
                }
            }
            Ok(())
        });
    }
    out
}
