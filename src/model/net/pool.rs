//! The greatest of many rows, each component by itself, as one operation.
use super::record::{Matrix, Record, entries, gradient, taken};
use dfdx::prelude::{Cpu, HasShape, Tape};

/// `yᵢ = max over the rows of run i`, `beside` runs side by side in one row of the result: (Σ counts, c) →
/// (runs / beside, beside · c). Of equals the first counts; what is not a number wins.
pub(super) fn greatest<T: Tape<f32, Cpu>>(
    record: &mut Record<T>,
    x: &Matrix,
    counts: &[usize],
    beside: usize,
) -> Matrix {
    let (columns, given) = (x.shape().1, entries(x));
    let mut out = Vec::with_capacity(counts.len() * columns);
    let mut winners = Vec::with_capacity(counts.len() * columns);
    let mut first = 0;
    for count in counts {
        let base = out.len();
        out.extend_from_slice(&given[first * columns..][..columns]);
        winners.resize(base + columns, first as u32);
        let (most, who) = (&mut out[base..], &mut winners[base..]);
        for row in first + 1..first + count {
            let own = &given[row * columns..][..columns];
            for ((x, most), who) in own.iter().zip(&mut *most).zip(&mut *who) {
                if x > most || x.is_nan() {
                    (*most, *who) = (*x, row as u32);
                }
            }
        }
        first += count;
    }
    let out = record.matrix(out, beside * columns);
    if T::OWNS_TAPE {
        let (ghost, x) = (out.ghost(), x.clone());
        record.tape.add_backward_op(move |grads| {
            let at = taken!(grads, &ghost);
            let at_x = gradient(grads, &x)?;
            for (place, (g, row)) in at.iter().zip(&winners).enumerate() {
                at_x[*row as usize * columns + place % columns] += g;
            }
            Ok(())
        });
    }
    out
}
