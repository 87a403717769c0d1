//! Making a list of triangles the boundary of a solid: welded, without slivers, facing outward, and closed.
use anyhow::Context;
use glam::DVec3;
use std::collections::{BTreeMap, VecDeque};

/// Whether a solid is the mesh that was given, or stands in for one that has holes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closure {
    /// The given triangles close; they were welded and turned outward, nothing else.
    Watertight,
    /// The given triangles leave a hole or share an edge three times, so inside and outside are undefined: the solid is
    /// their convex hull.
    ConvexHull,
}

/// Corners of triangles, by number.
pub(super) type Triangles = Vec<[u32; 3]>;

/// Vertices at the same place become one, and triangles without area go.
pub(super) fn weld(vertices: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Triangles) {
    let mut places: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut welded = Vec::new();
    let mut place = |vertex: DVec3| {
        // Adding zero makes −0 equal to 0.
        *places.entry((vertex + 0.0).to_array().map(f64::to_bits)).or_insert_with(|| {
            welded.push(vertex);
            welded.len() as u32 - 1
        })
    };
    let flat = |[a, b, c]: [DVec3; 3]| {
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        (b - a).cross(c - a).length() <= 1e-9 * longest
    };
    let kept = triangles.iter().filter(|t| !flat(t.map(|v| vertices[v as usize])));
    let kept = kept.map(|t| t.map(|v| place(vertices[v as usize]))).collect();
    (welded, kept)
}

/// Turns triangles so that neighbours agree and every connected piece encloses a positive volume, or `None` when an edge does
/// not have exactly two sides.
///
/// Triangles that already agree keep their sides, so that a cavity stays a cavity.
pub(super) fn orient(vertices: &[DVec3], mut triangles: Triangles) -> Option<Triangles> {
    let mut sides: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for (i, t) in triangles.iter().enumerate() {
        for (a, b) in edges(t) {
            sides.entry((a.min(b), a.max(b))).or_default().push(i);
        }
    }
    if sides.values().any(|s| s.len() != 2) || triangles.is_empty() {
        return None;
    }
    let mut turned = false;
    let mut piece = vec![usize::MAX; triangles.len()];
    let mut pieces = 0;
    for first in 0..triangles.len() {
        if piece[first] != usize::MAX {
            continue;
        }
        let mut queue = VecDeque::from([first]);
        piece[first] = pieces;
        while let Some(i) = queue.pop_front() {
            for (a, b) in edges(&triangles[i]) {
                let both = &sides[&(a.min(b), a.max(b))];
                let other = if both[0] == i { both[1] } else { both[0] };
                let agrees = edges(&triangles[other]).contains(&(b, a));
                if piece[other] == usize::MAX {
                    piece[other] = pieces;
                    queue.push_back(other);
                    if !agrees {
                        triangles[other].swap(1, 2);
                        turned = true;
                    }
                } else if !agrees {
                    return None;
                }
            }
        }
        pieces += 1;
    }
    let mut volumes = vec![0.0; pieces];
    for (t, &p) in triangles.iter().zip(&piece) {
        volumes[p] += six_volumes(vertices, t);
    }
    let inside_out = volumes.iter().sum::<f64>() <= 0.0;
    for (t, &p) in triangles.iter_mut().zip(&piece) {
        if if turned { volumes[p] < 0.0 } else { inside_out } {
            t.swap(1, 2);
        }
    }
    Some(triangles)
}

/// The convex hull of `vertices`, facing outward, by parry (in single precision).
pub(super) fn hull(vertices: &[DVec3]) -> anyhow::Result<(Vec<DVec3>, Triangles)> {
    let points: Vec<_> = vertices.iter().map(|v| v.as_vec3()).collect();
    let hull = parry3d::transformation::try_convex_hull(&points);
    let (points, triangles) = hull.map_err(|e| anyhow::anyhow!("it is not closed and has no convex hull: {e}"))?;
    let (vertices, triangles) = weld(&points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>(), &triangles);
    let extent = vertices.iter().fold(0.0, |e: f64, v| e.max(v.distance(vertices[0])));
    let encloses = |t: &Triangles| t.iter().map(|t| six_volumes(&vertices, t)).sum::<f64>() > 1e-6 * extent.powi(3);
    let triangles = orient(&vertices, triangles).filter(encloses).context("it is not closed and its hull is flat")?;
    Ok((vertices, triangles))
}

/// The directed edges of a triangle.
pub(super) fn edges(&[a, b, c]: &[u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

fn six_volumes(vertices: &[DVec3], triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| vertices[v as usize]);
    a.dot(b.cross(c))
}
