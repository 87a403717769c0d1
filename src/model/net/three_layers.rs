//! Perceptrons of two hidden layers over one or several inputs side by side.
use super::dense::{Finish, dense};
use super::parameters::{ACTIVE_GAIN, Parameters, Slots};
use super::record::{Matrix, Record};
use dfdx::prelude::{Cpu, HasShape, Tape};

/// Places of three layers' weights and biases.
#[derive(Clone, Debug)]
pub(super) struct ThreeLayers([(usize, usize); 3]);

impl ThreeLayers {
    /// The last layer starts `last` times as large as would keep the variance.
    pub(super) fn new(slots: &mut Slots, name: &str, [inputs, width, outputs]: [usize; 3], last: f64) -> Self {
        Self([
            slots.layer(&format!("{name}.first"), inputs, width, 1.0),
            slots.layer(&format!("{name}.hidden"), width, width, ACTIVE_GAIN),
            slots.layer(&format!("{name}.last"), width, outputs, last * ACTIVE_GAIN),
        ])
    }

    /// Of inputs side by side, with weights of `parameters`.
    pub(super) fn run<T: Tape<f32, Cpu>>(
        &self,
        parameters: &Parameters,
        record: &mut Record<T>,
        inputs: &[&Matrix],
        finish: Finish<'_>,
    ) -> Matrix {
        let rows = inputs[0].shape().0;
        let (weight, bias) = self.0[0];
        let mut end = 0;
        let terms = inputs.iter().map(|x| {
            let start = end;
            end += x.shape().1;
            (*x, parameters.part(weight, start..end))
        });
        let terms: Vec<_> = terms.collect();
        let first = dense(record, rows, &terms, Some(&parameters[bias]), Finish::Squareplus);
        let (weight, bias) = parameters.layer(self.0[1]);
        let hidden = dense(record, rows, &[(&first, weight)], Some(bias), Finish::Squareplus);
        let (weight, bias) = parameters.layer(self.0[2]);
        dense(record, rows, &[(&hidden, weight)], Some(bias), finish)
    }
}
