//! A small learned-like law: smooth, asked once a step, with weights.
use glam::DVec3;
use pliant::graph::Graph;
use pliant::model::law::{Law, Rate, View, ViewGrad};

/// Neighbours pull (w₀), tool samples push (w₁) and drag along (w₂), all fading smoothly.
pub(crate) struct Drift {
    pub(crate) weights: Vec<f32>,
}

const FADE: f64 = 0.02;

impl Drift {
    /// Calls back with each edge: (receiver, sender or sample's part, offset, fade, its slope, sample's velocity).
    fn edges(
        graph: &Graph,
        view: &View<'_>,
        mut visit: impl FnMut(usize, Result<usize, usize>, DVec3, f64, f64, DVec3),
    ) {
        for kind in 0..2 {
            for (i, j) in graph.edges[kind].pairs() {
                let sender = if kind == 0 { Ok(j) } else { Err(graph.nodes.parts[j].unwrap() as usize) };
                let offset = view.particles.positions[i] - graph.nodes.positions[j];
                let rest = 1.0 - offset.length_squared() / (FADE * FADE);
                let velocity = sender.err().map_or(DVec3::ZERO, |k| {
                    let arm = graph.nodes.positions[j] - view.poses[k].translation;
                    view.twists[k].linear + view.twists[k].angular.cross(arm)
                });
                visit(i, sender, offset, rest.max(0.0).powi(2), -4.0 * rest.max(0.0) / (FADE * FADE), velocity);
            }
        }
    }
}

impl Law for Drift {
    fn rate(&self) -> Rate {
        Rate::Step
    }
    fn weights(&self) -> Vec<f32> {
        self.weights.clone()
    }
    fn set_weights(&mut self, weights: &[f32]) {
        self.weights = weights.to_vec();
    }
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        let w: Vec<f64> = self.weights.iter().map(|w| f64::from(*w)).collect();
        Self::edges(view.graph, view, |i, sender, offset, fade, _, velocity| {
            out[i] += match sender {
                Ok(_) => -w[0] * fade * offset,
                Err(_) => fade * (w[1] * offset / FADE + w[2] * (velocity - view.particles.velocities[i])),
            };
        });
    }
    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let w: Vec<f64> = self.weights.iter().map(|w| f64::from(*w)).collect();
        Self::edges(view.graph, view, |i, sender, offset, fade, slope, velocity| {
            let at = out[i];
            let relative = velocity - view.particles.velocities[i];
            let (force, straight) = match sender {
                Ok(_) => (-w[0] * offset, -w[0]),
                Err(_) => (w[1] * offset / FADE + w[2] * relative, w[1] / FADE),
            };
            let by_offset = at.dot(force) * slope * offset + fade * straight * at;
            grad.particles.positions[i] += by_offset;
            let asked = !grad.weights.is_empty();
            match sender {
                Ok(j) => {
                    grad.particles.positions[j] -= by_offset;
                    if asked {
                        grad.weights[0] -= (fade * at.dot(offset)) as f32;
                    }
                }
                Err(k) => {
                    let by_velocity = fade * w[2] * at;
                    let arm = view.particles.positions[i] - offset - view.poses[k].translation;
                    // The sample sits at x − offset and turns with its part; its velocity turns with the arm.
                    let by_sample = by_velocity.cross(view.twists[k].angular) - by_offset;
                    grad.particles.velocities[i] -= by_velocity;
                    grad.poses[k].translation -= by_offset;
                    grad.poses[k].rotation += arm.cross(by_sample);
                    grad.twists[k].linear += by_velocity;
                    grad.twists[k].angular += arm.cross(by_velocity);
                    if asked {
                        grad.weights[1] += (fade * at.dot(offset) / FADE) as f32;
                        grad.weights[2] += (fade * at.dot(relative)) as f32;
                    }
                }
            }
        });
    }
}
