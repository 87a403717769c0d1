//! The error that everything is fitted by: where particles are against where they should be.
use crate::data::Episode;
use crate::model::Cost;
use crate::state::{Particles, ParticlesGrad};
use crate::train::windows::shifts;

/// Mean squared position error in units of a typical step,
/// `J = 1/K Σ_{t=1..K} 1/N Σᵢ |xᵢ(t) − x*ᵢ(t)|² / scale²`: 1 when every particle is one typical step away.
#[derive(Clone, Copy, Debug)]
pub struct Matched<'a> {
    /// x*, K states.
    pub targets: &'a [Particles],
    /// What a particle moves in a step, typically \[m\].
    pub scale: f64,
}

impl Matched<'_> {
    /// `1 / (K N scale²)`.
    fn weight(&self, count: usize) -> f64 {
        1.0 / (self.targets.len() as f64 * count.max(1) as f64 * self.scale * self.scale)
    }
}

impl Cost for Matched<'_> {
    fn at(&self, t: usize, _: usize, particles: &Particles) -> f64 {
        let Some(target) = t.checked_sub(1).and_then(|t| self.targets.get(t)) else { return 0.0 };
        let squares = particles.positions.iter().zip(&target.positions).map(|(x, y)| x.distance_squared(*y));
        squares.sum::<f64>() * self.weight(particles.len())
    }

    fn gradient(&self, t: usize, _: usize, particles: &Particles) -> ParticlesGrad {
        let mut gradient = ParticlesGrad::zero(particles.len());
        if let Some(target) = t.checked_sub(1).and_then(|t| self.targets.get(t)) {
            let weight = 2.0 * self.weight(particles.len());
            let pairs = particles.positions.iter().zip(&target.positions);
            gradient.positions.iter_mut().zip(pairs).for_each(|(g, (x, y))| *g = weight * (*x - *y));
        }
        gradient
    }
}

/// Root mean square of the displacements per control step that exceed `motion`, over all particles and steps \[m\].
///
/// # Errors
/// When nothing moves further than `motion` \[m\].
pub fn displacement_scale<'a>(episodes: impl IntoIterator<Item = &'a Episode>, motion: f64) -> anyhow::Result<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for episode in episodes {
        for pair in episode.states.windows(2) {
            for shift in shifts(pair).filter(|d| *d > motion) {
                sum += shift * shift;
                count += 1;
            }
        }
    }
    anyhow::ensure!(
        count > 0,
        "no particle of the training episodes moves more than {motion} m in a control step; \
         check the data, or lower `motion` in the training config"
    );
    Ok((sum / count as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn cloud(count: usize, rng: &mut ChaCha8Rng) -> Particles {
        Particles::at_rest((0..count).map(|_| DVec3::from_array(std::array::from_fn(|_| rng.random()))).collect())
    }

    #[test]
    fn gradient_agrees_with_central_differences_and_the_start_is_free() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let targets: Vec<_> = (0..3).map(|_| cloud(4, &mut rng)).collect();
        let states: Vec<_> = (0..4).map(|_| cloud(4, &mut rng)).collect();
        let cost = Matched { targets: &targets, scale: 0.3 };
        assert_eq!(cost.at(0, 3, &states[0]), 0.0);
        for (t, state) in states.iter().enumerate() {
            let gradient = cost.gradient(t, 3, state);
            for i in 0..4 {
                for axis in 0..3 {
                    let nudge = |h: f64| {
                        let mut state = state.clone();
                        state.positions[i][axis] += h;
                        cost.at(t, 3, &state)
                    };
                    let difference = (nudge(1e-5) - nudge(-1e-5)) / 2e-5;
                    assert!((difference - gradient.positions[i][axis]).abs() < 1e-7, "step {t}");
                    assert_eq!(t == 0, difference == 0.0);
                }
            }
        }
    }

    #[test]
    fn one_typical_step_away_costs_one() {
        let target = Particles::at_rest(vec![DVec3::ZERO; 5]);
        let away = Particles::at_rest(vec![DVec3::new(0.0, 0.2, 0.0); 5]);
        let targets = vec![target.clone(), target.clone()];
        let cost = Matched { targets: &targets, scale: 0.2 };
        assert!((cost.total(&[target, away.clone(), away]) - 1.0).abs() < 1e-12);
    }
}
