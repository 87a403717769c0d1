//! Products with a square weight matrix in bfloat16, sums in f32, by NumKong: on the processor's matrix unit where it has one.
use super::bfloat16::rounded;
use numkong::capabilities::configure_thread;
use numkong::{Dots, bf16};

/// A weight matrix W whose entries, like those of what meets it, are rounded to bfloat16: eight bits of each significand, a relative
/// error of at most 2⁻⁹ a factor. A row's product does not depend on the rows beside it, bit for bit.
#[derive(Debug)]
pub(super) struct Rounded {
    /// For `x W`.
    forward: Packed,
    /// For `δ Wᵀ`.
    backward: Packed,
}

/// A right factor in the order that the processor reads it.
#[derive(Debug)]
struct Packed {
    words: Vec<u64>,
    width: usize,
}

thread_local! {
    /// Whether this thread may use the matrix unit; asking is what turns it on.
    static READY: bool = configure_thread();
}

impl Rounded {
    /// Of W, `width` rows of as many entries.
    pub(super) fn new(weight: &[f32], width: usize) -> Self {
        let transposed: Vec<f32> = (0..width * width).map(|i| weight[i % width * width + i / width]).collect();
        Self { forward: Packed::new(&transposed, width), backward: Packed::new(weight, width) }
    }

    /// `out = x W`, x of whole rows.
    pub(super) fn multiply(&self, x: &[f32], out: &mut [f32]) {
        self.forward.multiply(x, out);
    }

    /// The same of what is rounded already.
    pub(super) fn multiply_rounded(&self, x: &[bf16], out: &mut [f32]) {
        self.forward.multiply_rounded(x, out);
    }

    /// `out += x W`.
    pub(super) fn multiply_add(&self, x: &[f32], out: &mut [f32]) {
        add(&self.forward, x, out);
    }

    /// `out = δ Wᵀ`.
    pub(super) fn multiply_transposed(&self, delta: &[f32], out: &mut [f32]) {
        self.backward.multiply(delta, out);
    }

    /// `out += δ Wᵀ`.
    pub(super) fn multiply_transposed_add(&self, delta: &[f32], out: &mut [f32]) {
        add(&self.backward, delta, out);
    }
}

fn add(factor: &Packed, x: &[f32], out: &mut [f32]) {
    let mut product = vec![0.0; out.len()];
    factor.multiply(x, &mut product);
    out.iter_mut().zip(product).for_each(|(y, p)| *y += p);
}

impl Packed {
    /// The factor whose columns are the rows of `columns`.
    fn new(columns: &[f32], width: usize) -> Self {
        let columns = rounded(columns);
        assert_eq!(columns.len(), width * width, "a square matrix");
        READY.with(|_| ());
        let mut words = vec![0; bf16::dots_packed_size(width, width).div_ceil(size_of::<u64>())];
        // SAFETY: `columns` holds width² numbers, a row every `width` of them, and `words` as many bytes as the library asks for.
        unsafe {
            bf16::dots_pack(columns.as_ptr(), width, width, width * size_of::<bf16>(), words.as_mut_ptr().cast())
        };
        Self { words, width }
    }

    fn multiply(&self, x: &[f32], out: &mut [f32]) {
        self.multiply_rounded(&rounded(x), out);
    }

    fn multiply_rounded(&self, x: &[bf16], out: &mut [f32]) {
        let (width, rows) = (self.width, x.len() / self.width);
        assert!(x.len() == rows * width && out.len() == x.len(), "whole rows");
        READY.with(|_| ());
        // SAFETY: `x` and `out` both hold rows × width numbers, a row every `width` of them, `words` is what `dots_pack` wrote for
        // width columns of depth width, and this thread has been configured.
        unsafe {
            bf16::dots_packed(
                x.as_ptr(),
                self.words.as_ptr().cast(),
                out.as_mut_ptr(),
                rows,
                width,
                width,
                width * size_of::<bf16>(),
                width * size_of::<f32>(),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, step: f32) -> Vec<f32> {
        (0..count).map(|i| (i as f32 * step).sin()).collect()
    }

    fn as_rounded(x: f32) -> f64 {
        f64::from(f32::from_bits(u32::from(rounded(&[x])[0].0) << 16))
    }

    #[test]
    fn products_are_those_of_rounded_factors() {
        for width in [1, 7, 16, 33, 64, 150] {
            for rows in [1, 5, 16, 193] {
                let (x, w) = (numbers(rows * width, 0.37), numbers(width * width, 0.73));
                let factor = Rounded::new(&w, width);
                let mut out = vec![[0.0; 4].map(|_: f32| 1.0); rows * width];
                let mut made = [
                    vec![7.0; rows * width],
                    vec![1.0; rows * width],
                    vec![7.0; rows * width],
                    vec![1.0; rows * width],
                ];
                factor.multiply(&x, &mut made[0]);
                factor.multiply_add(&x, &mut made[1]);
                factor.multiply_transposed(&x, &mut made[2]);
                factor.multiply_transposed_add(&x, &mut made[3]);
                for (k, made) in made.iter().enumerate() {
                    out.iter_mut().zip(made).for_each(|(out, made)| out[k] = *made);
                }
                for (place, got) in out.iter().enumerate() {
                    let (i, j) = (place / width, place % width);
                    let of = |w: &dyn Fn(usize) -> f32| -> f64 {
                        (0..width).map(|l| as_rounded(x[i * width + l]) * as_rounded(w(l))).sum()
                    };
                    let (forward, backward) = (of(&|l| w[l * width + j]), of(&|l| w[j * width + l]));
                    let expected = [forward, 1.0 + forward, backward, 1.0 + backward];
                    for (got, expected) in got.iter().zip(expected) {
                        assert!(
                            (f64::from(*got) - expected).abs() < 4e-6,
                            "{rows} × {width} at {i}, {j}: {got} against {expected}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_rows_product_does_not_depend_on_the_rows_beside_it() {
        let (width, rows) = (150, 61);
        let (x, w) = (numbers(rows * width, 0.37), numbers(width * width, 0.73));
        let factor = Rounded::new(&w, width);
        let mut together = vec![0.0; rows * width];
        factor.multiply(&x, &mut together);
        for i in 0..rows {
            let mut alone = vec![0.0; width];
            factor.multiply(&x[i * width..][..width], &mut alone);
            assert_eq!(alone, together[i * width..][..width], "row {i}");
        }
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        let factor = Rounded::new(&[1.0, 0.0, 0.0, 1.0], 2);
        for bad in [f32::NAN, f32::from_bits(0x7fff_ffff), f32::INFINITY] {
            let mut out = [0.0; 2];
            factor.multiply(&[bad, 1.0], &mut out);
            assert!(!out[0].is_finite(), "{bad} became {}", out[0]);
        }
    }
}
