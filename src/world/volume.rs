//! Volume held by pressure.
//!
//! The engine's sweeps leave squeezed dough short of its volume, which then springs back when the tool lets go. After each
//! physics step the particles move by the displacement that is least in the masses' norm and gives every lattice cell its
//! volume back, to first order (fast projection, Goldenthal et al. 2007, eq. 8):
//!
//! ```text
//! min ½ Σ m_i |Δx_i|²  with  V_c + ∇V_c · Δx = V⁰_c   ⇒   (J W Jᵀ) p = V⁰ − V,   Δx = W Jᵀ p,   J = ∂V/∂x,   W = M⁻¹
//! ```
//!
//! Particles in contact slide along what they touch: W leaves out the normals. Their friction is the engine's.
use glam::{DMat3, DVec3};
use rapier3d::prelude::{SoftBody, SoftBodyCell};

/// Share of a cell's volume that is left to the engine: within it, resting dough is not moved and does not creep.
const TOLERANCE: f64 = 0.01;
/// Relative residual at which the pressures are found.
const RESIDUAL: f64 = 1e-3;
/// Greatest number of conjugate gradient rounds.
const ROUNDS: usize = 60;
/// Longest move, in radii of a particle: a longer one could carry it through a tool.
const LONGEST: f64 = 3.0;
/// What is added to the diagonal, as a share of its mean: cells between two tools may have no other.
const SHIFT: f64 = 1e-3;

/// Moves the particles of `body` so that its lattice cells have their volumes: `owners` says to which cell each tetrahedron belongs,
/// and `touched` finds the normals of the surfaces that each particle touches.
pub(super) fn hold(body: &mut SoftBody, owners: &[u32], touched: impl Fn(&SoftBody) -> Vec<Vec<DVec3>>) -> Held {
    let positions: Vec<DVec3> = body.particle_positions().map(|p| p.as_dvec3()).collect();
    let cells = cells(body, owners, &positions);
    if cells.iter().all(|cell| cell.missing == 0.0) {
        return Held::Already;
    }
    let normals = touched(body);
    let slide = |normals: &Vec<DVec3>| normals.iter().fold(DMat3::IDENTITY, |way, normal| project_out(way, *normal));
    let weights = body.particles().iter().map(|p| f64::from(p.inv_mass()));
    let mobility: Vec<DMat3> = normals.iter().zip(weights).map(|(normals, weight)| weight * slide(normals)).collect();
    let pull = pulls(&cells, &pressures(&cells, &mobility), positions.len());
    let moves: Vec<DVec3> = mobility.iter().zip(&pull).map(|(way, pull)| *way * *pull).collect();
    let longest = moves.iter().map(|step| step.length()).fold(0.0, f64::max);
    let share = (LONGEST * f64::from(body.particle_radius()) / longest).min(1.0);
    for (i, (from, step)) in positions.iter().zip(&moves).enumerate() {
        if *step != DVec3::ZERO {
            body.set_particle_position(i, (*from + share * *step).as_vec3());
        }
    }
    Held::Anew
}

/// Whether particles had to be moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Held {
    /// Every cell had its volume.
    Already,
    /// Some had not.
    Anew,
}

/// The tetrahedra of a lattice cell come in a row; of one that a blade went through each piece has some.
fn cells(body: &SoftBody, owners: &[u32], positions: &[DVec3]) -> Vec<Cell> {
    let mut rest = body.cells();
    let take = |run: &[u32]| {
        let (tetrahedra, after) = rest.split_at(run.len());
        rest = after;
        Cell::of(tetrahedra, positions)
    };
    owners.chunk_by(|a, b| a == b).map(take).collect()
}

/// A lattice cell: what volume it lacks beyond the tolerance, and how its volume grows with each of its particles.
struct Cell {
    missing: f64,
    gradient: Vec<(usize, DVec3)>,
}

impl Cell {
    fn of(tetrahedra: &[SoftBodyCell], x: &[DVec3]) -> Self {
        let (mut volume, mut rest) = (0.0, 0.0);
        let mut gradient: Vec<(usize, DVec3)> = Vec::with_capacity(8);
        for t in tetrahedra {
            let corner = t.vertices.map(|i| i as usize);
            let [a, b, c] = [1, 2, 3].map(|k| x[corner[k]] - x[corner[0]]);
            let sides = [b.cross(c) / 6.0, c.cross(a) / 6.0, a.cross(b) / 6.0];
            volume += a.dot(sides[0]);
            rest += f64::from(t.rest_volume);
            for (i, side) in corner.into_iter().zip([-sides.iter().sum::<DVec3>(), sides[0], sides[1], sides[2]]) {
                match gradient.iter_mut().find(|(j, _)| *j == i) {
                    Some((_, sum)) => *sum += side,
                    None => gradient.push((i, side)),
                }
            }
        }
        let lack = rest - volume;
        Self { missing: lack.signum() * (lack.abs() - TOLERANCE * rest).max(0.0), gradient }
    }
}

/// f = Jᵀ p.
fn pulls(cells: &[Cell], pressures: &[f64], count: usize) -> Vec<DVec3> {
    let mut pulls = vec![DVec3::ZERO; count];
    for (cell, pressure) in cells.iter().zip(pressures) {
        cell.gradient.iter().for_each(|(i, side)| pulls[*i] += *pressure * *side);
    }
    pulls
}

/// The pressures p of (J W Jᵀ + ε) p = V⁰ − V by conjugate gradients.
fn pressures(cells: &[Cell], mobility: &[DMat3]) -> Vec<f64> {
    let diagonal = |cell: &Cell| cell.gradient.iter().map(|(i, side)| side.dot(mobility[*i] * *side)).sum::<f64>();
    let shift = SHIFT * cells.iter().map(diagonal).sum::<f64>() / cells.len() as f64 + f64::MIN_POSITIVE;
    let apply = |p: &[f64]| -> Vec<f64> {
        let moves: Vec<DVec3> = pulls(cells, p, mobility.len()).iter().zip(mobility).map(|(f, w)| *w * *f).collect();
        let grow = |cell: &Cell| cell.gradient.iter().map(|(i, side)| side.dot(moves[*i])).sum::<f64>();
        cells.iter().zip(p).map(|(cell, p)| grow(cell) + shift * p).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut residual: Vec<f64> = cells.iter().map(|cell| cell.missing).collect();
    let (mut p, mut way) = (vec![0.0; cells.len()], residual.clone());
    let (goal, mut size) = (RESIDUAL * RESIDUAL * dot(&residual, &residual), dot(&residual, &residual));
    for _ in 0..ROUNDS {
        if size <= goal {
            break;
        }
        let image = apply(&way);
        let step = size / dot(&way, &image);
        p.iter_mut().zip(&way).for_each(|(p, w)| *p += step * w);
        residual.iter_mut().zip(&image).for_each(|(r, a)| *r -= step * a);
        let next = dot(&residual, &residual);
        way.iter_mut().zip(&residual).for_each(|(w, r)| *w = r + next / size * *w);
        size = next;
    }
    p
}

/// The symmetric projection `way` without the direction `normal`.
fn project_out(way: DMat3, normal: DVec3) -> DMat3 {
    let across = way * normal;
    let length = across.length_squared();
    if length < 1e-6 {
        return way;
    }
    way - DMat3::from_cols(across * across.x, across * across.y, across * across.z) * (1.0 / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::lattice::{Lattice, TETRAHEDRA_PER_CELL};
    use rapier3d::prelude::{PhysicsWorld, SoftBodyBuilder, SoftBodyCellModel, SoftBodyHandle};

    /// A block of 4 × 3 × 3 unit cells, its particles moved by `bend`.
    fn block(bend: impl Fn(DVec3) -> DVec3) -> (PhysicsWorld, SoftBodyHandle) {
        let lattice = Lattice::fill(&|_| true, (DVec3::ZERO, DVec3::new(4.0, 3.0, 3.0)), 1.0).unwrap();
        let masses = lattice.volumes().iter().map(|v| *v as f32).collect();
        let body = SoftBodyBuilder::new(lattice.corners.iter().map(|p| p.as_vec3()).collect())
            .cells(lattice.tetrahedra.clone())
            .surface(crate::world::dough::faces(&lattice))
            .masses(masses)
            .cell_model(SoftBodyCellModel::Volume)
            .particle_radius(0.25);
        let mut physics = PhysicsWorld::new();
        let handle = physics.insert_soft_body(body);
        let body = &mut physics.soft_bodies[handle];
        for (i, p) in lattice.corners.iter().enumerate() {
            body.set_particle_position(i, bend(*p).as_vec3());
        }
        (physics, handle)
    }

    fn owners(body: &SoftBody) -> Vec<u32> {
        (0..body.cells().len()).map(|t| (t / TETRAHEDRA_PER_CELL) as u32).collect()
    }

    fn places(body: &SoftBody) -> Vec<DVec3> {
        body.particle_positions().map(|p| p.as_dvec3()).collect()
    }

    fn squeeze(p: DVec3) -> DVec3 {
        DVec3::new(p.x + 0.1 * p.z * p.y, p.y, p.z * (0.9 - 0.02 * p.x))
    }

    #[test]
    fn squeezed_cells_get_their_volume_back_and_nothing_is_pushed_or_turned_as_a_whole() {
        let (mut physics, handle) = block(squeeze);
        let body = &mut physics.soft_bodies[handle];
        let before = places(body);
        for _ in 0..3 {
            let none = |body: &SoftBody| vec![Vec::new(); body.num_particles()];
            hold(body, &owners(body), none);
        }
        let after = places(body);
        for cell in body.cells().chunks(TETRAHEDRA_PER_CELL) {
            let rest: f64 = cell.iter().map(|t| f64::from(t.rest_volume)).sum();
            let lack = Cell::of(cell, &after).missing;
            assert!(lack.abs() < 2e-3 * rest, "a cell lacks {lack} of {rest}");
        }
        let (mut push, mut turn, mut motion) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for ((x, y), particle) in before.iter().zip(&after).zip(body.particles()) {
            let shove = f64::from(particle.mass()) * (*y - *x);
            push += shove;
            turn += x.cross(shove);
            motion += shove.length();
        }
        assert!(motion > 1.0 && push.length() < 1e-4 * motion, "pushed by {push} of {motion}");
        // Each of the three moves turns nothing about its own start; the later ones start a little elsewhere.
        assert!(turn.length() < 0.02 * motion, "turned by {turn} of {motion}");
    }

    #[test]
    fn on_a_surface_particles_slide_and_never_enter_it() {
        let (mut physics, handle) = block(squeeze);
        let body = &mut physics.soft_bodies[handle];
        let before = places(body);
        let on_floor = |p: &DVec3| p.z == 0.0;
        let touched = |body: &SoftBody| {
            places(body).iter().map(|p| on_floor(p).then_some(DVec3::Z).into_iter().collect()).collect()
        };
        hold(body, &owners(body), touched);
        let moves = before.iter().zip(places(body)).filter(|(p, _)| on_floor(p)).map(|(p, q)| q - *p);
        let moves: Vec<DVec3> = moves.collect();
        assert!(moves.iter().all(|d| d.z.abs() < 1e-6), "moved off the floor: {moves:?}");
        let slid = moves.iter().filter(|d| d.length() > 1e-3).count();
        assert!(slid > 10, "of {} on the floor {slid} slide", moves.len());
    }

    #[test]
    fn a_rested_body_is_left_alone() {
        let (mut physics, handle) = block(|p| p * 1.002);
        let body = &mut physics.soft_bodies[handle];
        let before = places(body);
        let none = |body: &SoftBody| vec![Vec::new(); body.num_particles()];
        hold(body, &owners(body), none);
        assert_eq!(before, places(body));
    }

    #[test]
    fn a_projection_takes_out_two_normals_one_after_the_other() {
        let (a, b) = (DVec3::Z, DVec3::new(0.6, 0.0, 0.8));
        let way = project_out(project_out(DMat3::IDENTITY, a), b);
        for normal in [a, b] {
            assert!((way * normal).length() < 1e-12);
        }
        assert!((way * DVec3::Y - DVec3::Y).length() < 1e-12);
        assert_eq!(project_out(way, a), way);
    }
}
