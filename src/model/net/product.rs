//! Matrix products by the `gemm` crate, behind a safe face: a row's product does not depend on the rows beside it, bit for bit.
use gemm::{Parallelism, gemm};

/// What the entries of matrices may be.
pub(super) trait Number: Copy + PartialEq + From<u8> + 'static {}

impl Number for f32 {}
impl Number for f64 {}

/// A row-major matrix over a slice, or its transpose.
#[derive(Clone, Copy)]
pub(super) struct Block<'a, T = f32> {
    data: &'a [T],
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
}

impl<'a, T> Block<'a, T> {
    /// `data` as rows of `columns` numbers.
    pub(super) fn new(data: &'a [T], columns: usize) -> Self {
        assert_eq!(data.len() % columns, 0, "whole rows");
        Self { data, rows: data.len() / columns, columns, row_stride: columns, column_stride: 1 }
    }

    /// The transpose, without moving anything.
    pub(super) fn transposed(self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
            ..self
        }
    }
}

/// `out = a b`, row-major.
pub(super) fn multiply<T: Number>(a: Block<'_, T>, b: Block<'_, T>, out: &mut [T]) {
    run(a, b, out, T::from(0));
}

/// `out += a b`, row-major.
pub(super) fn multiply_add<T: Number>(a: Block<'_, T>, b: Block<'_, T>, out: &mut [T]) {
    run(a, b, out, T::from(1));
}

fn run<T: Number>(a: Block<'_, T>, b: Block<'_, T>, out: &mut [T], keep: T) {
    assert_eq!(a.columns, b.rows, "inner dimensions");
    assert_eq!(out.len(), a.rows * b.columns, "outer dimensions");
    if out.is_empty() {
        return;
    }
    if a.rows == 1 {
        // A lone row would be multiplied in another order of additions.
        let mut twice = out.repeat(2);
        run(Block::new(&a.data.repeat(2), a.columns.max(1)), b, &mut twice, keep);
        return out.copy_from_slice(&twice[..out.len()]);
    }
    // SAFETY: a `Block` covers exactly rows × columns elements of a live slice through its two strides (1 and the length of a
    // stored row, in either order), `out` holds rows × columns of the product contiguously, and being `&mut` overlaps neither.
    unsafe {
        gemm(
            a.rows,
            b.columns,
            a.columns,
            out.as_mut_ptr(),
            1,
            b.columns as isize,
            keep != T::from(0),
            a.data.as_ptr(),
            a.column_stride as isize,
            a.row_stride as isize,
            b.data.as_ptr(),
            b.column_stride as isize,
            b.row_stride as isize,
            keep,
            T::from(1),
            false,
            false,
            false,
            Parallelism::None,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_the_same_product_whatever_is_beside_it() {
        let fill = |n: usize, s: f32| -> Vec<f32> { (0..n).map(|i| ((i as f32 + s) * 0.7).sin()).collect() };
        for (rows, k, n) in [(70, 64, 64), (13, 10, 64), (200, 150, 150), (5, 64, 3)] {
            let (a, b, base) = (fill(rows * k, 0.1), fill(k * n, 0.5), fill(rows * n, 0.9));
            let mut together = base.clone();
            multiply_add(Block::new(&a, k), Block::new(&b, n), &mut together);
            for count in [1, 2, 3] {
                for first in (0..rows - count).step_by(3) {
                    let mut own = base[first * n..(first + count) * n].to_vec();
                    multiply_add(Block::new(&a[first * k..(first + count) * k], k), Block::new(&b, n), &mut own);
                    assert_eq!(own, together[first * n..(first + count) * n], "{count} of {rows} × {k} × {n}");
                }
            }
        }
    }

    #[test]
    fn products_and_transposes_agree_with_three_loops() {
        let fill = |n: usize, s: f32| -> Vec<f32> { (0..n).map(|i| ((i as f32 + s) * 0.7).sin()).collect() };
        for (m, k, n) in [(1, 1, 1), (5, 10, 64), (129, 64, 3), (33, 7, 17), (4, 0, 3)] {
            let (a, b) = (fill(m * k, 0.1), fill(k * n, 0.5));
            let mut expected = vec![1.0f32; m * n];
            for i in 0..m {
                for j in 0..n {
                    expected[i * n + j] += (0..k).map(|l| a[i * k + l] * b[l * n + j]).sum::<f32>();
                }
            }
            let close = |x: &[f32]| x.iter().zip(&expected).all(|(x, y)| (x - y).abs() < 1e-4);
            let mut out = vec![1.0; m * n];
            let (a_block, b_block) = if k > 0 {
                (Block::new(&a, k), Block::new(&b, n))
            } else {
                (Block::new(&a, m).transposed(), Block::new(&b, n))
            };
            multiply_add(a_block, b_block, &mut out);
            assert!(close(&out), "{m} {k} {n}");
            if k > 0 {
                let turned: Vec<f32> = (0..k * m).map(|i| a[(i % m) * k + i / m]).collect();
                let mut out = vec![7.0; m * n];
                multiply(Block::new(&turned, m).transposed(), b_block, &mut out);
                out.iter_mut().for_each(|x| *x += 1.0);
                assert!(close(&out), "transposed {m} {k} {n}");
            }
        }
    }
}
