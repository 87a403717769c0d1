//! Particles from the points that cameras saw.
use super::clean::{largest_cluster, thin, without_outliers};
use super::table::Plane;
use super::{Observation, Perception};
use crate::shape::{FillSpec, Filled, Shape};
use crate::state::Particles;
use anyhow::{Context, bail, ensure};
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Cloud`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CloudSpec {
    /// How far from its plane a point of the table may lie \[m\].
    #[schemars(range(min = 1e-5, max = 0.1))]
    pub table_tolerance: f64,
    /// Points at most this high above the table are not the object's \[m\].
    #[schemars(range(min = 0.0, max = 0.1))]
    pub clearance: f64,
    /// Neighbours whose mean distance tells an outlier.
    #[schemars(range(min = 1, max = 100))]
    pub neighbours: usize,
    /// Standard deviations beyond the mean of those distances at which a point is an outlier.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub sigmas: f64,
    /// Longest step between two points of the object \[m\].
    #[schemars(range(min = 1e-4, max = 1.0))]
    pub step: f64,
    /// How the volume under the surface is filled.
    pub fill: FillSpec,
}

impl CloudSpec {
    /// The perception that these numbers describe.
    ///
    /// # Errors
    /// A sentence naming the key whose value is impossible.
    pub fn build(self) -> anyhow::Result<Cloud> {
        let lengths = [
            ("table_tolerance", self.table_tolerance),
            ("step", self.step),
            ("fill.cell", self.fill.cell),
            ("sigmas", self.sigmas),
        ];
        for (key, value) in lengths {
            ensure!(value > 0.0 && value.is_finite(), "perception.{key} must be positive, got {value}");
        }
        ensure!(self.clearance >= 0.0, "perception.clearance must not be negative, got {}", self.clearance);
        ensure!(self.neighbours > 0, "perception.neighbours must be at least 1");
        Ok(Cloud { spec: self })
    }
}

/// Finds the table and the object on it in a cloud, fills the object, and samples it.
///
/// The cameras see only the outside; what they see is taken to stand on the table and to be full.
#[derive(Clone, Debug)]
pub struct Cloud {
    spec: CloudSpec,
}

impl Cloud {
    /// The points of the object's surface: x and y as observed, z the height above the table \[m\].
    ///
    /// The table is the plane of [`Plane::under`], or level at the lowest point when the cloud shows no table. What is higher
    /// than the clearance loses its outliers and all but the largest cluster.
    ///
    /// # Errors
    /// When the observation is not a cloud, or no point is left.
    pub fn surface(&self, observation: &Observation) -> anyhow::Result<Vec<DVec3>> {
        let spec = &self.spec;
        let Observation::Cloud(cloud) = observation else {
            bail!("true particles are no cloud; choose perception \"truth\"");
        };
        ensure!(cloud.iter().all(|p| p.is_finite()), "the cloud has a point that is not a finite number");
        let cloud = thin(cloud, spec.fill.cell / 2.0);
        let lowest = cloud.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let table = Plane::under(&cloud, spec.table_tolerance);
        let (table, clearance) = match table {
            Some(table) => (table, spec.clearance),
            None => (Plane { height: lowest, slope_x: 0.0, slope_y: 0.0 }, 0.0),
        };
        let above = cloud.iter().map(|p| p.with_z(table.above(*p))).filter(|p| p.z > clearance);
        let clean = without_outliers(&above.collect::<Vec<_>>(), spec.neighbours, spec.sigmas);
        let object = largest_cluster(&clean, spec.step);
        ensure!(!object.is_empty(), "no point of the cloud is more than {clearance} m above its table");
        Ok(object)
    }
}

impl Perception for Cloud {
    fn perceive(&self, observation: &Observation, count: usize, rng: &mut ChaCha8Rng) -> anyhow::Result<Particles> {
        Ok(Particles::at_rest(self.region(observation)?.points(count, rng)))
    }

    fn region(&self, observation: &Observation) -> anyhow::Result<Filled> {
        Filled::under(&self.surface(observation)?, &self.spec.fill).context("the cloud cannot be filled")
    }
}
