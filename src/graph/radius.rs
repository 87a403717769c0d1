//! Nodes closer than a radius, found with a cell list in O(N).
use super::{EDGE_KINDS, EdgeSet, Graph, GraphPolicy, Nodes, Window, kinds_named};
use anyhow::ensure;
use glam::{DVec3, IVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Points whose distances are compared at a time.
const LANES: usize = 16;

/// Config of [`Radius`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RadiusSpec {
    /// Radius of the neighbourhood \[m\].
    #[schemars(range(min = 1e-6))]
    pub radius: f64,
    /// Names of the edge kinds to draw.
    pub edges: Vec<String>,
    /// Most edges of a kind into a particle, from the nearest; all within the radius where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub degree: Option<usize>,
}

impl RadiusSpec {
    pub(crate) fn build(self) -> anyhow::Result<Radius> {
        Radius::new(self.radius, &self.edges, self.degree, "radius")
    }
}

/// Joins every particle to the nodes within a radius.
#[derive(Clone, Debug)]
pub struct Radius {
    radius: f64,
    kinds: Vec<usize>,
    degree: Option<usize>,
}

impl Radius {
    /// Draws the named kinds of edges within `radius` \[m\], of those that join what is near the nearest `degree`, in a graph of the
    /// kind `policy`.
    ///
    /// # Errors
    /// When the radius is no length, the degree is zero, a name is no kind's, or a kind of edges needs another kind of graph.
    pub(super) fn new(radius: f64, edges: &[String], degree: Option<usize>, policy: &str) -> anyhow::Result<Self> {
        ensure!(radius > 0.0 && radius.is_finite(), "graph.radius must be a positive length, got {radius}");
        ensure!(degree != Some(0), "graph.degree is 0: leave out the kinds that nothing is to be heard of by");
        let kinds = kinds_named("graph.edges", edges)?;
        for kind in kinds.iter().map(|&kind| EDGE_KINDS[kind]) {
            let needs = kind.needs().unwrap_or(policy);
            ensure!(needs == policy, "graph.edges names {:?}, which needs graph.kind = {needs:?}", kind.name());
        }
        Ok(Self { radius, kinds, degree })
    }
}

impl GraphPolicy for Radius {
    fn connect(&self, nodes: Nodes) -> Graph {
        let near = nodes.near(self.radius);
        let mut edges = vec![EdgeSet { offsets: vec![0; nodes.particles + 1], senders: Vec::new() }; EDGE_KINDS.len()];
        for &kind in &self.kinds {
            let all = EDGE_KINDS[kind].connect(&nodes, &near, self.radius);
            edges[kind] = match self.degree {
                Some(most) if EDGE_KINDS[kind].window() == Window::Fading => all.nearest(&nodes, most),
                _ => all,
            };
        }
        Graph { nodes, edges }
    }

    fn reach(&self) -> f64 {
        self.radius
    }
}

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
