//! Granular material: loose rigid grains, one particle each.
use super::SceneSpec;
use super::bodies::{self, Bodies};
use super::material::{self, Filling, Material, Matter};
use super::scale::{inward, length};
use anyhow::{Context, ensure};
use glam::{DQuat, DVec3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, UnitBall, UnitSphere};
use rapier3d::math::{Pose as EnginePose, Rotation};
use rapier3d::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A pile of grains, as many as the scene has particles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainsSpec {
    /// Shape of a grain; its sizes are drawn for each.
    pub grain: GrainSpec,
    /// Mass density of a grain \[kg/m³\].
    #[schemars(range(min = 1.0, max = 20000.0))]
    pub density: f64,
    /// Coulomb friction coefficient between grains, against table and tools.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub friction: f64,
    /// Newton's coefficient of restitution.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub restitution: f64,
    /// Rate at which a grain loses its spin \[1/s\], as by rolling resistance: a ball that rolls slows down as v' = −(2/7) rate v.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub rolling: f64,
}

/// The shape of a grain; pairs are ranges that every grain is drawn from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum GrainSpec {
    /// A ball.
    Ball {
        /// Radius \[m\].
        radius: [f64; 2],
    },
    /// A cylinder with round ends.
    Capsule {
        /// Radius \[m\].
        radius: [f64; 2],
        /// Half of the length without the ends \[m\].
        half_length: [f64; 2],
    },
    /// A box.
    Cuboid {
        /// Half extents along each axis \[m\].
        half: [[f64; 2]; 3],
    },
    /// The convex hull of random points.
    Hull {
        /// Greatest distance of a corner from the middle \[m\].
        radius: [f64; 2],
        /// Number of points.
        corners: usize,
    },
}

/// Two grains start at least this much apart, as a share of their size.
const GAP: f64 = 1.05;

impl GrainSpec {
    fn ranges(&self) -> Vec<[f64; 2]> {
        match self {
            Self::Ball { radius } | Self::Hull { radius, .. } => vec![*radius],
            Self::Capsule { radius, half_length } => vec![*radius, *half_length],
            Self::Cuboid { half } => half.to_vec(),
        }
    }

    /// Radius of the smallest ball around the middle that holds every grain \[m\].
    fn reach(&self) -> f64 {
        match self {
            Self::Ball { radius } | Self::Hull { radius, .. } => radius[1],
            Self::Capsule { radius, half_length } => radius[1] + half_length[1],
            Self::Cuboid { half } => half.iter().map(|h| h[1] * h[1]).sum::<f64>().sqrt(),
        }
    }

    fn draw(&self, rng: &mut ChaCha8Rng) -> anyhow::Result<ColliderBuilder> {
        let mut size = |[low, high]: [f64; 2]| low + (high - low) * rng.random::<f64>();
        Ok(match self {
            Self::Ball { radius } => ColliderBuilder::ball(length(size(*radius))),
            Self::Capsule { radius, half_length } => {
                let (radius, half_length) = (length(size(*radius)), length(size(*half_length)));
                ColliderBuilder::capsule_z(half_length, radius)
            }
            Self::Cuboid { half } => {
                let [x, y, z] = half.map(|range| length(size(range)));
                ColliderBuilder::cuboid(x, y, z)
            }
            Self::Hull { radius, corners } => {
                let radius = size(*radius);
                let corner = |_| inward(radius * DVec3::from_array(UnitSphere.sample(rng)));
                let points: Vec<Vector> = (0..*corners).map(corner).collect();
                ColliderBuilder::convex_hull(&points).context("the points of a grain have no hull: use more corners")?
            }
        })
    }
}

impl GrainsSpec {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn build(self) -> anyhow::Result<impl Material> {
        for [low, high] in self.grain.ranges() {
            ensure!(
                0.0 < low && low <= high && high <= 0.1,
                "material.grain has the range [{low}, {high}] m; it must be [low, high] with 0 < low ≤ high ≤ 0.1"
            );
        }
        if let GrainSpec::Hull { corners, .. } = self.grain {
            ensure!((6..=64).contains(&corners), "material.grain.corners is {corners}; it must lie in [6, 64]");
        }
        bodies::check(self.density, self.friction, self.restitution)?;
        material::check(&[("rolling", self.rolling, 0.0, 1e3)])?;
        Ok(self)
    }
}

impl Material for GrainsSpec {
    /// Layer upon layer over the region's footprint, turned at random, from where the grains fall into a pile.
    fn fill(
        &self,
        scene: &SceneSpec,
        filling: &Filling<'_>,
        physics: &mut PhysicsWorld,
        rng: &mut ChaCha8Rng,
    ) -> anyhow::Result<Matter> {
        let pitch = 2.0 * GAP * self.grain.reach();
        let ((low, high), turn) = (filling.bounds, DQuat::from_rotation_z(filling.turn));
        let counts = ((high - low) / pitch).floor().max(DVec3::ONE);
        let start = (low + high - (counts - 1.0) * pitch) / 2.0;
        let column = |i: usize, j: usize| start.truncate() + glam::DVec2::new(i as f64, j as f64) * pitch;
        let middle = (low.z + high.z) / 2.0;
        let columns: Vec<_> = (0..counts.x as usize)
            .flat_map(|i| (0..counts.y as usize).map(move |j| column(i, j)))
            .filter(|at| (filling.contains)(at.extend(middle)))
            .collect();
        ensure!(!columns.is_empty(), "no grain of {pitch} m fits into the region: choose a larger scene.start");
        let mut bodies = Bodies::of(self.density);
        for k in 0..scene.particles {
            let height = filling.raised + (0.5 + (k / columns.len()) as f64) * pitch;
            let at = turn * columns[k % columns.len()].extend(height) + filling.at.extend(0.0);
            // Up to half of the gap to any side, or a column of balls would stand like a tower.
            let at = at + (GAP - 1.0) * self.grain.reach() * DVec3::from_array(UnitBall.sample(rng));
            let axis = DVec3::from_array(UnitSphere.sample(rng));
            let spin = DQuat::from_axis_angle(axis, rng.random_range(0.0..std::f64::consts::TAU));
            let rotation = Rotation::from_xyzw(spin.x as Real, spin.y as Real, spin.z as Real, spin.w as Real);
            let collider = self.grain.draw(rng)?;
            let collider = collider.friction(self.friction as Real).restitution(self.restitution as Real);
            // The particle is the grain's centre of mass, which a hull of random points has off its origin.
            let middle = collider.shape.mass_properties(1.0).local_com;
            let body = RigidBodyBuilder::dynamic().pose(EnginePose::from_parts(inward(at), rotation));
            bodies.add(physics, body.angular_damping(self.rolling as Real), collider, vec![middle]);
        }
        Ok(Matter::Bodies(bodies))
    }

    fn friction(&self) -> f64 {
        self.friction
    }

    /// The engine's tolerances suit things about one unit long, so that a smaller grain would touch what it is not near to. What
    /// stands still here is bounded by planes, which nothing is fast enough to pass: looking for that is spared.
    fn tune(&self, scene: &SceneSpec, parameters: &mut IntegrationParameters) {
        parameters.num_internal_pgs_iterations = scene.solver.sweeps;
        let unit = length(2.0 * self.grain.reach()).min(parameters.length_unit);
        let finer = parameters.length_unit / unit;
        parameters.length_unit = unit;
        parameters.normalized_max_corrective_velocity *= finer;
        parameters.normalized_max_linear_velocity *= finer;
        parameters.max_ccd_substeps = 0;
    }

    fn settling(&self) -> f64 {
        2.0
    }
}
