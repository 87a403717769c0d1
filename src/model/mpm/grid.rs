//! The grid that particles meet on: a box of nodes around them, laid anew in every substep.
use super::real::{Quad, Real, Vector};
use super::spline::Stencil;
use glam::DVec3;

/// Most nodes of a grid. Particles farther apart than that have been blown apart.
const NODES: f64 = 2_097_152.0;

/// What a particle says around itself: `a + Σ_b B_b d_b` at an offset d \[m\], its first three coordinates a vector, the fourth a
/// mass.
#[derive(Clone, Copy)]
pub(super) struct Affine<R: Real> {
    /// a.
    pub(super) value: R::Quad,
    /// B, by columns.
    pub(super) slopes: [R::Quad; 3],
}

/// A box: index of its first node, and numbers of nodes.
pub(super) type Span = ([i64; 3], [usize; 3]);

/// A box of nodes, `cell` \[m\] apart; a node is a vector and a mass, or their derivatives.
pub(super) struct Grid<R: Real> {
    pub(super) cell: f64,
    low: [i64; 3],
    size: [usize; 3],
    pub(super) nodes: Vec<R::Quad>,
}

impl<R: Real> Grid<R> {
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
        self.nodes.resize(self.size.iter().product(), R::Quad::ZERO);
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
    pub(super) fn stencil(&self, position: DVec3) -> Stencil<R> {
        Stencil::new(position, self.cell)
    }

    /// Number of the first node of a stencil.
    #[inline]
    fn first(&self, stencil: &Stencil<R>) -> usize {
        let [i, j, k] = std::array::from_fn(|axis| (stencil.base[axis] as i64 - self.low[axis]) as usize);
        (i * self.size[1] + j) * self.size[2] + k
    }

    /// The nine rows of three nodes of a stencil: (first node, offset i, offset j).
    #[inline]
    fn rows(&self, stencil: &Stencil<R>) -> impl Iterator<Item = (usize, usize, usize)> + use<R> {
        let (first, stride) = (self.first(stencil), [self.size[1] * self.size[2], self.size[2]]);
        (0..9).map(move |n| (first + n / 3 * stride[0] + n % 3 * stride[1], n / 3, n % 3))
    }

    /// Adds `wᵢ (a + B dᵢ)` to every node i of a stencil.
    #[inline]
    pub(super) fn scatter(&mut self, stencil: &Stencil<R>, affine: &Affine<R>) {
        let Stencil { weights: [wx, wy, wz], offsets: [dx, dy, dz], .. } = stencil;
        for (row, i, j) in self.rows(stencil) {
            let nodes = &mut self.nodes[row..row + 3];
            let share = wx[i] * wy[j];
            let here = times(affine.slopes[1], dy[j], times(affine.slopes[0], dx[i], affine.value));
            for k in 0..3 {
                nodes[k] = times(times(affine.slopes[2], dz[k], here), share * wz[k], nodes[k]);
            }
        }
    }

    /// `Σᵢ wᵢ nᵢ` and `Σᵢ wᵢ nᵢ dᵢᵀ` over the nodes n of a stencil.
    #[inline]
    pub(super) fn gather(&self, stencil: &Stencil<R>) -> Affine<R> {
        let Stencil { weights: [wx, wy, wz], offsets: [dx, dy, dz], .. } = stencil;
        let (mut value, mut slopes) = (R::Quad::ZERO, [R::Quad::ZERO; 3]);
        for (row, i, j) in self.rows(stencil) {
            let nodes = &self.nodes[row..row + 3];
            let share = wx[i] * wy[j];
            let [a, b, c] = std::array::from_fn(|k| nodes[k] * R::Quad::splat(wz[k]));
            let sum = (a + b + c) * R::Quad::splat(share);
            value += sum;
            slopes[0] = times(sum, dx[i], slopes[0]);
            slopes[1] = times(sum, dy[j], slopes[1]);
            let rise = times(c, dz[2], times(b, dz[1], a * R::Quad::splat(dz[0])));
            slopes[2] = times(rise, share, slopes[2]);
        }
        Affine { value, slopes }
    }

    /// `∂/∂x Σᵢ wᵢ nᵢ · (a + B dᵢ)`, x being the place of the stencil, with `sum` = `Σᵢ wᵢ nᵢ`.
    #[inline]
    pub(super) fn slope(&self, stencil: &Stencil<R>, affine: &Affine<R>, sum: R::Quad) -> R::Vector {
        let Stencil { weights: [wx, wy, wz], slopes: [sx, sy, sz], offsets: [dx, dy, dz], .. } = stencil;
        let [mut x, mut y, mut z] = [R::Quad::ZERO; 3];
        for (row, i, j) in self.rows(stencil) {
            let nodes = &self.nodes[row..row + 3];
            let here = times(affine.slopes[1], dy[j], times(affine.slopes[0], dx[i], affine.value));
            // Coordinate by coordinate; the dot product's sum comes last.
            let [a, b, c] = std::array::from_fn(|k| nodes[k] * times(affine.slopes[2], dz[k], here));
            let along = times(c, wz[2], times(b, wz[1], a * R::Quad::splat(wz[0])));
            let across = times(c, sz[2], times(b, sz[1], a * R::Quad::splat(sz[0])));
            x = times(along, sx[i] * wy[j], x);
            y = times(along, wx[i] * sy[j], y);
            z = times(across, wx[i] * wy[j], z);
        }
        let slope = R::Vector::new([x, y, z].map(R::Quad::reduce_add));
        // Offsets shrink as the particle moves.
        slope - R::Vector::new(affine.slopes.map(|column| (column * sum).reduce_add()))
    }
}

/// Place of a node by its number \[m\].
#[inline]
pub(super) fn place((low, size): &Span, cell: f64, number: usize) -> DVec3 {
    // Half the width divides several times as fast; a grid has no more nodes than that.
    let [_, height, depth] = size.map(|n| n as u32);
    let (row, k) = (number as u32 / depth, number as u32 % depth);
    let index = [row / height, row % height, k];
    cell * DVec3::from_array(std::array::from_fn(|axis| (low[axis] + i64::from(index[axis])) as f64))
}

/// `v s + w`.
#[inline]
fn times<R: Real, Q: Quad<R>>(v: Q, s: R, w: Q) -> Q {
    v.mul_add(Q::splat(s), w)
}

/// A vector with a fourth coordinate.
#[inline]
pub(super) fn extend<R: Real>(v: R::Vector, fourth: R) -> R::Quad {
    let [x, y, z] = v.to_array();
    R::Quad::new([x, y, z, fourth])
}

/// The first three coordinates, and the fourth.
#[inline]
pub(super) fn split<R: Real>(v: R::Quad) -> (R::Vector, R) {
    let [x, y, z, fourth] = v.to_array();
    (R::Vector::new([x, y, z]), fourth)
}
