//! Numbers that compare an achieved shape with a goal.
use glam::DVec3;

/// A scalar on two point clouds \[m\], or on two matched particle lists.
pub trait Metric: Sync {
    /// Column title.
    fn name(&self) -> &'static str;
    /// Unit, for the table.
    fn unit(&self) -> &'static str;
    /// The number, or `None` where the metric is not defined for these clouds (no correspondence, too large).
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], matched: Matching) -> Option<f64>;
}

/// Whether row i of one cloud is the same particle as row i of the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matching {
    /// Rows correspond.
    Matched,
    /// Two samplings of shapes.
    Unmatched,
}
