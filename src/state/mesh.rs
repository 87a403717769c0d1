//! Triangle meshes as solids: the exact signed distance field and its derivatives.
use super::closure::{self, Closure};
use super::solid::{Projection, flat, rounded};
use super::triangle::{Feature, closest_point};
use glam::{DMat3, DVec3};
use parry3d::shape::{CompositeShapeRef, TriMesh};
use std::collections::BTreeMap;

/// A closed, outward-oriented triangle mesh.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    /// Vertices \[m\], no two at the same place.
    pub vertices: Vec<DVec3>,
    /// Corners of each triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Whether these are the triangles that were given.
    pub closure: Closure,
    /// Unit normal of each triangle.
    normals: Vec<DVec3>,
    /// Sum of the normals around each vertex, weighted by the angle there.
    vertex_normals: Vec<DVec3>,
    /// Triangles around each vertex, ascending.
    stars: Vec<Vec<u32>>,
    /// The triangle across each side.
    across: Vec<[u32; 3]>,
    query: TriMesh,
}

impl TriangleMesh {
    /// A solid from its vertices and triangles: coinciding vertices are welded, triangles without area dropped, the rest
    /// turned outward; where they do not close, the solid is their convex hull and [`TriangleMesh::closure`] says so.
    ///
    /// # Errors
    /// When there is no triangle, an index is out of range, a vertex is not finite, or an open mesh is flat.
    pub fn new(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> anyhow::Result<Self> {
        anyhow::ensure!(!triangles.is_empty(), "a mesh needs at least one triangle");
        anyhow::ensure!(vertices.iter().all(|v| v.is_finite()), "a mesh vertex is not a finite number");
        let count = vertices.len();
        anyhow::ensure!(
            triangles.iter().flatten().all(|&i| (i as usize) < count),
            "a triangle names a vertex that is not there"
        );
        let (welded, kept) = closure::weld(&vertices, &triangles);
        let (vertices, triangles, closure) = match closure::orient(&welded, kept) {
            Some(triangles) => (welded, triangles, Closure::Watertight),
            None => {
                let hull = closure::hull(&welded);
                let (vertices, triangles) = hull.map_err(|e| e.context("the mesh cannot be used as a solid"))?;
                (vertices, triangles, Closure::ConvexHull)
            }
        };
        Self::closed(vertices, triangles, closure)
    }

    fn closed(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>, closure: Closure) -> anyhow::Result<Self> {
        let mut normals = Vec::with_capacity(triangles.len());
        let mut vertex_normals = vec![DVec3::ZERO; vertices.len()];
        let mut stars = vec![Vec::new(); vertices.len()];
        let mut owner = BTreeMap::new();
        for (i, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|v| vertices[v as usize]);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            normals.push(normal);
            for k in 0..3 {
                let (to_next, to_last) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
                vertex_normals[triangle[k] as usize] += to_next.angle_between(to_last) * normal;
                stars[triangle[k] as usize].push(i as u32);
                owner.insert((triangle[k], triangle[(k + 1) % 3]), i as u32);
            }
        }
        let across = triangles.iter().map(|t| closure::edges(t).map(|(a, b)| owner[&(b, a)])).collect();
        let query = TriMesh::new(vertices.iter().map(|v| v.as_vec3()).collect(), triangles.clone())
            .map_err(|e| anyhow::anyhow!("the mesh cannot be used as a solid: {e}"))?;
        Ok(Self { vertices, triangles, closure, normals, vertex_normals, stars, across, query })
    }

    /// Enclosed volume \[m³\], by the divergence theorem.
    pub fn volume(&self) -> f64 {
        let corners = self.triangles.iter().map(|t| t.map(|v| self.vertices[v as usize]));
        corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    /// The signed distance field at `point`: parry's tree finds the triangle, the rest is exact in double precision.
    ///
    /// The nearest feature fixes all three derivatives: with w from it to the point, d = ±|w|, ∇d = w/d, and
    /// ∇²d = (P − ∇d ∇dᵀ)/d, P projecting onto the directions in which the nearest point stays put (none on a face, those
    /// across an edge, all at a vertex). The sign is that of w against the angle-weighted pseudonormal (Bærentzen & Aanæs 2005).
    pub(super) fn project(&self, point: DVec3) -> Projection {
        let mut triangle = self.nearest_triangle(point);
        let (mut nearest, mut feature) = closest_point(self.corners(triangle), point);
        // Single precision may have picked a neighbour of the right triangle; then the nearest point is on their border.
        for &other in self.neighbours(triangle, feature) {
            let (candidate, place) = closest_point(self.corners(other as usize), point);
            if candidate.distance_squared(point) < nearest.distance_squared(point) {
                (triangle, nearest, feature) = (other as usize, candidate, place);
            }
        }
        let offset = point - nearest;
        let around = self.neighbours(triangle, feature).iter().map(|&t| self.normals[t as usize]);
        let faces = std::iter::once(self.normals[triangle]).chain(around);
        // Above the border of coplanar triangles, and on the border of a face's prism, the field is a plane's.
        let above = |n: &DVec3| offset.reject_from_normalized(*n).length_squared() <= 1e-18 * offset.length_squared();
        if let Some(normal) = faces.clone().find(above) {
            return flat(offset.dot(normal), normal);
        }
        let (outward, free) = match feature {
            Feature::Face => (self.normals[triangle], DMat3::ZERO),
            Feature::Side(k) => {
                let [a, b] = [k, (k + 1) % 3].map(|k| self.vertices[self.triangles[triangle][k] as usize]);
                let along = (b - a).normalize();
                let across = self.normals[self.across[triangle][k] as usize];
                (self.normals[triangle] + across, DMat3::IDENTITY - outer(along))
            }
            Feature::Corner(k) => (self.vertex_normals[self.triangles[triangle][k] as usize], DMat3::IDENTITY),
        };
        match feature {
            Feature::Face => flat(offset.dot(outward), outward),
            Feature::Side(_) | Feature::Corner(_) => {
                let field = rounded(offset, free);
                let sign = 1_f64.copysign(offset.dot(outward));
                Projection {
                    distance: sign * field.distance,
                    normal: sign * field.normal,
                    curvature: sign * field.curvature,
                }
            }
        }
    }

    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    fn nearest_triangle(&self, point: DVec3) -> usize {
        let found = CompositeShapeRef(&self.query).project_local_point(point.as_vec3(), f32::MAX, false);
        // Farther than single precision can square, or not a number: no tree, but still an answer.
        let distance = |i: &usize| closest_point(self.corners(*i), point).0.distance_squared(point);
        found.map(|(i, _)| i as usize).unwrap_or_else(|| {
            let all = 0..self.triangles.len();
            all.min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a closed mesh has triangles")
        })
    }

    /// Other triangles that share `feature` of `triangle`; for a corner `triangle` itself is among them.
    fn neighbours(&self, triangle: usize, feature: Feature) -> &[u32] {
        match feature {
            Feature::Face => &[],
            Feature::Side(k) => std::slice::from_ref(&self.across[triangle][k]),
            Feature::Corner(k) => &self.stars[self.triangles[triangle][k] as usize],
        }
    }
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}
