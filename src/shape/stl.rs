//! STL meshes, binary and ASCII.
use crate::state::TriangleMesh;
use anyhow::{Context, ensure};
use glam::DVec3;
use std::borrow::Cow;
use std::io::Cursor;

/// Corners of the triangles, three a triangle.
fn corners(bytes: &[u8]) -> anyhow::Result<Vec<DVec3>> {
    let claimed = |bytes: &[u8]| {
        let count = bytes.get(80..84).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        count.map(|count| 84 + 50 * count as usize)
    };
    let length = claimed(bytes);
    let mut bytes = Cow::Borrowed(bytes);
    if length == Some(bytes.len()) {
        // Some binary files begin with "solid", by which the reader would take them for ASCII; their length tells.
        bytes.to_mut()[0] = b' ';
    } else if !bytes.starts_with(b"solid ") {
        let length = length.context("it is truncated: its header is not complete")?;
        ensure!(length <= bytes.len(), "its header claims {length} bytes but it has {}; it is truncated", bytes.len());
    }
    let mut source = Cursor::new(&bytes[..]);
    let triangles = stl_io::create_stl_reader(&mut source).context("it is no STL file")?;
    let mut corners = Vec::new();
    for triangle in triangles {
        let triangle = triangle.context("it is truncated or damaged")?;
        corners.extend(triangle.vertices.map(|v| DVec3::from_array(v.0.map(f64::from))));
    }
    Ok(corners)
}

pub(super) fn mesh(bytes: &[u8]) -> anyhow::Result<TriangleMesh> {
    let corners = corners(bytes)?;
    let triangles = (0..corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(corners, triangles)
}

/// The places of the vertices, each once, in the order of their first appearance.
pub(super) fn points(bytes: &[u8]) -> anyhow::Result<Vec<DVec3>> {
    let mut seen = std::collections::HashSet::new();
    let mut points = corners(bytes)?;
    points.retain(|p| seen.insert(p.to_array().map(f64::to_bits)));
    Ok(points)
}
