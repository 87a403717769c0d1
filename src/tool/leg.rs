//! Straight legs between waypoints, shared out over a fixed number of control steps.

/// A straight leg of a path in n path coordinates.
pub(super) struct Leg<const N: usize> {
    /// Its part of the steps, relative to the other legs.
    pub(super) share: usize,
    /// Where it ends.
    pub(super) to: [f64; N],
}

/// The path coordinates after each of `steps` steps from `from` along `legs`, at constant speed on each leg.
///
/// A leg ends at the step nearest to its share that leaves one for every later leg; with fewer steps than legs the first ones
/// are skipped, so that the end of the last is always reached.
pub(super) fn along<const N: usize>(steps: usize, from: [f64; N], legs: &[Leg<N>]) -> Vec<[f64; N]> {
    let total: usize = legs.iter().map(|leg| leg.share).sum();
    let mut path = Vec::with_capacity(steps);
    let (mut shares, mut at) = (0, from);
    for (i, leg) in legs.iter().enumerate() {
        shares += leg.share;
        let nearest = (2 * steps * shares + total) / (2 * total);
        let end = nearest.min((steps + i + 1).saturating_sub(legs.len())).max(path.len());
        let count = end - path.len();
        for k in 1..=count {
            let s = k as f64 / count as f64;
            // Weighted so that s = 1 gives the end itself, bit for bit.
            path.push(std::array::from_fn(|i| (1.0 - s) * at[i] + s * leg.to[i]));
        }
        at = leg.to;
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legs_take_their_shares_and_end_where_they_should() {
        let legs = [Leg { share: 4, to: [0.1] }, Leg { share: 8, to: [0.9] }, Leg { share: 3, to: [0.3] }];
        let path = along(15, [0.7], &legs);
        assert_eq!((path.len(), path[3], path[11], path[14]), (15, [0.1], [0.9], [0.3]));
        assert!((path[1][0] - 0.4).abs() < 1e-15 && (path[7][0] - 0.5).abs() < 1e-15);
        for steps in 1..40 {
            let path = along(steps, [0.7], &legs);
            assert_eq!((path.len(), path[steps - 1]), (steps, [0.3]), "{steps} steps");
        }
    }
}
