//! Point clouds and meshes from files, chosen by extension.
use super::{npy, ply, stl};
use crate::state::TriangleMesh;
use anyhow::{Context, ensure};
use glam::DVec3;
use std::path::Path;

type Reader = fn(&[u8]) -> anyhow::Result<Vec<DVec3>>;

/// File extensions that points can be read from.
const READERS: &[(&str, Reader)] =
    &[("ply", ply::points), ("npy", npy::points), ("npz", npy::archived_points), ("stl", stl::points)];

/// Points \[the file's unit: metres, for everything here\] of a `.ply` (vertices), `.npy` or `.npz` ((N, 3) array of f4 or f8,
/// called `positions` unless alone), or `.stl` file (vertices).
///
/// # Errors
/// When the file is missing, damaged, empty, of another type, or holds a number that is not finite.
pub fn read_points(path: &Path) -> anyhow::Result<Vec<DVec3>> {
    parse_points(path, &read(path)?)
}

/// What [`read_points`] takes from a file called `path` that holds `bytes`.
///
/// # Errors
/// As [`read_points`].
pub fn parse_points(path: &Path, bytes: &[u8]) -> anyhow::Result<Vec<DVec3>> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let known = || READERS.iter().map(|(e, _)| format!(".{e}")).collect::<Vec<_>>().join(", ");
    let reader = READERS.iter().find(|(e, _)| *e == extension);
    let (_, reader) = reader.with_context(|| format!("{} is not a point cloud: use {}", path.display(), known()))?;
    let parse = || {
        let points = reader(bytes)?;
        ensure!(!points.is_empty(), "it has no points");
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            anyhow::bail!("its point {i} is {}; remove the points that are not finite numbers", points[i]);
        }
        Ok(points)
    };
    parse().with_context(|| format!("cannot take points from {}", path.display()))
}

/// The solid in an `.stl` file, binary or ASCII \[the file's unit: metres, for everything here\].
///
/// Vertices are welded, triangles without area dropped, the rest turned outward. A mesh that is then not closed becomes its
/// convex hull, which [`TriangleMesh::closure`] tells.
///
/// # Errors
/// When the file is missing, damaged or empty, holds a number that is not finite, or encloses no volume.
pub fn read_mesh(path: &Path) -> anyhow::Result<TriangleMesh> {
    let bytes = read(path)?;
    stl::mesh(&bytes).with_context(|| format!("cannot take a mesh from {}", path.display()))
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("cannot read {}; check the path", path.display()))
}
