//! What a rollout does not depend on: the others of its batch, and, in the weights that make it, the number of particles.
use pliant::compare::{CompareSpec, ContenderSpec};
use pliant::config;
use pliant::model::WorldModel;
use pliant::state::{Scene, stream};
use pliant::tool::{Motion, Workpiece};
use pliant::world::World;
use rand::Rng;

const STEPS: usize = 3;

/// A part of the quickstart's dough that this many particles stand for, and motions of a press on it.
fn pressed(particles: usize) -> (Scene, Vec<Motion>) {
    let changes = ["start.x=[0.05,0.07]", "start.y=[0.05,0.07]", "start.z=[0.025,0.035]"].map(str::to_owned);
    let changes = [format!("particles={particles}")].into_iter().chain(changes);
    let changes: Vec<String> = changes.map(|change| format!("dataset.scene.{change}")).collect();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/compare/quickstart.toml");
    let spec = config::load::<CompareSpec>(path.as_ref(), &changes).unwrap().spec;
    let world = World::new(&spec.dataset.scene, 3).unwrap();
    let tool = spec.dataset.tool["press_square"].clone().build().unwrap();
    let piece = Workpiece::around(&world.particles());
    let theta = |k: usize| tool.space(&piece).at(&[0.3 + 0.1 * k as f64, 0.6 - 0.05 * k as f64, 0.1, 0.7]);
    let motions: Vec<Motion> = (0..5).map(|k| tool.motion(&theta(k), &piece, STEPS)).collect();
    (world.scene(tool.shape(), &motions[0].start), motions)
}

/// Every model of the configs that can start from `scene`, out of a zero start where it has weights, by its file's name.
fn models(scene: &Scene) -> Vec<(String, Box<dyn WorldModel>)> {
    let mut files: Vec<_> = std::fs::read_dir("configs/model").unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let built = files.iter().map(|file| {
        let mut model = config::load::<ContenderSpec>(file, &[]).unwrap().spec.dynamics.build().unwrap();
        let mut rng = stream(5, &[1]);
        let weights: Vec<f32> = model.weights().iter().map(|w| w + 0.05 * (rng.random::<f32>() - 0.5)).collect();
        model.set_weights(&weights);
        (file.file_stem().unwrap().to_string_lossy().into_owned(), model)
    });
    built.filter(|(_, model)| model.accepts(scene).is_ok()).collect()
}

#[test]
fn a_rollout_in_a_batch_is_the_one_alone_bit_for_bit() {
    let (scene, motions) = pressed(80);
    let models = models(&scene);
    for name in ["learned", "learned_roots", "fluid", "hybrid", "latent", "linear", "unet", "oracle"] {
        assert!(models.iter().any(|(known, _)| known == name), "{name} cannot start from the scene");
    }
    for (name, model) in models {
        let together = model.rollouts(&scene, &motions);
        assert_eq!(together.len(), motions.len(), "{name}");
        for (motion, rollout) in motions.iter().zip(&together) {
            let start = Scene { poses: motion.start.clone(), ..scene.clone() };
            assert!(model.rollout(&start, &motion.controls) == *rollout, "{name}");
        }
        assert!(
            name == "still" || together.iter().all(|rollout| rollout[0] != rollout[STEPS]),
            "{name}: nothing moved"
        );
        // In a bath there is no tool to tell motions by.
        let blind = name == "still" || name.starts_with("bath");
        assert!(blind || (1..5).all(|k| together[k] != together[0]), "{name}: the motions are one");
    }
}

#[test]
fn the_same_weights_roll_out_any_number_of_particles() {
    let sizes = [40, 110].map(pressed);
    let models = models(&sizes[0].0).into_iter().filter(|(_, model)| !model.weights().is_empty());
    let mut seen = 0;
    for (name, model) in models {
        let weights = model.weights();
        for (scene, motions) in &sizes {
            let rollout = model.rollout(scene, &motions[0].controls);
            let whole = rollout.iter().all(|x| x.len() == scene.particles.len() && x.is_finite());
            assert!(whole && rollout[0] != rollout[STEPS], "{name} of {} particles", scene.particles.len());
            assert!(model.weights() == weights, "{name}");
        }
        seen += 1;
    }
    assert_ne!(sizes[0].0.particles.len(), sizes[1].0.particles.len());
    assert!(seen > 8, "only {seen} models have weights");
}
