//! A dense layer of one or several inputs, recorded as one operation.
use super::product::{Block, multiply, multiply_add};
use super::record::Wanted;
use super::record::{Matrix, Record, add_rows, entries, gradient, taken};
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
/// Several inputs stand for one concatenated input: `[x₁, x₂] [W₁; W₂] = x₁ W₁ + x₂ W₂`; a weight matrix given with a first
/// row uses only its rows from there on.
pub(super) fn dense<T: Tape<f32, Cpu>>(
    record: &mut Record<T>,
    rows: usize,
    terms: &[(&Matrix, &Matrix, usize)],
    bias: Option<&Matrix>,
    finish: Finish<'_>,
) -> Matrix {
    let columns = terms[0].1.shape().1;
    let mut out = match finish {
        Finish::Onto(base) => entries(base).to_vec(),
        _ => vec![0.0; rows * columns],
    };
    let head = &mut out[..rows * columns];
    for (place, (input, weight, first)) in terms.iter().enumerate() {
        let (x, w) = operands(input, weight, *first, rows);
        match (place, finish) {
            (0, Finish::Linear | Finish::Squareplus) => multiply(x, w, head),
            _ => multiply_add(x, w, head),
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
    let terms: Vec<_> = terms.iter().map(|(x, w, first)| ((*x).clone(), (*w).clone(), *first)).collect();
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
        let delta = Block::new(&at, columns);
        for (input, weight, first) in &terms {
            let (x, w) = operands(input, weight, *first, rows);
            let inner = input.shape().1;
            multiply_add(delta, w.transposed(), &mut gradient(grads, input)?[..rows * inner]);
            if wanted == Wanted::InputsAndWeights {
                let place = first * columns..(first + inner) * columns;
                multiply_add(x.transposed(), delta, &mut gradient(grads, weight)?[place]);
            }
        }
        if let (Some(bias), Wanted::InputsAndWeights) = (&bias, wanted) {
            add_rows(&at, gradient(grads, bias)?);
        }
        Ok(())
    });
    out
}

fn operands<'a>(input: &'a Matrix, weight: &'a Matrix, first: usize, rows: usize) -> (Block<'a>, Block<'a>) {
    let (inner, columns) = (input.shape().1, weight.shape().1);
    let x = Block::new(&entries(input)[..rows * inner], inner);
    (x, Block::new(&entries(weight)[first * columns..(first + inner) * columns], columns))
}
