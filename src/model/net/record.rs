//! Where operations write down how to undo themselves: dfdx's tape, and what is wanted from it.
use dfdx::prelude::{
    Backward, Cpu, Gradients, HasShape, NoneTape, OwnedTape, PutTape, Rank0, SumTo, Tape, Tensor, TensorFromVec,
};

/// A matrix on dfdx's CPU.
pub(crate) type Matrix<T = NoneTape> = Tensor<(usize, usize), f32, Cpu, T>;

/// Which derivatives a backward sweep should compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Of inputs alone: planning.
    Inputs,
    /// Of inputs and weights: training.
    InputsAndWeights,
}

impl Wanted {
    /// What is wanted by who adds weights' derivatives to `weights`, empty where nobody asks.
    pub(crate) fn of(weights: &[f32]) -> Self {
        if weights.is_empty() { Self::Inputs } else { Self::InputsAndWeights }
    }
}

/// A tape and what is wanted from it; with `NoneTape` operations save nothing.
pub(crate) struct Record<T> {
    pub(super) tape: T,
    pub(super) wanted: Wanted,
    device: Cpu,
}

impl<T: Tape<f32, Cpu>> Record<T> {
    /// An empty record; its device is its own, so that threads share no allocator state.
    pub(super) fn new(wanted: Wanted) -> Self {
        Self { tape: T::default(), wanted, device: Cpu::default() }
    }

    /// A matrix from its rows, without copying.
    pub(super) fn matrix(&self, rows: Vec<f32>, columns: usize) -> Matrix {
        let count = rows.len() / columns;
        self.device.tensor_from_vec(rows, (count, columns))
    }
}

impl Record<OwnedTape<f32, Cpu>> {
    /// Derivatives of `output · at_output` by all that was recorded.
    pub(super) fn backward(self, output: Matrix, at_output: &[f32]) -> Gradients<f32, Cpu> {
        let cotangent = self.matrix(at_output.to_vec(), output.shape().1);
        (output.put_tape(self.tape) * cotangent).sum::<Rank0, _>().backward()
    }
}

/// The numbers of a contiguous matrix, row after row.
pub(super) fn entries(matrix: &Matrix) -> &[f32] {
    let &(rows, columns) = matrix.shape();
    if rows * columns == 0 {
        return &[];
    }
    let (first, last) = (&matrix[[0, 0]], &matrix[[rows - 1, columns - 1]]);
    let length = rows * columns;
    assert_eq!((first as *const f32).wrapping_add(length - 1), last as *const f32, "a contiguous matrix");
    // SAFETY: both ends lie in the matrix's one allocation, which lives as long as the borrow, and the assertion shows that
    // exactly `length` elements lie between them.
    unsafe { std::slice::from_raw_parts(first, length) }
}

/// Moves the gradient of a tensor (or its ghost) out of `$grads`, zero if nothing arrived there.
macro_rules! taken {
    ($grads:expr, $tensor:expr) => {
        std::mem::take(&mut **$grads.get_or_alloc_mut($tensor)?)
    };
}
pub(super) use taken;

/// The gradient of `matrix`, to add to.
pub(super) fn gradient<'a>(
    grads: &'a mut Gradients<f32, Cpu>,
    matrix: &Matrix,
) -> Result<&'a mut [f32], dfdx::prelude::CpuError> {
    Ok(&mut **grads.get_or_alloc_mut(matrix)?)
}

/// `total += Σ rows`.
pub(super) fn add_rows(rows: &[f32], total: &mut [f32]) {
    for row in rows.chunks_exact(total.len()) {
        total.iter_mut().zip(row).for_each(|(t, x)| *t += x);
    }
}
