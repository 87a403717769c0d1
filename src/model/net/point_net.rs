//! What a network says of two clouds of points, whatever the order of the points.
use super::dense::Finish;
use super::layers::{Layers, Trainable};
use super::parameters::{Parameters, Slots};
use super::pool::greatest;
use super::record::{Matrix, Record};
use super::three_layers::ThreeLayers;
use dfdx::prelude::{Cpu, Tape};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Numbers of a point: its place.
const POINT: usize = 3;
/// Clouds that are looked at together: as it is, and as it should be.
const CLOUDS: usize = 2;

/// What fixes a network's weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PointNetArchitecture {
    /// Width of every hidden layer, and numbers that a cloud is summed up in.
    pub(crate) width: usize,
    /// Numbers that it says of a pair of clouds.
    pub(crate) outputs: usize,
}

/// `y = MLP([maxᵢ MLP(pᵢ), maxⱼ MLP(qⱼ)])` of clouds p and q, one network for the points of both (Qi et al. 2017, eq. 1); says
/// zero until its last layer is trained.
#[derive(Clone, Debug)]
pub(crate) struct PointNet {
    architecture: PointNetArchitecture,
    parameters: Parameters,
    point: ThreeLayers,
    head: ThreeLayers,
}

impl PointNet {
    /// Untrained weights, drawn from the stream of `seed`.
    pub(crate) fn new(architecture: PointNetArchitecture, seed: u64) -> Self {
        let PointNetArchitecture { width, outputs } = architecture;
        let mut slots = Slots::default();
        let point = ThreeLayers::new(&mut slots, "point", [POINT, width, width], 1.0);
        let head = ThreeLayers::new(&mut slots, "head", [CLOUDS * width, width, outputs], 0.0);
        Self { architecture, parameters: Parameters::new(slots, seed), point, head }
    }
}

/// What the network says of pairs of clouds: points (Σ counts, 3) → (pairs, outputs).
pub(crate) struct Judge<'a> {
    pub(crate) net: &'a PointNet,
    /// Number of points of each cloud, the two of a pair one after the other.
    pub(crate) counts: &'a [usize],
}

impl Layers for Judge<'_> {
    fn owner(&self) -> &Parameters {
        &self.net.parameters
    }

    fn run<T: Tape<f32, Cpu>>(&self, record: &mut Record<T>, inputs: &[Matrix]) -> Matrix {
        let Self { net, counts } = self;
        let each = net.point.run(&net.parameters, record, &[&inputs[0]], Finish::Linear);
        let pairs = greatest(record, &each, counts, CLOUDS);
        net.head.run(&net.parameters, record, &[&pairs], Finish::Linear)
    }
}

impl Trainable for PointNet {
    type Architecture = PointNetArchitecture;

    fn architecture(&self) -> &PointNetArchitecture {
        &self.architecture
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }
}

impl fmt::Display for PointNetArchitecture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a point network of width {} that says {} numbers", self.width, self.outputs)
    }
}

#[cfg(test)]
mod tests {
    use super::super::layers::{forward, pull};
    use super::*;
    use crate::state::stream;
    use rand::Rng;

    const COUNTS: [usize; 4] = [7, 5, 9, 1];

    fn shaken() -> PointNet {
        let mut net = PointNet::new(PointNetArchitecture { width: 8, outputs: 5 }, 1);
        let mut rng = stream(2, &[2]);
        let weights: Vec<f32> = net.weights().iter().map(|w| w + rng.random_range(-0.3..0.3)).collect();
        net.set_weights(&weights);
        net
    }

    fn points() -> Vec<f32> {
        let mut rng = stream(3, &[3]);
        (0..3 * COUNTS.iter().sum::<usize>()).map(|_| rng.random_range(-1.0..1.0)).collect()
    }

    fn said(net: &PointNet, points: &[f32]) -> Vec<f32> {
        forward(&Judge { net, counts: &COUNTS }, vec![(points.to_vec(), POINT)])
    }

    #[test]
    fn gradients_of_weights_and_points_agree_with_differences() {
        let (net, points) = (shaken(), points());
        let mut rng = stream(4, &[4]);
        let at: Vec<f32> = (0..10).map(|_| rng.random_range(-1.0..1.0)).collect();
        let mut by_weights = vec![0.0; net.weights().len()];
        let judge = Judge { net: &net, counts: &COUNTS };
        let (out, mut pulled) = pull(&judge, vec![(points.clone(), POINT)], &at, &mut by_weights);
        assert_eq!(out, said(&net, &points));
        let by_points = pulled.remove(0);
        let value = |out: &[f32]| -> f64 { out.iter().zip(&at).map(|(y, g)| f64::from(y * g)).sum() };
        for _ in 0..20 {
            let mut direction =
                |count: usize| -> Vec<f32> { (0..count).map(|_| rng.random_range(-1.0..1.0)).collect() };
            let (dw, dx) = (direction(by_weights.len()), direction(by_points.len()));
            let along = |h: f32| {
                let mut moved = net.clone();
                let weights: Vec<f32> = net.weights().iter().zip(&dw).map(|(w, d)| w + h * d).collect();
                moved.set_weights(&weights);
                let there: Vec<f32> = points.iter().zip(&dx).map(|(x, d)| x + h * d).collect();
                value(&said(&moved, &there))
            };
            let dot = |a: &[f32], b: &[f32]| -> f64 { a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum() };
            let found = dot(&by_weights, &dw) + dot(&by_points, &dx);
            let expected = (along(5e-4) - along(-5e-4)) / 1e-3;
            assert!((found - expected).abs() < 0.01 * (1.0 + expected.abs()), "{found} against {expected}");
            assert!(expected.abs() > 1e-3, "nothing depends on anything");
        }
    }

    #[test]
    fn pairs_that_are_judged_together_are_judged_as_alone() {
        let (net, points) = (shaken(), points());
        let both = said(&net, &points);
        let alone =
            |counts: &[usize], points: &[f32]| forward(&Judge { net: &net, counts }, vec![(points.to_vec(), POINT)]);
        let cut = 3 * (COUNTS[0] + COUNTS[1]);
        let each = [alone(&COUNTS[..2], &points[..cut]), alone(&COUNTS[2..], &points[cut..])].concat();
        assert!(both.iter().zip(&each).all(|(a, b)| (a - b).abs() < 1e-5), "{both:?} against {each:?}");
    }

    #[test]
    fn what_is_not_a_number_is_not_hidden_by_the_maximum() {
        let (net, mut points) = (shaken(), points());
        points[4] = f32::NAN;
        assert!(said(&net, &points)[..5].iter().all(|y| y.is_nan()));
    }
}
