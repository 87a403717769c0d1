//! The networks of a latent model: clouds or pictures to a code, a code and a tool to the next code, a code to displacements.
use super::dense::{Finish, dense};
use super::layers::{Layers, Trainable};
use super::mixing::{Mixing, mix};
use super::parameters::{Parameters, Perceptron, Slots};
use super::record::{Matrix, Record};
use super::three_layers::ThreeLayers;
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
    /// Of a model that sees and tells pictures, how large these are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) picture: Option<PictureSize>,
}

/// Numbers of a picture that is seen, and of the field that is told of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PictureSize {
    pub(crate) seen: usize,
    pub(crate) told: usize,
}

/// Weights of the four networks.
#[derive(Clone, Debug)]
pub struct LatentNet {
    architecture: LatentArchitecture,
    parameters: Parameters,
    point: Option<Perceptron>,
    cloud: Perceptron,
    sample: Perceptron,
    next: ThreeLayers,
    decoder: ThreeLayers,
}

impl LatentNet {
    pub(crate) fn new(architecture: LatentArchitecture, seed: u64) -> Self {
        let LatentArchitecture { width, code, picture } = architecture;
        let mut slots = Slots::default();
        // A picture is seen whole, a cloud point by point.
        let point = picture.is_none().then(|| slots.perceptron("point", POINT, width, width, 1.0));
        let cloud = slots.perceptron("cloud", picture.map_or(width, |size| size.seen), width, code, 1.0);
        let sample = slots.perceptron("sample", SAMPLE, width, width, 1.0);
        let (inputs, outputs) = picture.map_or((code + POINT, 3), |size| (code, size.told));
        let next = ThreeLayers::new(&mut slots, "next", [code + width, width, code], 0.1);
        let decoder = ThreeLayers::new(&mut slots, "decoder", [inputs, width, outputs], 0.0);
        Self { architecture, parameters: Parameters::new(slots, seed), point, cloud, sample, next, decoder }
    }

    fn two<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, x: &Matrix, layers: &Perceptron) -> Matrix {
        let rows = x.shape().0;
        let (weight, bias) = self.parameters.layer(layers.first);
        let inner = dense(record, rows, &[(x, weight)], Some(bias), Finish::Squareplus);
        let (weight, bias) = self.parameters.layer(layers.last);
        dense(record, rows, &[(&inner, weight)], Some(bias), Finish::Linear)
    }
}

/// `z = MLP(mean MLP(xᵢ))` (Qi et al. 2017, eq. 1, with the mean): particles (N, 3) → (1, code).
pub(crate) struct Encode<'a> {
    pub(crate) net: &'a LatentNet,
    pub(crate) mean: Arc<Mixing>,
}

/// `z = MLP(h)`: a picture as one row → (1, code).
pub(crate) struct EncodePicture<'a> {
    pub(crate) net: &'a LatentNet,
}

impl Layers for EncodePicture<'_> {
    fn owner(&self) -> &Parameters {
        &self.net.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        self.net.two(record, &inputs[0], &self.net.cloud)
    }
}

impl Layers for Encode<'_> {
    fn owner(&self) -> &Parameters {
        &self.net.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        let point = self.net.point.as_ref().expect("a model that sees clouds has a network of points");
        let each = self.net.two(record, &inputs[0], point);
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
        self.net.next.run(&self.net.parameters, record, &[code, &action], Finish::Onto(code))
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
        self.net.decoder.run(&self.net.parameters, record, &[&codes, &inputs[1]], Finish::Linear)
    }
}

/// `field = MLP(z)`: (1, code) → a field as one row.
pub(crate) struct DecodePicture<'a> {
    pub(crate) net: &'a LatentNet,
}

impl Layers for DecodePicture<'_> {
    fn owner(&self) -> &Parameters {
        &self.net.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        self.net.decoder.run(&self.net.parameters, record, &[&inputs[0]], Finish::Linear)
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
        write!(f, "a code of {} numbers and networks of width {}", self.code, self.width)?;
        self.picture.map_or(Ok(()), |size| write!(f, " for pictures of {} numbers", size.seen))
    }
}
