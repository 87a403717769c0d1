//! The other kinds of learned model: exact derivatives through particles, tool and weights, and what each promises.
use glam::{DQuat, DVec3};
use pliant::model::{Cost, ModelSpec, WorldModel};
use pliant::state::{Control, Part, Particles, ParticlesGrad, Pose, Scene, Solid, SurfacePoint, ToolShape};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

mod difference;

const COUNT: usize = 60;
const STEPS: usize = 3;
/// Side of a picture's cell in these tests [m].
const CELL: f64 = 0.008;

fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
    2.0 * DVec3::from_array(rng.random::<[f64; 3]>()) - 1.0
}

const PICTURE: &str = "[picture]\ngrid = { cell = 0.008, rows = 16, columns = 20, height = 0.03, levels = 3 }\n\
                       top = 0.013\nreach = 0.02\nscale = 0.004\n";

/// One model of each kind, untrained.
fn specs() -> [(&'static str, ModelSpec); 3] {
    let read = |text: &str| toml_edit::de::from_str(text).unwrap();
    [
        ("linear", read(&format!("kind = \"linear\"\nwidth = 5\n{PICTURE}"))),
        ("unet", read(&format!("kind = \"unet\"\nwidth = 4\ndepth = 2\nseed = 1\n{PICTURE}"))),
        ("latent", read("kind = \"latent\"\ncode = 6\nwidth = 12\nextent = 0.04\nscale = 0.004\nseed = 1")),
    ]
}

/// The same out of its zero start.
fn shaken(spec: &ModelSpec) -> Box<dyn WorldModel> {
    let mut model = spec.clone().build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let weights: Vec<f32> = model.weights().iter().map(|w| w + rng.random_range(-0.1..0.1)).collect();
    model.set_weights(&weights);
    model
}

/// A flat lump under a tilted press that comes down and a rod that rolls in from the side.
fn problem() -> (Scene, Vec<Control>) {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut spread = |half: f64| half * vector(&mut rng);
    let positions = (0..COUNT).map(|_| DVec3::new(0.03, 0.02, 0.01) * (spread(1.0) + DVec3::Z)).collect();
    let velocities = (0..COUNT).map(|_| spread(0.02)).collect();
    let sample = |normal: DVec3, size: DVec3| SurfacePoint { position: normal * size, normal };
    let faces =
        |size: DVec3| [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::NEG_Z].map(|n| sample(n, size)).to_vec();
    let (half, rod) = (DVec3::new(0.016, 0.013, 0.006), DVec3::new(0.006, 0.03, 0.006));
    let tool = ToolShape::from(vec![
        Part { solid: Solid::Cuboid { half }, surface: faces(half) },
        Part { solid: Solid::Cylinder { radius: 0.006, half_length: 0.03 }, surface: faces(rod) },
    ]);
    let poses = |t: f64| {
        let (turn, roll) = (DVec3::new(0.15 - 0.1 * t, 0.1, 0.5 * t), DVec3::new(0.1 * t, 2.0 * t, 0.3));
        let (down, in_) =
            (DVec3::new(0.002 * t, 0.001, 0.033 - 0.012 * t), DVec3::new(-0.028 + 0.009 * t, 0.0, 0.0095));
        let pose = |translation, turn| Pose { translation, rotation: DQuat::from_scaled_axis(turn) };
        vec![pose(down, turn), pose(in_, roll)]
    };
    let controls = (1..=STEPS).map(|t| Control { poses: poses(t as f64 / STEPS as f64) }).collect();
    (Scene::open(Particles { positions, velocities }, tool.into(), poses(0.0), 0.1), controls)
}

/// `J = Σₜ Σᵢ aᵢ·x + bᵢ·v/10`, different at every step.
struct Mixed(Vec<Vec<[DVec3; 2]>>);

impl Mixed {
    fn random() -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        Self((0..=STEPS).map(|_| (0..COUNT).map(|_| [vector(&mut rng), vector(&mut rng)]).collect()).collect())
    }
}

impl Cost for Mixed {
    fn at(&self, t: usize, _: usize, x: &Particles) -> f64 {
        let rows = x.positions.iter().zip(&x.velocities).zip(&self.0[t]);
        rows.map(|((x, v), [a, b])| a.dot(*x) + 0.1 * b.dot(*v)).sum()
    }
    fn gradient(&self, t: usize, _: usize, _: &Particles) -> ParticlesGrad {
        ParticlesGrad {
            positions: self.0[t].iter().map(|[a, _]| *a).collect(),
            velocities: self.0[t].iter().map(|[_, b]| 0.1 * *b).collect(),
        }
    }
}

fn end(model: &dyn WorldModel, scene: &Scene, controls: &[Control]) -> Vec<DVec3> {
    model.rollout(scene, controls).pop().unwrap().positions
}

#[test]
fn untrained_nothing_moves_and_trained_the_tool_matters() {
    let (scene, controls) = problem();
    let still: Vec<Control> = controls.iter().map(|_| Control { poses: scene.poses.clone() }).collect();
    for (name, spec) in specs() {
        let untrained = spec.clone().build().unwrap();
        assert_eq!(end(&*untrained, &scene, &controls), scene.particles.positions, "{name}");
        let model = shaken(&spec);
        let rollout = model.rollout(&scene, &controls);
        assert_eq!(rollout[0], scene.particles, "{name}: a rollout starts at the scene");
        let pairs = rollout[STEPS].positions.iter().zip(&rollout[STEPS - 1].positions).zip(&rollout[STEPS].velocities);
        for ((now, before), velocity) in pairs {
            assert!((*now - *before - 0.1 * *velocity).length() < 1e-12, "{name}: velocity is the backward difference");
        }
        let apart = rollout[STEPS].positions.iter().zip(end(&*model, &scene, &still)).filter(|(a, b)| **a != *b);
        assert!(apart.count() > COUNT / 2, "{name}: the tool does not matter");
    }
}

#[test]
fn relabelling_relabels_the_prediction_bit_for_bit() {
    let (scene, controls) = problem();
    let order: Vec<usize> = (0..COUNT).map(|i| (i * 17 + 5) % COUNT).collect();
    let mut relabelled = scene.clone();
    relabelled.particles = Particles {
        positions: order.iter().map(|&i| scene.particles.positions[i]).collect(),
        velocities: order.iter().map(|&i| scene.particles.velocities[i]).collect(),
    };
    for (name, spec) in specs() {
        let model = shaken(&spec);
        let (one, other) = (end(&*model, &scene, &controls), end(&*model, &relabelled, &controls));
        assert!(order.iter().zip(&other).all(|(&i, x)| one[i] == *x), "{name}");
    }
}

#[test]
fn a_shift_along_the_table_shifts_the_prediction() {
    let (scene, controls) = problem();
    for (name, spec) in specs() {
        let model = shaken(&spec);
        // A picture has cells and an edge: it is shifted by whole cells and where the edge is not felt.
        for shift in [DVec3::new(CELL, -2.0 * CELL, 0.0), DVec3::new(0.0031, 0.0017, 0.0)] {
            let moved = |poses: &[Pose]| -> Vec<Pose> {
                poses.iter().map(|p| Pose { translation: p.translation + shift, ..*p }).collect()
            };
            let mut there = Scene { poses: moved(&scene.poses), ..scene.clone() };
            there.particles.positions.iter_mut().for_each(|x| *x += shift);
            let steps: Vec<Control> = controls.iter().map(|c| Control { poses: moved(&c.poses) }).collect();
            let (one, other) = (end(&*model, &scene, &controls), end(&*model, &there, &steps));
            let error = one.iter().zip(&other).map(|(a, b)| (*a + shift).distance(*b)).fold(0.0, f64::max);
            let whole = one.iter().zip(&scene.particles.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            let exact = name == "latent" || (name == "linear" && shift.x == CELL);
            assert!(error < if exact { 1e-4 * whole } else { 0.6 * whole }, "{name}: {error} of {whole} m at {shift}");
        }
    }
}

#[test]
fn the_linear_model_moves_two_lumps_as_it_moves_each_under_the_same_tool() {
    let (scene, controls) = problem();
    let mut model = specs()[0].1.clone().build().unwrap();
    // With nothing read from the height map, transport is linear in what lies on the table.
    let mut weights = shaken(&specs()[0].1).weights();
    let inputs = 1 + 4 * 3;
    for (row, outputs) in weights.chunks_exact_mut(9).enumerate() {
        if row % inputs == 0 {
            outputs.fill(0.0);
        }
    }
    model.set_weights(&weights);
    let part = |range: std::ops::Range<usize>| {
        let own = |rows: &[DVec3]| rows[range.clone()].to_vec();
        let Particles { positions, velocities } = &scene.particles;
        let particles = Particles { positions: own(positions), velocities: own(velocities) };
        Scene { body: vec![0; particles.len()].into(), particles, ..scene.clone() }
    };
    let half = COUNT / 2;
    let parts = [part(0..half), part(half..COUNT)].map(|scene| end(&*model, &scene, &controls));
    assert_eq!(end(&*model, &scene, &controls), parts.concat());
    assert_ne!(parts.concat(), scene.particles.positions);
}

#[test]
fn weights_survive_the_disk_and_another_architecture_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, controls) = problem();
    for (name, spec) in specs() {
        let path = folder.path().join(name);
        let model = shaken(&spec);
        model.save_weights(&path).unwrap();
        let with = |change: &[(&str, serde_json::Value)]| {
            let mut json = serde_json::to_value(&spec).unwrap();
            json["weights"] = serde_json::json!(path);
            change.iter().for_each(|(key, value)| json[key] = value.clone());
            serde_json::from_value::<ModelSpec>(json).unwrap().build()
        };
        assert_eq!(end(&*with(&[]).unwrap(), &scene, &controls), end(&*model, &scene, &controls), "{name}");
        let error = with(&[("width", 7.into())]).err().expect("another width does not fit");
        let story = format!("{error:#}");
        assert!(story.contains(name) && story.contains("config asks for") && story.contains('7'), "{story}");
    }
}

#[test]
fn impossible_configs_are_sentences() {
    let refusals = [
        ("kind = \"linear\"\nwidth = 4\n", PICTURE, "odd"),
        ("kind = \"unet\"\nwidth = 4\ndepth = 3\nseed = 1\n", PICTURE, "halved"),
        ("kind = \"latent\"\ncode = 0\nwidth = 4\nextent = 1.0\nscale = 1.0\nseed = 1\n", "", "code"),
        ("kind = \"latent\"\ncode = 3\nwidth = 4\nextent = 0.0\nscale = 1.0\nseed = 1\n", "", "extent"),
        ("kind = \"linear\"\nwidth = 3\n", &PICTURE.replace("reach = 0.02", "reach = -1.0"), "picture.reach"),
        ("kind = \"linear\"\nwidth = 3\n", &PICTURE.replace("levels = 3", "levels = 1"), "grid.levels"),
    ];
    for (head, tail, part) in refusals {
        let spec: ModelSpec = toml_edit::de::from_str(&format!("{head}{tail}")).unwrap();
        let error = spec.build().err().expect("an impossible config").to_string();
        assert!(error.contains(part), "{error}");
    }
}
