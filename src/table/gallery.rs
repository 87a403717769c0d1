//! `gallery.html`: goal, what each model achieved, and its tools, all seen from above.
use super::grid::html_text;
use crate::compare::Attempt;
use glam::{DVec2, DVec3};
use indexmap::{IndexMap, IndexSet};
use std::fmt::Write;

const STYLE: &str = "body{font:13px/1.35 system-ui,sans-serif;margin:1.5rem;color:#1a1a1a}h1{font-size:1.3rem}\
table{border-collapse:collapse}th,td{padding:.25rem .4rem;text-align:center;vertical-align:top;max-width:170px}\
thead th{position:sticky;top:0;background:#fff;border-bottom:2px solid #333}tbody th{text-align:left;font-size:1.1rem}\
tr{border-bottom:1px solid #ddd}svg{background:#fafafa}.cost{font-variant-numeric:tabular-nums}.tools{color:#555;font-size:11px}";

/// Side of a picture \[pixels\].
const SIDE: f64 = 150.0;

/// The page of all attempts of each goal's first seed, a line for every goal and planner, a column for every model; nothing in it
/// is loaded from elsewhere.
pub fn gallery(title: &str, attempts: &[Attempt]) -> String {
    let models: IndexSet<&str> = attempts.iter().map(|a| a.row.model.as_str()).collect();
    let mut seeds: IndexMap<&str, u64> = IndexMap::new();
    let mut lines: IndexMap<(&str, &str), Vec<&Attempt>> = IndexMap::new();
    for attempt in attempts {
        let row = &attempt.row;
        if *seeds.entry(&row.goal).or_insert(row.seed) == row.seed {
            lines.entry((&row.goal, &row.planner)).or_default().push(attempt);
        }
    }
    let heads: String = models.iter().map(|model| format!("<th>{}</th>", html_text(model))).collect();
    let body: String = lines.iter().map(|(key, line)| row(*key, line, &models)).collect();
    let title = html_text(title);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{title}</title><style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n<p>Seen from above; the number is the cost \
         against the goal, below it the tools in their order.</p>\n<table><thead><tr><th></th><th>start</th><th>goal</th>{heads}</tr>\
         </thead>\n<tbody>\n{body}</tbody></table>\n</body></html>\n"
    )
}

fn row((goal, planner): (&str, &str), line: &[&Attempt], models: &IndexSet<&str>) -> String {
    let Some(first) = line.first() else { return String::new() };
    let achieved = line.iter().map(|attempt| attempt.achieved.as_slice());
    let frame = Frame::around(&[&first.goal, &first.start], achieved);
    let of = |model: &&str| match line.iter().find(|a| a.row.model == **model) {
        None => "<td></td>".to_owned(),
        Some(attempt) => {
            let cost = attempt.row.achieved.map_or("no plan".to_owned(), |cost| format!("{:.2} mm", 1e3 * cost));
            let tools = html_text(&attempt.row.tools.join(" → "));
            let picture = frame.picture(&attempt.achieved);
            let outside = match frame.outside(&attempt.achieved) {
                0 => String::new(),
                count => format!("<div class=\"tools\">{count} particles outside</div>"),
            };
            format!("<td>{picture}<div class=\"cost\">{cost}</div><div class=\"tools\">{tools}</div>{outside}</td>")
        }
    };
    let cells: String = models.iter().map(of).collect();
    format!(
        "<tr><th>{}<div class=\"tools\">{}, seed {}</div></th><td>{}<div class=\"cost\">{:.2} mm</div></td><td>{}</td>{cells}</tr>\n",
        html_text(goal),
        html_text(planner),
        first.row.seed,
        frame.picture(&first.start),
        1e3 * first.row.start,
        frame.picture(&first.goal)
    )
}

/// Share of what was achieved that a picture is sure to hold.
const NEAR: f64 = 0.98;

/// A square of the table.
struct Frame {
    middle: DVec2,
    /// Half of its side \[m\].
    half: f64,
}

impl Frame {
    /// The square around all of the `given` clouds and what is near of the `achieved`: of each the nearest [`NEAR`] to the others'
    /// middle, so that a particle that was flung away does not make all else a dot.
    fn around<'a>(given: &[&[DVec3]], achieved: impl Iterator<Item = &'a [DVec3]>) -> Self {
        let flat =
            |cloud: &[DVec3]| -> Vec<DVec2> { cloud.iter().filter(|p| p.is_finite()).map(|p| p.truncate()).collect() };
        let mut points: Vec<DVec2> = given.iter().flat_map(|cloud| flat(cloud)).collect();
        let middle = Self::of(&points).middle;
        for cloud in achieved {
            let mut cloud = flat(cloud);
            cloud.sort_by(|a, b| a.distance_squared(middle).total_cmp(&b.distance_squared(middle)));
            cloud.truncate((NEAR * cloud.len() as f64).ceil() as usize);
            points.extend(cloud);
        }
        Self::of(&points)
    }

    fn of(points: &[DVec2]) -> Self {
        let (low, high) =
            points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let size = (high - low).max_element();
        if !size.is_finite() {
            return Self { middle: DVec2::ZERO, half: 0.05 };
        }
        Self { middle: (low + high) / 2.0, half: 0.55 * size.max(0.02) }
    }

    /// How many of `points` are not in its picture.
    fn outside(&self, points: &[DVec3]) -> usize {
        let inside = |p: &&DVec3| (p.truncate() - self.middle).abs().max_element() <= self.half;
        points.len() - points.iter().filter(inside).count()
    }

    /// Its picture: low particles first and darker, high ones over them.
    fn picture(&self, points: &[DVec3]) -> String {
        let scale = SIDE / (2.0 * self.half);
        let mut points: Vec<DVec3> = points.iter().copied().filter(|p| p.is_finite()).collect();
        points.sort_by(|a, b| a.z.total_cmp(&b.z));
        let mut svg = format!("<svg viewBox=\"0 0 {SIDE} {SIDE}\" width=\"{SIDE}\" height=\"{SIDE}\">");
        for p in points {
            let flat = scale * (p.truncate() - self.middle);
            let (x, y) = (SIDE / 2.0 + flat.x, SIDE / 2.0 - flat.y);
            let light = 40.0 + 35.0 * (p.z / 0.04).clamp(0.0, 1.0);
            let radius = (scale * 0.004).max(1.0);
            let _ =
                write!(svg, "<circle cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"{radius:.1}\" fill=\"hsl(32 70% {light:.0}%)\"/>");
        }
        svg + "</svg>"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attempt(goal: &str, model: &str, seed: u64, at: f64) -> Attempt {
        let row = serde_json::json!({ "model": model, "planner": "cem", "goal": goal, "seed": seed, "control": "closed",
            "tools": ["press", "knife"], "actions": [], "predicted": 0.1, "achieved": 0.0042, "start": 0.2, "one_step": null,
            "rollout": null, "metrics": {}, "floors": {}, "rollouts": 1, "gradients": 0, "not_finite": 0, "seconds": 0.0,
            "commit": "", "fingerprint": "" });
        let cloud = |x: f64| vec![DVec3::new(x, 0.0, 0.01), DVec3::new(x, 0.02, 0.0)];
        Attempt { row: serde_json::from_value(row).unwrap(), start: cloud(0.0), goal: cloud(0.03), achieved: cloud(at) }
    }

    #[test]
    fn every_goal_is_a_line_of_its_first_seed_with_a_picture_and_the_tools_of_every_model() {
        let all = [("A", "still", 3), ("A", "oracle", 3), ("A", "still", 4), ("<B>", "still", 3)];
        let attempts: Vec<_> = all.iter().map(|(goal, model, seed)| attempt(goal, model, *seed, 0.01)).collect();
        let page = gallery("letters", &attempts);
        assert_eq!(page.matches("<svg").count(), 4 + 3, "start and goal twice, and three attempts");
        assert_eq!(page.matches("press → knife").count(), 3);
        assert!(
            page.contains("4.20 mm") && page.contains("&lt;B&gt;") && !page.contains("<B>") && !page.contains("://")
        );
    }

    #[test]
    fn x_is_to_the_right_y_is_up_and_what_is_no_number_is_not_drawn() {
        let cloud = [DVec3::ZERO, DVec3::new(0.02, 0.04, 0.0), DVec3::NAN];
        let frame = Frame::around(&[&cloud], std::iter::empty());
        let svg = frame.picture(&cloud);
        let number = |circle: &str, key: &str| -> f64 {
            circle.split(&format!("{key}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
        };
        let circles: Vec<&str> = svg.split("<circle").skip(1).collect();
        assert_eq!(circles.len(), 2);
        assert!(
            number(circles[0], "cx") < number(circles[1], "cx") && number(circles[0], "cy") > number(circles[1], "cy")
        );
    }

    #[test]
    fn a_picture_holds_what_was_pushed_aside_but_not_what_was_flung_away_and_counts_it() {
        let given = [DVec3::ZERO, DVec3::new(0.02, 0.02, 0.0)];
        let mut achieved: Vec<DVec3> = (0..100).map(|i| DVec3::new(0.001 * f64::from(i), 0.0, 0.0)).collect();
        let frame = Frame::around(&[&given], [achieved.as_slice()].into_iter());
        assert_eq!(frame.outside(&achieved), 0, "half {}", frame.half);
        achieved[0].y = 5.0;
        achieved[1] = DVec3::NAN;
        let frame = Frame::around(&[&given], [achieved.as_slice()].into_iter());
        assert!(frame.half < 0.06, "half {}", frame.half);
        assert_eq!(frame.outside(&achieved), 2);
    }
}
