//! A dense layer of one or several inputs, recorded as one operation.
use super::part::Part;
use super::record::{Matrix, Record, Wanted, add_rows, entries, gradient, taken};
use super::squareplus::{slope, squareplus};
use dfdx::prelude::{Cpu, HasShape, Tape};

/// What follows the affine map.
#[derive(Clone, Copy)]
pub(super) enum Finish<'a> {
    /// Nothing.
    Linear,
    /// The activation.
    Squareplus,
    /// Addition to the first rows of this matrix, whose other rows pass unchanged.
    Onto(&'a Matrix),
}

/// `finish(Σ_p x_p W_p + b)` over the first `rows` rows of every x; shapes (≥ rows, k_p), (k_p, n), (1, n) → (rows, n).
///
/// Several inputs stand for one concatenated input, each with its [`Part`] of the weights.
pub(super) fn dense<T: Tape<f32, Cpu>>(
    record: &mut Record<T>,
    rows: usize,
    terms: &[(&Matrix, Part)],
    bias: Option<&Matrix>,
    finish: Finish<'_>,
) -> Matrix {
    let columns = terms[0].1.columns();
    let mut out = match finish {
        Finish::Onto(base) => entries(base).to_vec(),
        _ => vec![0.0; rows * columns],
    };
    let head = &mut out[..rows * columns];
    for (place, (input, part)) in terms.iter().enumerate() {
        let x = first_rows(input, rows);
        match (place, finish) {
            (0, Finish::Linear | Finish::Squareplus) => part.multiply(x, head),
            _ => part.multiply_add(x, head),
        }
    }
    if let Some(bias) = bias {
        let bias = entries(bias);
        head.chunks_exact_mut(columns).for_each(|row| row.iter_mut().zip(bias).for_each(|(x, b)| *x += b));
    }
    if let Finish::Squareplus = finish {
        head.iter_mut().for_each(|x| *x = squareplus(*x));
    }
    let out = record.matrix(out, columns);
    let Record { tape, wanted, .. } = record;
    if !T::OWNS_TAPE {
        return out;
    }
    let wanted = *wanted;
    let ghost = out.ghost();
    let terms: Vec<_> = terms.iter().map(|(x, part)| ((*x).clone(), part.clone())).collect();
    let bias = bias.cloned();
    let (active, base) = match finish {
        Finish::Linear => (None, None),
        Finish::Squareplus => (Some(out.clone()), None),
        Finish::Onto(base) => (None, Some(base.clone())),
    };
    tape.add_backward_op(move |grads| {
        let mut at = taken!(grads, &ghost);
        if let Some(base) = &base {
            gradient(grads, base)?.iter_mut().zip(&at).for_each(|(g, a)| *g += a);
        }
        at.truncate(rows * columns);
        if let Some(active) = &active {
            at.iter_mut().zip(entries(active)).for_each(|(g, y)| *g *= slope(*y));
        }
        for (input, part) in &terms {
            let inner = input.shape().1;
            part.pull_add(&at, &mut gradient(grads, input)?[..rows * inner]);
            if wanted == Wanted::InputsAndWeights {
                part.learn(first_rows(input, rows), &at, grads)?;
            }
        }
        if let (Some(bias), Wanted::InputsAndWeights) = (&bias, wanted) {
            add_rows(&at, gradient(grads, bias)?);
        }
        Ok(())
    });
    out
}

fn first_rows(input: &Matrix, rows: usize) -> &[f32] {
    &entries(input)[..rows * input.shape().1]
}
