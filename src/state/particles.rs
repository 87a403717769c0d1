//! Particles at one instant, rollouts, and gradients with respect to them.
use glam::DVec3;

/// N object particles at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Positions \[m\], N rows.
    pub positions: Vec<DVec3>,
    /// Velocities \[m/s\], N rows: the backward difference over the last control interval where the source is a recording.
    pub velocities: Vec<DVec3>,
}

impl Particles {
    /// Particles at rest.
    pub fn at_rest(positions: Vec<DVec3>) -> Self {
        Self { velocities: vec![DVec3::ZERO; positions.len()], positions }
    }

    /// Number of particles N.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.positions.iter().chain(&self.velocities).all(|v| v.is_finite())
    }
}

/// States x₀ … x_T of T control steps, the start included.
pub type Rollout = Vec<Particles>;

/// `∂J/∂particles`, N rows each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticlesGrad {
    /// `∂J/∂positions`.
    pub positions: Vec<DVec3>,
    /// `∂J/∂velocities`.
    pub velocities: Vec<DVec3>,
}

impl ParticlesGrad {
    /// Zero for `count` particles.
    pub fn zero(count: usize) -> Self {
        Self { positions: vec![DVec3::ZERO; count], velocities: vec![DVec3::ZERO; count] }
    }
}
