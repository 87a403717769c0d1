//! Entropic optimal transport between two clouds.
use super::gibbs::Gibbs;
use super::morton::along_curve;
use super::softmin::{Lanes, NEGLIGIBLE, grouped_points, softmin};
use glam::DVec3;
use rayon::prelude::*;

/// When an iteration stops.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// The error of the plan's marginals that is good enough: `Σᵢ |Σⱼ πᵢⱼ − 1/N|`.
    pub(super) tolerance: f64,
    /// Iterations at most.
    pub(super) iterations: usize,
}

/// Finite points, at least one, each of the same weight, ordered along a curve so that neighbours share a group.
pub(super) struct Cloud {
    order: Vec<usize>,
    points: Vec<DVec3>,
    groups: Vec<[Lanes; 3]>,
}

impl Cloud {
    pub(super) fn of(points: &[DVec3]) -> Self {
        let order = along_curve(points);
        let points: Vec<DVec3> = order.iter().map(|&i| points[i]).collect();
        Self { groups: grouped_points(&points), points, order }
    }
}

/// The potentials of `OT_ε(α, β) = min over plans π of Σ πᵢⱼ |aᵢ − bⱼ| + ε KL(π | α ⊗ β)` (Cuturi 2013), for N and M points of
/// weights 1/N and 1/M: the plan is `πᵢⱼ = exp((fᵢ + gⱼ − |aᵢ − bⱼ|)/ε)/(N M)`.
pub(super) struct Potentials<'a> {
    a: &'a Cloud,
    b: &'a Cloud,
    f: Vec<f64>,
    g: Vec<f64>,
    epsilon: f64,
    /// Error of the marginals at the last iteration.
    pub(super) error: f64,
}

/// A kernel is made anew when a potential has moved by more than this many ε.
const MOVED: f64 = 10.0;
/// Each ε of the descent over the one before, and the error of the marginals at which the next one takes over.
const DESCENT: f64 = 0.25;
const ROUGH: f64 = 0.05;

/// Solves between two clouds: Sinkhorn's algorithm with ε descending to its value (Schmitzer 2019), products with a sparse kernel
/// between exact steps in the log domain, over-relaxed (Thibault, Chizat, Dossal & Papadakis 2021).
pub(super) fn between<'a>(a: &'a Cloud, b: &'a Cloud, epsilon: f64, effort: Effort) -> Potentials<'a> {
    // Where the clouds nearly coincide, iterations from afar are slowest, and the goal's own potentials all but solve it.
    let own = within(b, epsilon, Effort { iterations: effort.iterations.min(20), ..effort });
    let mut now = Potentials { a, f: Vec::new(), ..own };
    now.project();
    now.scale(ROUGH, &mut 0);
    if now.error > ROUGH {
        let farthest = b.points.iter().map(|p| p.distance(a.points[0])).fold(0.0, f64::max);
        now = Potentials { g: vec![0.0; b.points.len()], epsilon: farthest.max(epsilon), ..now };
    }
    let mut left = effort.iterations;
    loop {
        now.project();
        let last = now.epsilon == epsilon;
        let settled = now.scale(if last { effort.tolerance } else { ROUGH }, &mut left);
        if last && (settled || left == 0) {
            // The last half step is exact, so that the plan holds all mass and the value is a lower bound.
            now.g = softmin(&b.points, &a.groups, &now.f, epsilon);
            return now;
        }
        if settled || left == 0 {
            now.epsilon = (now.epsilon * DESCENT).max(epsilon);
        }
    }
}

/// Solves between a cloud and itself, where `f = g` (the symmetric iteration of Feydy et al. 2019).
///
/// The plan's spectrum lies in \[0, 1\], so that a step of 2/3 toward the soft minimum leaves at most a third of the error.
pub(super) fn within(a: &Cloud, epsilon: f64, effort: Effort) -> Potentials<'_> {
    let mut f = vec![0.0; a.points.len()];
    for left in (0..effort.iterations).rev() {
        let new = softmin(&a.points, &a.groups, &f, epsilon);
        let error = f.iter().zip(&new).map(|(old, new)| (((old - new) / epsilon).exp() - 1.0).abs()).sum::<f64>();
        let error = error / f.len() as f64;
        if error <= effort.tolerance || left == 0 {
            return Potentials { a, b: a, g: new, f, epsilon, error };
        }
        f.iter_mut().zip(new).for_each(|(old, new)| *old += 2.0 / 3.0 * (new - *old));
    }
    unreachable!("at least one iteration was asked for")
}

impl Potentials<'_> {
    /// `OT_ε` \[m\], from below: the dual value, whose error is of second order in that of the marginals.
    pub(super) fn value(&self) -> f64 {
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        mean(&self.f) + mean(&self.g)
    }

    /// `Σⱼ πᵢⱼ h(|aᵢ − bⱼ|, aᵢ − bⱼ)` for every row i of `a`, in the rows' own order.
    fn over_plan<T: Copy + Send + Default + std::ops::AddAssign + std::ops::Mul<f64, Output = T>>(
        &self,
        h: impl Fn(f64, DVec3) -> T + Sync,
    ) -> Vec<T> {
        let mass = 1.0 / (self.f.len() * self.g.len()) as f64;
        let row = |(p, f): (&DVec3, &f64)| {
            let mut sum = T::default();
            for (q, g) in self.b.points.iter().zip(&self.g) {
                let (apart, distance) = (*p - *q, p.distance(*q));
                let z = (f + g - distance) / self.epsilon;
                if z > NEGLIGIBLE {
                    sum += h(distance, apart) * (mass * z.exp());
                }
            }
            sum
        };
        let sums: Vec<T> = self.a.points.par_iter().zip(&self.f).map(row).collect();
        let mut out = vec![T::default(); sums.len()];
        self.a.order.iter().zip(sums).for_each(|(&i, sum)| out[i] = sum);
        out
    }

    /// `∂OT_ε/∂aᵢ = Σⱼ πᵢⱼ (aᵢ − bⱼ)/|aᵢ − bⱼ|`, by the envelope theorem with the plan held.
    pub(super) fn pull(&self) -> Vec<DVec3> {
        self.over_plan(|distance, apart| if distance > 0.0 { apart / distance } else { DVec3::ZERO })
    }

    /// `Σ πᵢⱼ |aᵢ − bⱼ|` \[m\]: what the plan itself costs, without its entropy.
    pub(super) fn carried(&self) -> f64 {
        self.over_plan(|distance, _| distance).iter().sum()
    }

    /// One exact iteration in the log domain.
    fn project(&mut self) {
        self.f = softmin(&self.a.points, &self.b.groups, &self.g, self.epsilon);
        self.g = softmin(&self.b.points, &self.a.groups, &self.f, self.epsilon);
    }

    /// Iterates with one kernel until the marginals are within `tolerance`, which it says, or a new kernel is due.
    fn scale(&mut self, tolerance: f64, left: &mut usize) -> bool {
        let Self { a, b, epsilon, .. } = *self;
        let kernel = Gibbs::around(&a.points, &self.f, &b.groups, &self.g, epsilon);
        let (rows, columns) = (a.points.len(), b.points.len());
        // ln of the scalings u, v of the kernel's rows and columns.
        let (mut u, mut v) = (vec![0.0_f64; rows], vec![0.0_f64; columns]);
        let mut relaxation = Relaxation::default();
        let exp = |logs: &[f64]| logs.iter().map(|x| x.exp()).collect::<Vec<f64>>();
        let settled = loop {
            let sums = kernel.rows(&exp(&v));
            self.error = sums.iter().zip(&u).map(|(s, u)| (s * u.exp() - 1.0).abs()).sum::<f64>() / rows as f64;
            if self.error <= tolerance || *left == 0 {
                break self.error <= tolerance;
            }
            *left -= 1;
            let omega = relaxation.after(self.error);
            u.iter_mut().zip(sums).for_each(|(u, s)| *u -= omega * (*u + s.ln()));
            let sums = kernel.columns(&exp(&u));
            let share = columns as f64 / rows as f64;
            v.iter_mut().zip(sums.as_flattened()).for_each(|(v, s)| *v -= omega * (*v + (s * share).ln()));
            if !u.iter().chain(&v).all(|x| x.abs() < MOVED) {
                break false;
            }
        };
        // Scalings that have run away are dropped: the exact iteration that follows needs any g.
        let keep = |x: f64| if x.abs() < 2.0 * MOVED { x } else { 0.0 };
        self.f.iter_mut().zip(u).for_each(|(f, u)| *f += epsilon * keep(u));
        self.g.iter_mut().zip(v).for_each(|(g, v)| *g += epsilon * keep(v));
        settled
    }
}

/// The over-relaxation of a linear iteration, learned from how fast its error falls (Hageman & Young 1981, chapter 9).
struct Relaxation {
    omega: f64,
    since: usize,
    error: f64,
}

impl Default for Relaxation {
    fn default() -> Self {
        Self { omega: 1.0, since: 0, error: f64::NAN }
    }
}

impl Relaxation {
    /// Iterations between two adjustments.
    const EVERY: usize = 8;
    /// Above this, iterations far from the solution diverge too often.
    const MOST: f64 = 1.95;

    fn after(&mut self, error: f64) -> f64 {
        if self.since.is_multiple_of(Self::EVERY) {
            let rate = (error / self.error).powf(1.0 / Self::EVERY as f64);
            if rate < 1.0 && rate > self.omega - 1.0 {
                // The rate that plain iterations would have.
                let plain = ((rate + self.omega - 1.0) / self.omega).powi(2) / rate;
                self.omega = self.omega.max(2.0 / (1.0 + (1.0 - plain.min(1.0)).sqrt())).min(Self::MOST);
            } else if rate > 1.5 {
                self.omega = 1.0;
            }
            self.error = error;
        }
        self.since += 1;
        self.omega
    }
}
