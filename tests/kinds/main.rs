//! The other kinds of learned model: what each promises, and what it refuses.
use glam::DVec3;
use pliant::model::{Cost, ModelSpec, WorldModel};
use pliant::state::{Control, Particles, Pose, Scene, ToolShape};
use problem::{STEPS, problem};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use specs::{PICTURE, read, shaken, specs};

#[path = "../gradient/problem.rs"]
mod problem;
mod specs;

const COUNT: usize = 48;
/// Side of a picture's cell in these tests [m].
const CELL: f64 = 0.008;

fn lump() -> (Scene, Vec<Control>, impl Cost) {
    problem(&mut ChaCha8Rng::seed_from_u64(3))
}

fn end(model: &dyn WorldModel, scene: &Scene, controls: &[Control]) -> Vec<DVec3> {
    model.rollout(scene, controls).pop().unwrap().positions
}

#[test]
fn untrained_nothing_moves_and_trained_the_tool_matters() {
    let (scene, controls, _) = lump();
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
    let (scene, controls, _) = lump();
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
fn a_shift_along_the_table_by_whole_blocks_of_cells_shifts_the_prediction() {
    let (scene, controls, _) = lump();
    // A convolution feels the picture's edge, from far away a little; four cells are one of the coarsest.
    let wide = PICTURE.replace("rows = 16, columns = 20", "rows = 48, columns = 48");
    let unet = read("kind = \"unet\"\nwidth = 4\ndepth = 2\nseed = 1", &wide);
    let [(_, linear), _, (_, latent), _] = specs();
    for (name, spec, bound) in [("linear", linear, 1e-4), ("latent", latent, 1e-4), ("unet", unet, 2e-2)] {
        let model = shaken(&spec);
        let shift = DVec3::new(4.0 * CELL, -4.0 * CELL, 0.0) / if name == "linear" { 4.0 } else { 1.0 };
        let moved = |poses: &[Pose]| -> Vec<Pose> {
            poses.iter().map(|p| Pose { translation: p.translation + shift, ..*p }).collect()
        };
        let mut there = Scene { poses: moved(&scene.poses), ..scene.clone() };
        there.particles.positions.iter_mut().for_each(|x| *x += shift);
        let steps: Vec<Control> = controls.iter().map(|c| Control { poses: moved(&c.poses) }).collect();
        let (one, other) = (end(&*model, &scene, &controls), end(&*model, &there, &steps));
        let error = one.iter().zip(&other).map(|(a, b)| (*a + shift).distance(*b)).fold(0.0, f64::max);
        let whole = one.iter().zip(&scene.particles.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(error < bound * whole, "{name}: {error} of {whole} m");
    }
}

#[test]
fn displacements_by_two_parts_add_up_in_the_linear_model_and_not_in_the_unet() {
    let (scene, controls, _) = lump();
    let moves = |model: &dyn WorldModel, parts: &[usize]| -> Vec<DVec3> {
        let pick = |poses: &[Pose]| parts.iter().map(|&part| poses[part]).collect();
        let tool = ToolShape::from(parts.iter().map(|&part| scene.tool.parts[part].clone()).collect::<Vec<_>>());
        let scene = Scene { tool: tool.into(), poses: pick(&scene.poses), ..scene.clone() };
        let rollout = model.rollout(&scene, &[Control { poses: pick(&controls[0].poses) }]);
        rollout[1].positions.iter().zip(&scene.particles.positions).map(|(a, b)| *a - *b).collect()
    };
    let excess = |spec: &ModelSpec| {
        let model = shaken(spec);
        let [both, one, other, none] = [&[0, 1][..], &[0], &[1], &[]].map(|parts| moves(&*model, parts));
        let rows = (0..COUNT).map(|i| (both[i] + none[i] - one[i] - other[i]).length() / both[i].length());
        rows.fold(0.0, f64::max)
    };
    let [(_, linear), (_, unet), ..] = specs();
    assert!(excess(&linear) < 1e-4, "{}", excess(&linear));
    assert!(excess(&unet) > 1e-2, "{}", excess(&unet));
}

#[test]
fn nothing_to_move_no_tool_and_a_tool_nowhere_are_each_what_they_are() {
    let (scene, controls, cost) = lump();
    for (name, spec) in specs() {
        let model = shaken(&spec);
        let empty = Scene { particles: Particles::default(), body: Vec::new().into(), ..scene.clone() };
        let nothing = model.weight_gradient(&empty, &controls, &cost).unwrap();
        assert!(nothing.weights.iter().all(|g| *g == 0.0), "{name}");
        let bare = Scene { tool: ToolShape::from(Vec::new()).into(), poses: Vec::new(), ..scene.clone() };
        let gradient = model.weight_gradient(&bare, &vec![Control::default(); STEPS], &cost).unwrap();
        assert!(gradient.cost.is_finite() && gradient.weights.iter().all(|g| g.is_finite()), "{name}");
        let mut lost = controls.clone();
        lost[0].poses[0].translation.x = f64::NAN;
        assert!(end(&*model, &scene, &lost).iter().all(|x| !x.is_finite()), "{name}: a tool nowhere goes unseen");
    }
}

#[test]
fn weights_survive_the_disk_and_another_architecture_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, controls, _) = lump();
    let asked =
        ["a filter 7 cells wide", "a U-Net of 7 channels", "networks of width 7", "width 7 for pictures of 320"];
    for ((name, spec), asked) in specs().into_iter().zip(asked) {
        let path = folder.path().join("w.safetensors");
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
        assert!(
            story.contains("w.safetensors") && story.contains("config asks for") && story.contains(asked),
            "{story}"
        );
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
        ("kind = \"linear\"\nwidth = 63\n", &PICTURE.replace("16, columns = 20", "999, columns = 999"), "too large"),
        (
            "kind = \"latent\"\ncode = 3\nwidth = 1024\nextent = 1.0\nscale = 1.0\nseed = 1\n",
            "[view]\nkind = \"picture\"\ntop = 0.01\ngrid = { cell = 0.01, rows = 999, columns = 999, height = 0.1, levels = 3 }",
            "too large",
        ),
        (
            "kind = \"unet\"\nwidth = 256\ndepth = 2\nseed = 1\n",
            &PICTURE.replace("16, columns = 20", "512, columns = 512"),
            "too large",
        ),
    ];
    for (head, tail, part) in refusals {
        let error = read(head, tail).build().err().expect("an impossible config").to_string();
        assert!(error.contains(part), "{error}");
    }
}
