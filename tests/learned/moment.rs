//! Particles, a tool and roots at one moment, and laws to ask about it.
use glam::{DQuat, DVec3};
use indexmap::IndexMap;
use pliant::graph::{EDGE_KINDS, EdgeSet, Graph, GraphSpec, Nodes, Roots, Skeleton};
use pliant::model::law::{FrameSpec, History, Law, Learned, LearnedSpec, View};
use pliant::model::net::{Aggregation, Precision, Sharing};
use pliant::state::{Constants, Part, Particles, Pose, Solid, SurfacePoint, ToolShape, Twist, Wall};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use std::sync::Arc;

pub(crate) const RADIUS: f64 = 0.02;
pub(crate) const INTERVAL: f64 = 0.1;
pub(crate) const SCALE: f64 = 0.004;

#[derive(Clone)]
pub(crate) struct Moment {
    pub(crate) particles: Particles,
    pub(crate) past: Vec<Vec<DVec3>>,
    pub(crate) body: Vec<u32>,
    pub(crate) constants: Constants,
    pub(crate) walls: Vec<Wall>,
    pub(crate) tool: ToolShape,
    pub(crate) poses: Vec<Pose>,
    pub(crate) twists: Vec<Twist>,
    pub(crate) skeleton: Arc<Skeleton>,
}

pub(crate) fn vector(rng: &mut ChaCha8Rng, size: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

impl Moment {
    pub(crate) fn random(count: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let positions = (0..count).map(|_| vector(&mut rng, 0.02) + DVec3::Z * 0.02).collect();
        let velocities = (0..count).map(|_| vector(&mut rng, 0.04)).collect();
        let mut part = || Part {
            solid: Solid::Cuboid { half: DVec3::splat(0.01) },
            surface: (0..12)
                .map(|_| SurfacePoint { position: vector(&mut rng, 0.015), normal: vector(&mut rng, 1.0).normalize() })
                .collect(),
        };
        let tool = ToolShape::from(vec![part(), part()]);
        let pose = |s: f64| Pose {
            translation: DVec3::new(0.01 * s, 0.003, 0.02),
            rotation: DQuat::from_scaled_axis(DVec3::new(0.4 * s, -0.3, 0.7)),
        };
        let twist =
            |s: f64| Twist { linear: DVec3::new(0.02, -0.03 * s, 0.01), angular: DVec3::new(1.0, 0.5, -0.7 * s) };
        Self {
            particles: Particles { positions, velocities },
            past: Vec::new(),
            body: vec![0; count],
            constants: Constants::new(),
            walls: Vec::new(),
            tool,
            poses: vec![pose(1.0), pose(-1.0)],
            twists: vec![twist(1.0), twist(-1.0)],
            skeleton: Arc::default(),
        }
    }

    /// The same under roots, `counts` of them from level to level.
    pub(crate) fn rooted(self, counts: &[usize]) -> Self {
        let all = (0..self.particles.len() as u32).collect();
        let roots = Roots::over(&self.particles.positions, &[all], counts);
        Self { skeleton: Arc::new(Skeleton { roots, ..Skeleton::default() }), ..self }
    }

    /// The same with every particle bonded to a few others wherever they are.
    pub(crate) fn bonded(self) -> Self {
        let count = self.particles.len() as u32;
        let senders = (0..count).flat_map(|i| [(i + 7) % count, (i + 11) % count]).collect();
        let bonds = EdgeSet { offsets: (0..=count).map(|i| 2 * i).collect(), senders };
        Self { skeleton: Arc::new(Skeleton { bonds, ..Skeleton::default() }), ..self }
    }

    /// The same with `count` velocities of the past.
    pub(crate) fn remembering(self, count: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(16);
        let mut rows = || self.particles.velocities.iter().map(|v| *v + vector(&mut rng, 0.02)).collect();
        Self { past: (0..count).map(|_| rows()).collect(), ..self }
    }

    /// The same between two walls, every third particle of another body.
    pub(crate) fn walled(self) -> Self {
        let wall = |normal: DVec3, offset| Wall { normal: normal.normalize(), offset };
        let walls = vec![wall(DVec3::new(1.0, 0.4, 0.2), -0.024), wall(DVec3::new(-0.3, -1.0, 0.0), -0.02)];
        Self { walls, body: (0..self.particles.len()).map(|i| u32::from(i % 3 == 0)).collect(), ..self }
    }

    /// A graph that reaches beyond the law, drawn anew wherever things stand.
    pub(crate) fn graph(&self) -> Graph {
        let policy = if self.skeleton.bonds.is_empty() { "hierarchy" } else { "fixed" };
        let own = EDGE_KINDS.iter().filter(|kind| kind.needs().is_none_or(|needs| needs == policy));
        let edges: Vec<&str> = own.map(|kind| kind.name()).collect();
        let mut spec = json!({ "kind": policy, "radius": 1.2 * RADIUS, "edges": edges });
        if policy == "hierarchy" {
            spec["roots"] = json!([]);
        }
        let policy = serde_json::from_value::<GraphSpec>(spec).unwrap().build().unwrap();
        policy.connect(Nodes::gather(
            &self.particles,
            &self.skeleton,
            &self.walls,
            &self.tool,
            &self.poses,
            &self.poses,
            INTERVAL,
        ))
    }

    pub(crate) fn view<'a>(&'a self, graph: &'a Graph) -> View<'a> {
        View {
            particles: &self.particles,
            past: &self.past,
            body: &self.body,
            walls: &self.walls,
            constants: &self.constants,
            graph,
            tool: &self.tool,
            poses: &self.poses,
            twists: &self.twists,
            history: History::NONE,
            interval: INTERVAL,
        }
    }

    pub(crate) fn acceleration(&self, law: &Learned) -> Vec<DVec3> {
        let graph = self.graph();
        let mut out = vec![DVec3::ZERO; self.particles.len()];
        law.accelerate(&self.view(&graph), &mut out);
        out
    }
}

/// Names of the first `count` kinds of edges; the first three need no roots.
pub(crate) fn kinds(count: usize) -> Vec<String> {
    EDGE_KINDS[..count].iter().map(|kind| kind.name().to_owned()).collect()
}

pub(crate) fn spec(width: usize) -> LearnedSpec {
    LearnedSpec {
        width,
        rounds: 2,
        sharing: Sharing::Shared,
        aggregation: Aggregation::Sum,
        history: 1,
        bodies: 1,
        constants: IndexMap::new(),
        edges: kinds(3),
        shared_edges: false,
        layer_norm: false,
        radius: RADIUS,
        scale: SCALE,
        frame: FrameSpec::default(),
        precision: Precision::default(),
        seed: 1,
        weights: None,
    }
}

/// A law that was shaken out of its zero start.
pub(crate) fn shaken(frame: FrameSpec) -> Learned {
    shake(LearnedSpec { frame, ..spec(16) })
}

pub(crate) fn shake(spec: LearnedSpec) -> Learned {
    let mut law = spec.build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let weights: Vec<f32> = law.weights().iter().map(|w| w + rng.random_range(-0.15..0.15)).collect();
    law.set_weights(&weights);
    law
}
