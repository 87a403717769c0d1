//! What makes messages die that data do not ask for.
use crate::model::WorldModel;
use crate::state::{Control, Scene};

/// `λ/M Σ (|N| + |T|)` over the M messages at the start of a control step; adds its derivative to `weights`.
pub(super) fn shrink(
    model: &dyn WorldModel,
    scene: &Scene,
    control: &Control,
    lambda: f64,
    weights: &mut [f32],
) -> f64 {
    let messages = model.messages(scene, control);
    let share = lambda / messages.len().max(1) as f64;
    // Zero has the slope zero, unlike with `f64::signum`.
    let slope = |x: f64| if x == 0.0 { 0.0 } else { share * x.signum() };
    let at: Vec<[f64; 2]> = messages.iter().map(|m| [slope(m.normal), slope(m.tangential)]).collect();
    model.messages_vjp(scene, control, &at, weights);
    share * messages.iter().map(|m| m.normal.abs() + m.tangential.abs()).sum::<f64>()
}
