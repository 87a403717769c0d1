//! Dough as a soft body of the engine, and which of its particles models see.
use super::SceneSpec;
use super::lattice::Lattice;
use super::scale::{inward, length};
use glam::DVec3;
use rapier3d::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Thickness of the contact skin around the surface \[m\]; resting particles stand this far above the table.
pub(super) fn skin(spacing: f64) -> f64 {
    spacing / 4.0
}

/// The soft body that fills `lattice`, lifted by `lift` \[m\].
pub(super) fn body(spec: &SceneSpec, lattice: &Lattice, lift: f64) -> SoftBodyBuilder {
    let surface = ColliderBuilder::ball(1.0).density(0.0).friction(spec.material.friction as Real);
    SoftBodyBuilder::new(lattice.corners.iter().map(|p| inward(p + DVec3::Z * lift)).collect())
        .cells(lattice.tetrahedra.clone())
        .edges(edges(lattice))
        .surface(faces(lattice))
        .masses(lattice.volumes().into_iter().map(|v| spec.material.mass(v)).collect())
        .material(spec.material.springs(spec.spacing))
        .cell_model(SoftBodyCellModel::Volume)
        .particle_radius(length(skin(spec.spacing)))
        .additional_pgs_iterations(spec.solver.sweeps - 1)
        .surface_collider(surface)
        .can_sleep(false)
}

/// The `count` points that repeated choice of the one farthest from all chosen before gives, from the first on.
pub(super) fn farthest(points: &[DVec3], count: usize) -> Vec<u32> {
    let mut distances = vec![f64::INFINITY; points.len()];
    let mut chosen = Vec::with_capacity(count);
    let mut next = 0;
    for _ in 0..count {
        chosen.push(next as u32);
        let from = points[next];
        let mut best = -1.0;
        for (i, (point, distance)) in points.iter().zip(&mut distances).enumerate() {
            *distance = distance.min(point.distance_squared(from));
            if *distance > best {
                (best, next) = (*distance, i);
            }
        }
    }
    chosen
}

fn edges(lattice: &Lattice) -> Vec<[u32; 2]> {
    let pairs = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let ordered = |t: &[u32; 4], [a, b]: [usize; 2]| [t[a].min(t[b]), t[a].max(t[b])];
    let unique: BTreeSet<_> = lattice.tetrahedra.iter().flat_map(|t| pairs.map(|p| ordered(t, p))).collect();
    unique.into_iter().collect()
}

/// Faces of one tetrahedron only, seen from outside counter-clockwise.
pub(super) fn faces(lattice: &Lattice) -> Vec<[u32; 3]> {
    let mut single = BTreeMap::new();
    for t in &lattice.tetrahedra {
        for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|f| f.map(|k: usize| t[k])) {
            let mut key = face;
            key.sort_unstable();
            if single.remove(&key).is_none() {
                single.insert(key, face);
            }
        }
    }
    single.into_values().collect()
}
