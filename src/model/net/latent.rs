//! The networks of a latent model: clouds to a code, a code and a tool to the next code, a code to displacements.
use super::dense::{Finish, dense};
use super::layers::{Layers, Trainable};
use super::mixing::{Mixing, mix};
use super::parameters::{ACTIVE_GAIN, Parameters, Perceptron, Slots};
use super::record::{Matrix, Record};
use dfdx::prelude::{Cpu, HasShape, Tape};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// Numbers of a particle: its place.
pub(crate) const POINT: usize = 3;
/// Numbers of a sample of the tool's surface: place, displacement, normal.
pub(crate) const SAMPLE: usize = 9;

/// What fixes a latent model's weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LatentArchitecture {
    /// Width of every hidden layer.
    pub(crate) width: usize,
    /// Length of the code.
    pub(crate) code: usize,
}

/// Places of three layers' weights and biases.
type Three = [(usize, usize); 3];

/// Weights of the four networks.
#[derive(Clone, Debug)]
pub(crate) struct LatentNet {
    architecture: LatentArchitecture,
    parameters: Parameters,
    point: Perceptron,
    cloud: Perceptron,
    sample: Perceptron,
    next: Three,
    decoder: Three,
}

impl LatentNet {
    pub(crate) fn new(architecture: LatentArchitecture, seed: u64) -> Self {
        let LatentArchitecture { width, code } = architecture;
        let mut slots = Slots::default();
        let point = slots.perceptron("point", POINT, width, width, 1.0);
        let cloud = slots.perceptron("cloud", width, width, code, 1.0);
        let sample = slots.perceptron("sample", SAMPLE, width, width, 1.0);
        let mut three = |name: &str, inputs: usize, outputs: usize, last: f64| {
            [
                slots.layer(&format!("{name}.first"), inputs, width, 1.0),
                slots.layer(&format!("{name}.hidden"), width, width, ACTIVE_GAIN),
                slots.layer(&format!("{name}.last"), width, outputs, last * ACTIVE_GAIN),
            ]
        };
        let (next, decoder) = (three("next", code + width, code, 0.1), three("decoder", code + POINT, 3, 0.0));
        Self { architecture, parameters: Parameters::new(slots, seed), point, cloud, sample, next, decoder }
    }

    fn two<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, x: &Matrix, layers: &Perceptron) -> Matrix {
        let rows = x.shape().0;
        let (weight, bias) = self.parameters.layer(layers.first);
        let inner = dense(record, rows, &[(x, weight, 0)], Some(bias), Finish::Squareplus);
        let (weight, bias) = self.parameters.layer(layers.last);
        dense(record, rows, &[(&inner, weight, 0)], Some(bias), Finish::Linear)
    }

    /// Of two inputs side by side.
    fn three<T: Tape<f32, Cpu>>(
        &self,
        record: &mut Record<T>,
        [a, b]: [&Matrix; 2],
        layers: &Three,
        finish: Finish<'_>,
    ) -> Matrix {
        let rows = a.shape().0;
        let (weight, bias) = self.parameters.layer(layers[0]);
        let terms = [(a, weight, 0), (b, weight, a.shape().1)];
        let first = dense(record, rows, &terms, Some(bias), Finish::Squareplus);
        let (weight, bias) = self.parameters.layer(layers[1]);
        let hidden = dense(record, rows, &[(&first, weight, 0)], Some(bias), Finish::Squareplus);
        let (weight, bias) = self.parameters.layer(layers[2]);
        dense(record, rows, &[(&hidden, weight, 0)], Some(bias), finish)
    }
}

/// `z = MLP(mean MLP(xᵢ))` (Qi et al. 2017, eq. 1, with the mean): particles (N, 3) → (1, code).
pub(crate) struct Encode<'a> {
    pub(crate) net: &'a LatentNet,
    pub(crate) mean: Arc<Mixing>,
}

impl Layers for Encode<'_> {
    fn owner(&self) -> &Parameters {
        &self.net.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        let each = self.net.two(record, &inputs[0], &self.net.point);
        let mean = mix(record, &each, &self.mean, 1);
        self.net.two(record, &mean, &self.net.cloud)
    }
}

/// `z' = z + MLP([z, mean MLP(sⱼ)])` over the tool's samples s: codes (1, code) and samples (P, 9) → (1, code).
pub(crate) struct Advance<'a> {
    pub(crate) net: &'a LatentNet,
    pub(crate) mean: Arc<Mixing>,
}

impl Layers for Advance<'_> {
    fn owner(&self) -> &Parameters {
        &self.net.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        let (code, samples) = (&inputs[0], &inputs[1]);
        let each = self.net.two(record, samples, &self.net.sample);
        let action = mix(record, &each, &self.mean, 1);
        self.net.three(record, [code, &action], &self.net.next, Finish::Onto(code))
    }
}

/// `dᵢ = MLP([z, xᵢ])`: codes (1, code) and particles (N, 3) → (N, 3), as a template is folded (Yang et al. 2018).
pub(crate) struct Decode<'a> {
    pub(crate) net: &'a LatentNet,
    pub(crate) copies: Arc<Mixing>,
}

impl Layers for Decode<'_> {
    fn owner(&self) -> &Parameters {
        &self.net.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        let codes = mix(record, &inputs[0], &self.copies, 1);
        self.net.three(record, [&codes, &inputs[1]], &self.net.decoder, Finish::Linear)
    }
}

impl Trainable for LatentNet {
    type Architecture = LatentArchitecture;

    fn architecture(&self) -> &LatentArchitecture {
        &self.architecture
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }
}

impl fmt::Display for LatentArchitecture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a code of {} numbers and networks of width {}", self.code, self.width)
    }
}
