//! Roots: points that stand for many particles, so that news crosses a body in a few steps whatever its size.
use crate::shape::farthest_points;
use glam::DVec3;
use std::collections::BTreeSet;
use std::ops::Range;

/// The roots over a list of particles, level upon level; built once, and kept while the particles move.
///
/// Roots are numbered body by body and from the lowest level up, and stand in a graph behind the particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Roots {
    /// Number of particles N.
    particles: usize,
    /// Roots of each level of each body.
    levels: Vec<Range<usize>>,
    /// Particles under each root.
    leaves: Vec<Vec<u32>>,
    /// Rows right under each root: particles, or roots of the level below; ascending.
    children: Vec<Vec<u32>>,
}

/// Most sweeps of k-means; the assignment stands still long before.
const SWEEPS: usize = 50;

impl Roots {
    /// Over each body, a list of rows of `points`, `counts[0]` roots, `counts[1]` over those, and so on, by k-means (Lloyd 1982) from
    /// points far apart; fewer where there are fewer points to stand for.
    pub fn over(points: &[DVec3], bodies: &[Vec<u32>], counts: &[usize]) -> Self {
        let mut roots = Self { particles: points.len(), ..Self::default() };
        for body in bodies {
            let mut below: Vec<DVec3> = body.iter().map(|&i| points[i as usize]).collect();
            let mut rows = body.clone();
            for &count in counts {
                let (of, middles) = clusters(&below, count);
                let start = roots.leaves.len();
                for root in 0..middles.len() {
                    let children: Vec<u32> =
                        rows.iter().zip(&of).filter(|(_, k)| **k == root).map(|(i, _)| *i).collect();
                    let leaves = children.iter().flat_map(|&child| roots.under(child as usize)).collect();
                    roots.children.push(children);
                    roots.leaves.push(leaves);
                }
                roots.levels.push(start..roots.leaves.len());
                (below, rows) =
                    (middles, (points.len() + start..points.len() + roots.len()).map(|i| i as u32).collect());
            }
        }
        roots
    }

    /// Number of roots.
    pub fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.leaves.is_empty()
    }

    /// Rows of the roots of each level of each body, in a graph of these particles.
    pub fn levels(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.levels.iter().map(|level| level.start + self.particles..level.end + self.particles)
    }

    /// The row of each root, and the rows right under it.
    pub fn children(&self) -> impl Iterator<Item = (usize, &[u32])> {
        self.children.iter().enumerate().map(|(root, children)| (root + self.particles, &children[..]))
    }

    /// The particles' `values` and, behind them, of every root the mean of its particles'.
    pub fn with_means(&self, values: &[DVec3]) -> Vec<DVec3> {
        let mean = |leaves: &Vec<u32>| leaves.iter().map(|&i| values[i as usize]).sum::<DVec3>() / leaves.len() as f64;
        values.iter().copied().chain(self.leaves.iter().map(mean)).collect()
    }

    /// Adds to the particles' rows of `at`, the derivative by what [`Roots::with_means`] gives, what follows from the roots' rows.
    pub fn with_means_vjp(&self, at: &mut [DVec3]) {
        let (values, means) = at.split_at_mut(self.particles);
        for (leaves, back) in self.leaves.iter().zip(means) {
            leaves.iter().for_each(|&i| values[i as usize] += *back / leaves.len() as f64);
        }
    }

    /// The particles' `bodies` and, behind them, that of every root.
    pub fn with_bodies(&self, bodies: &[u32]) -> Vec<u32> {
        bodies.iter().copied().chain(self.leaves.iter().map(|leaves| bodies[leaves[0] as usize])).collect()
    }

    fn under(&self, row: usize) -> Vec<u32> {
        row.checked_sub(self.particles).map_or_else(|| vec![row as u32], |root| self.leaves[root].clone())
    }
}

/// The cluster of every point, and the clusters' means; none of them is empty.
fn clusters(points: &[DVec3], count: usize) -> (Vec<usize>, Vec<DVec3>) {
    let mut means: Vec<DVec3> = farthest_points(points, count).into_iter().map(|i| points[i]).collect();
    let mut of = Vec::new();
    for _ in 0..SWEEPS {
        let nearest = |p: &DVec3| {
            let gap = |k: usize| p.distance_squared(means[k]);
            (0..means.len()).fold(0, |best, k| if gap(k) < gap(best) { k } else { best })
        };
        let next: Vec<usize> = points.iter().map(nearest).collect();
        let used: BTreeSet<usize> = next.iter().copied().collect();
        let next: Vec<usize> = next.iter().map(|k| used.range(..k).count()).collect();
        if next == of {
            break;
        }
        let (mut sums, mut sizes) = (vec![DVec3::ZERO; used.len()], vec![0.0; used.len()]);
        for (p, &k) in points.iter().zip(&next) {
            sums[k] += *p;
            sizes[k] += 1.0;
        }
        means = sums.into_iter().zip(sizes).map(|(sum, size)| sum / size).collect();
        of = next;
    }
    (of, means)
}
