//! A plane figure with a thickness.
use super::Shape;
use anyhow::{bail, ensure};
use glam::{DVec2, DVec3};

/// A figure in the table plane.
pub trait Outline: Send + Sync {
    /// Whether the figure covers `at` \[m\].
    fn covers(&self, at: DVec2) -> bool;
    /// Half of its width and height \[m\]; the middle of its bounding box is the origin.
    fn half(&self) -> DVec2;
    /// Area \[m²\].
    fn area(&self) -> f64;
}

/// A figure extruded from the table up.
#[derive(Clone, Debug, PartialEq)]
pub struct Extruded<O> {
    /// Footprint.
    pub outline: O,
    /// Thickness \[m\].
    pub thickness: f64,
}

impl<O: Outline> Shape for Extruded<O> {
    fn contains(&self, point: DVec3) -> bool {
        (0.0..=self.thickness).contains(&point.z) && self.outline.covers(point.truncate())
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let half = self.outline.half();
        ((-half).extend(0.0), half.extend(self.thickness))
    }

    fn volume(&self) -> f64 {
        self.outline.area() * self.thickness
    }
}

impl<O: Outline> Extruded<O> {
    /// A figure of a given thickness \[m\] or else volume \[m³\].
    ///
    /// # Errors
    /// When neither or both are given, or the one given is not positive.
    pub fn new(outline: O, thickness: Option<f64>, volume: Option<f64>) -> anyhow::Result<Self> {
        let thickness = height("thickness", thickness, volume, outline.area())?;
        Ok(Self { outline, thickness })
    }
}

/// The height of a shape from itself (called `key` in the config) or from a volume, `area` being volume per height \[m²\].
pub(super) fn height(key: &str, height: Option<f64>, volume: Option<f64>, area: f64) -> anyhow::Result<f64> {
    match (height, volume) {
        (Some(height), None) => positive(key, height),
        (None, Some(volume)) => Ok(positive("volume", volume)? / area),
        (None, None) => bail!("a shape needs its {key} [m] or its volume [m³]; give one of the two"),
        (Some(_), Some(_)) => bail!("a shape has both {key} and volume; remove one of the two"),
    }
}

/// `value` if it can be a length or a volume.
pub(super) fn positive(key: &str, value: f64) -> anyhow::Result<f64> {
    ensure!(value > 0.0 && value.is_finite(), "{key} must be positive, got {value}");
    Ok(value)
}
