//! A fluid of particles: position-based, coupled both ways to the engine's rigid bodies.
//!
//! A step moves particles freely and then, in sweeps, against the gradient of the density wherever it exceeds that at rest
//! (Macklin & Müller 2013, eq. 11 to 14):
//!
//! ```text
//! C_i = Σ_j W_ij + Σ_s γ(s_i) − 1 ≤ 0,   λ_i = −C_i / (|∇_i C_i|² + Σ_j |∇_j C_i|² + ε),   Δx_i = Σ_j (λ_i + λ_j) ∇W_ij + λ_i ∇γ
//! ```
//!
//! A solid counts as the half-space beyond its nearest point; what it pushes a particle with, it is pushed with in turn.
use super::cells::Neighbours;
use super::kernel::Kernel;
use super::material::Substance;
use super::scale::{GRAVITY, LENGTH, inward, outward};
use glam::DVec3;
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::prelude::{Aabb, Collider, PhysicsWorld, RigidBodyHandle};
use serde::{Deserialize, Serialize};

/// Fluid particles in a fixed order.
#[derive(Clone, Serialize, Deserialize)]
pub struct Liquid {
    /// \[m\]
    pub(super) positions: Vec<DVec3>,
    /// \[m/s\]
    pub(super) velocities: Vec<DVec3>,
    /// Distance of neighbours at rest \[m\].
    pub(super) spacing: f64,
    /// Mass of a particle \[kg\].
    pub(super) mass: f64,
    /// Share of the velocity difference to its neighbours that a particle loses in a step (XSPH).
    pub(super) viscosity: f64,
    /// Constraint sweeps a step.
    pub(super) sweeps: usize,
}

/// ε over the constraint's own squared gradient in the bulk: keeps lone pairs of particles from being thrown apart.
const RELAXATION: f64 = 0.01;
/// Pairs up to this many supports apart are looked at, as particles come nearer during the sweeps.
const MARGIN: f64 = 1.1;
/// Particles keep this many spacings from solids, whatever the pressure.
const CLEARANCE: f64 = 0.2;
/// The most that pressure accelerates a particle beyond the speed of what is near it, in gravities.
const HARDEST: f64 = 1.0;

/// A solid near a particle, as the plane through its nearest point.
struct Plane {
    solid: usize,
    normal: DVec3,
    /// Distance from the plane at the start of the sweeps \[m\].
    distance: f64,
}

impl Liquid {
    fn advance(&mut self, physics: &mut PhysicsWorld) {
        let dt = f64::from(physics.integration_parameters.dt);
        let kernel = Kernel::new(self.spacing);
        let before = self.positions.clone();
        for (x, v) in self.positions.iter_mut().zip(&mut self.velocities) {
            *v -= GRAVITY * dt * DVec3::Z;
            *x += *v * dt;
        }
        let neighbours = Neighbours::within(&self.positions, MARGIN * kernel.support);
        let solids: Vec<(Option<RigidBodyHandle>, &Collider)> =
            physics.colliders.iter().map(|(_, collider)| (collider.parent(), collider)).collect();
        let reach = (kernel.support * LENGTH) as f32;
        let boxes: Vec<Aabb> = solids.iter().map(|(_, c)| c.compute_aabb().loosened(reach)).collect();
        let planes: Vec<Vec<Plane>> =
            self.positions.iter().map(|x| planes(*x, &solids, &boxes, kernel.support)).collect();
        let start = self.positions.clone();
        let mut impulses = vec![(DVec3::ZERO, DVec3::ZERO); solids.len()];
        for _ in 0..self.sweeps {
            let moves = self.moves(&kernel, &neighbours, &planes, &start);
            for (i, ((own, pushes), x)) in moves.into_iter().zip(&mut self.positions).enumerate() {
                *x += own;
                for (plane, push) in planes[i].iter().zip(pushes) {
                    *x += push * plane.normal;
                    note(&mut impulses[plane.solid], *x, -push * self.mass / dt * plane.normal);
                }
            }
        }
        for (i, x) in self.positions.iter_mut().enumerate() {
            for plane in &planes[i] {
                let short = CLEARANCE * self.spacing - (plane.distance + plane.normal.dot(*x - start[i]));
                if short > 0.0 {
                    *x += short * plane.normal;
                    note(&mut impulses[plane.solid], *x, -short * self.mass / dt * plane.normal);
                }
            }
        }
        let parents: Vec<_> = solids.iter().map(|(parent, _)| *parent).collect();
        // Between walls nearer to each other than particles fit no correction is right, and the particles would be shot out.
        let carried = |plane: &Plane, x: DVec3| {
            let body = parents[plane.solid].map(|handle| &physics.bodies[handle]);
            body.map_or(0.0, |body| outward(body.velocity_at_point(inward(x))).length())
        };
        let free: Vec<f64> = self.velocities.iter().map(|v| v.length()).collect();
        for (i, (v, (x, from))) in self.velocities.iter_mut().zip(self.positions.iter().zip(&before)).enumerate() {
            let near =
                neighbours.of(i).iter().map(|&j| free[j]).chain(planes[i].iter().map(|plane| carried(plane, *x)));
            *v = ((*x - *from) / dt).clamp_length_max(near.fold(free[i], f64::max) + HARDEST * GRAVITY * dt);
        }
        self.smooth(&kernel, &neighbours);
        for (parent, (push, turn)) in parents.into_iter().zip(impulses) {
            let Some(body) = parent.map(|handle| &mut physics.bodies[handle]).filter(|body| body.is_dynamic()) else {
                continue;
            };
            let middle = outward(body.center_of_mass());
            let scale = LENGTH.powi(3);
            body.apply_impulse(inward(push * scale), true);
            body.apply_torque_impulse(((turn - middle.cross(push)) * scale * LENGTH * LENGTH).as_vec3(), true);
        }
    }

    /// One sweep: how far each particle goes because of others, and along the normal of each plane because of that.
    fn moves(
        &self,
        kernel: &Kernel,
        neighbours: &Neighbours,
        planes: &[Vec<Plane>],
        start: &[DVec3],
    ) -> Vec<(DVec3, Vec<f64>)> {
        let x = &self.positions;
        let away = |i: usize, plane: &Plane| plane.distance + plane.normal.dot(x[i] - start[i]);
        // −∇W of every pair, which both the multipliers and the steps are made of.
        let mut slopes = Vec::with_capacity(neighbours.pairs());
        let mut multiplier = |i: usize| {
            let (mut density, mut own, mut squares) = (kernel.weight(0.0), DVec3::ZERO, 0.0);
            for &j in neighbours.of(i) {
                let between = x[i] - x[j];
                let r = between.length();
                let slope = if r > 0.0 { kernel.slope(r) / r * between } else { DVec3::ZERO };
                density += kernel.weight(r);
                own -= slope;
                squares += slope.length_squared();
                slopes.push(slope);
            }
            for plane in &planes[i] {
                let (part, slope) = kernel.ground(away(i, plane));
                density += part;
                own -= slope * plane.normal;
            }
            let excess = (density - 1.0).max(0.0);
            excess / (squares + own.length_squared() + RELAXATION / (self.spacing * self.spacing))
        };
        let multipliers: Vec<f64> = (0..x.len()).map(&mut multiplier).collect();
        let step = |i: usize| {
            let near = neighbours.of(i).iter().zip(&slopes[neighbours.range(i)]);
            let own = near.map(|(&j, slope)| (multipliers[i] + multipliers[j]) * *slope).sum();
            let push = |plane: &Plane| multipliers[i] * kernel.ground(away(i, plane)).1;
            (own, planes[i].iter().map(push).collect())
        };
        (0..x.len()).map(step).collect()
    }

    /// XSPH viscosity (Schechter & Bridson 2012): v_i += c Σ_j (v_j − v_i) W_ij, which keeps the momentum.
    fn smooth(&mut self, kernel: &Kernel, neighbours: &Neighbours) {
        let (x, v) = (&self.positions, &self.velocities);
        let change = |i: usize| -> DVec3 {
            neighbours.of(i).iter().map(|&j| (v[j] - v[i]) * kernel.weight(x[i].distance(x[j]))).sum()
        };
        let changes: Vec<DVec3> = (0..x.len()).map(change).collect();
        self.velocities.iter_mut().zip(changes).for_each(|(v, change)| *v += self.viscosity * change);
    }
}

/// Adds an impulse \[N s\] at `x` to a sum of impulses and of their moments about the origin.
fn note((push, turn): &mut (DVec3, DVec3), x: DVec3, impulse: DVec3) {
    *push += impulse;
    *turn += x.cross(impulse);
}

/// The solids within `reach` of `x`.
fn planes(x: DVec3, solids: &[(Option<RigidBodyHandle>, &Collider)], boxes: &[Aabb], reach: f64) -> Vec<Plane> {
    let point = inward(x);
    let near = solids.iter().zip(boxes).enumerate().filter(|(_, (_, around))| around.contains_local_point(point));
    let plane = |(solid, ((_, collider), _)): (usize, (&(Option<RigidBodyHandle>, &Collider), &Aabb))| {
        let on = collider.shape().project_point(collider.position(), point, false);
        let away = x - outward(on.point);
        let side = if on.is_inside { -1.0 } else { 1.0 };
        let normal = side * away.normalize_or_zero();
        (normal != DVec3::ZERO && side * away.length() < reach).then(|| Plane {
            solid,
            normal,
            distance: side * away.length(),
        })
    };
    near.filter_map(plane).collect()
}

impl Substance for Liquid {
    fn positions(&self, _: &PhysicsWorld) -> Vec<DVec3> {
        self.positions.clone()
    }

    fn bodies(&self) -> Vec<usize> {
        vec![0; self.positions.len()]
    }

    fn surface(&self, physics: &PhysicsWorld) -> Vec<DVec3> {
        self.positions(physics)
    }

    fn volume(&self, _: &PhysicsWorld) -> f64 {
        self.positions.len() as f64 * self.spacing.powi(3)
    }

    fn kick(&mut self, velocity: &dyn Fn(DVec3) -> DVec3, _: &mut PhysicsWorld) {
        self.velocities.iter_mut().zip(&self.positions).for_each(|(v, x)| *v += velocity(*x));
    }

    fn shift(&mut self, by: &dyn Fn(DVec3) -> DVec3, _: &mut PhysicsWorld) {
        self.positions.iter_mut().for_each(|x| *x += by(*x));
    }

    fn mend(&mut self, physics: &mut PhysicsWorld, _: &[RigidBodyHandle]) {
        self.advance(physics);
    }
}
