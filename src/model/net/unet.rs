//! A small convolutional network over a picture, coarse to fine and back.
use super::dense::{Finish, dense};
use super::layers::{Layers, Trainable};
use super::mixing::{Mixing, mix};
use super::parameters::{ACTIVE_GAIN, Parameters, Slots};
use super::picture::Size;
use super::record::{Matrix, Record};
use dfdx::prelude::{Cpu, Tape};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// Cells along a side of every convolution's neighbourhood.
const SIDE: usize = 3;

/// What fixes a U-Net's weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct UNetArchitecture {
    pub(crate) size: Size,
    /// Numbers a cell that it reads and writes.
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    /// Channels at full resolution; twice as many at each coarser one.
    pub(crate) width: usize,
    /// Number of times that the resolution is halved.
    pub(crate) depth: usize,
}

/// Places of two convolutions' weights and biases.
type Pair = [(usize, usize); 2];

/// Convolutions of 3 × 3 cells, two a resolution on the way down and two on the way up, where what was seen at that resolution
/// stands beside what comes from below (Ronneberger, Fischer & Brox 2015); zero until its last layer is trained.
#[derive(Clone, Debug)]
pub(crate) struct UNet {
    architecture: UNetArchitecture,
    parameters: Parameters,
    /// From fine to coarse; the last is the bottom.
    down: Vec<Pair>,
    /// From coarse to fine.
    up: Vec<Pair>,
    last: (usize, usize),
    resolutions: Vec<Resolution>,
}

/// What a resolution's pictures are mixed by.
#[derive(Clone, Debug)]
struct Resolution {
    cells: usize,
    neighbourhoods: Arc<Mixing>,
    halving: Arc<Mixing>,
    doubling: Arc<Mixing>,
}

impl UNet {
    pub(crate) fn new(architecture: UNetArchitecture, seed: u64) -> Self {
        let UNetArchitecture { size, inputs, outputs, width, depth } = architecture;
        let mut slots = Slots::default();
        let area = SIDE * SIDE;
        let channels = |level: usize| width << level;
        let mut pair = |name: &str, level: usize, inputs: usize, gain: f64| {
            let own = channels(level);
            [
                slots.layer(&format!("{name}.{level}.first"), area * inputs, own, gain),
                slots.layer(&format!("{name}.{level}.last"), area * own, own, ACTIVE_GAIN),
            ]
        };
        let down = (0..=depth).map(|level| match level {
            0 => pair("down", 0, inputs, 1.0),
            _ => pair("down", level, channels(level - 1), ACTIVE_GAIN),
        });
        let down = down.collect();
        let up = (0..depth).rev().map(|level| pair("up", level, channels(level) + channels(level + 1), ACTIVE_GAIN));
        let up = up.collect();
        let last = slots.layer("last", width, outputs, 0.0);
        let sizes = std::iter::successors(Some(size), |size| Some(size.halved())).take(depth + 1);
        let resolution = |size: Size| Resolution {
            cells: size.cells(),
            neighbourhoods: Arc::new(size.neighbourhoods(SIDE)),
            halving: Arc::new(size.halving()),
            doubling: Arc::new(size.doubling()),
        };
        let resolutions = sizes.map(resolution).collect();
        Self { architecture, parameters: Parameters::new(slots, seed), down, up, last, resolutions }
    }

    /// A convolution of pictures side by side, and the activation.
    fn convolve<T: Tape<f32, Cpu>>(
        &self,
        record: &mut Record<T>,
        level: usize,
        pictures: &[&Matrix],
        layer: (usize, usize),
    ) -> Matrix {
        let Resolution { cells, neighbourhoods, .. } = &self.resolutions[level];
        let (weight, bias) = layer;
        let around: Vec<Matrix> = pictures.iter().map(|x| mix(record, x, neighbourhoods, SIDE * SIDE)).collect();
        let mut first = 0;
        let terms = around.iter().map(|x| {
            let rows = first..first + columns(x);
            first = rows.end;
            (x, self.parameters.part(weight, rows))
        });
        let terms: Vec<_> = terms.collect();
        dense(record, *cells, &terms, Some(&self.parameters[bias]), Finish::Squareplus)
    }
}

fn columns(x: &Matrix) -> usize {
    dfdx::prelude::HasShape::shape(x).1
}

impl Layers for UNet {
    fn owner(&self) -> &Parameters {
        &self.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        let mut picture = inputs[0].clone();
        let mut seen = Vec::new();
        for (level, [first, last]) in self.down.iter().enumerate() {
            if level > 0 {
                picture = mix(record, &picture, &self.resolutions[level - 1].halving, 1);
            }
            picture = self.convolve(record, level, &[&picture], *first);
            picture = self.convolve(record, level, &[&picture], *last);
            seen.push(picture.clone());
        }
        for (level, [first, last]) in (0..self.up.len()).rev().zip(&self.up) {
            let fine = mix(record, &picture, &self.resolutions[level].doubling, 1);
            picture = self.convolve(record, level, &[&seen[level], &fine], *first);
            picture = self.convolve(record, level, &[&picture], *last);
        }
        let (weight, bias) = self.parameters.layer(self.last);
        dense(record, self.resolutions[0].cells, &[(&picture, weight)], Some(bias), Finish::Linear)
    }
}

impl Trainable for UNet {
    type Architecture = UNetArchitecture;

    fn architecture(&self) -> &UNetArchitecture {
        &self.architecture
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }
}

impl fmt::Display for UNetArchitecture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size: Size { rows, columns }, inputs, outputs, width, depth } = self;
        write!(
            f,
            "a U-Net of {width} channels halved {depth} times on {rows} × {columns} cells of {inputs} numbers, {outputs} out"
        )
    }
}
