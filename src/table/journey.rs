//! What one model did for one goal: lines for the terminal, a table, and a page with the shape after every action.
use super::{Grid, Picture, Report, report};
use crate::compare::{Journey, Step};
use crate::config::write_whole;

/// An action as one line.
pub fn sentence(step: &Step) -> String {
    let Step { action, tool, predicted, achieved, seconds, rollouts, gradients, .. } = step;
    format!(
        "{action}  {tool}  {}: predicted {:.2} mm, achieved {:.2} mm, planned in {seconds:.2} s with {rollouts} \
         rollouts, {gradients} gradients",
        theta(step),
        1e3 * predicted,
        1e3 * achieved
    )
}

/// θ by name: lengths as millimetres, angles as degrees.
fn theta(step: &Step) -> String {
    let coordinate = |(name, value): (&String, &f64)| match ANGLES.contains(&name.as_str()) {
        true => format!("{name} {:.0}°", value.to_degrees()),
        false => format!("{name} {:.1} mm", 1e3 * value),
    };
    step.theta.iter().map(coordinate).collect::<Vec<_>>().join(", ")
}

/// Coordinates of actions that are angles \[rad\]; all others are lengths \[m\].
const ANGLES: &[&str] = &["rotation", "direction"];

/// Writes `report.html` into the journey's folder, and returns its table.
///
/// # Errors
/// When the file cannot be written.
pub fn write_journey(journey: &Journey, config: &str) -> anyhow::Result<Grid> {
    let [model, planner, goal] = &journey.names;
    let title = format!("{model} with {planner} to {goal}");
    let header = ["action", "tool", "θ", "predicted [mm]", "achieved [mm]", "seconds", "rollouts", "gradients"];
    let line = |step: &Step| {
        let millimetres = |cost: f64| format!("{:.2}", 1e3 * cost);
        vec![
            step.action.to_string(),
            step.tool.clone(),
            theta(step),
            millimetres(step.predicted),
            millimetres(step.achieved),
            format!("{:.2}", step.seconds),
            step.rollouts.to_string(),
            step.gradients.to_string(),
        ]
    };
    let grid = Grid {
        title: title.clone(),
        header: header.map(String::from).to_vec(),
        rows: journey.steps.iter().map(line).collect(),
        notes: vec![format!("cost before the first action: {:.2} mm", 1e3 * journey.start)],
    };
    let after = |k: usize| match k.checked_sub(1).map(|k| &journey.steps[k]) {
        None => format!("start, {:.2} mm", 1e3 * journey.start),
        Some(step) => format!("{} {}, {:.2} mm", step.action, step.tool, 1e3 * step.achieved),
    };
    let shapes = journey.shapes.iter().enumerate();
    let shapes = shapes.map(|(k, points)| Picture { title: after(k), points: points.clone() });
    let pictures = shapes.chain([Picture { title: "goal".into(), points: journey.goal.clone() }]).collect();
    let page = Report {
        title: format!("Pliant: {title}"),
        tables: vec![grid.clone()],
        galleries: vec![("after every action".into(), pictures)],
        plots: Vec::new(),
        config: config.to_owned(),
    };
    write_whole(&journey.folder.join("report.html"), report(&page).as_bytes())?;
    Ok(grid)
}
