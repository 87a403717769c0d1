//! The prediction table: each model's error on held-out episodes.
use super::Grid;
use crate::compare::Prediction;

/// One line a model: one-step and whole-rollout error, and their ratio to nothing moving.
pub fn forecast(predictions: &[Prediction]) -> Grid {
    let header = [
        "model",
        "one step [mm]",
        "÷ still",
        "squared ÷ still",
        "rollout [mm]",
        "÷ still",
        "squared ÷ still",
        "not finite",
    ]
    .map(String::from)
    .to_vec();
    let line = |p: &Prediction| {
        let e = &p.held_out;
        vec![
            p.model.clone(),
            format!("{:.3}", 1e3 * e.one_step),
            format!("{:.2}", e.one_step / e.still_one_step),
            format!("{:.2}", (e.one_step / e.still_one_step).powi(2)),
            format!("{:.2}", 1e3 * e.rollout),
            format!("{:.2}", e.rollout / e.still_rollout),
            format!("{:.2}", (e.rollout / e.still_rollout).powi(2)),
            e.not_finite.to_string(),
        ]
    };
    let episodes = predictions.first().map_or(0, |p| p.held_out.episodes);
    Grid {
        title: "Prediction".into(),
        header,
        rows: predictions.iter().map(line).collect(),
        notes: vec![
            format!("root mean square over particles of {episodes} held-out episodes that no fit has seen"),
            "squared: the mean square error over that of nothing moving, as GNS and LagrangeBench report errors".into(),
        ],
    }
}
