//! Where descents start: the middle of the box, and the cheapest of a few uniform draws.
use super::best::Best;
use super::{Objective, within};
use anyhow::ensure;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Checks how many plans descend, of how many candidates.
pub(super) fn check(candidates: usize, starts: usize) -> anyhow::Result<()> {
    ensure!(starts >= 1, "planner.starts must be at least 1");
    ensure!(
        candidates >= starts,
        "planner.candidates = {candidates} is less than planner.starts = {starts}: every start is a candidate"
    );
    Ok(())
}

/// `count` starts beside the middle \[fractions of the box\]: the cheapest of `candidates` draws, which are costed only where
/// there is a choice between them.
pub(super) fn others(
    objective: &dyn Objective,
    candidates: usize,
    count: usize,
    best: &mut Best,
    rng: &mut ChaCha8Rng,
) -> Vec<Vec<f64>> {
    let space = objective.space();
    let mut drawn: Vec<Vec<f64>> =
        (0..candidates).map(|_| (0..space.dimension()).map(|_| rng.random::<f64>()).collect()).collect();
    if drawn.len() > count && count > 0 {
        let plans: Vec<_> = drawn.iter().map(|u| within(space, u)).collect();
        let costs = best.costs(objective, &plans);
        let mut order: Vec<usize> = (0..drawn.len()).filter(|&i| costs[i].is_finite()).collect();
        order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
        drawn = order.iter().map(|&i| drawn[i].clone()).collect();
    }
    drawn.truncate(count);
    drawn
}
