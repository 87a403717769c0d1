//! The ground truth: dough, grains, rigid pieces and fluids on a table, worked by rigid tools, in Rapier.
//!
//! Dough is a Rapier soft body, several once a blade has parted it: lattice cells cut into tetrahedra that keep their volume, and
//! edges that flow plastically. Grains and rigid pieces are rigid bodies. A fluid is position-based particles that push the bodies
//! and are pushed by them. A [`World`] belongs to one thread and holds everything that its future depends on, so that its clones
//! and its [snapshots](World::snapshot) continue bit for bit as it would.
use crate::shape::farthest_points_from;
use crate::state::{Control, Particles, Pose, Rollout, Scene, ToolShape, Wall};
use crate::tool::Motion;
use anyhow::Context;
use glam::{DVec2, DVec3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

mod bodies;
mod cells;
mod contact;
mod cut;
mod dough;
mod dough_spec;
mod drops;
mod engine;
mod fluid;
mod grains;
mod hand;
mod kernel;
mod lattice;
mod liquid;
mod material;
mod piece;
mod rigid;
mod scale;
mod snapshot;
mod spec;
mod start;
mod volume;

use engine::Engine;

pub use dough_spec::DoughSpec;
pub use drops::DropsSpec;
pub use fluid::FluidSpec;
pub use grains::{GrainSpec, GrainsSpec};
pub use material::{Filling, Material, MaterialSpec};
pub use piece::PieceSpec;
pub use rigid::RigidSpec;
pub use spec::{SceneSpec, SolverSpec, WallsSpec};
pub use start::{BlockSpec, EllipsoidSpec, Region, Start, StartSpec};

/// A simulated table with some material and, between [`World::take`] and the next, a tool.
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
    /// Walls around the table.
    walls: Vec<Wall>,
}

impl World {
    /// The scene's material in a start drawn by `seed`, settled on the table.
    ///
    /// # Errors
    /// A sentence naming the key of `spec` that makes it impossible.
    pub fn new(spec: &SceneSpec, seed: u64) -> anyhow::Result<Self> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let Region { bounds, contains, turn, raised } = spec.start.clone().build()?.draw(&mut rng);
        Self::settled(spec, &Filling { bounds, contains: &*contains, turn, at: DVec2::ZERO, raised }, &mut rng)
    }

    /// The scene's material in the part of the box `bounds` that `contains` holds, settled on the table.
    ///
    /// # Errors
    /// A sentence saying why the region or `spec` is impossible.
    pub fn around(spec: &SceneSpec, contains: &dyn Fn(DVec3) -> bool, bounds: (DVec3, DVec3)) -> anyhow::Result<Self> {
        let filling = Filling { bounds, contains, turn: 0.0, at: DVec2::ZERO, raised: 0.0 };
        Self::settled(spec, &filling, &mut ChaCha8Rng::seed_from_u64(0))
    }

    fn settled(spec: &SceneSpec, filling: &Filling<'_>, rng: &mut ChaCha8Rng) -> anyhow::Result<Self> {
        let materials = spec.check()?;
        // What stands beside it may well be in the air: it falls before everyone's eyes.
        let settling = materials[0].settling();
        let mut world = Self::placed(spec, &materials, filling, rng)?;
        for _ in 0..(settling / spec.interval).ceil() as usize {
            world.step(&Control::default());
        }
        world.before = world.positions();
        Ok(world)
    }

    /// The scene's material at rest where it is put, not yet settled.
    ///
    /// # Errors
    /// A sentence saying why the region or `spec` is impossible.
    pub fn standing(spec: &SceneSpec, filling: &Filling<'_>, rng: &mut ChaCha8Rng) -> anyhow::Result<Self> {
        Self::placed(spec, &spec.check()?, filling, rng)
    }

    fn placed(
        spec: &SceneSpec,
        materials: &[Box<dyn Material>],
        filling: &Filling<'_>,
        rng: &mut ChaCha8Rng,
    ) -> anyhow::Result<Self> {
        let mut engine = Engine::new(spec, materials);
        engine.add(spec, materials[0].as_ref(), filling, rng)?;
        for ((name, piece), material) in spec.beside.iter().zip(&materials[1..]) {
            let fill = |filling: &Filling<'_>, rng: &mut ChaCha8Rng| engine.add(spec, material.as_ref(), filling, rng);
            piece.place(rng, fill).with_context(|| format!("in scene.beside.{name}"))?;
        }
        let all: Vec<DVec3> = engine.pieces().flatten().collect();
        anyhow::ensure!(
            spec.particles <= all.len(),
            "the material holds {} simulator particles, fewer than scene.particles = {}: choose a smaller scene.spacing",
            all.len(),
            spec.particles
        );
        let mut chosen: Vec<u32> =
            farthest_points_from(&all, 0, spec.particles).into_iter().map(|i| i as u32).collect();
        // Each piece's particles in one run.
        let owners = engine.owners();
        chosen.sort_by_key(|i| owners[*i as usize]);
        let before = chosen.iter().map(|&i| all[i as usize]).collect();
        let walls = spec.walls.as_ref().map(WallsSpec::planes).unwrap_or_default();
        let (interval, steps) = (spec.interval, spec.solver.steps);
        Ok(Self { engine, chosen, before, poses: Vec::new(), interval, steps, walls })
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
        self.engine.pieces().flatten().collect()
    }

    /// For every particle that models see, the number of its piece: 0 for the scene's own material, then those beside it.
    pub fn pieces(&self) -> Vec<usize> {
        self.seen(&self.engine.owners())
    }

    /// For every particle that models see, the number of the body it belongs to: a connected lump of dough, a grain, a rigid piece; a
    /// fluid is one body.
    pub fn bodies(&self) -> Vec<usize> {
        let mut all = Vec::new();
        let mut first = 0;
        for piece in self.engine.bodies() {
            let count = piece.iter().max().map_or(0, |last| last + 1);
            all.extend(piece.into_iter().map(|body| first + body));
            first += count;
        }
        self.seen(&all)
    }

    /// Particles of the simulator on the material's surface \[m\].
    pub fn surface(&self) -> Vec<DVec3> {
        self.engine.surface()
    }

    /// Volume of the material \[m³\].
    pub fn volume(&self) -> f64 {
        self.engine.volumes().sum()
    }

    /// Volume of each of the [pieces](World::pieces) \[m³\].
    pub fn volumes(&self) -> Vec<f64> {
        self.engine.volumes().collect()
    }

    /// Walls around the table.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
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
            let poses = self.poses.iter().zip(&control.poses).map(|(from, to)| from.toward(to, way));
            self.engine.step(&poses.collect::<Vec<_>>());
        }
        self.engine.forget();
        self.poses.iter_mut().zip(&control.poses).for_each(|(from, to)| *from = *to);
    }

    /// Adds a velocity \[m/s\] to all of the material: a shove from outside.
    pub fn kick(&mut self, velocity: DVec3) {
        self.blow(&|_| velocity);
    }

    /// Adds a velocity \[m/s\] to one of the [pieces](World::pieces).
    pub fn kick_piece(&mut self, piece: usize, velocity: DVec3) {
        self.engine.kick(piece, &|_| velocity);
    }

    /// Adds to every particle the velocity \[m/s\] that `velocity` gives for its place \[m\], to a rigid body that of its
    /// middle.
    pub fn blow(&mut self, velocity: &dyn Fn(DVec3) -> DVec3) {
        (0..self.engine.pieces().count()).for_each(|piece| self.engine.kick(piece, velocity));
    }

    /// Moves every particle by what `by` gives for its place, a rigid body by what it gives for its middle \[m\].
    pub fn shift(&mut self, by: &dyn Fn(DVec3) -> DVec3) {
        self.engine.shift(by);
    }

    /// Lays the tool in hand aside and lets `steps` control steps pass.
    pub fn wait(&mut self, steps: usize) {
        self.take(&Arc::new(ToolShape::from(Vec::new())), &[]);
        (0..steps).for_each(|_| self.step(&Control::default()));
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
            past: Vec::new(),
            body: self.pieces().into_iter().map(|piece| piece as u32).collect(),
            walls: self.walls.clone().into(),
            constants: Arc::default(),
            tool: tool.clone(),
            poses: start.to_vec(),
            interval: self.interval,
            snapshot: Some(self.snapshot()),
        }
    }

    fn positions(&self) -> Vec<DVec3> {
        self.seen(&self.all_positions())
    }

    /// Of what `all` particles of the simulator have, that of those which models see.
    fn seen<T: Copy>(&self, all: &[T]) -> Vec<T> {
        self.chosen.iter().map(|&i| all[i as usize]).collect()
    }
}
