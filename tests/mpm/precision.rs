//! Single precision beside double: how near it comes, and what it must keep as exactly.
use super::problem::STEPS;
use super::*;

/// Most of the way moved that rounding may make, over the some hundred substeps of a rollout, each of which rounds by 6e-8.
const ROLLOUT: f64 = 3e-4;
/// Most of a gradient that it may make.
const GRADIENT: f64 = 3e-3;

fn single(spec: MpmSpec) -> MpmSpec {
    MpmSpec { precision: Precision::Single, ..spec }
}

/// Through contact, friction and flow: as shipped, and stiffer, heavier dough.
fn doughs() -> [MpmSpec; 2] {
    [shipped(), MpmSpec { density: 1.2e4, yield_stress: 30.0, viscosity: 1.0, gravity: 2.0, ..elastic() }]
}

fn gap(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>().sqrt()
}

#[test]
fn single_rollouts_and_gradients_are_those_of_double_to_its_rounding() {
    for spec in doughs() {
        let (scene, controls, cost) = problem::problem(&mut ChaCha8Rng::seed_from_u64(7));
        let models = [model(spec.clone()), model(single(spec))];
        let [double, other] = models.each_ref().map(|model| model.rollout(&scene, &controls));
        let start = &scene.particles.positions;
        let (moved, off) =
            (gap(&double[STEPS].positions, start), gap(&double[STEPS].positions, &other[STEPS].positions));
        assert!(moved > 0.02, "the tools moved the dough by {moved} only");
        assert!(off > 0.0 && off < ROLLOUT * moved, "{off} of {moved} m");
        let [double, other] = models.each_ref().map(|model| {
            let gradient = WorldModel::gradient(model, &scene, &controls, &cost).unwrap();
            let poses = gradient.controls.iter().flat_map(|control| &control.poses).chain(&gradient.scene.poses);
            let by_tool: Vec<DVec3> = poses.flat_map(|pose| [pose.translation, pose.rotation]).collect();
            let particles = gradient.scene.particles;
            [particles.positions, particles.velocities, by_tool]
        });
        for (a, b) in double.iter().zip(&other) {
            let (length, off) = (gap(a, &vec![DVec3::ZERO; a.len()]), gap(a, b));
            assert!(length > 0.1 && off > 0.0 && off < GRADIENT * length, "{off} of {length}");
        }
    }
}

#[test]
fn single_is_no_worse_far_from_the_origin() {
    let spec = single(shipped());
    // So far that f32 has places to a tenth of a cell.
    let cells = DVec3::new(1_048_576.0, -2_097_152.0, 0.0);
    let (scene, controls, _) = problem::problem(&mut ChaCha8Rng::seed_from_u64(7));
    let (mut far, mut far_controls) = (scene.clone(), controls.clone());
    let away = spec.cell * cells;
    far.particles.positions.iter_mut().for_each(|x| *x += away);
    let poses = far_controls.iter_mut().flat_map(|control| &mut control.poses).chain(&mut far.poses);
    poses.for_each(|pose| pose.translation += away);
    let model = model(spec);
    let [near, far] =
        [(&scene, &controls), (&far, &far_controls)].map(|(scene, controls)| model.rollout(scene, controls));
    let back: Vec<DVec3> = far[STEPS].positions.iter().map(|x| *x - away).collect();
    let moved = gap(&near[STEPS].positions, &scene.particles.positions);
    let off = gap(&near[STEPS].positions, &back);
    assert!(off < ROLLOUT * moved, "{off} of {moved} m");
}
