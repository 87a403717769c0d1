//! Points within a radius, found with a cell list in O(N).
use super::EdgeSet;
use glam::{DVec3, IVec3};
use std::ops::Range;

/// Points whose distances are compared at a time.
const LANES: usize = 16;

/// Points binned into cubic cells as wide as the search radius; a search visits 27 cells.
#[derive(Clone, Debug)]
pub struct CellList {
    origin: DVec3,
    inverse: f64,
    size: IVec3,
    starts: Vec<u32>,
    /// Cell after cell; the coordinates of the same points follow, one axis after the other.
    members: Vec<u32>,
    axes: [Vec<f64>; 3],
}

impl CellList {
    /// Bins `points` into cells of width `radius` \[m\], widened where the cloud is so sparse that cells would outnumber it.
    pub fn new(points: &[DVec3], radius: f64) -> Self {
        let (low, high) =
            points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let (low, high) =
            if points.is_empty() || !(high - low).is_finite() { (DVec3::ZERO, DVec3::ZERO) } else { (low, high) };
        let limit = 8.0 * points.len() as f64 + 64.0;
        let mut width = radius;
        while ((high - low) / width + 1.0).element_product() > limit {
            width *= 1.5;
        }
        let size = ((high - low) / width).floor().as_ivec3() + 1;
        let mut cells = Self {
            origin: low,
            inverse: width.recip(),
            size,
            starts: vec![0; size.element_product() as usize + 1],
            members: vec![0; points.len()],
            axes: Default::default(),
        };
        let of: Vec<usize> = points.iter().map(|p| cells.index(cells.coordinate(*p))).collect();
        for &c in &of {
            cells.starts[c + 1] += 1;
        }
        for c in 1..cells.starts.len() {
            cells.starts[c] += cells.starts[c - 1];
        }
        let mut next = cells.starts.clone();
        for (point, &c) in of.iter().enumerate() {
            cells.members[next[c] as usize] = point as u32;
            next[c] += 1;
        }
        cells.axes = [0, 1, 2].map(|axis| cells.members.iter().map(|&point| points[point as usize][axis]).collect());
        cells
    }

    /// Makes `near` the binned points strictly within `radius` of `at`, in their order.
    fn within(&self, at: DVec3, radius: f64, near: &mut Vec<u32>) {
        near.clear();
        let centre = self.coordinate(at);
        let (low, high) = ((centre - 1).max(IVec3::ZERO), (centre + 1).min(self.size - 1));
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                let (a, b) = (self.index(IVec3::new(low.x, y, z)), self.index(IVec3::new(high.x, y, z)));
                self.admit(self.starts[a] as usize..self.starts[b + 1] as usize, at, radius * radius, near);
            }
        }
        near.sort_unstable();
    }

    /// Appends the members of a row of cells that are near enough: which ones nobody can foresee, so nothing branches on it.
    fn admit(&self, row: Range<usize>, at: DVec3, square: f64, near: &mut Vec<u32>) {
        let [x, y, z] = self.axes.each_ref().map(|axis| &axis[row.clone()]);
        let members = &self.members[row];
        let mut count = near.len();
        near.resize(count + members.len(), 0);
        let (mut inside, mut first) = ([false; LANES], 0);
        while first < members.len() {
            let chunk = first..members.len().min(first + LANES);
            let points = x[chunk.clone()].iter().zip(&y[chunk.clone()]).zip(&z[chunk.clone()]);
            for (inside, ((x, y), z)) in inside.iter_mut().zip(points) {
                *inside = (x - at.x).powi(2) + (y - at.y).powi(2) + (z - at.z).powi(2) < square;
            }
            for (member, inside) in members[chunk].iter().zip(inside) {
                near[count] = *member;
                count += usize::from(inside);
            }
            first += LANES;
        }
        near.truncate(count);
    }

    /// Edges into each of `receivers` from all binned points strictly within `radius` \[m\], itself too where it is binned; the
    /// radius is no more than that of the cells.
    pub fn neighbours(&self, receivers: &[DVec3], radius: f64) -> EdgeSet {
        let mut set = EdgeSet { offsets: vec![0], senders: Vec::new() };
        let mut near = Vec::new();
        for at in receivers {
            self.within(*at, radius, &mut near);
            set.senders.extend_from_slice(&near);
            set.offsets.push(set.senders.len() as u32);
        }
        set
    }

    fn coordinate(&self, point: DVec3) -> IVec3 {
        ((point - self.origin) * self.inverse).floor().as_ivec3().clamp(IVec3::ZERO, self.size - 1)
    }

    fn index(&self, cell: IVec3) -> usize {
        ((cell.z * self.size.y + cell.y) * self.size.x + cell.x) as usize
    }
}
