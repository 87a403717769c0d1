//! Laws written as formulas: the same accelerations and gradients as the laws written in Rust, whatever a particle meets.
use glam::{DQuat, DVec3};
use pliant::graph::{EDGE_KINDS, EdgeSet, Graph};
use pliant::model::ModelSpec;
use pliant::model::law::{History, Law, LawSpec, View, ViewGrad};
use pliant::model::particles::ParticlesSpec;
use pliant::state::{Constants, Part, Particles, ParticlesGrad, Pose, PoseGrad, Solid, ToolShape, Twist};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

mod kinds;
mod refusal;
mod shipped;

#[derive(Deserialize)]
struct Contender {
    dynamics: ModelSpec,
}

fn spec(name: &str) -> ParticlesSpec {
    let path = format!("{}/configs/model/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let ModelSpec::Particles(spec) = toml_edit::de::from_str::<Contender>(&text).unwrap().dynamics else {
        panic!("{name} is a particle model");
    };
    spec
}

fn law(text: &str) -> Box<dyn Law> {
    toml_edit::de::from_str::<LawSpec>(text).unwrap().build().unwrap()
}

fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
    2.0 * DVec3::from_array(rng.random::<[f64; 3]>()) - 1.0
}

/// A lump of particles on the table, some at rest, under a tilted board and a rod that move.
struct Bench {
    particles: Particles,
    graph: Graph,
    tool: ToolShape,
    poses: Vec<Pose>,
    twists: Vec<Twist>,
    constants: Constants,
}

impl Bench {
    fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let place = |n: usize| DVec3::new((n % 5) as f64 - 2.0, (n / 5 % 5) as f64 - 2.0, (n / 25) as f64 + 0.2);
        let positions: Vec<DVec3> = (0..75).map(|n| 0.0105 * place(n) + 0.002 * vector(&mut rng)).collect();
        let velocity = |n: usize| if n.is_multiple_of(4) { DVec3::ZERO } else { 0.3 * vector(&mut rng) };
        let velocities = (0..75).map(velocity).collect();
        let mut set = EdgeSet { offsets: vec![0], senders: Vec::new() };
        for i in 0..75u32 {
            set.senders.extend(i + 1..75);
            set.offsets.push(set.senders.len() as u32);
        }
        let mut edges = vec![EdgeSet { offsets: vec![0; 76], senders: Vec::new() }; EDGE_KINDS.len()];
        edges[0] = set;
        let part = |solid| Part { solid, surface: Vec::new() };
        let board = Solid::Cuboid { half: DVec3::new(0.02, 0.02, 0.006) };
        let rod = Solid::Cylinder { radius: 0.006, half_length: 0.03 };
        let pose =
            |x, z, turn: DVec3| Pose { translation: DVec3::new(x, 0.001, z), rotation: DQuat::from_scaled_axis(turn) };
        Self {
            particles: Particles { positions, velocities },
            graph: Graph { edges, ..Graph::default() },
            tool: ToolShape::from(vec![part(board), part(rod)]),
            poses: vec![pose(0.0, 0.03, DVec3::new(0.1, -0.1, 0.4)), pose(-0.024, 0.009, DVec3::new(0.0, 2.0, 0.3))],
            twists: (0..2).map(|_| Twist { linear: 0.2 * vector(&mut rng), angular: 3.0 * vector(&mut rng) }).collect(),
            constants: Constants::new(),
        }
    }

    fn view(&self) -> View<'_> {
        let Self { particles, graph, tool, poses, twists, constants } = self;
        View {
            particles,
            past: &[],
            body: &[],
            walls: &[],
            constants,
            graph,
            tool,
            poses,
            twists,
            interval: 0.1,
            history: History::NONE,
        }
    }

    fn accelerations(&self, law: &dyn Law) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; self.particles.len()];
        law.accelerate(&self.view(), &mut out);
        out
    }

    /// All parts of the gradient of `Σ at·a`, as rows.
    fn gradient(&self, law: &dyn Law, at: &[DVec3]) -> Vec<DVec3> {
        let mut grad = ViewGrad {
            particles: ParticlesGrad::zero(self.particles.len()),
            poses: vec![PoseGrad::default(); 2],
            twists: vec![Twist::default(); 2],
            past: Vec::new(),
            history: Vec::new(),
            weights: &mut [],
        };
        law.accelerate_vjp(&self.view(), at, &mut grad);
        let tool = grad.poses.iter().flat_map(|p| [p.translation, p.rotation]);
        let moves = grad.twists.iter().flat_map(|t| [t.linear, t.angular]);
        let particles = grad.particles.positions.iter().chain(&grad.particles.velocities).copied();
        particles.chain(tool).chain(moves).collect()
    }
}

fn close(a: &[DVec3], b: &[DVec3], tolerance: f64, what: &str) {
    let largest = a.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    assert!(largest > 0.0, "{what}: nothing is zero by chance");
    for (a, b) in a.iter().zip(b) {
        assert!((*a - *b).abs().max_element() <= tolerance * largest, "{what}: {a} and {b}, of at most {largest}");
    }
}

/// A law in formulas.
fn formula(text: &str) -> Box<dyn Law> {
    law(&format!("kind = \"formula\"\n{text}"))
}
