//! The ground truth: plastic dough on a table, worked by rigid tools, in Rapier.
//!
//! The dough is one Rapier soft body: lattice cells cut into tetrahedra that keep their volume, and edges that flow
//! plastically. A [`World`] belongs to one thread and holds everything that its future depends on, so that its clones and
//! its [snapshots](World::snapshot) continue bit for bit as it would.
use crate::state::{Control, Particles, Pose, Rollout, Scene, ToolShape};
use crate::tool::Motion;
use glam::{DQuat, DVec3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

mod dough;
mod engine;
mod hand;
mod lattice;
mod material;
mod scale;
mod snapshot;
mod spec;
mod start;

use engine::Engine;
use lattice::Lattice;

pub use material::MaterialSpec;
pub use spec::{SceneSpec, SolverSpec};
pub use start::{BlockSpec, EllipsoidSpec, Region, Start, StartSpec};

/// How long new dough settles on the table \[s\].
const SETTLE: f64 = 0.5;

/// A simulated table with dough and, between [`World::take`] and the next, a tool.
#[derive(Clone)]
pub struct World {
    engine: Engine,
    /// The simulator's particles that models see, in their order.
    chosen: Vec<u32>,
    /// Where those were one control step ago; where they are, before the first step.
    before: Vec<DVec3>,
    /// Pose of each part of the tool in hand.
    poses: Vec<Pose>,
    interval: f64,
    steps: usize,
}

impl World {
    /// Dough of a start drawn by `seed`, settled on the table.
    ///
    /// # Errors
    /// A sentence naming the key of `spec` that makes it impossible.
    pub fn new(spec: &SceneSpec, seed: u64) -> anyhow::Result<Self> {
        let region = spec.start.clone().build()?.draw(&mut ChaCha8Rng::seed_from_u64(seed));
        spec.check()?;
        let mut lattice = Lattice::fill(&region.contains, region.bounds, spec.spacing)?;
        let turn = DQuat::from_rotation_z(region.turn);
        lattice.corners.iter_mut().for_each(|corner| *corner = turn * *corner);
        Self::settled(spec, &lattice)
    }

    /// Dough that fills the part of the box `bounds` that `contains` holds, settled on the table.
    ///
    /// # Errors
    /// A sentence saying why the region or `spec` is impossible.
    pub fn around(spec: &SceneSpec, contains: &dyn Fn(DVec3) -> bool, bounds: (DVec3, DVec3)) -> anyhow::Result<Self> {
        spec.check()?;
        Self::settled(spec, &Lattice::fill(contains, bounds, spec.spacing)?)
    }

    fn settled(spec: &SceneSpec, lattice: &Lattice) -> anyhow::Result<Self> {
        let lowest = lattice.corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let mut world = Self::standing(spec, lattice, dough::skin(spec.spacing) - lowest)?;
        for _ in 0..(SETTLE / spec.interval).ceil() as usize {
            world.step(&Control::default());
        }
        world.before = world.positions();
        Ok(world)
    }

    /// Dough whose lattice is lifted by `lift` \[m\], at rest and not yet settled.
    fn standing(spec: &SceneSpec, lattice: &Lattice, lift: f64) -> anyhow::Result<Self> {
        anyhow::ensure!(
            spec.particles <= lattice.corners.len(),
            "the dough holds {} simulator particles, fewer than scene.particles = {}: choose a smaller scene.spacing",
            lattice.corners.len(),
            spec.particles
        );
        let engine = Engine::new(spec, lattice, lift);
        let chosen = dough::farthest(&lattice.corners, spec.particles);
        let mut world = Self {
            engine,
            chosen,
            before: Vec::new(),
            poses: Vec::new(),
            interval: spec.interval,
            steps: spec.solver.steps,
        };
        world.before = world.positions();
        Ok(world)
    }

    /// The particles that models see: positions \[m\], and velocities \[m/s\] as the backward difference over the last control
    /// step, zero before the first.
    pub fn particles(&self) -> Particles {
        let positions = self.positions();
        let velocities = positions.iter().zip(&self.before).map(|(now, then)| (now - then) / self.interval).collect();
        Particles { positions, velocities }
    }

    /// All particles of the simulator \[m\].
    pub fn all_positions(&self) -> Vec<DVec3> {
        self.engine.positions().collect()
    }

    /// Particles of the simulator on the dough's surface \[m\].
    pub fn surface(&self) -> Vec<DVec3> {
        self.engine.surface().collect()
    }

    /// Volume of the dough \[m³\].
    pub fn volume(&self) -> f64 {
        self.engine.volume()
    }

    /// Duration of a control step \[s\].
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Lays the tool in hand aside and holds this one, one pose a part; velocities count from here.
    pub fn take(&mut self, tool: &Arc<ToolShape>, start: &[Pose]) {
        self.engine.hold(tool, start);
        self.poses = start.to_vec();
        self.before = self.positions();
    }

    /// One control step: each tool part moves at constant twist to the control's pose.
    pub fn step(&mut self, control: &Control) {
        self.before = self.positions();
        for i in 1..=self.steps {
            let way = i as f64 / self.steps as f64;
            self.engine.step(self.poses.iter().zip(&control.poses).map(|(from, to)| from.toward(to, way)));
        }
        self.engine.forget();
        self.poses.iter_mut().zip(&control.poses).for_each(|(from, to)| *from = *to);
    }

    /// One tool action: [`World::take`], then every step; the states x₀ … x_H.
    pub fn execute(&mut self, tool: &Arc<ToolShape>, motion: &Motion) -> Rollout {
        self.take(tool, &motion.start);
        let mut rollout = vec![self.particles()];
        for control in &motion.controls {
            self.step(control);
            rollout.push(self.particles());
        }
        rollout
    }

    /// What models are told before `tool` moves from `start`: the x₀ of [`World::execute`], and this world's snapshot.
    pub fn scene(&self, tool: &Arc<ToolShape>, start: &[Pose]) -> Scene {
        Scene {
            particles: Particles::at_rest(self.positions()),
            tool: tool.clone(),
            poses: start.to_vec(),
            interval: self.interval,
            snapshot: Some(self.snapshot()),
        }
    }

    fn positions(&self) -> Vec<DVec3> {
        let all = self.all_positions();
        self.chosen.iter().map(|&i| all[i as usize]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn before_it_lands_dough_falls_as_everything_falls() {
        let size = DVec3::new(0.05, 0.04, 0.03);
        let spec = SceneSpec {
            material: MaterialSpec {
                density: 1200.0,
                young_modulus: 2e4,
                poisson_ratio: 0.499,
                damping_ratio: 1.0,
                yield_strain: 0.02,
                creep_rate: 60.0,
                largest_set: 0.8,
                friction: 0.5,
            },
            start: StartSpec::Block(BlockSpec { x: [0.05; 2], y: [0.04; 2], z: [0.03; 2], turn: [0.0; 2] }),
            spacing: 0.01,
            particles: 10,
            interval: 0.05,
            solver: SolverSpec { steps: 10, substeps: 4, sweeps: 4 },
        };
        let lattice = Lattice::fill(&|_| true, (DVec3::ZERO, size), spec.spacing).unwrap();
        let mut world = World::standing(&spec, &lattice, 0.5).unwrap();
        let start = world.all_positions();
        for i in 1..=5 {
            world.step(&Control::default());
            let time = i as f64 * spec.interval;
            let fall = 0.5 * scale::GRAVITY * time * time;
            // Semi-implicit Euler falls g t dt/2 too far.
            let ahead = scale::GRAVITY * time * spec.interval / 80.0;
            for (now, then) in world.all_positions().iter().zip(&start) {
                let error = (*now - *then + DVec3::Z * fall).length();
                assert!(error <= 1.02 * ahead + 1e-5, "{error} m off after {time} s, {ahead} expected");
            }
        }
    }
}
