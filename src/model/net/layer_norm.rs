//! Rows brought to mean zero and variance one, as one operation.
use super::record::{Matrix, Record, Wanted, entries, gradient, taken};
use dfdx::prelude::{Cpu, HasShape, Tape};

/// What keeps a constant row finite.
const LEAST: f32 = 1e-5;

/// `y = (1 + g) (x − mean) / √(variance + 10⁻⁵) + b` of each row by itself (Ba, Kiros & Hinton 2016, eq. 4); (M, W), (1, W), (1, W) →
/// (M, W).
pub(super) fn layer_norm<T: Tape<f32, Cpu>>(
    record: &mut Record<T>,
    x: &Matrix,
    gain: &Matrix,
    shift: &Matrix,
) -> Matrix {
    let width = x.shape().1;
    let mut out = Vec::with_capacity(entries(x).len());
    for row in entries(x).chunks_exact(width) {
        let (mean, scale) = moments(row);
        let of = |(x, (g, b)): (&f32, (&f32, &f32))| (1.0 + g) * (x - mean) * scale + b;
        out.extend(row.iter().zip(entries(gain).iter().zip(entries(shift))).map(of));
    }
    let out = record.matrix(out, width);
    if !T::OWNS_TAPE {
        return out;
    }
    let Record { tape, wanted, .. } = record;
    let (ghost, wanted) = (out.ghost(), *wanted);
    let (x, gain, shift) = (x.clone(), gain.clone(), shift.clone());
    tape.add_backward_op(move |grads| {
        let at = taken!(grads, &ghost);
        let at_x = gradient(grads, &x)?;
        let (mut at_gain, mut at_shift, mut normal) = (vec![0.0; width], vec![0.0; width], vec![0.0; width]);
        for ((row, at), at_x) in
            entries(&x).chunks_exact(width).zip(at.chunks_exact(width)).zip(at_x.chunks_exact_mut(width))
        {
            let (mean, scale) = moments(row);
            normal.iter_mut().zip(row).for_each(|(n, x)| *n = (x - mean) * scale);
            // With δ = (1 + g) ∂J/∂y and n the normal row: ∂J/∂x = scale (δ − mean δ − n mean (δ n)).
            let deltas = || at.iter().zip(entries(&gain)).map(|(a, g)| a * (1.0 + g));
            let mean_delta = sum(deltas()) / width as f32;
            let along = sum(deltas().zip(&normal).map(|(d, n)| d * n)) / width as f32;
            for ((to, d), n) in at_x.iter_mut().zip(deltas()).zip(&normal) {
                *to += scale * (d - mean_delta - n * along);
            }
            if wanted == Wanted::InputsAndWeights {
                at_gain.iter_mut().zip(at.iter().zip(&normal)).for_each(|(g, (a, n))| *g += a * n);
                at_shift.iter_mut().zip(at).for_each(|(b, a)| *b += a);
            }
        }
        if wanted == Wanted::InputsAndWeights {
            gradient(grads, &gain)?.iter_mut().zip(&at_gain).for_each(|(to, g)| *to += g);
            gradient(grads, &shift)?.iter_mut().zip(&at_shift).for_each(|(to, b)| *to += b);
        }
        Ok(())
    });
    out
}

/// Mean of a row, and one over its deviation.
fn moments(row: &[f32]) -> (f32, f32) {
    let count = row.len() as f32;
    let mean = sum(row.iter().copied()) / count;
    let variance = sum(row.iter().map(|x| (x - mean) * (x - mean))) / count;
    (mean, (variance + LEAST).sqrt().recip())
}

/// In eight lanes, because a plain fold fixes the order of additions.
fn sum(numbers: impl Iterator<Item = f32>) -> f32 {
    let mut lanes = [0.0f32; 8];
    numbers.enumerate().for_each(|(k, x)| lanes[k % 8] += x);
    lanes.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dfdx::prelude::NoneTape;

    #[test]
    fn rows_have_mean_zero_and_variance_one_whatever_was_added_or_multiplied() {
        let mut record = Record::<NoneTape>::new(Wanted::Inputs);
        let width = 37;
        let row: Vec<f32> = (0..width).map(|i| (i as f32 * 0.7).sin()).collect();
        let other: Vec<f32> = row.iter().map(|x| 5.0 * x - 3.0).collect();
        let matrix = |rows: Vec<f32>| record.matrix(rows, width);
        let (x, zero) = (matrix([row, other, vec![2.0; width]].concat()), matrix(vec![0.0; width]));
        let y = layer_norm(&mut record, &x, &zero, &zero);
        let rows: Vec<&[f32]> = entries(&y).chunks_exact(width).collect();
        for row in &rows[..2] {
            let mean = row.iter().sum::<f32>() / width as f32;
            let variance = row.iter().map(|x| x * x).sum::<f32>() / width as f32;
            assert!(mean.abs() < 1e-6 && (variance - 1.0).abs() < 1e-4, "{mean}, {variance}");
        }
        assert!(rows[0].iter().zip(rows[1]).all(|(a, b)| (a - b).abs() < 1e-4));
        assert!(rows[2].iter().all(|x| *x == 0.0), "a constant row has no direction");
    }
}
