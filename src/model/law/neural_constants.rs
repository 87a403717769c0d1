//! Written laws between particles whose constants a small network sets, pair by pair and in every substep.
use super::compliant::positive;
use super::pair::{Pair, visit};
use super::{Law, LawSpec, View, ViewGrad};
use crate::model::net::Stack;
use anyhow::{Context, ensure};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Config of [`NeuralConstants`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NeuralConstantsSpec {
    /// Width of both hidden layers.
    #[schemars(range(min = 1, max = 256))]
    pub width: usize,
    /// Greatest logarithm b of a factor: a constant stays between e^−b and e^b times the written one \[1\].
    #[schemars(range(min = 1e-9))]
    pub bound: f64,
    /// Distance R that counts as one, and within which particles crowd each other \[m\].
    #[schemars(range(min = 1e-6))]
    pub radius: f64,
    /// Relative speed V that counts as one \[m/s\].
    #[schemars(range(min = 1e-9))]
    pub speed: f64,
    /// Seed of the untrained weights.
    pub seed: u64,
    /// The written laws, each between two particles.
    pub laws: Vec<LawSpec>,
    /// File of trained weights (safetensors).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
}

impl NeuralConstantsSpec {
    /// The law, with the weights of the file or untrained.
    ///
    /// # Errors
    /// A sentence naming the impossible key, the law that is not one between particles, or what is wrong with the file of weights.
    pub fn build(self) -> anyhow::Result<NeuralConstants> {
        ensure!((1..=256).contains(&self.width), "width must be between 1 and 256, got {}", self.width);
        let scales = [("bound", self.bound), ("radius", self.radius), ("speed", self.speed)];
        scales.into_iter().try_for_each(|(key, value)| positive("neural_constants", key, value))?;
        ensure!(!self.laws.is_empty(), "laws of the law \"neural_constants\" is empty; name at least one");
        let (mut pairs, mut constants) = (Vec::new(), Vec::new());
        for (i, law) in self.laws.into_iter().enumerate() {
            let called = law.called();
            let pair = law.build().with_context(|| format!("in laws[{i}]"))?.into_pair().with_context(|| {
                format!(
                    "laws[{i}] of the law \"neural_constants\" is {called:?}, which is not a law in Rust between two particles, or remembers them; \
                     move it to dynamics.laws"
                )
            })?;
            constants.extend(pair.constants().iter().map(|constant| format!("laws.{called}.{constant}")));
            pairs.push(pair);
        }
        let mut stack = Stack::new(&["particle".to_owned()], [INPUTS, self.width, pairs.len()], self.seed);
        if let Some(path) = &self.weights {
            stack.load(path)?;
        }
        Ok(NeuralConstants { pairs, constants, stack, bound: self.bound, radius: self.radius, speed: self.speed })
    }
}

/// Distance, separating speed, sliding speed, crowding.
const INPUTS: usize = 4;

/// `a = Σ_k exp(b tanh o_k) a_k(x, v)` with the written laws a_k and
/// `o = MLP(r/R, v_n/√(v_n² + V²), |v_t|²/(|v_t|² + V²), m/(2 + m))`, `m = ρᵢ + ρⱼ`, `ρᵢ = Σ_j (1 − r²/R²)²₊`.
///
/// Every written law is linear in one of its constants — contact in its stiffness, cohesion in its strength, viscosity in its
/// rate — so its factor sets this constant for the pair, positive and within bounds. What the network reads does not change when
/// the two particles are exchanged: linear momentum is kept to rounding, and no law changes its direction. In f64; untrained
/// every factor is exactly one (a network inside known laws and a known integrator: Ma et al. 2023, NCLaw).
pub struct NeuralConstants {
    pairs: Vec<Box<dyn Pair>>,
    constants: Vec<String>,
    stack: Stack,
    bound: f64,
    radius: f64,
    speed: f64,
}

/// Two particles near each other.
struct Meeting {
    i: usize,
    j: usize,
    offset: DVec3,
    square: f64,
    velocity: DVec3,
}

impl Meeting {
    /// `(r, n, v_n, v_t)`.
    fn split(&self) -> (f64, DVec3, f64, DVec3) {
        let distance = self.square.sqrt();
        let normal = self.offset / distance;
        let separating = self.velocity.dot(normal);
        (distance, normal, separating, self.velocity - separating * normal)
    }
}

impl NeuralConstants {
    /// All meetings, in the order of the list.
    fn meetings(&self, view: &View<'_>) -> Vec<Meeting> {
        let velocities = &view.particles.velocities[..];
        let mut found = Vec::new();
        visit(view, self.reach(), |i, j, offset, square| {
            found.push(Meeting { i, j, offset, square, velocity: velocities[i] - velocities[j] });
        });
        found
    }

    /// `(1 − r²/R²)₊`, whose square crowds two particles.
    fn fade(&self, square: f64) -> f64 {
        (1.0 - square / (self.radius * self.radius)).max(0.0)
    }

    /// ρ of every particle.
    fn crowds(&self, meetings: &[Meeting], count: usize) -> Vec<f64> {
        let mut crowds = vec![0.0; count];
        for m in meetings {
            let near = self.fade(m.square).powi(2);
            crowds[m.i] += near;
            crowds[m.j] += near;
        }
        crowds
    }

    fn inputs(&self, meetings: &[Meeting], crowds: &[f64]) -> Vec<f64> {
        let unit = self.speed * self.speed;
        let row = |m: &Meeting| {
            let (distance, _, separating, sliding) = m.split();
            let (slide, crowd) = (sliding.length_squared(), crowds[m.i] + crowds[m.j]);
            [
                distance / self.radius,
                separating / (separating * separating + unit).sqrt(),
                slide / (slide + unit),
                crowd / (2.0 + crowd),
            ]
        };
        meetings.iter().flat_map(row).collect()
    }

    /// The factor of every law from the network's output for it, and its derivative.
    fn factor(&self, output: f64) -> (f64, f64) {
        let turn = output.tanh();
        let factor = (self.bound * turn).exp();
        (factor, factor * self.bound * (1.0 - turn * turn))
    }

    /// The factors, a row of as many as there are laws for each meeting.
    fn factors(&self, meetings: &[Meeting], count: usize) -> Vec<f64> {
        if self.stack.is_silent() {
            return vec![1.0; meetings.len() * self.pairs.len()];
        }
        let inputs = self.inputs(meetings, &self.crowds(meetings, count));
        let outputs = self.stack.networks()[0].forward(inputs);
        outputs.rows().flatten().map(|o| self.factor(*o).0).collect()
    }

    /// Calls `visit(k, pair, meeting, place)` with every law k and every meeting within its reach, `place` that of its factor;
    /// law by law, as written laws in a list are asked, so that untrained sums round alike.
    fn ask(&self, meetings: &[Meeting], mut visit: impl FnMut(usize, &dyn Pair, &Meeting, usize)) {
        for (k, pair) in self.pairs.iter().enumerate() {
            let limit = pair.reach() * pair.reach();
            for (row, m) in meetings.iter().enumerate().filter(|(_, m)| m.square < limit) {
                visit(k, &**pair, m, row * self.pairs.len() + k);
            }
        }
    }

    /// `(∂J/∂x, ∂J/∂v)` of a meeting from `∂J/∂inputs`, but for the crowding.
    fn pull(&self, m: &Meeting, by: &[f64]) -> (DVec3, DVec3) {
        let (distance, normal, separating, sliding) = m.split();
        let unit = self.speed * self.speed;
        let by_separating = by[1] * unit / (separating * separating + unit).powf(1.5);
        let by_slide = 2.0 * by[2] * unit / (sliding.length_squared() + unit).powi(2);
        let turning = (by_separating - by_slide * separating) / distance;
        (by[0] / self.radius * normal + turning * sliding, by_separating * normal + by_slide * sliding)
    }
}

impl Law for NeuralConstants {
    fn reach(&self) -> f64 {
        self.pairs.iter().map(|pair| pair.reach()).fold(self.radius, f64::max)
    }

    /// That of the stiffest law at its greatest factor.
    fn stable(&self) -> f64 {
        let least = self.pairs.iter().map(|pair| pair.stable()).fold(f64::INFINITY, f64::min);
        least * (-self.bound).exp()
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        let meetings = self.meetings(view);
        let factors = self.factors(&meetings, out.len());
        self.ask(&meetings, |_, pair, m, place| {
            let push = factors[place] * pair.acceleration(m.offset, m.square, m.velocity);
            out[m.i] += push;
            out[m.j] -= push;
        });
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let meetings = self.meetings(view);
        let crowds = self.crowds(&meetings, out.len());
        let network = &self.stack.networks()[0];
        let outputs = network.forward(self.inputs(&meetings, &crowds));
        let factors: Vec<(f64, f64)> = outputs.rows().flatten().map(|o| self.factor(*o)).collect();
        let particles = &mut grad.particles;
        let mut give = |m: &Meeting, x: DVec3, v: DVec3| {
            particles.positions[m.i] += x;
            particles.positions[m.j] -= x;
            particles.velocities[m.i] += v;
            particles.velocities[m.j] -= v;
        };
        let mut at_outputs = vec![0.0; factors.len()];
        self.ask(&meetings, |_, pair, m, place| {
            let (at, (factor, slope)) = (out[m.i] - out[m.j], factors[place]);
            let (x, v) = pair.pull(m.offset, m.square, m.velocity, factor * at);
            give(m, x, v);
            at_outputs[place] = slope * at.dot(pair.acceleration(m.offset, m.square, m.velocity));
        });
        let by_inputs = network.pull(&outputs, &at_outputs, grad.weights);
        let mut by_crowds = vec![0.0; crowds.len()];
        for (m, by) in meetings.iter().zip(by_inputs.chunks_exact(INPUTS)) {
            let (x, v) = self.pull(m, by);
            give(m, x, v);
            let by_crowd = 2.0 * by[3] / (2.0 + crowds[m.i] + crowds[m.j]).powi(2);
            by_crowds[m.i] += by_crowd;
            by_crowds[m.j] += by_crowd;
        }
        for m in &meetings {
            let fall = -4.0 * self.fade(m.square) / (self.radius * self.radius);
            give(m, (by_crowds[m.i] + by_crowds[m.j]) * fall * m.offset, DVec3::ZERO);
        }
    }

    fn constants(&self) -> Vec<&str> {
        self.constants.iter().map(String::as_str).collect()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        let meetings = self.meetings(view);
        let factors = self.factors(&meetings, out.len());
        let mut starts = vec![0];
        starts.extend(self.pairs.iter().scan(0, |end, pair| {
            *end += pair.constants().len();
            Some(*end)
        }));
        self.ask(&meetings, |k, pair, m, place| {
            let at = factors[place] * (out[m.i] - out[m.j]);
            pair.pull_constants(m.offset, m.square, m.velocity, at, &mut constants[starts[k]..starts[k + 1]]);
        });
    }

    fn weights(&self) -> Vec<f32> {
        self.stack.weights()
    }

    fn matrices(&self) -> Vec<(String, usize)> {
        self.stack.matrices()
    }

    fn set_weights(&mut self, weights: &[f32]) {
        self.stack.set_weights(weights);
    }

    fn save_weights(&self, path: &Path) -> anyhow::Result<()> {
        self.stack.save(path)
    }
}
