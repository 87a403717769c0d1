//! Dough that a blade goes through.
//!
//! The engine splits the particles along a flat triangle, so that every tetrahedron that it meets goes whole to the side of its
//! middle, and makes a soft body of every piece that comes apart. A blade drags along what it cuts: were the sides judged where
//! the particles are now, later steps would cut other faces and leave crumbs. So they are judged where the particles were when
//! the blade was taken; and in the blade's own coordinates, in which a ring is as flat as a knife. The dough's own books follow:
//! where each particle of the whole went, and which lattice cell each tetrahedron is of.
use super::dough::{Dough, Lump};
use super::scale::{LENGTH, inward, outward};
use crate::state::{Blade, Pose};
use glam::DVec3;
use rapier3d::prelude::{PhysicsWorld, SoftBody, SoftBodyHandle, SoftBodyTearEvent, Vector};
use std::collections::BTreeMap;

/// Cuts all lumps of `dough` along `blade`, which stands at `pose`.
pub(super) fn part(dough: &mut Dough, physics: &mut PhysicsWorld, blade: &Blade, pose: &Pose) {
    let mut now = Vec::new();
    for lump in &dough.lumps {
        let body = &mut physics.soft_bodies[lump.body];
        now.push(body.particle_positions().collect::<Vec<_>>());
        let flat = lump.uncut.iter().map(|point| inward(blade.place(pose.inverse_apply(*point))));
        place(body, flat);
    }
    let [a, b, c, d] = blade.corners().map(inward);
    for triangle in [[a, b, c], [a, c, d]] {
        for number in 0..dough.lumps.len() {
            let handle = dough.lumps[number].body;
            let whole: Vec<[u32; 4]> = physics.soft_bodies[handle].cells().iter().map(|t| t.vertices).collect();
            if let Some(event) = physics.cut_soft_body(handle, &triangle) {
                let pieces = pieces(&event, &physics.soft_bodies[handle]);
                follow(dough, number, &mut now, &pieces, &whole, physics);
            }
        }
    }
    for (lump, now) in dough.lumps.iter().zip(now) {
        let body = &mut physics.soft_bodies[lump.body];
        place(body, now);
        make_way(body, &lump.uncut, blade, pose);
    }
}

/// Particles on the cut begin in the blade, whose collider would push some out to the wrong side: each makes way to the side that
/// its tetrahedra are on.
fn make_way(body: &mut SoftBody, uncut: &[DVec3], blade: &Blade, pose: &Pose) {
    let out: Vec<f64> = uncut.iter().map(|point| blade.place(pose.inverse_apply(*point)).x).collect();
    let mut sides = vec![[false; 2]; out.len()];
    for tetrahedron in body.cells() {
        let beyond = tetrahedron.vertices.iter().map(|i| out[*i as usize]).sum::<f64>() > 0.0;
        tetrahedron.vertices.iter().for_each(|i| sides[*i as usize][usize::from(beyond)] = true);
    }
    let skin = f64::from(body.particle_radius()) / LENGTH;
    for (i, side) in sides.into_iter().enumerate() {
        let [within, beyond] = side;
        let point = pose.inverse_apply(outward(body.particle_position(i)));
        let way = if beyond { 1.0 } else { -1.0 };
        if let Some(to) = (within != beyond).then(|| blade.clear(point, way, skin)).flatten() {
            body.set_particle_position(i, inward(pose.apply(to)));
        }
    }
}

fn place(body: &mut SoftBody, positions: impl IntoIterator<Item = Vector>) {
    for (i, position) in positions.into_iter().enumerate() {
        body.set_particle_position(i, position);
    }
}

/// What a cut left, the largest first: the body, and for each of its particles the one before the cut that it was or was split from.
type Piece = (SoftBodyHandle, Vec<u32>);

fn pieces(event: &SoftBodyTearEvent, body: &SoftBody) -> Vec<Piece> {
    let source: BTreeMap<u32, u32> = event.split_particles.iter().copied().collect();
    let origin = |particle: &u32| {
        let mut particle = *particle;
        while let Some(&from) = source.get(&particle) {
            particle = from;
        }
        particle
    };
    if event.pieces.is_empty() {
        return vec![(event.soft_body, (0..body.num_particles() as u32).map(|i| origin(&i)).collect())];
    }
    event.pieces.iter().map(|piece| (piece.soft_body, piece.particles.iter().map(origin).collect())).collect()
}

/// Replaces the lump of this number, whose tetrahedra had the particles `whole`, by its pieces.
fn follow(
    dough: &mut Dough,
    number: usize,
    now: &mut Vec<Vec<Vector>>,
    pieces: &[Piece],
    whole: &[[u32; 4]],
    physics: &PhysicsWorld,
) {
    let (lump, positions) = (dough.lumps[number].clone(), now[number].clone());
    let owner: BTreeMap<[u32; 4], u32> = whole.iter().map(|t| sorted(*t)).zip(lump.cells).collect();
    let mut went = BTreeMap::new();
    for (k, (body, origins)) in pieces.iter().enumerate() {
        let tetrahedra = physics.soft_bodies[*body].cells().iter().map(|t| t.vertices.map(|i| origins[i as usize]));
        let piece = Lump {
            body: *body,
            cells: tetrahedra.map(|t| owner[&sorted(t)]).collect(),
            uncut: origins.iter().map(|i| lump.uncut[*i as usize]).collect(),
        };
        let positions = origins.iter().map(|i| positions[*i as usize]).collect();
        let to = if k == 0 { number } else { dough.lumps.len() };
        // Of a particle that was split the first piece's copy is the one that goes on.
        for (i, origin) in origins.iter().enumerate() {
            went.entry((number as u32, *origin)).or_insert((to as u32, i as u32));
        }
        if k == 0 {
            (dough.lumps[number], now[number]) = (piece, positions);
        } else {
            dough.lumps.push(piece);
            now.push(positions);
        }
    }
    for place in &mut dough.places {
        if let Some(to) = went.get(place) {
            *place = *to;
        }
    }
}

fn sorted(mut corners: [u32; 4]) -> [u32; 4] {
    corners.sort_unstable();
    corners
}
