//! Boxes, discs, rings and ellipsoids.
use super::Shape;
use super::extruded::{Extruded, Outline, height, positive};
use anyhow::ensure;
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A box standing on the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CuboidSpec {
    /// Extent along x \[m\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub width: f64,
    /// Extent along y \[m\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub length: f64,
    /// Extent along z \[m\]; this or `volume`.
    #[schemars(range(min = 1e-5, max = 10.0))]
    pub thickness: Option<f64>,
    /// Volume \[m³\]; this or `thickness`.
    #[schemars(range(min = 1e-12, max = 100.0))]
    pub volume: Option<f64>,
}

/// A cylinder standing on its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscSpec {
    /// Diameter \[m\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub diameter: f64,
    /// Extent along z \[m\]; this or `volume`.
    #[schemars(range(min = 1e-5, max = 10.0))]
    pub thickness: Option<f64>,
    /// Volume \[m³\]; this or `thickness`.
    #[schemars(range(min = 1e-12, max = 100.0))]
    pub volume: Option<f64>,
}

/// A disc with a round hole in its middle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RingSpec {
    /// Outer diameter \[m\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub outer: f64,
    /// Diameter of the hole \[m\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub inner: f64,
    /// Extent along z \[m\]; this or `volume`.
    #[schemars(range(min = 1e-5, max = 10.0))]
    pub thickness: Option<f64>,
    /// Volume \[m³\]; this or `thickness`.
    #[schemars(range(min = 1e-12, max = 100.0))]
    pub volume: Option<f64>,
}

/// An ellipsoid that touches the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidSpec {
    /// Extent along x \[m\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub width: f64,
    /// Extent along y \[m\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub length: f64,
    /// Extent along z \[m\]; this or `volume`.
    #[schemars(range(min = 1e-5, max = 10.0))]
    pub height: Option<f64>,
    /// Volume \[m³\]; this or `height`.
    #[schemars(range(min = 1e-12, max = 100.0))]
    pub volume: Option<f64>,
}

impl CuboidSpec {
    pub(crate) fn build(self) -> anyhow::Result<Extruded<Rectangle>> {
        let half = DVec2::new(positive("width", self.width)?, positive("length", self.length)?) / 2.0;
        Extruded::new(Rectangle { half }, self.thickness, self.volume)
    }
}

impl DiscSpec {
    pub(crate) fn build(self) -> anyhow::Result<Extruded<Ellipse>> {
        let half = DVec2::splat(positive("diameter", self.diameter)? / 2.0);
        Extruded::new(Ellipse { half }, self.thickness, self.volume)
    }
}

impl RingSpec {
    pub(crate) fn build(self) -> anyhow::Result<Extruded<Ring>> {
        let (outer, inner) = (positive("outer", self.outer)? / 2.0, positive("inner", self.inner)? / 2.0);
        ensure!(inner < outer, "a ring's inner diameter {} must be smaller than its outer {}", self.inner, self.outer);
        Extruded::new(Ring { inner, outer }, self.thickness, self.volume)
    }
}

impl EllipsoidSpec {
    pub(crate) fn build(self) -> anyhow::Result<Ellipsoid> {
        let (width, length) = (positive("width", self.width)?, positive("length", self.length)?);
        let height = height("height", self.height, self.volume, PI / 6.0 * width * length)?;
        Ok(Ellipsoid { half: DVec3::new(width, length, height) / 2.0 })
    }
}

/// A rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Rectangle {
    /// Half of its sides \[m\].
    pub half: DVec2,
}

impl Outline for Rectangle {
    fn covers(&self, at: DVec2) -> bool {
        at.abs().cmple(self.half).all()
    }
    fn half(&self) -> DVec2 {
        self.half
    }
    fn area(&self) -> f64 {
        4.0 * self.half.element_product()
    }
}

/// An ellipse.
#[derive(Clone, Debug, PartialEq)]
pub struct Ellipse {
    /// Semi-axes along x and y \[m\].
    pub half: DVec2,
}

impl Outline for Ellipse {
    fn covers(&self, at: DVec2) -> bool {
        (at / self.half).length_squared() <= 1.0
    }
    fn half(&self) -> DVec2 {
        self.half
    }
    fn area(&self) -> f64 {
        PI * self.half.element_product()
    }
}

/// The plane between two concentric circles.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Radius of the hole \[m\].
    pub inner: f64,
    /// Outer radius \[m\].
    pub outer: f64,
}

impl Outline for Ring {
    fn covers(&self, at: DVec2) -> bool {
        (self.inner..=self.outer).contains(&at.length())
    }
    fn half(&self) -> DVec2 {
        DVec2::splat(self.outer)
    }
    fn area(&self) -> f64 {
        PI * (self.outer * self.outer - self.inner * self.inner)
    }
}

/// An ellipsoid that touches the table from above.
#[derive(Clone, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Semi-axes \[m\].
    pub half: DVec3,
}

impl Shape for Ellipsoid {
    fn contains(&self, point: DVec3) -> bool {
        ((point - self.half.z * DVec3::Z) / self.half).length_squared() <= 1.0
    }
    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::new(-self.half.x, -self.half.y, 0.0), DVec3::new(self.half.x, self.half.y, 2.0 * self.half.z))
    }
    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.half.element_product()
    }
}
