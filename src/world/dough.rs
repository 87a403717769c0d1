//! Dough as a soft body of the engine.
use super::contact::contacts;
use super::cut;
use super::lattice::{Lattice, TETRAHEDRA_PER_CELL};
use super::material::{Filling, Material, Matter, Substance, check};
use super::scale::{inward, length, outward};
use super::volume::{self, Held};
use super::{DoughSpec, SceneSpec};
use crate::state::{Blade, Pose};
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Soft bodies: one, until a blade parts it.
#[derive(Clone, Serialize, Deserialize)]
pub struct Dough {
    pub(super) lumps: Vec<Lump>,
    /// Where each particle of the whole is now: the number of its lump, and its own in it.
    pub(super) places: Vec<(u32, u32)>,
}

/// A connected piece of the dough.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Lump {
    pub(super) body: SoftBodyHandle,
    /// The lattice cell that each of its tetrahedra belongs to.
    pub(super) cells: Vec<u32>,
    /// Where its particles were when the blade in hand was taken \[m\]; empty when none is.
    pub(super) uncut: Vec<DVec3>,
}

/// Greatest number of times that the cells get their volume back in a physics step: where the tool crushes, once is too little.
const ROUNDS: usize = 4;

/// Greatest speed of a particle of dough along the table \[m/s\], seven times that of the tools.
const FASTEST: f64 = 1.5;

/// Thickness of the contact skin around the surface \[m\]; resting particles stand this far above the table.
fn skin(spacing: f64) -> f64 {
    spacing / 4.0
}

impl DoughSpec {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn build(self) -> anyhow::Result<impl Material> {
        let ranges = [
            ("density", self.density, 1.0, 2e4),
            ("young_modulus", self.young_modulus, 100.0, 1e7),
            ("poisson_ratio", self.poisson_ratio, 0.0, 0.4999),
            ("damping_ratio", self.damping_ratio, 0.0, 100.0),
            ("yield_strain", self.yield_strain, 0.0, 1.0),
            ("creep_rate", self.creep_rate, 0.0, 1e6),
            ("largest_set", self.largest_set, 0.0, 0.95),
            ("friction", self.friction, 0.0, 10.0),
        ];
        check(&ranges)?;
        Ok(self)
    }
}

impl Material for DoughSpec {
    fn fill(
        &self,
        scene: &SceneSpec,
        filling: &Filling<'_>,
        physics: &mut PhysicsWorld,
        _: &mut ChaCha8Rng,
    ) -> anyhow::Result<Matter> {
        let lattice = filling.lattice(scene.spacing, skin(scene.spacing))?;
        let body = physics.insert_soft_body(self.body(scene, &lattice));
        let cells = (0..lattice.tetrahedra.len()).map(|t| (t / TETRAHEDRA_PER_CELL) as u32).collect();
        let places = (0..lattice.corners.len() as u32).map(|corner| (0, corner)).collect();
        Ok(Matter::Dough(Dough { lumps: vec![Lump { body, cells, uncut: Vec::new() }], places }))
    }

    fn friction(&self) -> f64 {
        self.friction
    }

    /// The detection of crossings serves soft bodies that meet themselves or each other, which this one never does; and sweeps
    /// spent on it would be better spent on the dough's volume, as are those of the engine's stabilisation pass.
    fn tune(&self, _: &SceneSpec, parameters: &mut IntegrationParameters) {
        parameters.num_internal_pgs_iterations = 1;
        parameters.num_internal_stabilization_iterations = 0;
        let soft = &mut parameters.soft_bodies;
        soft.max_extra_substeps = 0;
        soft.recovery.inverted_cell_detection = false;
        soft.recovery.self_crossing_detection = false;
        soft.recovery.cross_body_detection = false;
        soft.recovery.overlap_constraints = false;
    }

    fn settling(&self) -> f64 {
        0.5
    }
}

impl DoughSpec {
    /// The soft body that fills `lattice`.
    fn body(&self, scene: &SceneSpec, lattice: &Lattice) -> SoftBodyBuilder {
        let surface = ColliderBuilder::ball(1.0).density(0.0).friction(self.friction as Real);
        SoftBodyBuilder::new(lattice.corners.iter().map(|p| inward(*p)).collect())
            .cells(lattice.tetrahedra.clone())
            .edges(edges(lattice))
            .surface(faces(lattice))
            .masses(lattice.volumes().into_iter().map(|v| self.mass(v)).collect())
            .material(self.springs(scene.spacing))
            .cell_model(SoftBodyCellModel::Volume)
            .particle_radius(length(skin(scene.spacing)))
            .additional_pgs_iterations(scene.solver.sweeps - 1)
            .surface_collider(surface)
            .can_sleep(false)
    }
}

impl Dough {
    fn each<'a>(&'a self, physics: &'a PhysicsWorld) -> impl Iterator<Item = &'a SoftBody> {
        self.lumps.iter().map(|lump| &physics.soft_bodies[lump.body])
    }
}

impl Substance for Dough {
    fn positions(&self, physics: &PhysicsWorld) -> Vec<DVec3> {
        let lumps: Vec<&SoftBody> = self.each(physics).collect();
        self.places.iter().map(|&(lump, i)| outward(lumps[lump as usize].particle_position(i as usize))).collect()
    }

    fn bodies(&self) -> Vec<usize> {
        self.places.iter().map(|&(lump, _)| lump as usize).collect()
    }

    fn surface(&self, physics: &PhysicsWorld) -> Vec<DVec3> {
        let corners = |body: &SoftBody| {
            let corners: BTreeSet<u32> = body.boundary().iter().flatten().copied().collect();
            corners.into_iter().map(|i| outward(body.particle_position(i as usize))).collect::<Vec<_>>()
        };
        self.each(physics).flat_map(corners).collect()
    }

    fn volume(&self, physics: &PhysicsWorld) -> f64 {
        let volume = |body: &SoftBody| -> f64 {
            let corner = |i: u32| outward(body.particle_position(i as usize));
            let under = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0;
            body.boundary().iter().map(under).sum()
        };
        self.each(physics).map(volume).sum()
    }

    fn kick(&mut self, velocity: &dyn Fn(DVec3) -> DVec3, physics: &mut PhysicsWorld) {
        for lump in &self.lumps {
            let body = &mut physics.soft_bodies[lump.body];
            for i in 0..body.num_particles() {
                let more = inward(velocity(outward(body.particle_position(i))));
                body.set_particle_velocity(i, body.particle_velocity(i) + more);
            }
        }
    }

    fn shift(&mut self, by: &dyn Fn(DVec3) -> DVec3, physics: &mut PhysicsWorld) {
        for lump in &self.lumps {
            let body = &mut physics.soft_bodies[lump.body];
            for i in 0..body.num_particles() {
                let position = body.particle_position(i);
                body.set_particle_position(i, position + inward(by(outward(position))));
            }
        }
    }

    fn face(&mut self, physics: &PhysicsWorld, cuts: bool) {
        for lump in &mut self.lumps {
            let body = &physics.soft_bodies[lump.body];
            lump.uncut = if cuts { body.particle_positions().map(outward).collect() } else { Vec::new() };
        }
    }

    fn cut(&mut self, physics: &mut PhysicsWorld, blade: &Blade, pose: &Pose) {
        cut::part(self, physics, blade, pose);
    }

    /// Gives the cells their volume back; and contacts give way a little, so that dough pinched between a tool and the table
    /// could be pushed through it: a particle below the table is put back onto it. Dough also sticks to what pinches it, which the
    /// engine's does not, so that a crumb under a cutter would leave like a squeezed pip: along the table none is faster than
    /// [`FASTEST`].
    fn mend(&mut self, physics: &mut PhysicsWorld, hand: &[RigidBodyHandle]) {
        for lump in &self.lumps {
            let body = &mut physics.soft_bodies[lump.body];
            let touched = |body: &SoftBody| contacts(body, (&physics.bodies, &physics.colliders), hand);
            for _ in 0..ROUNDS {
                if volume::hold(body, &lump.cells, touched) == Held::Already {
                    break;
                }
            }
            for i in 0..body.num_particles() {
                let (position, velocity) = (body.particle_position(i), body.particle_velocity(i));
                if position.z < 0.0 {
                    body.set_particle_position(i, position.with_z(0.0));
                    body.set_particle_velocity(i, velocity.with_z(velocity.z.max(0.0)));
                }
                let slide = velocity.with_z(0.0);
                if slide.length_squared() > length(FASTEST).powi(2) {
                    let slowed = slide.clamp_length_max(length(FASTEST));
                    body.set_particle_velocity(i, slowed.with_z(body.particle_velocity(i).z));
                }
            }
        }
    }

    fn refresh(&mut self, physics: &mut PhysicsWorld) {
        for lump in &self.lumps {
            let body = &mut physics.soft_bodies[lump.body];
            body.set_particle_position(0, body.particle_position(0));
        }
    }
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
