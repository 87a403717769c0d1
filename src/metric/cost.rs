//! Costs that pull the end of a rollout toward a goal shape.
use super::is_finite;
use crate::model::Cost;
use crate::state::{Particles, ParticlesGrad};
use anyhow::ensure;
use glam::DVec3;

/// A differentiable distance from a point cloud to a goal cloud.
pub trait ShapeLoss: Send + Sync {
    /// The distance \[m\]; `∞` when a coordinate is not finite or a cloud is empty.
    fn value(&self, points: &[DVec3], goal: &[DVec3]) -> f64;
    /// `∂value/∂points`, exact wherever the nearest neighbours or the assignment are unique (of what iterates, to its tolerance); a
    /// point on its goal adds zero.
    fn gradient(&self, points: &[DVec3], goal: &[DVec3]) -> Vec<DVec3>;
    /// Whether the gradient says where the distance falls, which it does not of one that changes by steps.
    fn has_gradient(&self) -> bool {
        true
    }
}

family! {
    /// Every shape loss that a config can name.
    CostSpec builds Box<dyn ShapeLoss> {
        Chamfer(super::ChamferSpec),
        Emd(super::EmdSpec),
        Weighted(super::WeightedSpec),
        Sinkhorn(super::SinkhornSpec),
        Aligned(super::AlignedSpec),
        Missed(super::MissedSpec),
    }
}

/// `ℓ_H(x) = loss(x, goal)` at the last step, zero before it.
pub struct GoalCost {
    loss: Box<dyn ShapeLoss>,
    goal: Vec<DVec3>,
}

impl GoalCost {
    /// The cost of missing `goal` \[m\], measured by `loss`.
    ///
    /// # Errors
    /// When the goal has no point or a coordinate is not finite.
    pub fn new(loss: Box<dyn ShapeLoss>, goal: Vec<DVec3>) -> anyhow::Result<Self> {
        ensure!(!goal.is_empty(), "the goal has no points: give a shape with at least one");
        ensure!(is_finite(&goal), "a coordinate of the goal is not a finite number: clean the cloud first");
        Ok(Self { loss, goal })
    }
}

impl Cost for GoalCost {
    fn at(&self, t: usize, horizon: usize, particles: &Particles) -> f64 {
        if t < horizon { 0.0 } else { self.loss.value(&particles.positions, &self.goal) }
    }

    fn gradient(&self, t: usize, horizon: usize, particles: &Particles) -> ParticlesGrad {
        let mut out = ParticlesGrad::zero(particles.len());
        if t == horizon {
            out.positions = self.loss.gradient(&particles.positions, &self.goal);
        }
        out
    }

    fn has_gradient(&self) -> bool {
        self.loss.has_gradient()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::tests::cloud;

    fn specs() -> Vec<CostSpec> {
        let read = |text: &str| toml_edit::de::from_str(text).unwrap();
        let weighted = "kind = 'weighted'\nchamfer = 0.5\nemd = 0.5";
        let sinkhorn = "kind = 'sinkhorn'\nepsilon = 0.1\ntolerance = 1e-10";
        let aligned = "kind = 'aligned'\nof = { kind = 'chamfer' }";
        let free = "kind = 'aligned'\nof = { kind = 'chamfer' }\nfreedom = 'full'";
        ["kind = 'chamfer'", "kind = 'emd'", weighted, sinkhorn, aligned, free].map(read).to_vec()
    }

    #[test]
    fn gradients_agree_with_central_differences() {
        for (goal, spec) in [20, 12].into_iter().flat_map(|m| specs().into_iter().map(move |s| (cloud(m, 2), s))) {
            // Between unequal clouds the earth mover's distance iterates to 1e-4 of the mass; a point has 1/20.
            let iterated = goal.len() != 20 && matches!(spec, CostSpec::Emd(_) | CostSpec::Weighted(_));
            let tolerance = match spec {
                _ if iterated => 5e-4 / 20.0,
                // What the search for the motion leaves.
                CostSpec::Aligned(_) => 1e-5,
                _ => 1e-7,
            };
            let cost = GoalCost::new(spec.clone().build().unwrap(), goal).unwrap();
            let mut start = Particles::at_rest(cloud(20, 1));
            let gradient = cost.gradient(3, 3, &start);
            assert!(gradient.velocities.iter().all(|v| *v == DVec3::ZERO));
            for i in 0..start.len() {
                for axis in 0..3 {
                    let h = 1e-6;
                    let mut at = |h: f64| {
                        let before = start.positions[i][axis];
                        start.positions[i][axis] += h;
                        let value = cost.at(3, 3, &start);
                        start.positions[i][axis] = before;
                        value
                    };
                    let expected = (at(h) - at(-h)) / (2.0 * h);
                    let found = gradient.positions[i][axis];
                    assert!((found - expected).abs() < tolerance, "{spec:?} {i} {axis}: {found} against {expected}");
                }
            }
        }
    }

    #[test]
    fn only_the_last_step_costs_and_the_goal_itself_costs_nothing() {
        let goal = cloud(10, 3);
        for spec in specs() {
            let cost = GoalCost::new(spec.clone().build().unwrap(), goal.clone()).unwrap();
            let away = Particles::at_rest(cloud(10, 4));
            assert_eq!(cost.at(2, 3, &away), 0.0);
            assert_eq!(cost.gradient(2, 3, &away), ParticlesGrad::zero(10));
            let there = Particles::at_rest(goal.clone());
            // An iteration ends a little beside zero.
            let gradient = cost.gradient(3, 3, &there);
            let most = gradient.positions.iter().map(|g| g.length()).fold(0.0, f64::max);
            assert!(cost.at(3, 3, &there) < 1e-12 && most < 1e-10, "{spec:?}: {} and {most}", cost.at(3, 3, &there));
        }
    }

    #[test]
    fn a_broken_rollout_costs_infinity_and_a_broken_goal_is_refused() {
        let build = |goal| GoalCost::new(specs().remove(2).build().unwrap(), goal);
        let mut broken = Particles::at_rest(cloud(5, 1));
        broken.positions[2].z = f64::NAN;
        assert_eq!(build(cloud(5, 2)).unwrap().at(1, 1, &broken), f64::INFINITY);
        assert!(build(vec![]).is_err());
        assert!(build(broken.positions).is_err());
    }

    #[test]
    fn impossible_weights_are_refused() {
        for (chamfer, emd) in [(-1.0, 1.0), (0.0, 0.0), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
            assert!(CostSpec::Weighted(crate::metric::WeightedSpec { chamfer, emd }).build().is_err());
        }
        assert!(toml_edit::de::from_str::<CostSpec>("kind = 'chamfer'\nweight = 1.0").is_err());
    }
}
