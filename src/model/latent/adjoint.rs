//! The adjoint of a latent model.
use super::{LatentModel, LatentState};
use crate::model::Adjoint;
use crate::model::cotangent::StateGrad;
use crate::model::net::pull;
use crate::state::{Control, ControlGrad, ParticlesGrad, SceneGrad};
use glam::{DVec2, DVec3};

/// `∂J/∂state`, flat as `[particles and poses | code | base 3N | first positions 3N | middle 2]`.
struct LatentGrad {
    state: StateGrad,
    code: Vec<f64>,
    base: Vec<f64>,
    first: Vec<DVec3>,
    middle: DVec2,
}

impl LatentGrad {
    fn read(flat: &[f64], state: &LatentState) -> Self {
        let count = state.particles.len();
        let (own, rest) = flat.split_at(6 * (count + state.poses.len()));
        let (code, rest) = rest.split_at(state.code.len());
        let (base, rest) = rest.split_at(3 * count);
        let (first, middle) = rest.split_at(3 * count);
        Self {
            state: StateGrad::read(own, count, 0),
            code: code.to_vec(),
            base: base.to_vec(),
            first: first.chunks_exact(3).map(DVec3::from_slice).collect(),
            middle: DVec2::from_slice(middle),
        }
    }

    fn flat(&self) -> Vec<f64> {
        let first = self.first.iter().flat_map(|x| x.to_array());
        let rest = self.code.iter().chain(&self.base).copied().chain(first);
        self.state.flat().into_iter().chain(rest).chain(self.middle.to_array()).collect()
    }
}

fn add(sum: &mut [f64], terms: &[f32]) {
    sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += f64::from(*term));
}

fn single(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|x| *x as f32).collect()
}

impl LatentModel {
    /// Pulls `∂J/∂decoded` back to the code and the first positions.
    fn decoder_vjp(&self, state: &LatentState, code: &[f32], at: &[f32], grad: &mut LatentGrad, weights: &mut [f32]) {
        let (at_code, at_first) = self.view.decoded_vjp(&self.net, &state.start, code, at, weights);
        add(&mut grad.code, &at_code);
        grad.first.iter_mut().zip(at_first).for_each(|(sum, at)| *sum += at);
    }
}

impl Adjoint<LatentState> for LatentModel {
    fn step_vjp(
        &self,
        state: &LatentState,
        control: &Control,
        next: &[f64],
        weights: &mut [f32],
    ) -> (Vec<f64>, ControlGrad) {
        let mut grad = LatentGrad::read(next, state);
        let code = self.advance(state, control);
        let interval = state.start.interval;
        let mut at_decoded = Vec::with_capacity(3 * grad.first.len());
        let ParticlesGrad { positions, velocities } = &mut grad.state.particles;
        for (i, (x, v)) in positions.iter_mut().zip(velocities).enumerate() {
            let at_velocity = std::mem::take(v) / interval;
            let at_position = std::mem::replace(x, -at_velocity) + at_velocity;
            grad.first[i] += at_position;
            at_decoded.extend((self.scale * at_position).as_vec3().to_array());
        }
        for (base, at) in grad.base.iter_mut().zip(&at_decoded) {
            *base -= f64::from(*at);
        }
        self.decoder_vjp(state, &code, &at_decoded, &mut grad, weights);

        let inputs = vec![(state.code.clone(), state.code.len()), self.samples(state, control)];
        let (_, pulled) = pull(&self.next(state), inputs, &single(&grad.code), weights);
        grad.code = pulled[0].iter().map(|x| f64::from(*x)).collect();
        let (before, after, middle) = self.samples_vjp(state, control, &pulled[1]);
        grad.middle += middle;
        let mut poses = std::mem::replace(&mut grad.state.poses, before);
        poses.iter_mut().zip(after).for_each(|(at_end, by)| *at_end += by);
        (grad.flat(), ControlGrad { poses })
    }

    fn decode_vjp(&self, state: &LatentState, particles: &ParticlesGrad) -> Vec<f64> {
        let (order, count) = (&state.start.order, state.particles.len());
        let particles = ParticlesGrad {
            positions: order.gather(&particles.positions),
            velocities: order.gather(&particles.velocities),
        };
        let grad = LatentGrad {
            state: StateGrad::of(particles, 0, state.poses.len()),
            code: vec![0.0; state.code.len()],
            base: vec![0.0; 3 * count],
            first: vec![DVec3::ZERO; count],
            middle: DVec2::ZERO,
        };
        grad.flat()
    }

    fn encode_vjp(&self, start: &LatentState, at_start: &[f64], weights: &mut [f32]) -> SceneGrad {
        let mut grad = LatentGrad::read(at_start, start);
        let count = grad.first.len();
        let at_base = single(&grad.base);
        self.decoder_vjp(start, &start.code, &at_base, &mut grad, weights);
        let at_code = single(&grad.code);
        let at_seen = self.view.encoded_vjp(&self.net, &start.start, &at_code, weights);
        let share = (grad.middle / count.max(1) as f64).extend(0.0);
        let ParticlesGrad { positions, velocities } = &grad.state.particles;
        let at = positions.iter().zip(&grad.first).zip(&at_seen);
        let positions: Vec<DVec3> = at.map(|((x, first), seen)| *x + *first + *seen + share).collect();
        let order = &start.start.order;
        let particles = ParticlesGrad { positions: order.scatter(&positions), velocities: order.scatter(velocities) };
        SceneGrad { particles, poses: grad.state.poses }
    }
}
