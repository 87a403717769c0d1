//! The rotation of a head about the vertical, an action's last number where the tool has one.
use crate::state::ActionSpace;

/// Appends the coordinate `rotation` in ±`bound` \[rad\], unless the bound is zero.
pub(super) fn append(space: &mut ActionSpace, bound: f64) {
    if bound > 0.0 {
        space.names.push("rotation".to_owned());
        space.low.push(-bound);
        space.high.push(bound);
    }
}

/// The other coordinates and the rotation \[rad\]: zero where the bound is.
pub(super) fn take(theta: &[f64], bound: f64) -> (&[f64], f64) {
    match theta {
        [others @ .., rotation] if bound > 0.0 => (others, *rotation),
        others => (others, 0.0),
    }
}
