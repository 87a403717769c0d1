//! Sinkhorn divergence.
use super::transport::{Cloud, Effort, between, within};
use super::{ShapeLoss, is_finite};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Sinkhorn`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SinkhornSpec {
    /// ε over the goal's size, which is the root mean square distance of its points from their mean.
    #[serde(default = "epsilon")]
    #[schemars(range(min = 1e-4, max = 100.0))]
    pub epsilon: f64,
    /// Error of the plan's marginals, as a share of the mass, at which iterations end.
    #[serde(default = "tolerance")]
    #[schemars(range(min = 1e-12, max = 0.1))]
    pub tolerance: f64,
    /// Iterations at most.
    #[serde(default = "iterations")]
    #[schemars(range(min = 1))]
    pub iterations: usize,
}

fn epsilon() -> f64 {
    0.05
}

fn tolerance() -> f64 {
    1e-6
}

fn iterations() -> usize {
    1000
}

impl Default for SinkhornSpec {
    fn default() -> Self {
        Self { epsilon: epsilon(), tolerance: tolerance(), iterations: iterations() }
    }
}

impl SinkhornSpec {
    /// The divergence.
    ///
    /// # Errors
    /// A sentence naming the number that is impossible.
    pub fn build(self) -> anyhow::Result<Sinkhorn> {
        let Self { epsilon, tolerance, iterations } = self;
        ensure!((1e-4..=100.0).contains(&epsilon), "cost.epsilon must be within 1e-4 … 100 sizes, got {epsilon}");
        ensure!((1e-12..=0.1).contains(&tolerance), "cost.tolerance must be within 1e-12 … 0.1, got {tolerance}");
        ensure!(iterations > 0, "cost.iterations must be at least 1, got 0");
        Ok(Sinkhorn::of(&self))
    }
}

/// `S_ε(a, b) = OT_ε(a, b) − ½ OT_ε(a, a) − ½ OT_ε(b, b)` \[m\] with the distance |aᵢ − bⱼ| as cost and equal weights
/// (Feydy, Séjourné, Vialard, Amari, Trouvé & Peyré 2019, equation 3).
///
/// It is zero only where the clouds are equal, tends to the earth mover's distance as ε → 0, and needs neither correspondence nor
/// equal sizes. The value is exact to the order of the tolerance squared, the gradient to
/// a few times the tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Sinkhorn {
    /// ε over the goal's size.
    epsilon: f64,
    effort: Effort,
}

/// What the entropic transport between two clouds came to, beside the divergence.
#[derive(Clone, Copy, Debug)]
pub struct Entropic {
    /// ε \[m\].
    pub epsilon: f64,
    /// `OT_ε(a, b) = Σ πᵢⱼ |aᵢ − bⱼ| + ε KL(π | α ⊗ β)` \[m\].
    pub value: f64,
    /// `Σ πᵢⱼ |aᵢ − bⱼ|` \[m\].
    pub carried: f64,
    /// Error of the plan's marginals, as a share of the mass.
    pub error: f64,
}

impl Sinkhorn {
    /// The divergence that `spec` describes, whose numbers are taken to be possible.
    pub(super) fn of(spec: &SinkhornSpec) -> Self {
        let effort = Effort { tolerance: spec.tolerance, iterations: spec.iterations };
        Self { epsilon: spec.epsilon, effort }
    }

    /// The transport between two clouds by itself, without what makes it a divergence; `None` when a cloud is empty or not
    /// finite, or all goal points are one.
    pub fn transport(&self, points: &[DVec3], goal: &[DVec3]) -> Option<Entropic> {
        let epsilon = self.epsilon(points, goal)?;
        let (a, b) = (Cloud::of(points), Cloud::of(goal));
        let found = between(&a, &b, epsilon, self.effort);
        Some(Entropic { epsilon, value: found.value(), carried: found.carried(), error: found.error })
    }

    /// ε \[m\]: it hangs on the goal alone, which no planner moves, so that it has no gradient.
    fn epsilon(&self, points: &[DVec3], goal: &[DVec3]) -> Option<f64> {
        if points.is_empty() || goal.is_empty() || !is_finite(points) || !is_finite(goal) {
            return None;
        }
        let mean = goal.iter().sum::<DVec3>() / goal.len() as f64;
        let size = (goal.iter().map(|p| p.distance_squared(mean)).sum::<f64>() / goal.len() as f64).sqrt();
        // A size that is rounding error is none.
        let least = 1e-9 * goal.iter().map(|p| p.length()).fold(0.0, f64::max);
        (size > least).then_some(self.epsilon * size)
    }
}

impl ShapeLoss for Sinkhorn {
    fn value(&self, points: &[DVec3], goal: &[DVec3]) -> f64 {
        let Some(epsilon) = self.epsilon(points, goal) else { return to_one_point(points, goal) };
        let (a, b) = (Cloud::of(points), Cloud::of(goal));
        let own = |cloud| within(cloud, epsilon, self.effort).value();
        // A divergence is at least zero; what is below it is what the iterations left.
        (between(&a, &b, epsilon, self.effort).value() - 0.5 * (own(&a) + own(&b))).max(0.0)
    }

    fn gradient(&self, points: &[DVec3], goal: &[DVec3]) -> Vec<DVec3> {
        let Some(epsilon) = self.epsilon(points, goal) else { return toward_one_point(points, goal) };
        let (a, b) = (Cloud::of(points), Cloud::of(goal));
        let own = within(&a, epsilon, self.effort).pull();
        // Both arguments of OT_ε(a, a) move: twice its half is the whole.
        between(&a, &b, epsilon, self.effort).pull().into_iter().zip(own).map(|(pull, own)| pull - own).collect()
    }
}

/// The mean distance to a goal whose points are one, which every plan costs; `∞` where there is none.
fn to_one_point(points: &[DVec3], goal: &[DVec3]) -> f64 {
    match goal.first() {
        Some(one) if !points.is_empty() && is_finite(points) && is_finite(goal) => {
            points.iter().map(|p| p.distance(*one)).sum::<f64>() / points.len() as f64
        }
        _ => f64::INFINITY,
    }
}

fn toward_one_point(points: &[DVec3], goal: &[DVec3]) -> Vec<DVec3> {
    let finite = is_finite(points) && is_finite(goal);
    let one = goal.first().filter(|_| finite);
    points.iter().map(|p| one.map_or(DVec3::ZERO, |q| (p - q).normalize_or_zero() / points.len() as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::tests::cloud;
    use crate::metric::{EMD_LIMIT, Emd};

    fn sinkhorn(epsilon: f64) -> Sinkhorn {
        Sinkhorn::of(&SinkhornSpec { epsilon, tolerance: 1e-10, iterations: 5000 })
    }

    /// Sinkhorn's algorithm as Cuturi (2013) writes it, without logarithms: `OT_ε` and `Σ πᵢⱼ |aᵢ − bⱼ|`.
    fn naive(a: &[DVec3], b: &[DVec3], epsilon: f64) -> (f64, f64) {
        let (n, m) = (a.len() as f64, b.len() as f64);
        let kernel = |p: &DVec3, q: &DVec3| (-p.distance(*q) / epsilon).exp() / (n * m);
        let (mut u, mut v) = (vec![1.0; a.len()], vec![1.0; b.len()]);
        for _ in 0..3_000 {
            u = a.iter().map(|p| 1.0 / n / b.iter().zip(&v).map(|(q, v)| kernel(p, q) * v).sum::<f64>()).collect();
            v = b.iter().map(|q| 1.0 / m / a.iter().zip(&u).map(|(p, u)| kernel(p, q) * u).sum::<f64>()).collect();
        }
        let (mut carried, mut divergence) = (0.0, 0.0);
        for (p, u) in a.iter().zip(&u) {
            for (q, v) in b.iter().zip(&v) {
                let mass = u * kernel(p, q) * v;
                carried += mass * p.distance(*q);
                divergence += mass * (mass * n * m).ln();
            }
        }
        (carried + epsilon * divergence, carried)
    }

    #[test]
    fn it_agrees_with_the_naive_algorithm_on_unequal_clouds() {
        let (a, b) = (cloud(23, 1), cloud(14, 2));
        for epsilon in [1.0, 0.3] {
            let found = sinkhorn(epsilon).transport(&a, &b).unwrap();
            let (value, carried) = naive(&a, &b, found.epsilon);
            assert!((found.value - value).abs() < 1e-12, "{found:?} against {value}");
            assert!((found.carried - carried).abs() < 1e-9, "{found:?} against {carried}");
            let own = |x: &[DVec3]| naive(x, x, found.epsilon).0;
            let expected = value - 0.5 * (own(&a) + own(&b));
            let divergence = sinkhorn(epsilon).value(&a, &b);
            assert!((divergence - expected).abs() < 1e-12, "{divergence} against {expected}");
        }
    }

    #[test]
    fn one_point_to_two_by_hand() {
        let (a, b) = ([DVec3::new(0.2, 0.9, 0.1)], [DVec3::ZERO, DVec3::X]);
        for epsilon in [0.01_f64, 0.3, 2.0] {
            // The size of the goal is 1/2; its own plan has two kinds of entries.
            let e = 0.5 * epsilon;
            let own = e * (2.0 / (1.0 + (-1.0 / e).exp())).ln();
            let expected = 0.5 * (a[0].distance(b[0]) + a[0].distance(b[1])) - 0.5 * own;
            let found = sinkhorn(epsilon).value(&a, &b);
            assert!((found - expected).abs() < 1e-12, "ε = {epsilon}: {found} against {expected}");
        }
        assert_eq!(sinkhorn(0.1).value(&b, &a), 0.5 * (a[0].distance(b[0]) + a[0].distance(b[1])));
    }

    #[test]
    fn it_is_zero_on_itself_and_tends_to_the_exact_distance() {
        let (a, b) = (cloud(60, 1), cloud(60, 2));
        assert!(sinkhorn(0.05).value(&a, &a) < 1e-12);
        let exact = Emd.value(&a, &b);
        let gap = |epsilon| (1.0 - sinkhorn(epsilon).value(&a, &b) / exact).abs();
        assert!(gap(0.02) < 0.04 && gap(0.004) < 0.003, "{} and {}", gap(0.02), gap(0.004));
    }

    #[test]
    fn a_cloud_that_slides_away_goes_as_far_as_it_slid() {
        let a = cloud(EMD_LIMIT + 88, 1);
        let slid: Vec<DVec3> = a.iter().map(|p| *p + DVec3::new(0.3, -0.4, 1.2)).collect();
        let distance = Emd.value(&slid, &a);
        assert!((distance / 1.3 - 1.0).abs() < 0.01, "{distance}");
    }

    #[test]
    fn results_are_the_same_bits_on_any_number_of_threads() {
        let (a, b) = (cloud(200, 1), cloud(150, 2));
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| (Emd.value(&a, &b), Emd.gradient(&a, &b)))
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn impossible_numbers_are_refused_and_clouds_without_size_have_a_distance() {
        for text in ["epsilon = 0.0", "tolerance = 0.0", "iterations = 0", "epsilon = nan"] {
            assert!(toml_edit::de::from_str::<SinkhornSpec>(text).unwrap().build().is_err(), "{text}");
        }
        let (a, one) = (cloud(9, 1), vec![DVec3::Y; 4]);
        let mean = a.iter().map(|p| p.distance(DVec3::Y)).sum::<f64>() / 9.0;
        assert!((sinkhorn(0.1).value(&a, &one) - mean).abs() < 1e-15);
        assert!(sinkhorn(0.1).value(&one, &a).is_finite());
        assert_eq!(sinkhorn(0.1).value(&[], &a), f64::INFINITY);
        assert_eq!(sinkhorn(0.1).value(&[DVec3::NAN], &one), f64::INFINITY);
    }
}
