//! The adjoint of one control step, substep by substep backwards.
use super::contact::PartsGrad;
use super::grid::{Affine, Grid, extend, place, split};
use super::interval::{Interval, Met, Node, Tape};
use super::real::{Matrix, Real, Vector};
use super::state::StateGrad;
use super::{MpmModel, MpmState, Points};
use crate::model::Adjoint;
use crate::state::{Control, ControlGrad, ParticlesGrad, PoseGrad, SceneGrad, Twist};
use glam::{DMat3, DVec3};

/// What flows backwards through an interval.
pub(super) struct Backward<'a, R: Real> {
    interval: &'a Interval<'a, R>,
    points: Points<R>,
    /// `∂J/∂(start poses)` and `∂J/∂(end poses)`.
    from: Vec<PoseGrad>,
    to: Vec<PoseGrad>,
    /// Velocities of the nodes that particles took theirs from, and `∂J/∂` of the nodes.
    grid: Grid<R>,
    by_grid: Grid<R>,
}

impl<'a, R: Real> Backward<'a, R> {
    /// What is known at the end of an interval.
    pub(super) fn new(interval: &'a Interval<'a, R>, StateGrad { points, poses: to }: StateGrad) -> Self {
        let from = vec![PoseGrad::default(); to.len()];
        let [grid, by_grid] = [(); 2].map(|()| Grid::new(interval.model.cell));
        Self { interval, points: Points::of(&points), from, to, grid, by_grid }
    }

    /// Pulls back to the start.
    pub(super) fn pull(mut self, tape: &Tape<R>) -> (StateGrad, ControlGrad) {
        let count = self.points.positions.len();
        // What was blown apart has nothing more to say.
        for k in (0..tape.met.spans.len()).rev() {
            self.substep(k, k * count, tape);
        }
        (StateGrad { points: self.points.wide(), poses: self.from }, ControlGrad { poses: self.to })
    }

    /// Pulls back through substep `k`, whose rows of the tape begin at `start`.
    fn substep(&mut self, k: usize, start: usize, tape: &Tape<R>) {
        let count = self.points.positions.len();
        let Met { spans, ends, nodes } = &tape.met;
        let met = &nodes[k.checked_sub(1).map_or(0, |k| ends[k])..ends[k]];
        self.grid.restore(spans[k]);
        self.by_grid.restore(spans[k]);
        met.iter().for_each(|node| self.grid.nodes[node.number as usize] = extend(node.after, R::ZERO));
        for i in 0..count {
            let (row, next) = (start + i, start + count + i);
            self.grid_to_particles(i, tape.points.positions[row], tape.points.velocities[next]);
        }
        self.meet(k, met);
        for i in 0..count {
            self.particles_to_grid(i, start + i, tape);
        }
    }

    /// `v' = Σ w u`, `C' = 4/Δ² Σ w u dᵀ` and `x' = x + h v'` are linear in the nodes' velocities u: with `g = λ_v + h λ_x`, node
    /// by node `λ_u += w (g + 4/Δ² λ_C d)`; `taken` is v'.
    fn grid_to_particles(&mut self, i: usize, position: DVec3, taken: R::Vector) {
        let interval = self.interval;
        let by = self.points.velocities[i] + R::Vector::of(self.points.positions[i]) * interval.h;
        let columns = self.points.affine[i].columns();
        let pull = Affine { value: extend(by, R::ZERO), slopes: columns.map(|c| extend(c * interval.sharp, R::ZERO)) };
        let stencil = self.grid.stencil(position);
        self.by_grid.scatter(&stencil, &pull);
        self.points.positions[i] += self.grid.slope(&stencil, &pull, extend(taken, R::ZERO)).wide();
    }

    /// Through contacts, gravity and the division of momentum by mass: `λ_p = λ_v/m`, `λ_m = −λ_v · p/m²`.
    fn meet(&mut self, k: usize, met: &[Node<R>]) {
        let Interval { state, control, fall, .. } = self.interval;
        let contacts = self.interval.contacts(k);
        let parts = state.poses.len();
        let mut grad = PartsGrad { poses: vec![PoseGrad::default(); parts], twists: vec![Twist::default(); parts] };
        let (span, cell) = (self.by_grid.span(), self.by_grid.cell);
        let nodes = &mut self.by_grid.nodes;
        for Node { number, mass, before, .. } in met {
            let node = &mut nodes[*number as usize];
            let (place, by_after) = (place(&span, cell, *number as usize), split::<R>(*node).0.wide());
            let by_velocity = R::Vector::of(contacts.pull(place, before.wide(), by_after, &mut grad)) / *mass;
            *node = extend(by_velocity, -by_velocity.dot(*before - *fall));
        }
        for (i, (pose, twist)) in grad.poses.iter().zip(&grad.twists).enumerate() {
            let (start, end) = (&state.poses[i], &control.poses[i]);
            let (at_from, at_to) = start.toward_vjp(end, self.interval.fraction(k), pose, twist, state.interval);
            self.from[i] += at_from;
            self.to[i] += at_to;
        }
    }

    /// Through what a particle told the nodes, the flow of its material, and `T = M b Mᵀ`: `λ_M = 2 λ_T M b`, `λ_b = Mᵀ λ_T M`.
    fn particles_to_grid(&mut self, i: usize, row: usize, tape: &Tape<R>) {
        let interval = self.interval;
        let (material, viscosity) = (&interval.continuum.material, interval.continuum.viscosity);
        let Points { positions, velocities, affine, strain } = &tape.points;
        let spectrum = &tape.spectra[row];
        let strains = material.strains(spectrum.values);
        let told = interval.momentum(velocities[row], affine[row], material.stress(spectrum, &strains));
        let stencil = self.by_grid.stencil(positions[row]);
        let Affine { value, slopes } = self.by_grid.gather(&stencil);
        self.points.positions[i] += self.by_grid.slope(&stencil, &told, value).wide();
        self.points.velocities[i] = split::<R>(value).0;
        let by_spread = R::Matrix::new(slopes.map(|column| split::<R>(column).0));
        let by_stress = (by_spread + by_spread.transpose()) * (R::of(-0.5) * interval.h * interval.sharp);
        let by_trial = material.pull(spectrum, &strains, self.points.strain[i], by_stress);
        let (two, growth) = (R::of(2.0), R::Matrix::IDENTITY + affine[row] * interval.h);
        let pulled = by_trial * growth;
        self.points.affine[i] = by_spread + by_stress * (two * viscosity) + pulled * strain[row] * (two * interval.h);
        self.points.strain[i] = growth.transpose() * pulled;
    }
}

impl Adjoint<MpmState> for MpmModel {
    fn step_vjp(&self, state: &MpmState, control: &Control, next: &[f64], _: &mut [f32]) -> (Vec<f64>, ControlGrad) {
        let next = StateGrad::read(next, state.points.positions.len());
        let (at_state, at_control) = self.continuum.step_vjp(self, state, control, next);
        (at_state.flat(), at_control)
    }

    fn decode_vjp(&self, state: &MpmState, particles: &ParticlesGrad) -> Vec<f64> {
        let count = state.points.positions.len();
        let points = Points {
            positions: state.order.gather(&particles.positions),
            velocities: state.order.gather(&particles.velocities),
            affine: vec![DMat3::ZERO; count],
            strain: vec![DMat3::ZERO; count],
        };
        StateGrad { points, poses: vec![PoseGrad::default(); state.poses.len()] }.flat()
    }

    /// At the start there is neither strain nor affine motion, whatever the scene.
    fn encode_vjp(&self, start: &MpmState, at_start: &[f64], _: &mut [f32]) -> SceneGrad {
        let StateGrad { points, poses } = StateGrad::read(at_start, start.points.positions.len());
        let particles = ParticlesGrad {
            positions: start.order.scatter(&points.positions),
            velocities: start.order.scatter(&points.velocities),
        };
        SceneGrad { particles, poses }
    }
}
