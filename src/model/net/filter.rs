//! One linear filter over a picture.
use super::dense::{Finish, dense};
use super::layers::{Layers, Trainable};
use super::mixing::{Mixing, mix};
use super::parameters::{Parameters, Slots};
use super::picture::Size;
use super::record::{Matrix, Record};
use dfdx::prelude::{Cpu, Tape};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// What fixes a filter's weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FilterArchitecture {
    pub(crate) size: Size,
    /// Numbers a cell that it reads and writes.
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    /// Cells along a side of the neighbourhood, odd.
    pub(crate) width: usize,
}

/// `y_c = Σ_o W_o x_{c+o}` over the cells o of a square neighbourhood; zero until trained.
#[derive(Clone, Debug)]
pub(crate) struct Filter {
    architecture: FilterArchitecture,
    parameters: Parameters,
    weight: usize,
    neighbourhoods: Arc<Mixing>,
}

impl Filter {
    pub(crate) fn new(architecture: FilterArchitecture) -> Self {
        let FilterArchitecture { size, inputs, outputs, width } = architecture;
        let mut slots = Slots::default();
        let weight = slots.matrix("filter", width * width * inputs, outputs, 0.0);
        let neighbourhoods = Arc::new(size.neighbourhoods(width));
        Self { architecture, parameters: Parameters::new(slots, 0), weight, neighbourhoods }
    }
}

impl Layers for Filter {
    fn owner(&self) -> &Parameters {
        &self.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        let FilterArchitecture { size, width, .. } = self.architecture;
        let around = mix(record, &inputs[0], &self.neighbourhoods, width * width);
        dense(record, size.cells(), &[(&around, self.parameters.whole(self.weight))], None, Finish::Linear)
    }
}

impl Trainable for Filter {
    type Architecture = FilterArchitecture;

    fn architecture(&self) -> &FilterArchitecture {
        &self.architecture
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }
}

impl fmt::Display for FilterArchitecture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size: Size { rows, columns }, inputs, outputs, width } = self;
        write!(f, "a filter {width} cells wide on {rows} × {columns} cells of {inputs} numbers, {outputs} out")
    }
}
