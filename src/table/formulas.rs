//! The formulas that a network was read as.
use super::Grid;
use crate::train::distil::Candidate;

/// One line a formula, the believed ones marked.
pub fn formulas(front: &[Candidate]) -> Grid {
    let header = ["edge", "force", "complexity", "fit [%]", "validation [%]", "held out [%]", "believed", "formula"];
    let percent = |error: f64| format!("{:.3}", 100.0 * error);
    let line = |c: &Candidate| {
        let constants: Vec<String> = c.constants.iter().map(|(name, value)| format!("{name} = {value:.4e}")).collect();
        vec![
            c.edge.clone(),
            c.force.clone(),
            c.complexity.to_string(),
            percent(c.fit),
            percent(c.validation),
            c.held_out.map_or_else(|| "–".to_owned(), percent),
            if c.chosen { "yes" } else { "" }.to_owned(),
            format!("{}  {}", c.formula, constants.join(", ")).trim_end().to_owned(),
        ]
    };
    Grid {
        title: "Formulas that no simpler one beats".into(),
        header: header.map(String::from).to_vec(),
        rows: front.iter().map(line).collect(),
        notes: vec![
            "errors: root mean square over meetings, as a fraction of the messages' own".into(),
            "believed: where ln(validation error) falls most steeply with complexity, among those within 1.5 of the least".into(),
        ],
    }
}
