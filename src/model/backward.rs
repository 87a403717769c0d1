//! The sweep back through a rollout, written once for every [`Dynamics`].
use super::{Adjoint, Cost, Dynamics, Traced};
use crate::state::{Control, ControlGrad, Particles, Scene};

/// J, and its derivatives by the state that a rollout starts from and what moves it.
pub(super) struct Swept<S> {
    pub(super) cost: f64,
    pub(super) start: S,
    /// `∂J/∂x₀`.
    pub(super) at_start: Vec<f64>,
    pub(super) controls: Vec<ControlGrad>,
}

/// Most memory that the traces of one sweep hold \[bytes\]; the same derivatives are computed from states alone beyond it.
const ROOM: usize = 256 << 20;

/// How a sweep goes back through a step.
pub(super) trait Back<S> {
    /// What the step leads to and its trace, where both are wanted.
    fn trace<'a>(&self, adjoint: &'a dyn Adjoint<S>, state: &S, control: &Control) -> Option<(S, Traced<'a, S>)> {
        let _ = (adjoint, state, control);
        None
    }
    /// `(∂J/∂xₜ, ∂J/∂uₜ)` from `∂J/∂xₜ₊₁`, `next`.
    fn pull(&mut self, step: Step<'_, S>, next: &[f64]) -> (Vec<f64>, ControlGrad);
}

/// A step to go back through.
pub(super) struct Step<'a, S> {
    pub(super) adjoint: &'a dyn Adjoint<S>,
    pub(super) state: &'a S,
    pub(super) control: &'a Control,
    pub(super) traced: Option<Traced<'a, S>>,
}

/// A state on the way, and the trace of the step from it.
struct Kept<'a, S> {
    state: S,
    decoded: Particles,
    traced: Option<Traced<'a, S>>,
}

/// Forward through the steps, then backward; only states are kept, those that the model's [`super::Checkpoints`] say, and the traces of
/// steps from them as long as there is room. Nothing flows back across every `truncation`-th step.
pub(super) fn sweep<D: Dynamics>(
    model: &D,
    scene: &Scene,
    controls: &[Control],
    cost: &dyn Cost,
    truncation: usize,
    mut back: impl Back<D::State>,
) -> Option<Swept<D::State>> {
    let adjoint = model.adjoint()?;
    let horizon = controls.len();
    let stride = model.checkpoints().stride(horizon);
    let mut room = ROOM;
    let mut costs = Vec::with_capacity(horizon + 1);
    // Where a state is soon gone back to, the step from it leaves a trace.
    let advance = |state: &D::State, control: &Control, room: &mut usize, back: &dyn Back<D::State>| {
        let traced = if *room == 0 { None } else { back.trace(adjoint, state, control) };
        let Some((next, traced)) = traced else { return (model.step(state, control), None) };
        let left = room.checked_sub(traced.bytes);
        *room = left.unwrap_or(0);
        (next, left.map(|_| traced))
    };
    let mut kept = Vec::new();
    let mut state = model.encode(scene);
    for (t, control) in controls.iter().enumerate() {
        let (next, traced) = match stride {
            1 => advance(&state, control, &mut room, &back),
            _ => (model.step(&state, control), None),
        };
        let state = std::mem::replace(&mut state, next);
        let decoded = model.decode(&state);
        costs.push(cost.at(t, horizon, &decoded));
        if t.is_multiple_of(stride) {
            kept.push(Kept { state, decoded, traced });
        }
    }
    let decoded = model.decode(&state);
    costs.push(cost.at(horizon, horizon, &decoded));
    let mut at_state = adjoint.decode_vjp(&state, &cost.gradient(horizon, horizon, &decoded));
    drop((state, decoded));

    let mut at_controls = vec![ControlGrad::default(); horizon];
    let mut start = None;
    while let Some(first) = kept.pop() {
        let from = stride * kept.len();
        let mut segment = vec![first];
        let mut room = ROOM;
        for control in &controls[from..horizon.min(from + stride) - 1] {
            let last = segment.last_mut().expect("a kept state");
            let (state, traced) = advance(&last.state, control, &mut room, &back);
            last.traced = traced;
            let decoded = model.decode(&state);
            segment.push(Kept { state, decoded, traced: None });
        }
        while let Some(Kept { state, decoded, traced }) = segment.pop() {
            let t = from + segment.len();
            let step = Step { adjoint, state: &state, control: &controls[t], traced };
            let (earlier, control) = back.pull(step, &at_state);
            at_controls[t] = control;
            at_state = adjoint.decode_vjp(&state, &cost.gradient(t, horizon, &decoded));
            if t == 0 || !t.is_multiple_of(truncation) {
                at_state.iter_mut().zip(&earlier).for_each(|(a, b)| *a += b);
            }
            start = Some(state);
        }
    }
    let start = start.unwrap_or_else(|| model.encode(scene));
    Some(Swept { cost: costs.iter().sum(), start, at_start: at_state, controls: at_controls })
}
