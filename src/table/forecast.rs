//! The prediction table: each model's error on held-out episodes.
use super::Grid;
use crate::compare::Prediction;

/// One line a model: one-step and whole-rollout error, and their ratio to nothing moving.
pub fn forecast(predictions: &[Prediction]) -> Grid {
    let header =
        ["model", "one step [mm]", "÷ still", "rollout [mm]", "÷ still", "not finite"].map(String::from).to_vec();
    let line = |p: &Prediction| {
        let e = &p.held_out;
        vec![
            p.model.clone(),
            format!("{:.3}", 1e3 * e.one_step),
            format!("{:.2}", e.one_step / e.still_one_step),
            format!("{:.2}", 1e3 * e.rollout),
            format!("{:.2}", e.rollout / e.still_rollout),
            e.not_finite.to_string(),
        ]
    };
    let episodes = predictions.first().map_or(0, |p| p.held_out.episodes);
    Grid {
        title: "Prediction".into(),
        header,
        rows: predictions.iter().map(line).collect(),
        notes: vec![format!("root mean square over particles of {episodes} held-out episodes that no fit has seen")],
    }
}
