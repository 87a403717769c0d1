//! Mixings on a picture, cells in rows and columns: neighbourhoods, half and double resolution.
use super::mixing::Mixing;
use serde::{Deserialize, Serialize};

/// A picture's size, in cells; cell (row, column) is row `row · columns + column` of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Size {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
}

impl Size {
    /// Number of cells.
    pub(crate) fn cells(self) -> usize {
        self.rows * self.columns
    }

    /// Half as many rows and columns.
    pub(super) fn halved(self) -> Self {
        Self { rows: self.rows / 2, columns: self.columns / 2 }
    }

    fn each(self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.rows).flat_map(move |row| (0..self.columns).map(move |column| (row, column)))
    }

    fn place(self, row: usize, column: usize) -> usize {
        row * self.columns + column
    }

    /// The `width` × `width` cells around each cell, nothing beyond the picture; `width` is odd.
    pub(super) fn neighbourhoods(self, width: usize) -> Mixing {
        let half = width / 2;
        let rows = self.each().flat_map(move |(row, column)| {
            (0..width * width).map(move |k| {
                let (r, c) = ((row + k / width).checked_sub(half), (column + k % width).checked_sub(half));
                let inside = r.zip(c).filter(|&(r, c)| r < self.rows && c < self.columns);
                inside.map(|(r, c)| (self.place(r, c), 1.0))
            })
        });
        Mixing::new(rows)
    }

    /// The means of blocks of 2 × 2 cells.
    pub(super) fn halving(self) -> Mixing {
        let corner = |row, column| {
            [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(r, c)| (self.place(2 * row + r, 2 * column + c), 0.25))
        };
        Mixing::new(self.halved().each().map(|(row, column)| corner(row, column)))
    }

    /// Each cell of a picture half as fine, for the four cells it stands for.
    pub(super) fn doubling(self) -> Mixing {
        Mixing::new(self.each().map(|(row, column)| [(self.halved().place(row / 2, column / 2), 1.0)]))
    }
}
