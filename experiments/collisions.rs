//! Clouds of particles that fly through each other under a law that is known.
use glam::DVec3;
use pliant::data::Episode;
use pliant::model::law::formula::{FormulaSpec, Programs};
use pliant::model::law::{LawSpec, Message};
use pliant::model::particles::ParticlesSpec;
use pliant::model::{ModelSpec, WorldModel};
use pliant::state::{Control, Particles, stream};
use pliant::train::{Split, Tools};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::{Value, json};
use std::sync::Arc;

/// Distance beyond which no particle acts on another \[m\].
pub(crate) const REACH: f64 = 0.016;
/// Duration of a control step \[s\], and its substeps.
const INTERVAL: f64 = 0.005;
const SUBSTEPS: usize = 2;
/// Particles along an edge of the cloud, their spacing, and how far they are off it \[m\].
const SIDE: usize = 3;
const SPACING: f64 = 0.0095;
const OFF: f64 = 0.0012;
/// Standard deviation of a component of their velocity \[m/s\].
const SPEED: f64 = 0.05;
const STEPS: usize = 6;

/// The laws: contact of spheres with damping (Hertz 1882; Hunt & Crossley 1975), alone and with smooth Coulomb friction.
pub(crate) fn laws() -> [(&'static str, Value); 2] {
    let normal = "stiffness * max(0, diameter - r)^1.5 * (1 - damping*vn)";
    let constants = json!({ "stiffness": 5e4, "diameter": 0.0116, "damping": 2.0 });
    let contact = json!({ "kind": "formula", "between": "particles", "reach": REACH, "normal_force": normal, "constants": constants });
    let mut rough = contact.clone();
    rough["tangential_force"] = json!("-friction * normal * vt / sqrt(vt^2 + slip^2)");
    rough["constants"]["friction"] = json!(0.3);
    rough["constants"]["slip"] = json!(0.05);
    [("contact", contact), ("contact, friction", rough)]
}

/// Particles under nothing but `law`.
pub(crate) fn model(law: &Value) -> anyhow::Result<ModelSpec> {
    let laws: Vec<LawSpec> = vec![serde_json::from_value(law.clone())?];
    let spec = json!({ "kind": "particles", "substeps": SUBSTEPS, "keep": 1.0 });
    let ModelSpec::Particles(spec) = serde_json::from_value(spec)? else { unreachable!("it says which kind it is") };
    Ok(ModelSpec::Particles(ParticlesSpec { laws, ..spec }))
}

/// What clouds do under a law, so many to learn from and so many held out.
pub(crate) fn episodes(law: &Value, [train, held_out]: [u64; 2], seed: u64) -> anyhow::Result<Split> {
    let model = model(law)?.build()?;
    let all = |part: u64, count: u64| {
        let rng = |k: u64| stream(seed, &[u64::from_le_bytes(*b"collides"), part, k]);
        (0..count).map(|k| episode(&*model, &mut rng(k))).collect()
    };
    let tools: Tools = [(String::new(), Arc::new(Vec::new().into()))].into_iter().collect();
    Ok(Split { train: all(0, train), held_out: all(1, held_out), tools })
}

fn episode(model: &dyn WorldModel, rng: &mut ChaCha8Rng) -> Episode {
    let mut about = |deviation: f64| {
        let mut component = || {
            let n: f64 = StandardNormal.sample(rng);
            deviation * n
        };
        DVec3::new(component(), component(), component())
    };
    let places = (0..SIDE.pow(3)).map(|k| [k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE]);
    let places: Vec<DVec3> = places.map(|at| SPACING * DVec3::from_array(at.map(|n| n as f64))).collect();
    let positions: Vec<DVec3> = places.iter().map(|at| *at + about(OFF)).collect();
    let velocities = places.iter().map(|_| about(SPEED)).collect();
    let (count, start) = (positions.len(), Particles { positions, velocities });
    let mut episode = Episode {
        tool: String::new(),
        theta: Vec::new(),
        interval: INTERVAL,
        start: Vec::new(),
        controls: vec![Control { poses: Vec::new() }; STEPS],
        states: vec![start],
        body: vec![0; count].into(),
        walls: Arc::default(),
        constants: Arc::default(),
    };
    episode.states = model.rollout(&episode.scene(0, &Arc::new(Vec::new().into())), &episode.controls);
    episode
}

/// What a law of formulas says where messages were heard.
pub(crate) fn said(law: &FormulaSpec, heard: &[Message]) -> anyhow::Result<Vec<Message>> {
    let meetings: Vec<[f64; 3]> = heard.iter().map(|m| [m.distance, m.separating, m.sliding]).collect();
    let forces = Programs::new(law)?.forces(&meetings);
    let with = |(m, [normal, tangential]): (&Message, [f64; 2])| Message { normal, tangential, ..*m };
    Ok(heard.iter().zip(forces).map(with).collect())
}

/// `√(Σ |f − f*|²/Σ |f*|²)` of forces f where they should be f*.
pub(crate) fn error(found: &[Message], truth: &[Message]) -> f64 {
    let gaps = found.iter().zip(truth);
    let gaps = gaps.map(|(f, y)| (f.normal - y.normal).powi(2) + (f.tangential - y.tangential).powi(2)).sum::<f64>();
    (gaps / truth.iter().map(|y| y.normal.powi(2) + y.tangential.powi(2)).sum::<f64>()).sqrt()
}
