//! Result rows → tables for people (terminal, Markdown), papers (LaTeX) and the report (HTML, plots).
mod ablation;
mod forecast;
mod formulas;
mod grid;
mod identification;
mod interval;
mod output;
mod paired;
mod picture;
mod plot;
mod report;
mod sheet;
mod summary;
mod verdict;

pub use ablation::{TrialRow, ablation};
pub use forecast::forecast;
pub use formulas::formulas;
pub use grid::Grid;
pub use identification::identification;
pub use interval::Interval;
pub use output::write;
pub use picture::{Picture, picture};
pub use plot::{Curve, curves};
pub use report::{Report, report};
pub use sheet::{Frame, Strip, sheet};
pub use summary::summary;
pub use verdict::verdict;
