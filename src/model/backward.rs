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

/// Forward through the steps, then backward by `pull`, which gives `(∂J/∂xₜ, ∂J/∂uₜ)` from `∂J/∂xₜ₊₁`; only states are kept, those
/// that the model's [`super::Checkpoints`] say, and each step's tape lives for that step alone. Nothing flows back across every
/// `truncation`-th step.
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
    let stride = model.checkpoints().stride(horizon);
    let (mut kept, mut costs) = (Vec::new(), Vec::with_capacity(horizon + 1));
    let mut state = model.encode(scene);
    for (t, control) in controls.iter().enumerate() {
        let next = model.step(&state, control);
        let state = std::mem::replace(&mut state, next);
        let decoded = model.decode(&state);
        costs.push(cost.at(t, horizon, &decoded));
        if t.is_multiple_of(stride) {
            kept.push((state, decoded));
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
        let mut states = vec![first];
        for control in &controls[from..horizon.min(from + stride) - 1] {
            let state = model.step(&states.last().expect("a kept state").0, control);
            let decoded = model.decode(&state);
            states.push((state, decoded));
        }
        while let Some((state, decoded)) = states.pop() {
            let t = from + states.len();
            let (back, control) = pull(adjoint, &state, &controls[t], &at_state);
            at_controls[t] = control;
            at_state = adjoint.decode_vjp(&state, &cost.gradient(t, horizon, &decoded));
            if t == 0 || !t.is_multiple_of(truncation) {
                at_state.iter_mut().zip(&back).for_each(|(a, b)| *a += b);
            }
            start = Some(state);
        }
    }
    let start = start.unwrap_or_else(|| model.encode(scene));
    Some(Swept { cost: costs.iter().sum(), start, at_start: at_state, controls: at_controls })
}
