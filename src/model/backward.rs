//! The sweep back through a rollout, written once for every [`Dynamics`].
use super::{Adjoint, Cost, Dynamics};
use crate::state::{Control, ControlGrad, Scene};

/// J, and its derivatives by the state that a rollout starts from and what moves it.
pub(super) struct Swept<S> {
    pub(super) cost: f64,
    pub(super) start: S,
    /// `∂J/∂x₀`.
    pub(super) at_start: Vec<f64>,
    pub(super) controls: Vec<ControlGrad>,
}

/// Forward through the steps, then backward by `pull`, which gives `(∂J/∂xₜ, ∂J/∂uₜ)` from `∂J/∂xₜ₊₁`; only states are kept, each
/// step's tape lives for that step alone. Nothing flows back across every `truncation`-th step.
pub(super) fn sweep<D: Dynamics>(
    model: &D,
    scene: &Scene,
    controls: &[Control],
    cost: &dyn Cost,
    truncation: usize,
    mut pull: impl FnMut(&dyn Adjoint<D::State>, &D::State, &Control, &[f64]) -> (Vec<f64>, ControlGrad),
) -> Option<Swept<D::State>> {
    let adjoint = model.adjoint()?;
    let horizon = controls.len();
    let mut states = vec![model.encode(scene)];
    for control in controls {
        states.push(model.step(states.last().expect("the encoded start"), control));
    }
    let decoded: Vec<_> = states.iter().map(|x| model.decode(x)).collect();
    let at = |t: usize| adjoint.decode_vjp(&states[t], &cost.gradient(t, horizon, &decoded[t]));
    let mut at_state = at(horizon);
    let mut at_controls = vec![ControlGrad::default(); horizon];
    for t in (0..horizon).rev() {
        let (back, control) = pull(adjoint, &states[t], &controls[t], &at_state);
        at_controls[t] = control;
        at_state = at(t);
        if t == 0 || !t.is_multiple_of(truncation) {
            at_state.iter_mut().zip(&back).for_each(|(a, b)| *a += b);
        }
    }
    let start = states.swap_remove(0);
    Some(Swept { cost: cost.total(&decoded), start, at_start: at_state, controls: at_controls })
}
