//! The volume between the table and a cloud of surface points.
use super::Shape;
use super::extruded::positive;
use anyhow::ensure;
use glam::{DVec2, DVec3, IVec2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a surface cloud is filled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FillSpec {
    /// Width of a cell of the height map \[m\].
    #[schemars(range(min = 1e-4, max = 0.1))]
    pub cell: f64,
    /// Gaps in the footprint that are at most twice this wide are closed \[m\].
    #[schemars(range(min = 0.0, max = 0.1))]
    pub closing: f64,
    /// Then parts of the footprint that are at most twice this wide are dropped: the whiskers that cameras draw at edges \[m\].
    #[schemars(range(min = 0.0, max = 0.1))]
    pub opening: f64,
}

/// A height map on a grid: everything from the table up to the height of its cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    origin: DVec2,
    cell: f64,
    size: IVec2,
    /// Height of each cell \[m\], row by row; zero outside the footprint.
    heights: Vec<f64>,
}

impl Filled {
    /// The volume under `surface`, whose table is z = 0.
    ///
    /// A cell with points is as high as the highest of them; the footprint is closed and opened (Serra 1982) with discs, and its
    /// cells without points take the mean of the cells with points nearby, weighted by 1/distance².
    ///
    /// # Errors
    /// When no point lies above the table, a length of `spec` is impossible, the cloud is too wide for its cells, or opening
    /// leaves nothing.
    pub fn under(surface: &[DVec3], spec: &FillSpec) -> anyhow::Result<Self> {
        let cell = positive("fill.cell", spec.cell)?;
        for (key, length) in [("closing", spec.closing), ("opening", spec.opening)] {
            ensure!((0.0..=0.1).contains(&length), "fill.{key} must lie between 0 and 0.1 m, got {length}");
        }
        let above: Vec<_> = surface.iter().filter(|p| p.z > 0.0).collect();
        ensure!(!above.is_empty(), "no point of the cloud lies above the table");
        let reach = (spec.closing / cell).round() as i32;
        let bounds = |(l, h): (DVec2, DVec2), p: &&DVec3| (l.min(p.truncate()), h.max(p.truncate()));
        let (low, high) = above.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), bounds);
        let width = ((high - low) / cell).floor();
        ensure!(
            width.is_finite() && (width + 2.0 * f64::from(reach) + 3.0).element_product() < 1e7,
            "the cloud is {:.3} m by {:.3} m, too wide for fill.cell = {cell}; crop it or widen the cells",
            high.x - low.x,
            high.y - low.y
        );
        let origin = low - cell * f64::from(reach + 1);
        let size = width.as_ivec2() + 2 * reach + 3;
        let mut filled = Self { origin, cell, size, heights: vec![0.0; size.element_product() as usize] };
        for point in above {
            let index = filled.index(filled.place(point.truncate())).expect("the grid holds the cloud");
            filled.heights[index] = filled.heights[index].max(point.z);
        }
        filled.close(reach, (spec.opening / cell).round() as i32);
        ensure!(
            filled.heights.iter().any(|&h| h > 0.0),
            "no part of the cloud is as wide as twice fill.opening = {}; make it smaller",
            spec.opening
        );
        Ok(filled)
    }

    /// Closes, then opens the footprint with discs of so many cells, and gives the new cells a height.
    fn close(&mut self, closing: i32, opening: i32) {
        let known = self.heights.clone();
        let occupied: Vec<bool> = known.iter().map(|&h| h > 0.0).collect();
        let (gaps, whiskers) = (disc(closing), disc(opening));
        let closed = self.shrunk(&self.grown(&occupied, &gaps), &gaps);
        let opened = self.grown(&self.shrunk(&closed, &whiskers), &whiskers);
        for (i, cell) in self.cells().enumerate().filter(|(i, _)| !opened[*i] || !occupied[*i]) {
            let near = gaps.iter().filter_map(|&d| Some((d, known[self.index(cell + d)?]))).filter(|(_, h)| *h > 0.0);
            let (mut sum, mut weight) = (0.0, 0.0);
            for (d, height) in near {
                let w = 1.0 / f64::from(d.length_squared().max(1));
                (sum, weight) = (sum + w * height, weight + w);
            }
            // A closed cell lies within the disc of some cell with points, so there is always a weight.
            self.heights[i] = if opened[i] { sum / weight } else { 0.0 };
        }
    }

    fn cells(&self) -> impl Iterator<Item = IVec2> + use<> {
        let size = self.size;
        (0..size.y).flat_map(move |y| (0..size.x).map(move |x| IVec2::new(x, y)))
    }

    fn grown(&self, mask: &[bool], disc: &[IVec2]) -> Vec<bool> {
        let covered = |at: IVec2| self.index(at).is_some_and(|i| mask[i]);
        self.cells().map(|c| disc.iter().any(|&d| covered(c + d))).collect()
    }

    fn shrunk(&self, mask: &[bool], disc: &[IVec2]) -> Vec<bool> {
        let covered = |at: IVec2| self.index(at).is_some_and(|i| mask[i]);
        self.cells().map(|c| disc.iter().all(|&d| covered(c + d))).collect()
    }

    /// Height of the surface above `at`; zero outside the footprint \[m\].
    pub fn height(&self, at: DVec2) -> f64 {
        self.index(self.place(at)).map_or(0.0, |i| self.heights[i])
    }

    /// The same volume, moved by `by` \[m\] in the table plane.
    pub fn moved(mut self, by: DVec2) -> Self {
        self.origin += by;
        self
    }

    fn place(&self, at: DVec2) -> IVec2 {
        ((at - self.origin) / self.cell).floor().as_ivec2()
    }

    fn index(&self, cell: IVec2) -> Option<usize> {
        let inside = cell.cmpge(IVec2::ZERO).all() && cell.cmplt(self.size).all();
        inside.then(|| (cell.y * self.size.x + cell.x) as usize)
    }
}

/// The cells whose middles are at most `reach` cells from that of the one in the middle.
fn disc(reach: i32) -> Vec<IVec2> {
    let square = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| IVec2::new(x, y)));
    square.filter(|d| d.length_squared() <= reach * reach).collect()
}

impl Shape for Filled {
    fn contains(&self, point: DVec3) -> bool {
        point.z >= 0.0 && point.z < self.height(point.truncate())
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let full = self.heights.iter().enumerate().filter(|(_, h)| **h > 0.0);
        let (low, high, top) = full.fold((IVec2::MAX, IVec2::MIN, 0.0_f64), |(l, h, top), (i, &height)| {
            let cell = IVec2::new(i as i32 % self.size.x, i as i32 / self.size.x);
            (l.min(cell), h.max(cell + 1), top.max(height))
        });
        let corner = |c: IVec2| self.origin + self.cell * c.as_dvec2();
        (corner(low).extend(0.0), corner(high).extend(top))
    }

    fn volume(&self) -> f64 {
        self.heights.iter().sum::<f64>() * self.cell * self.cell
    }
}
