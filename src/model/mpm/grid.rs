//! The grid that particles meet on: a box of nodes around them, laid anew in every substep.
use super::spline::Stencil;
use glam::{DVec3, DVec4};

/// Most nodes of a grid. Particles farther apart than that have been blown apart.
const NODES: f64 = 2_097_152.0;

/// What a particle says around itself: `a + Σ_b B_b d_b` at an offset d \[m\], its first three coordinates a vector, the fourth a mass.
#[derive(Clone, Copy)]
pub(super) struct Affine {
    /// a.
    pub(super) value: DVec4,
    /// B, by columns.
    pub(super) slopes: [DVec4; 3],
}

/// A box: index of its first node, and numbers of nodes.
pub(super) type Span = ([i64; 3], [usize; 3]);

/// A box of nodes, `cell` \[m\] apart; a node is a vector and a mass, or their derivatives.
pub(super) struct Grid {
    pub(super) cell: f64,
    low: [i64; 3],
    size: [usize; 3],
    pub(super) nodes: Vec<DVec4>,
}

impl Grid {
    pub(super) fn new(cell: f64) -> Self {
        Self { cell, low: [0; 3], size: [0; 3], nodes: Vec::new() }
    }

    /// Lays zeros wherever the stencil of one of `positions` reaches; says no where these are not finite or too far apart.
    pub(super) fn cover(&mut self, positions: &[DVec3]) -> bool {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut finite = true;
        for x in positions {
            finite &= x.is_finite();
            (low, high) = (low.min(*x), high.max(*x));
        }
        if positions.is_empty() {
            (low, high) = (DVec3::ZERO, DVec3::ZERO);
        }
        let [first, last] = [low, high].map(|x| (x / self.cell - 0.5).floor());
        let size = last - first + 3.0;
        if !finite || size.element_product() > NODES || first.abs().max_element() > 1e15 {
            return false;
        }
        self.low = first.to_array().map(|n| n as i64);
        self.size = size.to_array().map(|n| n as usize);
        self.clear();
        true
    }

    /// Zero everywhere.
    pub(super) fn clear(&mut self) {
        self.nodes.clear();
        self.nodes.resize(self.size.iter().product(), DVec4::ZERO);
    }

    /// Place of a node by its number \[m\].
    #[inline]
    pub(super) fn place((low, size): &Span, cell: f64, number: usize) -> DVec3 {
        let (row, k) = (number / size[2], number % size[2]);
        let index = [row / size[1], row % size[1], k];
        cell * DVec3::from_array(std::array::from_fn(|axis| (low[axis] + index[axis] as i64) as f64))
    }

    /// Where the box lies.
    pub(super) fn span(&self) -> Span {
        (self.low, self.size)
    }

    /// Lays zeros over a box that was there before.
    pub(super) fn restore(&mut self, (low, size): Span) {
        (self.low, self.size) = (low, size);
        self.clear();
    }

    /// The nodes around `position`, which the grid covers.
    #[inline]
    pub(super) fn stencil(&self, position: DVec3) -> Stencil {
        Stencil::new(position, self.cell)
    }

    /// Number of the first node of a stencil.
    #[inline]
    fn first(&self, stencil: &Stencil) -> usize {
        let [i, j, k] = std::array::from_fn(|axis| (stencil.base[axis] as i64 - self.low[axis]) as usize);
        (i * self.size[1] + j) * self.size[2] + k
    }

    /// The nine rows of three nodes of a stencil: (first node, offset i, offset j).
    #[inline]
    fn rows(&self, stencil: &Stencil) -> impl Iterator<Item = (usize, usize, usize)> + use<> {
        let (first, stride) = (self.first(stencil), [self.size[1] * self.size[2], self.size[2]]);
        (0..9).map(move |n| (first + n / 3 * stride[0] + n % 3 * stride[1], n / 3, n % 3))
    }

    /// Adds `wᵢ (a + B dᵢ)` to every node i of a stencil.
    #[inline]
    pub(super) fn scatter(&mut self, stencil: &Stencil, affine: &Affine) {
        let Stencil { weights: [wx, wy, wz], offsets: [dx, dy, dz], .. } = stencil;
        for (row, i, j) in self.rows(stencil) {
            let nodes = &mut self.nodes[row..row + 3];
            let share = wx[i] * wy[j];
            let value = share * (affine.value + affine.slopes[0] * dx[i] + affine.slopes[1] * dy[j]);
            let slope = share * affine.slopes[2];
            for k in 0..3 {
                nodes[k] += wz[k] * (value + slope * dz[k]);
            }
        }
    }

    /// `Σᵢ wᵢ nᵢ` and `Σᵢ wᵢ nᵢ dᵢᵀ` over the nodes n of a stencil.
    #[inline]
    pub(super) fn gather(&self, stencil: &Stencil) -> Affine {
        let Stencil { weights: [wx, wy, wz], offsets: [dx, dy, dz], .. } = stencil;
        let (mut value, mut slopes) = (DVec4::ZERO, [DVec4::ZERO; 3]);
        for (row, i, j) in self.rows(stencil) {
            let nodes = &self.nodes[row..row + 3];
            let share = wx[i] * wy[j];
            let [a, b, c] = std::array::from_fn(|k| nodes[k] * (share * wz[k]));
            let sum = a + b + c;
            value += sum;
            slopes[0] += sum * dx[i];
            slopes[1] += sum * dy[j];
            slopes[2] += a * dz[0] + b * dz[1] + c * dz[2];
        }
        Affine { value, slopes }
    }

    /// `∂/∂x Σᵢ wᵢ nᵢ · (a + B dᵢ)`, x being the place of the stencil.
    #[inline]
    pub(super) fn slope(&self, stencil: &Stencil, affine: &Affine) -> DVec3 {
        let Stencil { weights: [wx, wy, wz], slopes: [sx, sy, sz], offsets: [dx, dy, dz], .. } = stencil;
        let mut slope = DVec3::ZERO;
        let mut sum = DVec4::ZERO;
        for (row, i, j) in self.rows(stencil) {
            let nodes = &self.nodes[row..row + 3];
            let share = affine.value + affine.slopes[0] * dx[i] + affine.slopes[1] * dy[j];
            let work: [f64; 3] = std::array::from_fn(|k| nodes[k].dot(share + affine.slopes[2] * dz[k]));
            let along = wz[0] * work[0] + wz[1] * work[1] + wz[2] * work[2];
            let across = sz[0] * work[0] + sz[1] * work[1] + sz[2] * work[2];
            slope += DVec3::new(sx[i] * wy[j] * along, wx[i] * sy[j] * along, wx[i] * wy[j] * across);
            sum += (nodes[0] * wz[0] + nodes[1] * wz[1] + nodes[2] * wz[2]) * (wx[i] * wy[j]);
        }
        // Offsets shrink as the particle moves.
        slope - DVec3::from_array(affine.slopes.map(|column| column.dot(sum)))
    }
}
