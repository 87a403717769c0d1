//! Strokes that reach a given depth into the side of the workpiece.
use super::Workpiece;
use crate::state::ActionSpace;
use anyhow::ensure;

/// Checks the bounds of the depth and the distance kept before and after \[m\].
pub(super) fn check([least, greatest]: [f64; 2], clearance: f64) -> anyhow::Result<()> {
    ensure!(0.0 < least && least <= greatest, "`depth` needs 0 < least ≤ greatest, not {least} and {greatest}");
    ensure!(clearance > 0.0, "`clearance` must be positive");
    Ok(())
}

/// The greatest depth that makes sense: not beyond the piece's smaller width \[m\].
pub(super) fn deepest(piece: &Workpiece, [least, greatest]: [f64; 2]) -> f64 {
    (2.0 * piece.narrow()).min(greatest).max(least)
}

/// The box (r, rotation, depth) of a stroke along a line at offset r from the middle, within the piece's smaller half extent.
pub(super) fn across(piece: &Workpiece, rotation: f64, depth: [f64; 2]) -> ActionSpace {
    let narrow = piece.narrow();
    ActionSpace {
        names: ["r", "rotation", "depth"].map(String::from).to_vec(),
        low: vec![-narrow, -rotation, depth[0]],
        high: vec![narrow, rotation, deepest(piece, depth)],
    }
}
