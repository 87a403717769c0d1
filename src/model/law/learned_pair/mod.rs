//! A small network as a law of every substep: what two particles do to each other, and what tool and table do to one.
mod meeting;
mod spec;

use super::compliant::ContactGrad;
use super::message::Message;
use super::pair::PARTICLE;
use super::{Law, View, ViewGrad};
use crate::model::net::Stack;
use crate::model::placed::Placed;
use glam::DVec3;
use meeting::{Ends, Meeting};
use std::path::Path;

pub use spec::LearnedPairSpec;

/// Distance, separating speed, sliding speed.
const INPUTS: usize = 3;
/// Along the normal, and along the sliding.
const OUTPUTS: usize = 2;

/// `a = strength · w(s) (α n + β v_t/√(|v_t|² + V²))` with `(α, β) = MLP(s, v_n/√(v_n² + V²), |v_t|²/(|v_t|² + V²))`, s the distance over
/// its reach, `w = (1 − s₊²)²`, and n, v the normal and the relative velocity.
///
/// Of two particles the second gets the opposite: what the network reads does not change when they are exchanged, n and v change
/// their signs, so linear momentum between particles is kept to rounding (antisymmetric decoding, Prantl et al. 2022, DMCF). Tool
/// and table are free. In f64; untrained it is exactly zero.
#[derive(Clone, Debug)]
pub struct LearnedPair {
    kinds: Vec<usize>,
    stack: Stack,
    spec: LearnedPairSpec,
}

impl LearnedPair {
    fn reach_of(&self, kind: usize) -> f64 {
        if kind == PARTICLE { self.spec.radius } else { self.spec.skin }
    }

    fn inputs(&self, meetings: &[Meeting<'_>], reach: f64) -> Vec<f64> {
        let square = self.spec.speed * self.spec.speed;
        let row = |m: &Meeting<'_>| {
            let slide = m.sliding.length_squared();
            [m.distance / reach, m.separating / (m.separating * m.separating + square).sqrt(), slide / (slide + square)]
        };
        meetings.iter().flat_map(row).collect()
    }

    /// `(w, ∂w/∂r)`.
    fn window(distance: f64, reach: f64) -> (f64, f64) {
        let s = (distance / reach).max(0.0);
        let rest = 1.0 - s * s;
        (rest * rest, -4.0 * s * rest / reach)
    }

    /// The parts of a view for which tool meetings are looked for.
    fn parts<'a>(&self, view: &View<'a>) -> Vec<Placed<'a>> {
        Placed::all(view, self.spec.skin)
    }

    /// `e = v_t/√(|v_t|² + V²)` and the root.
    fn slide(&self, m: &Meeting<'_>) -> (DVec3, f64) {
        let root = (m.sliding.length_squared() + self.spec.speed * self.spec.speed).sqrt();
        (m.sliding / root, root)
    }

    /// `|v_t|` and `|v_t|/√(|v_t|² + V²)`.
    fn pace(&self, m: &Meeting<'_>) -> (f64, f64) {
        let speed = m.sliding.length();
        (speed, speed / self.slide(m).1)
    }

    /// `∂J/∂(r, n, v)` of a meeting from `at` = `∂J/∂a`, the outputs and `∂J/∂inputs`.
    fn pull(&self, m: &Meeting<'_>, reach: f64, at: DVec3, out: &[f64], by: &[f64]) -> ContactGrad {
        let ((window, fall), (slide, root)) = (Self::window(m.distance, reach), self.slide(m));
        let square = self.spec.speed * self.spec.speed;
        let (push, strength) = (self.spec.strength * window, self.spec.strength);
        let by_distance = by[0] / reach + strength * fall * (out[0] * at.dot(m.normal) + out[1] * at.dot(slide));
        let by_separating = by[1] * square / (m.separating * m.separating + square).powf(1.5);
        let by_slide = push * out[1] * at;
        let by_sliding =
            by[2] * 2.0 * square / root.powi(4) * m.sliding + (by_slide - slide * slide.dot(by_slide)) / root;
        let along = by_separating - by_sliding.dot(m.normal);
        ContactGrad {
            overlap: -by_distance,
            normal: push * out[0] * at + along * m.velocity - m.separating * by_sliding,
            velocity: by_sliding + along * m.normal,
        }
    }
}

impl Law for LearnedPair {
    fn reach(&self) -> f64 {
        if self.kinds.contains(&PARTICLE) { self.spec.radius } else { 0.0 }
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        if self.stack.is_silent() {
            return;
        }
        let parts = self.parts(view);
        for (&kind, network) in self.kinds.iter().zip(self.stack.networks()) {
            let reach = self.reach_of(kind);
            let meetings = self.meetings(kind, view, &parts);
            let outputs = network.forward(self.inputs(&meetings, reach));
            for (m, o) in meetings.iter().zip(outputs.rows()) {
                let push = self.spec.strength * Self::window(m.distance, reach).0;
                let a = push * (o[0] * m.normal + o[1] * self.slide(m).0);
                match &m.ends {
                    Ends::Pair(i, j) => {
                        out[*i] += a;
                        out[*j] -= a;
                    }
                    Ends::Touch(touch) => out[touch.particle] += a,
                    Ends::Plane(i, _) => out[*i] += a,
                }
            }
        }
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let parts = self.parts(view);
        let mut start = 0;
        for (&kind, network) in self.kinds.iter().zip(self.stack.networks()) {
            let reach = self.reach_of(kind);
            let meetings = self.meetings(kind, view, &parts);
            let outputs = network.forward(self.inputs(&meetings, reach));
            let felt = |m: &Meeting<'_>| match &m.ends {
                Ends::Pair(i, j) => out[*i] - out[*j],
                Ends::Touch(touch) => out[touch.particle],
                Ends::Plane(i, _) => out[*i],
            };
            let by_output = |m: &Meeting<'_>| {
                let (push, at) = (self.spec.strength * Self::window(m.distance, reach).0, felt(m));
                [push * at.dot(m.normal), push * at.dot(self.slide(m).0)]
            };
            let at_outputs: Vec<f64> = meetings.iter().flat_map(by_output).collect();
            let end = start + network.weight_count();
            let own = if grad.weights.is_empty() { 0..0 } else { start..end };
            start = end;
            let by_inputs = network.pull(&outputs, &at_outputs, &mut grad.weights[own]);
            for ((m, o), by) in meetings.iter().zip(outputs.rows()).zip(by_inputs.chunks_exact(INPUTS)) {
                let by = self.pull(m, reach, felt(m), o, by);
                match &m.ends {
                    Ends::Pair(i, j) => {
                        let across = (by.normal - m.normal * m.normal.dot(by.normal)) / m.distance;
                        let x = across - by.overlap * m.normal;
                        grad.particles.positions[*i] += x;
                        grad.particles.positions[*j] -= x;
                        grad.particles.velocities[*i] += by.velocity;
                        grad.particles.velocities[*j] -= by.velocity;
                    }
                    Ends::Touch(touch) => touch.pull(&by, grad),
                    Ends::Plane(i, normal) => {
                        grad.particles.positions[*i] -= by.overlap * *normal;
                        grad.particles.velocities[*i] += by.velocity;
                    }
                }
            }
        }
    }

    fn messages(&self, view: &View<'_>) -> Vec<Message> {
        let parts = self.parts(view);
        let mut all = Vec::new();
        for (&kind, network) in self.kinds.iter().zip(self.stack.networks()) {
            let reach = self.reach_of(kind);
            let meetings = self.meetings(kind, view, &parts);
            let outputs = network.forward(self.inputs(&meetings, reach));
            all.extend(meetings.iter().zip(outputs.rows()).map(|(m, o)| {
                let (push, (sliding, drag)) = (self.spec.strength * Self::window(m.distance, reach).0, self.pace(m));
                let (distance, separating) = (m.distance, m.separating);
                Message { kind, distance, separating, sliding, normal: push * o[0], tangential: push * drag * o[1] }
            }));
        }
        all
    }

    fn messages_vjp(&self, view: &View<'_>, mut at: &[[f64; 2]], mut weights: &mut [f32]) {
        let parts = self.parts(view);
        for (&kind, network) in self.kinds.iter().zip(self.stack.networks()) {
            let reach = self.reach_of(kind);
            let meetings = self.meetings(kind, view, &parts);
            let outputs = network.forward(self.inputs(&meetings, reach));
            let (own, others) = at.split_at(meetings.len());
            let by_output = |(m, at): (&Meeting<'_>, &[f64; 2])| {
                let push = self.spec.strength * Self::window(m.distance, reach).0;
                [push * at[0], push * self.pace(m).1 * at[1]]
            };
            let at_outputs: Vec<f64> = meetings.iter().zip(own).flat_map(by_output).collect();
            let (mine, rest) = weights.split_at_mut(network.weight_count());
            network.pull(&outputs, &at_outputs, mine);
            (at, weights) = (others, rest);
        }
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
