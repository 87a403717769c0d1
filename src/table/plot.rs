//! Curves as SVG, the only user of the plotting library.
use kuva::prelude::{Layout, LinePlot, Plot, render_to_svg};

/// One line of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// (x, y) points in order; points that are not finite, or not positive (the y axis is logarithmic), are left out.
    pub points: Vec<(f64, f64)>,
}

/// The palette of Wong (2011, Nature Methods 8:441), told apart by colour-blind readers too.
const COLOURS: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];

/// An SVG of `curves` over a logarithmic y axis, or `None` when no curve has two points.
pub fn curves(title: &str, x: &str, y: &str, curves: &[Curve]) -> Option<String> {
    let drawable = |c: &Curve| -> Vec<(f64, f64)> {
        c.points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite() && *y > 0.0).collect()
    };
    let lines: Vec<(&str, Vec<(f64, f64)>)> =
        curves.iter().map(|c| (c.name.as_str(), drawable(c))).filter(|(_, points)| points.len() > 1).collect();
    if lines.is_empty() {
        return None;
    }
    let plots: Vec<Plot> = lines
        .into_iter()
        .zip(COLOURS.iter().cycle())
        .map(|((name, points), colour)| LinePlot::new().with_data(points).with_color(*colour).with_legend(name).into())
        .collect();
    let layout = Layout::auto_from_plots(&plots).with_title(title).with_x_label(x).with_y_label(y).with_log_y();
    Some(render_to_svg(plots, layout))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_what_can_be_drawn_and_nothing_else() {
        let good = Curve { name: "loss".into(), points: vec![(0.0, 1.0), (1.0, 0.1), (2.0, f64::NAN), (3.0, 0.01)] };
        let bad = Curve { name: "empty".into(), points: vec![(0.0, -1.0), (1.0, 0.0)] };
        let svg = curves("t", "x", "y", &[good, bad.clone()]).expect("one curve has points");
        assert!(svg.starts_with("<svg") && svg.contains("loss") && !svg.contains("empty") && !svg.contains("NaN"));
        assert_eq!(curves("t", "x", "y", &[bad]), None);
    }
}
