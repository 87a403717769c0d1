//! The picture's place in the world, and fields on it read where a particle is.
use crate::model::net::Size;
use anyhow::ensure;
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the picture lies and how fine it is: `rows` × `columns` square cells on the table, around the world's vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GridSpec {
    /// Side of a cell \[m\].
    #[schemars(range(min = 1e-6))]
    pub cell: f64,
    /// Number of cells along y.
    #[schemars(range(min = 1, max = 1024))]
    pub rows: usize,
    /// Number of cells along x.
    #[schemars(range(min = 1, max = 1024))]
    pub columns: usize,
    /// Height of the highest level \[m\]; what lies above moves as it does.
    #[schemars(range(min = 1e-6))]
    pub height: f64,
    /// Number of levels, the table's included, at which tools are seen and motion is told.
    #[schemars(range(min = 2, max = 32))]
    pub levels: usize,
}

impl GridSpec {
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        for (key, value) in [("cell", self.cell), ("height", self.height)] {
            ensure!(value > 0.0 && value.is_finite(), "grid.{key} must be a positive length, got {value}");
        }
        for (key, value) in [("rows", self.rows), ("columns", self.columns)] {
            ensure!((1..=1024).contains(&value), "grid.{key} must be between 1 and 1024, got {value}");
        }
        ensure!((2..=32).contains(&self.levels), "grid.levels must be between 2 and 32, got {}", self.levels);
        Ok(())
    }

    pub(crate) fn size(&self) -> Size {
        Size { rows: self.rows, columns: self.columns }
    }

    /// Place of the middle of cell (0, 0).
    fn origin(&self) -> DVec2 {
        -0.5 * self.cell * DVec2::new(self.columns as f64 - 1.0, self.rows as f64 - 1.0)
    }

    /// The middle of every cell, in the picture's order.
    pub(super) fn middles(&self) -> impl Iterator<Item = DVec2> + '_ {
        let place = |row, column| self.origin() + self.cell * DVec2::new(column as f64, row as f64);
        (0..self.rows).flat_map(move |row| (0..self.columns).map(move |column| place(row, column)))
    }

    /// Height of a level \[m\].
    pub(super) fn level(&self, level: usize) -> f64 {
        self.height * level as f64 / (self.levels - 1) as f64
    }

    /// The cells whose middle is not farther from `place` than `reach`, along x and y each: (cell, its middle).
    pub(super) fn around(&self, place: DVec2, reach: f64) -> impl Iterator<Item = (usize, DVec2)> + '_ {
        let (low, high) = ((place - reach - self.origin()) / self.cell, (place + reach - self.origin()) / self.cell);
        let range = |low: f64, high: f64, count: usize| {
            low.ceil().max(0.0) as usize..((high.floor() + 1.0).max(0.0) as usize).min(count)
        };
        let columns = range(low.x, high.x, self.columns);
        range(low.y, high.y, self.rows).flat_map(move |row| {
            let middle = move |column: usize| self.origin() + self.cell * DVec2::new(column as f64, row as f64);
            columns.clone().map(move |column| (row * self.columns + column, middle(column)))
        })
    }

    /// The eight corners around `point` that a field is interpolated from, linearly along each axis: (cell · levels + level, weight,
    /// the weight's derivative). Beyond the picture the field is zero, above the highest level as on it.
    fn corners(&self, point: DVec3) -> impl Iterator<Item = (usize, f64, DVec3)> + '_ {
        let place = (point.truncate() - self.origin()) / self.cell;
        let per_level = (self.levels - 1) as f64 / self.height;
        let free = (0.0..=self.height).contains(&point.z);
        let up = (point.z * per_level).clamp(0.0, (self.levels - 1) as f64);
        let low = [place.x.floor(), place.y.floor(), up.floor().min((self.levels - 2) as f64)];
        let share = [place.x - low[0], place.y - low[1], up - low[2]];
        let slope = [self.cell.recip(), self.cell.recip(), if free { per_level } else { 0.0 }];
        (0..8).filter_map(move |corner| {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let at: [f64; 3] = std::array::from_fn(|axis| low[axis] + side[axis] as f64);
            let inside = (0.0..self.columns as f64).contains(&at[0]) && (0.0..self.rows as f64).contains(&at[1]);
            let along = |axis: usize| if side[axis] == 1 { share[axis] } else { 1.0 - share[axis] };
            let by = |axis: usize| if side[axis] == 1 { slope[axis] } else { -slope[axis] };
            let (x, y, z) = (along(0), along(1), along(2));
            let cell = at[1] as usize * self.columns + at[0] as usize;
            let derivative = DVec3::new(by(0) * y * z, x * by(1) * z, x * y * by(2));
            inside.then_some((cell * self.levels + at[2] as usize, x * y * z, derivative))
        })
    }

    /// The vector of a field (cells · levels, 3) at `point`.
    pub(crate) fn read(&self, field: &[f32], point: DVec3) -> DVec3 {
        self.corners(point).map(|(place, weight, _)| weight * vector(field, place)).sum()
    }

    /// Adds `∂J/∂field` from `∂J/∂vector` at `point`.
    pub(crate) fn spread(&self, at_field: &mut [f32], point: DVec3, at: DVec3) {
        for (place, weight, _) in self.corners(point) {
            let own = &mut at_field[3 * place..][..3];
            own.iter_mut().zip((weight * at).as_vec3().to_array()).for_each(|(g, w)| *g += w);
        }
    }

    /// `∂J/∂point` from `∂J/∂vector` at `point`.
    pub(crate) fn slope(&self, field: &[f32], point: DVec3, at: DVec3) -> DVec3 {
        self.corners(point).map(|(place, _, derivative)| vector(field, place).dot(at) * derivative).sum()
    }
}

/// What a field says at a cell and level.
fn vector(field: &[f32], place: usize) -> DVec3 {
    glam::Vec3::from_slice(&field[3 * place..]).as_dvec3()
}
