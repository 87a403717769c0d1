//! Flat sides of the room: the table, and walls around it.
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A plane that particles stay in front of: `normal · x ≥ offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Unit normal, into the room.
    pub normal: DVec3,
    /// `normal · x` of the points on it \[m\].
    pub offset: f64,
}

impl Wall {
    /// The table, z = 0.
    pub const FLOOR: Self = Self { normal: DVec3::Z, offset: 0.0 };

    /// The normal and the offset.
    pub fn to_array(&self) -> [f64; 4] {
        let [x, y, z] = self.normal.to_array();
        [x, y, z, self.offset]
    }

    /// How far `point` is in front of it \[m\].
    pub fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// From the nearest point on it to `point` \[m\].
    pub fn offset_to(&self, point: DVec3) -> DVec3 {
        self.distance(point) * self.normal
    }
}
