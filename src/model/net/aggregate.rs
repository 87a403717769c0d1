//! What the messages of all kinds come to at each node, as one operation.
use super::ends::Ends;
use super::part::Part;
use super::record::{Matrix, Record, Wanted, entries, gradient, taken};
use dfdx::prelude::{Cpu, Tape};
use std::sync::Arc;

/// One kind's sums, a row for each node that it reaches.
pub(super) struct Sums {
    pub(super) receivers: Arc<Ends>,
    /// (R, W).
    pub(super) sums: Matrix,
    /// (W, W), the edge network's last layer.
    pub(super) last: Part,
}

/// `Aᵢ = Σ_k Sₖᵢ Wₖ` over the kinds k that reach node i; (R_k, W) each → (rows, W).
pub(super) fn aggregate<T: Tape<f32, Cpu>>(record: &mut Record<T>, rows: usize, kinds: Vec<Sums>) -> Matrix {
    let width = kinds[0].last.columns();
    let mut out = vec![0.0; rows * width];
    for Sums { receivers, sums, last } in &kinds {
        receivers.scatter(&mut out, width, |out| last.multiply_add(entries(sums), out));
    }
    let out = record.matrix(out, width);
    if T::OWNS_TAPE {
        let (ghost, wanted) = (out.ghost(), record.wanted);
        record.tape.add_backward_op(move |grads| {
            let at = taken!(grads, &ghost);
            for Sums { receivers, sums, last } in &kinds {
                let at = receivers.gather(&at, width);
                last.pull_add(&at, gradient(grads, sums)?);
                if wanted == Wanted::InputsAndWeights {
                    last.learn(entries(sums), &at, grads)?;
                }
            }
            Ok(())
        });
    }
    out
}
