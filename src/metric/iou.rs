//! Intersection over union of volumes.
use super::{Better, Matching, Metric, is_finite};
use crate::shape::spacing;
use anyhow::ensure;
use glam::{DVec3, UVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `|A ∩ B| / |A ∪ B|` of the volumes that two clouds fill, counted in voxels.
///
/// A cloud fills the closing of its points (Serra 1982): what is within R of a point and more than R − δ from all that is not. So
/// neither where inside the shape the points lie nor how many there are matters much, as long as R bridges the gaps between them; δ
/// is how far the cell that a point stands for reaches beyond it. R is `REACH` and δ `CELL` of the larger of the two clouds'
/// spacings (see [`spacing`]), and a voxel an eighth of R unless its side is given. A grid of more than `MOST` voxels is made
/// coarser.
#[derive(Clone, Copy, Debug, Default)]
pub struct Iou {
    /// Side of a voxel \[m\].
    pub voxel: Option<f64>,
}

/// Config of [`Iou`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IouSpec {
    /// Side of a voxel \[m\]; by default a quarter of the larger spacing of the two clouds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6))]
    pub voxel: Option<f64>,
}

impl IouSpec {
    pub(crate) fn build(self) -> anyhow::Result<Iou> {
        let voxel = self.voxel;
        ensure!(
            voxel.is_none_or(|v| v > 0.0 && v.is_finite()),
            "`voxel` of the metric iou must be a length above 0, got {voxel:?}"
        );
        Ok(Iou { voxel })
    }
}

/// Radius of the ball that closes a cloud, in spacings: two samplings of a box or a disc by 300 points share 0.89 with it, 0.86 with
/// 1.5 and 0.92 with 3, which would also close gaps of six spacings.
const REACH: f64 = 2.0;
/// Half the side of the cell that a point stands for, in spacings.
const CELL: f64 = 0.5;
/// The most voxels of a grid.
const MOST: f64 = 4e6;

impl Metric for Iou {
    fn name(&self) -> &'static str {
        "iou"
    }
    fn unit(&self) -> &'static str {
        ""
    }
    fn better(&self) -> Better {
        Better::Higher
    }
    fn evaluate(&self, achieved: &[DVec3], goal: &[DVec3], _: Matching) -> Option<f64> {
        if achieved.is_empty() || goal.is_empty() {
            return None;
        }
        if !is_finite(achieved) || !is_finite(goal) {
            return Some(0.0);
        }
        let reach = REACH * spacing(achieved)?.max(spacing(goal)?);
        let grid = Grid::around(achieved.iter().chain(goal), reach, self.voxel.unwrap_or(reach / 8.0))?;
        let (a, b) = (grid.filled(achieved), grid.filled(goal));
        let count = |both: &dyn Fn(bool, bool) -> bool| a.iter().zip(&b).filter(|(a, b)| both(**a, **b)).count();
        let union = count(&|a, b| a || b);
        (union > 0).then(|| count(&|a, b| a && b) as f64 / union as f64)
    }
}

/// A box of voxels with room for a ball around every point.
struct Grid {
    low: DVec3,
    voxel: f64,
    size: UVec3,
    reach: f64,
}

impl Grid {
    /// `None` where all points are one.
    fn around<'a>(points: impl Iterator<Item = &'a DVec3>, reach: f64, voxel: f64) -> Option<Self> {
        let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let extent = high - low + 2.0 * reach;
        let voxel = voxel.max((extent.element_product() / MOST).cbrt());
        let reach = reach.max(voxel);
        let margin = reach + 2.0 * voxel;
        let size = ((high - low + 2.0 * margin) / voxel).ceil().as_uvec3();
        (voxel > 0.0).then_some(Self { low: low - margin, voxel, size, reach })
    }

    fn row(&self, cell: UVec3) -> usize {
        (cell.x as usize * self.size.y as usize + cell.y as usize) * self.size.z as usize + cell.z as usize
    }

    fn cells(&self, from: UVec3, to: UVec3) -> impl Iterator<Item = UVec3> + use<> {
        (from.x..to.x)
            .flat_map(move |x| (from.y..to.y).flat_map(move |y| (from.z..to.z).map(move |z| UVec3::new(x, y, z))))
    }

    /// Voxels of the closing of `points`: within reach of one, and with no voxel that is not within R − δ.
    fn filled(&self, points: &[DVec3]) -> Vec<bool> {
        let mut near = vec![false; self.size.x as usize * self.size.y as usize * self.size.z as usize];
        let reach = self.reach / self.voxel;
        for point in points {
            let middle = (*point - self.low) / self.voxel;
            self.ball(middle, reach, |row| near[row] = true);
        }
        let kept = reach * (1.0 - CELL / REACH);
        let mut filled = near.clone();
        let one = UVec3::ONE;
        for cell in self.cells(one, self.size - one).filter(|cell| !near[self.row(*cell)]) {
            // Of the empty voxels only those at the border reach a voxel that the others do not.
            let beside = [UVec3::X, UVec3::Y, UVec3::Z].into_iter().flat_map(|axis| [cell + axis, cell - axis]);
            if beside.into_iter().any(|cell| near[self.row(cell)]) {
                self.ball(cell.as_dvec3() + 0.5, kept, |row| filled[row] = false);
            }
        }
        filled
    }

    /// Calls `with` for every voxel whose middle is at most `reach` from `middle`, both in voxels.
    fn ball(&self, middle: DVec3, reach: f64, mut with: impl FnMut(usize)) {
        let low = (middle - 0.5 - reach).ceil().max(DVec3::ZERO).as_uvec3();
        let high = (middle + 0.5 + reach).floor().as_uvec3().min(self.size);
        // Loops, not an iterator of cells: whether the compiler sees through that differs from build to build, by a factor of three.
        for x in low.x..high.x {
            for y in low.y..high.y {
                for z in low.z..high.z {
                    let cell = UVec3::new(x, y, z);
                    if (cell.as_dvec3() + 0.5).distance_squared(middle) <= reach * reach {
                        with(self.row(cell));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{CuboidSpec, ShapeSpec};
    use crate::state::stream;

    fn iou(a: &[DVec3], b: &[DVec3]) -> f64 {
        Iou::default().evaluate(a, b, Matching::Unmatched).unwrap()
    }

    fn lattice(size: DVec3, step: f64) -> Vec<DVec3> {
        let count = |length: f64| 0..=(length / step).round() as u32;
        let cells = count(size.x)
            .flat_map(|x| count(size.y).flat_map(move |y| count(size.z).map(move |z| UVec3::new(x, y, z))));
        cells.map(|cell| cell.as_dvec3() * step).collect()
    }

    fn moved(points: &[DVec3], by: DVec3) -> Vec<DVec3> {
        points.iter().map(|p| *p + by).collect()
    }

    #[test]
    fn boxes_that_overlap_by_half_share_a_third() {
        let a = lattice(DVec3::new(0.06, 0.04, 0.03), 0.0025);
        for (by, expected) in [(0.0, 1.0), (0.03, 1.0 / 3.0), (0.015, 0.6), (0.045, 1.0 / 7.0), (0.07, 0.0)] {
            let found = iou(&a, &moved(&a, DVec3::X * by));
            assert!((found - expected).abs() < 0.02, "moved by {by}: {found} against {expected}");
        }
    }

    #[test]
    fn two_samplings_of_one_box_are_almost_the_same_and_apart_they_share_nothing() {
        let spec = CuboidSpec { width: 0.06, length: 0.06, thickness: Some(0.03), volume: None };
        let shape = ShapeSpec::Cuboid(spec).build().unwrap();
        for (first, second, least) in [(300, 300, 0.87), (300, 1000, 0.87), (1000, 1000, 0.9)] {
            let sample = |count, k| shape.points(count, &mut stream(1, &[k]));
            let (a, b) = (sample(first, 1), sample(second, 2));
            let found = iou(&a, &b);
            assert!(found > least, "{first} and {second} points: {found}");
            assert_eq!(iou(&a, &moved(&b, DVec3::Y * 0.07)), 0.0);
        }
    }

    #[test]
    fn one_particle_far_away_changes_little_and_clouds_without_volume_have_none() {
        let a = lattice(DVec3::splat(0.04), 0.004);
        let mut stray = a.clone();
        stray.push(DVec3::X * 0.3);
        assert!(iou(&stray, &a) > 0.98);
        assert_eq!(Iou::default().evaluate(&[DVec3::ZERO], &a, Matching::Unmatched), None);
        assert_eq!(Iou::default().evaluate(&[DVec3::ZERO; 2], &[DVec3::ZERO; 2], Matching::Unmatched), None);
    }
}
