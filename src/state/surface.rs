//! Near-uniform samples of a solid's surface, with outward normals; the same points every time.
use super::{Solid, SurfacePoint, TriangleMesh, assembly};
use glam::DVec3;
use std::f64::consts::TAU;

impl Solid {
    /// Points about `spacing` \[m\] apart that cover the whole surface, none on an edge, each with its outward normal.
    ///
    /// Boxes and cylinders are cut into cells at most `spacing` wide, one point in the middle of each; a mesh is strewn with a
    /// low-discrepancy sequence (Roberts 2018) and thinned to points at least 0.8 `spacing` apart (Cook 1986).
    pub fn surface(&self, spacing: f64) -> Vec<SurfacePoint> {
        assert!(spacing > 0.0, "surface samples need a positive spacing");
        match self {
            Self::Cuboid { half } => cuboid(*half, spacing),
            Self::Cylinder { radius, half_length } => cylinder(*radius, *half_length, spacing),
            Self::Mesh(mesh) => strewn(mesh, spacing),
            Self::Assembly(pieces) => assembly::surface(pieces, spacing),
        }
    }
}

/// The middles of the fewest equal cells of `[-half, half]` that are at most `spacing` wide.
fn middles(half: f64, spacing: f64) -> impl Iterator<Item = f64> + Clone {
    let count = (2.0 * half / spacing - 1e-9).ceil().max(1.0);
    (0..count as usize).map(move |i| half * ((2 * i + 1) as f64 / count - 1.0))
}

fn cuboid(half: DVec3, spacing: f64) -> Vec<SurfacePoint> {
    let mut points = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for sign in [-1.0, 1.0] {
            for a in middles(half[u], spacing) {
                for b in middles(half[v], spacing) {
                    let normal = sign * DVec3::AXES[axis];
                    let position = normal * half[axis] + DVec3::AXES[u] * a + DVec3::AXES[v] * b;
                    points.push(SurfacePoint { position, normal });
                }
            }
        }
    }
    points
}

fn cylinder(radius: f64, half_length: f64, spacing: f64) -> Vec<SurfacePoint> {
    let around = |radius: f64| {
        let count = (TAU * radius / spacing - 1e-9).ceil().max(1.0);
        (0..count as usize).map(move |i| {
            let (sine, cosine) = (TAU * i as f64 / count).sin_cos();
            DVec3::new(cosine, 0.0, sine)
        })
    };
    let mut points = Vec::new();
    for y in middles(half_length, spacing) {
        points.extend(around(radius).map(|normal| SurfacePoint { position: radius * normal + y * DVec3::Y, normal }));
    }
    for end in [-DVec3::Y, DVec3::Y] {
        for ring in middles(radius / 2.0, spacing).map(|r| r + radius / 2.0) {
            points.extend(around(ring).map(|d| SurfacePoint { position: ring * d + half_length * end, normal: end }));
        }
    }
    points
}

fn strewn(mesh: &TriangleMesh, spacing: f64) -> Vec<SurfacePoint> {
    // The generalised golden ratio in three dimensions: its powers give the most even sequence of triples.
    const RATIO: f64 = 1.220_744_084_605_759_5;
    let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices[v as usize]);
    let mut reached = 0.0;
    let areas: Vec<f64> = (mesh.triangles.iter())
        .map(|t| {
            let [a, b, c] = corners(t);
            reached += (b - a).cross(c - a).length() / 2.0;
            reached
        })
        .collect();
    let (candidates, apart) = ((16.0 * reached / (spacing * spacing)).ceil().max(64.0), 0.8 * spacing);
    let mut points: Vec<SurfacePoint> = Vec::new();
    for k in 1..=candidates as usize {
        let [w, u, v] = [1, 2, 3].map(|power| (0.5 + k as f64 / RATIO.powi(power)).fract());
        let place = areas.partition_point(|&area| area <= w * reached).min(areas.len() - 1);
        let [a, b, c] = corners(&mesh.triangles[place]);
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let (position, normal) = (a + u * (b - a) + v * (c - a), (b - a).cross(c - a).normalize_or_zero());
        // The far side of a thin plate is no neighbour.
        let crowded = |p: &SurfacePoint| p.position.distance(position) < apart && p.normal.dot(normal) > -0.5;
        if normal != DVec3::ZERO && !points.iter().any(crowded) {
            points.push(SurfacePoint { position, normal });
        }
    }
    points
}
