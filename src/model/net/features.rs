//! From a scene to numbers and back: the features of nodes and edges, and their pullback to particles, poses and twists.
use super::architecture::{node_features, told_apart};
use super::input::{EDGE_FEATURES, Edges, Input, InputGrad, Links, NODE_FEATURES};
use crate::graph::{EDGE_KINDS, Window};
use crate::model::law::{View, ViewGrad};
use crate::state::{Pose, SurfacePoint, Twist, Wall};
use glam::DVec3;
use indexmap::IndexMap;
use std::sync::Arc;

/// How a scene becomes the network's input; every feature is unchanged by a shift along the table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Features {
    /// Places in [`crate::graph::EDGE_KINDS`] of the kinds with an edge network, in the network's order.
    pub(crate) kinds: Vec<usize>,
    /// Number of velocities of a particle that are seen.
    pub(crate) history: usize,
    /// Number of bodies told apart.
    pub(crate) bodies: usize,
    /// Constants that particles and roots are told, each with the range that becomes −1 to 1.
    pub(crate) constants: IndexMap<String, [f64; 2]>,
    /// Radius R at which a message has faded to zero \[m\].
    pub(crate) radius: f64,
    /// Displacement that counts as one \[m\].
    pub(crate) scale: f64,
}

/// Position, velocity and normal of every node, or the derivatives with respect to them.
struct Nodes {
    /// The walls and, last, the floor.
    planes: Vec<Wall>,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
    normals: Vec<DVec3>,
}

impl Nodes {
    /// Rows as in [`crate::graph::Nodes`]. With `u = R s` for the sample s: `p = u + t`, `v = linear + angular × u`, `n = R n₀`.
    fn of(view: &View<'_>) -> Self {
        let roots = view.graph.nodes.roots();
        let mut nodes = Self {
            planes: view.walls.iter().copied().chain([Wall::FLOOR]).collect(),
            positions: roots.with_means(&view.particles.positions),
            velocities: roots.with_means(&view.particles.velocities),
            normals: vec![DVec3::ZERO; view.particles.len() + roots.len()],
        };
        for (_, pose, twist, point) in samples(view) {
            let arm = pose.rotation * point.position;
            nodes.positions.push(arm + pose.translation);
            nodes.velocities.push(twist.linear + twist.angular.cross(arm));
            nodes.normals.push(pose.rotation * point.normal);
        }
        nodes.normals.extend(nodes.planes.iter().map(|plane| plane.normal));
        let count = nodes.normals.len();
        nodes.positions.resize(count, DVec3::ZERO);
        nodes.velocities.resize(count, DVec3::ZERO);
        nodes
    }

    /// Zero for every row of this.
    fn zero(&self) -> Self {
        let zero = || vec![DVec3::ZERO; self.positions.len()];
        Self { planes: Vec::new(), positions: zero(), velocities: zero(), normals: zero() }
    }

    /// Row of the first plane.
    fn first_plane(&self) -> usize {
        self.positions.len() - self.planes.len()
    }

    /// `xᵢ − xⱼ`, a plane's place being the receiver's projection on it.
    fn offset(&self, i: usize, j: usize) -> DVec3 {
        match j.checked_sub(self.first_plane()) {
            Some(plane) => self.planes[plane].offset_to(self.positions[i]),
            None => self.positions[i] - self.positions[j],
        }
    }

    /// Whether row j is a plane and row i on its far side.
    fn is_behind(&self, i: usize, j: usize) -> bool {
        let plane = j.checked_sub(self.first_plane());
        plane.is_some_and(|plane| self.planes[plane].distance(self.positions[i]) < 0.0)
    }

    /// Adds to `at` what follows from `∂J/∂offset` of the edge from row j to row i; for a plane at `n·x = d` the offset is
    /// `(n·xᵢ − d) n`.
    fn pull_offset(&self, (i, j): (usize, usize), back: DVec3, at: &mut Self) {
        match j.checked_sub(self.first_plane()) {
            Some(plane) => {
                let plane = &self.planes[plane];
                let along = plane.normal.dot(back);
                at.positions[i] += along * plane.normal;
                at.normals[j] += plane.distance(self.positions[i]) * back + along * self.positions[i];
            }
            None => {
                at.positions[i] += back;
                at.positions[j] -= back;
            }
        }
    }
}

fn samples<'a>(view: &'a View<'_>) -> impl Iterator<Item = (usize, &'a Pose, &'a Twist, &'a SurfacePoint)> {
    let parts = view.tool.parts.iter().zip(view.poses).zip(view.twists).enumerate();
    parts.flat_map(|(k, ((part, pose), twist))| part.surface.iter().map(move |point| (k, pose, twist, point)))
}

/// How an edge of offset x sees its length.
struct Reach {
    kind: Window,
    /// `x/R`, and for an edge of any length `x/√(x² + R²)`.
    offset: DVec3,
    /// `(1 − x²/R²)²`, none beyond R; 1 for an edge of any length, and behind a plane, however far.
    window: f64,
    /// `−R ∂window/∂x` along the offset, over its length.
    fading: f64,
    radius: f64,
}

impl Reach {
    fn of(kind: Window, nodes: &Nodes, (i, j): (usize, usize), radius: f64) -> Self {
        let offset = nodes.offset(i, j);
        let square = offset.length_squared();
        let (length, window, fading) = match kind {
            // What is behind a plane must not lose sight of it.
            Window::Fading if nodes.is_behind(i, j) => (radius, 1.0, 0.0),
            Window::Fading => {
                let root = (1.0 - square / (radius * radius)).max(0.0);
                (radius, root * root, 4.0 * root)
            }
            Window::Open => ((square + radius * radius).sqrt(), 1.0, 0.0),
        };
        Self { kind, offset: offset / length, window, fading, radius }
    }

    /// `∂J/∂x` from `∂J/∂offset` and `∂J/∂window`.
    fn pull(&self, at_offset: DVec3, at_window: f64) -> DVec3 {
        match self.kind {
            Window::Fading => (at_offset - at_window * self.fading * self.offset) / self.radius,
            Window::Open => {
                let flat = (1.0 - self.offset.length_squared()).sqrt();
                (at_offset - self.offset * self.offset.dot(at_offset)) * flat / self.radius
            }
        }
    }

    /// `∂J/∂x` from `∂J/∂features` g and `∂J/∂window` of an edge.
    fn pull_edge(&self, g: &[f32], at_window: f32) -> DVec3 {
        self.pull(read(&g[..3]) + f64::from(g[3]) * self.offset.normalize_or_zero(), at_window.into())
    }
}

impl Features {
    /// The network's input.
    pub(crate) fn input(&self, view: &View<'_>) -> Input {
        let nodes = Nodes::of(view);
        let particles = view.particles.len();
        let receivers = particles + view.graph.nodes.roots().len();
        let per_speed = view.interval / self.scale;
        let (planes, count) = (nodes.first_plane(), nodes.positions.len());
        let (bodies, of) = (told_apart(self.bodies), view.graph.nodes.roots().with_bodies(view.body));
        let past: Vec<_> = self.past(view).map(|velocities| view.graph.nodes.roots().with_means(velocities)).collect();
        let constant = |(path, [low, high]): (&String, &[f64; 2])| {
            let value = view.constants.get(path).copied().unwrap_or(0.5 * (low + high));
            (2.0 * (value - low) / (high - low) - 1.0) as f32
        };
        let constants: Vec<f32> = self.constants.iter().map(constant).collect();
        let mut rows = Vec::with_capacity(count * self.width());
        for row in 0..count {
            push(&mut rows, nodes.velocities[row] * per_speed);
            // A root has none of the roles.
            let role = glam::BVec3::new(row < particles, row >= receivers && row < planes, row >= planes);
            push(&mut rows, DVec3::select(role, DVec3::ONE, DVec3::ZERO));
            rows.push(if row < receivers { self.height(nodes.positions[row].z).0 as f32 } else { 0.0 });
            push(&mut rows, nodes.normals[row]);
            let own = |body: usize| of.get(row).is_some_and(|number| *number as usize == body);
            rows.extend((0..bodies).map(|body| if own(body) { 1.0 } else { 0.0 }));
            let before = past.iter().map(|velocities| velocities.get(row).copied().unwrap_or_default());
            before.for_each(|velocity| push(&mut rows, velocity * per_speed));
            rows.extend(constants.iter().map(|constant| if row < receivers { *constant } else { 0.0 }));
        }
        let edges = self.kinds.iter().map(|&kind| self.edges(view, &nodes, kind, per_speed)).collect();
        Input { particles, receivers, nodes: rows, edges }
    }

    /// Numbers a node.
    fn width(&self) -> usize {
        node_features(self.history, self.bodies, self.constants.len())
    }

    /// The velocities of the past that are seen.
    fn past<'a>(&self, view: &View<'a>) -> impl Iterator<Item = &'a Vec<DVec3>> {
        view.past.iter().take(self.history - 1)
    }

    /// `z/√(z² + R²)` and its derivative: linear near the table, constant far above it.
    fn height(&self, z: f64) -> (f64, f64) {
        let root = z.hypot(self.radius);
        (z / root, (self.radius / root).powi(2) / root)
    }

    fn edges(&self, view: &View<'_>, nodes: &Nodes, kind: usize, per_speed: f64) -> Edges {
        let set = &view.graph.edges[kind];
        let (mut links, mut features, mut window) = (Links::default(), Vec::new(), Vec::new());
        features.reserve(set.len() * EDGE_FEATURES);
        for (i, j) in set.pairs() {
            let reach = Reach::of(EDGE_KINDS[kind].window(), nodes, (i, j), self.radius);
            if reach.window > 0.0 {
                links.receivers.push(i as u32);
                links.senders.push(j as u32);
                window.push(reach.window as f32);
                push(&mut features, reach.offset);
                features.push(reach.offset.length() as f32);
                push(&mut features, nodes.normals[j]);
                push(&mut features, (nodes.velocities[i] - nodes.velocities[j]) * per_speed);
            }
        }
        Edges { links: Arc::new(links), features, window }
    }

    /// Adds `∂J/∂view` to `grad`, from `∂J/∂input` and the links of that input; returns `∂J/∂normal` of every wall.
    pub(crate) fn pull(
        &self,
        view: &View<'_>,
        links: &[Arc<Links>],
        at: &InputGrad,
        grad: &mut ViewGrad<'_>,
    ) -> Vec<DVec3> {
        let nodes = Nodes::of(view);
        let roots = view.graph.nodes.roots();
        let (particles, receivers) = (view.particles.len(), view.particles.len() + roots.len());
        let per_speed = view.interval / self.scale;
        let mut at_nodes = nodes.zero();
        let first = NODE_FEATURES + told_apart(self.bodies);
        let mut at_past: Vec<_> = self.past(view).map(|_| vec![DVec3::ZERO; receivers]).collect();
        for (row, g) in at.nodes.chunks_exact(self.width()).enumerate() {
            at_nodes.velocities[row] += read(&g[..3]) * per_speed;
            if row < receivers {
                at_nodes.positions[row].z += f64::from(g[6]) * self.height(nodes.positions[row].z).1;
            }
            at_nodes.normals[row] += read(&g[7..10]);
            if row < receivers {
                let before = at_past.iter_mut().zip(g[first..].chunks_exact(3));
                before.for_each(|(at, g)| at[row] = read(g) * per_speed);
            }
        }
        for ((links, at), &kind) in links.iter().zip(&at.edges).zip(&self.kinds) {
            let window = EDGE_KINDS[kind].window();
            let rows = at.features.chunks_exact(EDGE_FEATURES).zip(&at.window);
            for ((&i, &j), (g, &at_window)) in links.receivers.iter().zip(&links.senders).zip(rows) {
                let (i, j) = (i as usize, j as usize);
                let reach = Reach::of(window, &nodes, (i, j), self.radius);
                nodes.pull_offset((i, j), reach.pull_edge(g, at_window), &mut at_nodes);
                at_nodes.normals[j] += read(&g[4..7]);
                let speed = read(&g[7..]) * per_speed;
                at_nodes.velocities[i] += speed;
                at_nodes.velocities[j] -= speed;
            }
        }
        roots.with_means_vjp(&mut at_nodes.positions);
        roots.with_means_vjp(&mut at_nodes.velocities);
        for (at, own) in at_past.iter_mut().zip(&mut grad.past) {
            roots.with_means_vjp(at);
            own.iter_mut().zip(at).for_each(|(own, at)| *own += *at);
        }
        for i in 0..particles {
            grad.particles.positions[i] += at_nodes.positions[i];
            grad.particles.velocities[i] += at_nodes.velocities[i];
        }
        for (row, (k, pose, twist, point)) in (receivers..).zip(samples(view)) {
            let (at_velocity, at_normal) = (at_nodes.velocities[row], at_nodes.normals[row]);
            let arm = pose.rotation * point.position;
            let at_arm = at_nodes.positions[row] + at_velocity.cross(twist.angular);
            grad.poses[k].translation += at_nodes.positions[row];
            grad.poses[k].rotation += arm.cross(at_arm) + (pose.rotation * point.normal).cross(at_normal);
            grad.twists[k].linear += at_velocity;
            grad.twists[k].angular += arm.cross(at_velocity);
        }
        let planes = nodes.first_plane();
        at_nodes.normals[planes..planes + view.walls.len()].to_vec()
    }
}

fn push(row: &mut Vec<f32>, v: DVec3) {
    row.extend(v.as_vec3().to_array());
}

fn read(row: &[f32]) -> DVec3 {
    glam::Vec3::from_slice(row).as_dvec3()
}
