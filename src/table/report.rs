//! `report.html`: one self-contained page with the table, the shapes and the learning curves.
use super::grid::html_text;
use super::{Grid, Picture, picture};
use glam::DVec3;

/// What the page shows.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Page title.
    pub title: String,
    /// Tables, in order.
    pub tables: Vec<Grid>,
    /// Rows of pictures drawn to one scale: caption and pictures.
    pub galleries: Vec<(String, Vec<Picture>)>,
    /// SVG plots.
    pub plots: Vec<String>,
    /// The resolved config that made the page, as TOML.
    pub config: String,
}

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;margin:2rem auto;max-width:1640px;padding:0 1rem;color:#1a1a1a}\
h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem}table{border-collapse:collapse;font-size:13px}\
th,td{padding:.3rem .6rem;text-align:left;border-bottom:1px solid #ddd;white-space:nowrap;font-variant-numeric:tabular-nums}\
thead th{border-bottom:2px solid #333}.note{color:#555;font-size:13px;margin:.2rem 0}\
.gallery{display:flex;flex-wrap:wrap;gap:.5rem}figure{margin:0;text-align:center;font-size:13px}\
.plots svg{max-width:100%;height:auto}pre{background:#f6f6f6;padding:1rem;overflow:auto;font-size:12px}\
.scroll{overflow-x:auto}";

/// The page as HTML; nothing in it is loaded from elsewhere.
pub fn report(report: &Report) -> String {
    let tables: String =
        report.tables.iter().map(|t| format!("<div class=\"scroll\">{}</div>\n", t.to_html())).collect();
    let galleries: String = report.galleries.iter().map(|(caption, pictures)| gallery(caption, pictures)).collect();
    let plots: String = report.plots.concat();
    let plots = if plots.is_empty() {
        plots
    } else {
        format!("<h2>Learning curves</h2>\n<div class=\"plots\">{plots}</div>\n")
    };
    let (title, config) = (html_text(&report.title), html_text(&report.config));
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{title}</title><style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n{tables}{galleries}{plots}\
         <h2>Config</h2>\n<details><summary>resolved config</summary><pre>{config}</pre></details>\n</body></html>\n"
    )
}

fn gallery(caption: &str, pictures: &[Picture]) -> String {
    let middle = middle(pictures.first().map_or(&[], |start| &start.points));
    let offsets = pictures.iter().flat_map(|p| &p.points).map(|p| *p - middle);
    let half_width = 1.25 * offsets.map(|p| p.x.abs().max(p.y.abs())).filter(|r| r.is_finite()).fold(0.03, f64::max);
    let figure = |p: &Picture| {
        format!("<figure>{}<figcaption>{}</figcaption></figure>", picture(p, middle, half_width), html_text(&p.title))
    };
    let figures: String = pictures.iter().map(figure).collect();
    format!("<h2>{}</h2>\n<div class=\"gallery\">{figures}</div>\n", html_text(caption))
}

/// The mean of the finite points in the table plane, z = 0 \[m\].
fn middle(points: &[DVec3]) -> DVec3 {
    let finite = || points.iter().filter(|p| p.is_finite());
    (finite().sum::<DVec3>() / finite().count().max(1) as f64).with_z(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_stands_alone_and_escapes_what_it_is_given() {
        let points = vec![DVec3::ZERO];
        let page = report(&Report {
            title: "a < b".into(),
            galleries: vec![("goal".into(), vec![Picture { title: "<x>".into(), points }])],
            config: "x = \"<script>\"".into(),
            ..Report::default()
        });
        for loaded in ["http://", "https://", "src=", "<script>", "<x>"] {
            assert!(!page.contains(loaded), "{loaded}");
        }
        assert!(page.contains("a &lt; b"));
    }
}
