//! A model that knows a scene by one vector: a code of fixed length, moved on by the tool, and decoded to displacements.
//!
//! ```text
//! z₀ = encoder(x₀)                              particles around their middle, or their height map
//! z ← z + network([z, the tool's samples])
//! x = x₀ + scale · (decoder(z, x₀) − decoder(z₀, x₀)),  v = (x − the x before)/T
//! ```
//!
//! A decoder that folds the particles of the start, or carries them with a field, keeps each the same particle, has as many as the
//! scene, and at the start nothing has moved. Walls and velocities are not seen.
use super::net::{Advance, LatentArchitecture, LatentNet, Mixing, Trainable, forward};
use super::{Adjoint, Dynamics};
use crate::state::{Control, Order, Particles, Pose, Scene, ToolShape};
use anyhow::ensure;
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

mod adjoint;
mod samples;
mod view;

use view::View;
pub use view::{CloudSpec, TopSpec, ViewSpec};

/// Most weights that a picture may take.
const LARGEST: usize = 1 << 26;

/// Config of the latent model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LatentSpec {
    /// Length of the code.
    #[schemars(range(min = 1, max = 4096))]
    pub code: usize,
    /// Width of every hidden layer.
    #[schemars(range(min = 1, max = 1024))]
    pub width: usize,
    /// Length that counts as one, for places \[m\].
    #[schemars(range(min = 1e-9))]
    pub extent: f64,
    /// Displacement in a control step that counts as one, for the tool's; what is decoded counts in it, too \[m\].
    #[schemars(range(min = 1e-9))]
    pub scale: f64,
    /// What it sees and tells: particles, or pictures.
    #[serde(default, skip_serializing_if = "ViewSpec::is_default")]
    pub view: ViewSpec,
    /// Seed of the untrained weights.
    pub seed: u64,
    /// File of trained weights (safetensors).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
}

impl LatentSpec {
    pub(super) fn build(self) -> anyhow::Result<LatentModel> {
        ensure!((1..=4096).contains(&self.code), "code must be between 1 and 4096, got {}", self.code);
        ensure!((1..=1024).contains(&self.width), "width must be between 1 and 1024, got {}", self.width);
        for (key, value) in [("extent", self.extent), ("scale", self.scale)] {
            ensure!(value > 0.0 && value.is_finite(), "{key} must be a positive length, got {value}");
        }
        let view = self.view.build()?;
        let (width, code, picture) = (self.width, self.code, view.picture());
        let told = picture.map_or(0, |size| size.seen + size.told);
        ensure!(width * told <= LARGEST, "a width of {width} is too large for such a picture; lower it or the grid");
        let net = LatentNet::new(LatentArchitecture { width, code, picture }, self.seed);
        let net = net.loaded(self.weights.as_deref())?;
        Ok(LatentModel { net, view, extent: self.extent, scale: self.scale })
    }
}

/// Encoder, dynamics of the code, and decoder.
pub(crate) struct LatentModel {
    net: LatentNet,
    view: Box<dyn View>,
    extent: f64,
    scale: f64,
}

/// A code, and what it stands for.
#[derive(Clone, Debug)]
pub(crate) struct LatentState {
    start: Arc<Start>,
    code: Vec<f32>,
    /// In canonical order.
    particles: Particles,
    poses: Vec<Pose>,
}

/// What stays the same over a rollout, particles in canonical order.
#[derive(Debug)]
pub struct Start {
    order: Order,
    positions: Vec<DVec3>,
    /// Their middle on the table.
    middle: DVec2,
    /// Length that counts as one \[m\].
    extent: f64,
    /// Places around it in units of the extent, (N, 3).
    points: Vec<f32>,
    /// What the first code decodes to, (N, 3).
    base: Vec<f32>,
    copies: Arc<Mixing>,
    /// Over the tool's samples.
    mean: Arc<Mixing>,
    tool: Arc<ToolShape>,
    interval: f64,
}

impl LatentModel {
    fn advance(&self, state: &LatentState, control: &Control) -> Vec<f32> {
        let inputs = vec![(state.code.clone(), state.code.len()), self.samples(state, control)];
        forward(&self.next(state), inputs)
    }

    fn next(&self, state: &LatentState) -> Advance<'_> {
        Advance { net: &self.net, mean: Arc::clone(&state.start.mean) }
    }
}

fn rows(flat: &[f32]) -> impl Iterator<Item = DVec3> + '_ {
    flat.chunks_exact(3).map(|row| glam::Vec3::from_slice(row).as_dvec3())
}

impl Dynamics for LatentModel {
    type State = LatentState;

    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        scene.check()
    }

    fn encode(&self, scene: &Scene) -> LatentState {
        let order = Order::of(scene);
        let positions = order.gather(&scene.particles.positions);
        let velocities = order.gather(&scene.particles.velocities);
        let count = positions.len();
        let middle = positions.iter().map(|x| x.truncate()).sum::<DVec2>() / count.max(1) as f64;
        let place = |x: &DVec3| ((*x - middle.extend(0.0)) / self.extent).as_vec3().to_array();
        let points: Vec<f32> = positions.iter().flat_map(place).collect();
        let samples = scene.tool.parts.iter().map(|part| part.surface.len()).sum();
        let mut start = Start {
            order,
            positions: positions.clone(),
            middle,
            extent: self.extent,
            points,
            base: Vec::new(),
            copies: Arc::new(Mixing::copies(count)),
            mean: Arc::new(Mixing::mean(samples)),
            tool: Arc::clone(&scene.tool),
            interval: scene.interval,
        };
        let code = self.view.encoded(&self.net, &start);
        start.base = self.view.decoded(&self.net, &start, &code);
        let particles = Particles { positions, velocities };
        LatentState { start: Arc::new(start), code, particles, poses: scene.poses.clone() }
    }

    fn step(&self, state: &LatentState, control: &Control) -> LatentState {
        let (start, code) = (&state.start, self.advance(state, control));
        let decoded = self.view.decoded(&self.net, start, &code);
        let moved = rows(&decoded).zip(rows(&start.base)).zip(&start.positions);
        let positions: Vec<DVec3> = moved.map(|((d, base), x)| *x + self.scale * (d - base)).collect();
        let before = &state.particles.positions;
        let velocities = positions.iter().zip(before).map(|(x, before)| (*x - *before) / start.interval).collect();
        let particles = Particles { positions, velocities };
        LatentState { start: Arc::clone(start), code, particles, poses: control.poses.clone() }
    }

    fn decode(&self, state: &LatentState) -> Particles {
        let Particles { positions, velocities } = &state.particles;
        let order = &state.start.order;
        Particles { positions: order.scatter(positions), velocities: order.scatter(velocities) }
    }

    fn adjoint(&self) -> Option<&dyn Adjoint<LatentState>> {
        Some(self)
    }

    fn weights(&self) -> Vec<f32> {
        self.net.weights()
    }

    fn matrices(&self) -> Vec<(String, usize)> {
        self.net.matrices()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        self.net.set_weights(weights);
    }

    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        self.net.save(path)
    }
}
