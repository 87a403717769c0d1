//! A solid region as lattice cells cut into tetrahedra: the one way in which all dough is made.
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Five tetrahedra of a cube, for cells of even and of odd parity so that neighbours share their face diagonals; corner `c`
/// of a cube has the bits (x, y, z) = (c & 1, c >> 1 & 1, c >> 2 & 1). All are positively oriented.
const TETRAHEDRA: [[[usize; 4]; TETRAHEDRA_PER_CELL]; 2] = [
    [[0, 3, 6, 5], [1, 3, 0, 5], [2, 6, 0, 3], [4, 5, 0, 6], [7, 3, 5, 6]],
    [[1, 2, 4, 7], [0, 1, 2, 4], [3, 1, 7, 2], [5, 1, 4, 7], [6, 2, 7, 4]],
];

/// How many tetrahedra in a row make a cell.
pub(super) const TETRAHEDRA_PER_CELL: usize = 5;

type Cell = [i32; 3];

/// Corners of lattice cells, and the tetrahedra between them.
pub(super) struct Lattice {
    /// Corner positions \[m\], in a fixed order.
    pub corners: Vec<DVec3>,
    /// Corner indices of each tetrahedron.
    pub tetrahedra: Vec<[u32; 4]>,
}

impl Lattice {
    /// Fills the part of the box `bounds` that `contains` holds with cells of about `spacing` \[m\]: those whose middle is
    /// inside, of them the largest piece connected through faces, its pinched edges filled so that its surface is closed.
    ///
    /// # Errors
    /// When the box is not one, or no cell lies inside.
    pub(super) fn fill(contains: &dyn Fn(DVec3) -> bool, bounds: (DVec3, DVec3), spacing: f64) -> anyhow::Result<Self> {
        let (low, high) = bounds;
        let size = high - low;
        anyhow::ensure!(
            size.is_finite() && size.min_element() > 0.0,
            "the dough's bounding box {low} … {high} is empty"
        );
        let counts = (size / spacing).round().max(DVec3::ONE);
        anyhow::ensure!(
            counts.element_product() <= 1e6,
            "dough of {size} m at a spacing of {spacing} m takes more than a million cells: choose a larger scene.spacing"
        );
        let step = size / counts;
        let inside = all_cells(counts).filter(|c| contains(low + (at(c) + 0.5) * step)).collect();
        let mut cells = largest_piece(inside);
        anyhow::ensure!(
            !cells.is_empty(),
            "no lattice cell of {spacing} m lies inside the dough: choose a smaller scene.spacing or larger dough"
        );
        fill_pinches(&mut cells);
        Ok(Self::cut(&cells, low, step))
    }

    fn cut(cells: &BTreeSet<Cell>, low: DVec3, step: DVec3) -> Self {
        let mut numbers = BTreeMap::new();
        let (mut corners, mut tetrahedra) = (Vec::new(), Vec::new());
        for cell in cells {
            let corner: [u32; 8] = std::array::from_fn(|c| {
                let place = [cell[0] + (c & 1) as i32, cell[1] + (c >> 1 & 1) as i32, cell[2] + (c >> 2 & 1) as i32];
                *numbers.entry(place).or_insert_with(|| {
                    corners.push(low + at(&place) * step);
                    corners.len() as u32 - 1
                })
            });
            let parity = cell.iter().sum::<i32>().rem_euclid(2) as usize;
            tetrahedra.extend(TETRAHEDRA[parity].map(|t| t.map(|c| corner[c])));
        }
        Self { corners, tetrahedra }
    }

    /// Volume belonging to each corner \[m³\]: a quarter of every tetrahedron around it.
    pub(super) fn volumes(&self) -> Vec<f64> {
        let mut volumes = vec![0.0; self.corners.len()];
        for t in &self.tetrahedra {
            let quarter = volume(t.map(|i| self.corners[i as usize])) / 4.0;
            t.iter().for_each(|&i| volumes[i as usize] += quarter);
        }
        volumes
    }
}

/// Signed volume of a tetrahedron.
fn volume([a, b, c, d]: [DVec3; 4]) -> f64 {
    (b - a).cross(c - a).dot(d - a) / 6.0
}

fn at(cell: &Cell) -> DVec3 {
    DVec3::new(cell[0].into(), cell[1].into(), cell[2].into())
}

fn all_cells(counts: DVec3) -> impl Iterator<Item = Cell> {
    let [nx, ny, nz] = counts.to_array().map(|n| n as i32);
    (0..nx).flat_map(move |i| (0..ny).flat_map(move |j| (0..nz).map(move |k| [i, j, k])))
}

fn largest_piece(mut cells: BTreeSet<Cell>) -> BTreeSet<Cell> {
    let mut largest = BTreeSet::new();
    while let Some(first) = cells.pop_first() {
        let mut piece = BTreeSet::from([first]);
        let mut front = VecDeque::from([first]);
        while let Some(cell) = front.pop_front() {
            for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                let mut next = cell;
                next[axis] += step;
                if cells.remove(&next) {
                    piece.insert(next);
                    front.push_back(next);
                }
            }
        }
        if piece.len() > largest.len() {
            largest = piece;
        }
    }
    largest
}

/// Two cells that touch along an edge only would give it four surface triangles, which no collision surface can have.
fn fill_pinches(cells: &mut BTreeSet<Cell>) {
    loop {
        let mut missing = BTreeSet::new();
        for &cell in cells.iter() {
            for (a, b) in [(0, 1), (0, 2), (1, 2)] {
                for side in [-1, 1] {
                    let step = |da: i32, db: i32| {
                        let mut next = cell;
                        (next[a], next[b]) = (cell[a] + da, cell[b] + db);
                        next
                    };
                    let (beside, beyond) = (step(1, 0), step(0, side));
                    if cells.contains(&step(1, side)) && !cells.contains(&beside) && !cells.contains(&beyond) {
                        missing.insert(beside.min(beyond));
                    }
                }
            }
        }
        if missing.is_empty() {
            return;
        }
        cells.extend(missing);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_box_is_filled_to_its_volume_by_positive_tetrahedra() {
        let bounds = (DVec3::new(-0.03, 0.01, 0.0), DVec3::new(0.034, 0.05, 0.025));
        let lattice = Lattice::fill(&|_| true, bounds, 0.01).unwrap();
        let size = bounds.1 - bounds.0;
        assert!((lattice.volumes().iter().sum::<f64>() - size.element_product()).abs() < 1e-15);
        assert!(lattice.tetrahedra.iter().all(|t| volume(t.map(|i| lattice.corners[i as usize])) > 0.0));
        assert_eq!(lattice.corners.len(), 7 * 5 * 4, "2.5 cells round to 3");
    }

    #[test]
    fn ragged_regions_have_one_piece_and_a_closed_surface() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..30 {
            let holes: Vec<bool> = (0..512).map(|_| rng.random::<f64>() < 0.6).collect();
            let contains = |p: DVec3| {
                let cell = p.floor().as_u64vec3();
                holes[(cell.x * 64 + cell.y * 8 + cell.z) as usize]
            };
            let lattice = Lattice::fill(&contains, (DVec3::ZERO, DVec3::splat(8.0)), 1.0).unwrap();
            let mut sides = BTreeMap::new();
            for face in crate::world::dough::faces(&lattice) {
                for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                    *sides.entry((face[a], face[b])).or_insert(0) += 1;
                }
            }
            assert!(sides.iter().all(|((a, b), n)| *n == 1 && sides.get(&(*b, *a)) == Some(&1)));
        }
    }

    #[test]
    fn of_two_pieces_the_larger_stays() {
        let contains = |p: DVec3| !(2.0..3.0).contains(&p.x);
        let lattice = Lattice::fill(&contains, (DVec3::ZERO, DVec3::new(7.0, 2.0, 2.0)), 1.0).unwrap();
        assert!(lattice.corners.iter().all(|c| c.x >= 3.0));
    }
}
