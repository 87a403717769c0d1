//! The projection onto what physics allows: what it does, that it is the nearest, and its derivative.
use super::direction::Direction;
use super::hybrids::corrected;
use super::problem::vector;
use super::*;
use pliant::model::correction::Correction;
use pliant::model::correction::projection::ProjectedSpec;
use rand::Rng;

const SPEC: ProjectedSpec =
    ProjectedSpec { clearance: 0.003, diameter: 0.0098, bond: 0.012, stretch: 0.05, limit: 0.02 };

fn projection(spec: &ProjectedSpec) -> Vec<Box<dyn Correction>> {
    vec![Box::new(spec.clone().build().unwrap())]
}

/// Particles that fly straight for one control step, and are then projected.
fn flown(spec: Option<&ProjectedSpec>, scene: &Scene) -> Particles {
    let model = ParticleModel::new(1, 1.0, None, Vec::new()).unwrap();
    let model = model.corrected(spec.map(projection).unwrap_or_default()).unwrap();
    model.rollout(scene, &[Control { poses: scene.poses.clone() }]).pop().unwrap()
}

fn plate(z: f64, positions: Vec<DVec3>, velocities: Vec<DVec3>) -> Scene {
    let part = Part { solid: Solid::Cuboid { half: DVec3::new(0.1, 0.1, 0.01) }, surface: Vec::new() };
    let poses = vec![Pose { translation: DVec3::Z * (z + 0.01), ..Pose::default() }];
    Scene::open(Particles { positions, velocities }, Arc::new(ToolShape::from(vec![part])), poses, 0.1)
}

/// A lump that flies together, down into the table and up into a plate, and apart.
fn crowd(rng: &mut ChaCha8Rng) -> Scene {
    let place = |n: usize| DVec3::new((n % 4) as f64 - 1.5, (n / 4 % 4) as f64 - 1.5, (n / 16) as f64 + 0.4);
    let positions: Vec<DVec3> = (0..48).map(|n| 0.0105 * place(n) + 0.0005 * vector(rng)).collect();
    let velocities = positions.iter().map(|_| 0.03 * vector(rng)).collect();
    plate(0.0302, positions, velocities)
}

fn worst(spec: &ProjectedSpec, start: &Scene, x: &[DVec3]) -> [f64; 4] {
    let floor = x.iter().map(|x| spec.clearance - x.z).fold(f64::MIN, f64::max);
    let plate = start.poses[0].translation.z - 0.01;
    let tool = x.iter().map(|x| spec.clearance - (plate - x.z)).fold(f64::MIN, f64::max);
    let (mut near, mut far) = (f64::MIN, f64::MIN);
    for i in 0..x.len() {
        for j in 0..i {
            let before = start.particles.positions[i].distance(start.particles.positions[j]);
            near = near.max(spec.diameter - x[i].distance(x[j]));
            if before < spec.bond {
                far = far.max(x[i].distance(x[j]) - (1.0 + spec.stretch) * before.max(spec.diameter));
            }
        }
    }
    [floor, tool, near, far]
}

#[test]
fn what_is_allowed_stays_bit_for_bit_and_what_is_not_becomes_so_once_and_for_all() {
    let start = crowd(&mut ChaCha8Rng::seed_from_u64(1));
    let free = flown(None, &start);
    let violated = worst(&SPEC, &start, &free.positions);
    assert!(violated.iter().all(|w| *w > 1e-4), "every kind of constraint is violated: {violated:?}");
    let once = flown(Some(&SPEC), &start);
    let left = worst(&SPEC, &start, &once.positions);
    assert!(left.iter().all(|w| *w < 1e-7), "{left:?}");
    for (v, (to, from)) in once.velocities.iter().zip(once.positions.iter().zip(&start.particles.positions)) {
        assert!(v.distance((*to - *from) / 0.1) < 1e-12, "it flew straight to where it is");
    }
    let again = Scene { particles: Particles::at_rest(once.positions.clone()), ..start.clone() };
    assert_eq!(flown(Some(&SPEC), &again).positions, once.positions);
    let wide = ProjectedSpec { clearance: -0.01, diameter: 1e-3, bond: 0.0, ..SPEC };
    assert_eq!(flown(Some(&wide), &start), free);
}

#[test]
fn the_result_is_the_nearest_that_is_allowed() {
    let crowd = crowd(&mut ChaCha8Rng::seed_from_u64(2));
    let start = plate(0.3, crowd.particles.positions, crowd.particles.velocities);
    let spec = ProjectedSpec { bond: 0.0, limit: 0.1, ..SPEC };
    let (free, found) = (flown(None, &start).positions, flown(Some(&spec), &start).positions);
    let moved: f64 = free.iter().zip(&found).map(|(a, b)| a.distance(*b)).sum();
    assert!(moved > 1e-2, "{moved}");
    // The constraints as they are linearised: a convex set, whose nearest point x to x̂ has (x̂ − x)·(z − x) ≤ 0 for all z in it.
    let allowed = |z: &[DVec3]| {
        let apart = |i: usize, j: usize| (free[i] - free[j]).normalize().dot(z[i] - z[j]) >= spec.diameter;
        z.iter().all(|z| z.z >= spec.clearance) && (0..48).all(|i| (0..i).all(|j| apart(i, j)))
    };
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut seen = 0;
    for _ in 0..400 {
        let (grow, shake) = (1.0 + rng.random::<f64>().powi(3), 0.002 * rng.random::<f64>().powi(3));
        let shift = DVec3::new(1.0, 1.0, 0.5) * 0.01 * vector(&mut rng) + DVec3::Z * 0.005;
        let z: Vec<DVec3> = found.iter().map(|x| grow * *x + shift + shake * vector(&mut rng)).collect();
        if allowed(&z) {
            seen += 1;
            let work: f64 = (0..48).map(|i| (free[i] - found[i]).dot(z[i] - found[i])).sum();
            assert!(work < 1e-9, "moving on toward an allowed place would have been nearer: {work}");
        }
    }
    assert!(seen > 20, "only {seen} places were allowed");
}

#[test]
fn one_particle_and_two_go_where_geometry_says() {
    let spec = ProjectedSpec { clearance: 0.002, diameter: 0.01, bond: 0.03, stretch: 0.1, limit: 0.05 };
    let end = |positions: Vec<DVec3>, velocities: Vec<DVec3>| flown(Some(&spec), &plate(0.2, positions, velocities));
    let close = |a: DVec3, b: DVec3| assert!(a.distance(b) < 1e-9, "{a} against {b}");
    let fallen = end(vec![DVec3::new(0.01, 0.02, 0.01)], vec![DVec3::new(0.1, 0.0, -0.3)]);
    close(fallen.positions[0], DVec3::new(0.02, 0.02, 0.002));
    let high = DVec3::Z * 0.05;
    let met = end(vec![high, high + DVec3::X * 0.02], vec![DVec3::X * 0.1, DVec3::X * -0.05]);
    close(met.positions[0], high + DVec3::X * (0.0125 - 0.005));
    close(met.positions[1], high + DVec3::X * (0.0125 + 0.005));
    let parted = end(vec![high, high + DVec3::X * 0.02], vec![DVec3::Y * -0.2, DVec3::Y * 0.2]);
    let along = DVec3::new(0.02, 0.04, 0.0).normalize() * 0.011;
    close(parted.positions[0], high + DVec3::X * 0.01 - along);
    close(parted.positions[1], high + DVec3::X * 0.01 + along);
    // A gap of 1 mm cannot hold a clearance of 2 mm on either side: both give way alike.
    let squeezed = flown(Some(&spec), &plate(0.001, vec![DVec3::Z * 0.0007], vec![DVec3::ZERO]));
    assert!(squeezed.is_finite() && (0.0..0.001).contains(&squeezed.positions[0].z), "{squeezed:?}");
}

/// Each kind alone, and all together.
fn kinds() -> [(&'static str, ProjectedSpec); 4] {
    let none = ProjectedSpec { clearance: -0.015, diameter: 1e-3, bond: 0.0, ..SPEC };
    [
        ("clearance", ProjectedSpec { clearance: SPEC.clearance, ..none.clone() }),
        ("diameter", ProjectedSpec { diameter: 0.011, ..none.clone() }),
        ("stretch", ProjectedSpec { bond: SPEC.bond, ..none.clone() }),
        ("all", ProjectedSpec { diameter: 0.0101, stretch: 0.1, ..SPEC }),
    ]
}

#[test]
fn the_gradient_through_the_projection_agrees_with_central_differences() {
    // One step of free flight, then rollouts under the analytical laws.
    for (name, spec) in kinds() {
        let flight =
            |corrections| ParticleModel::new(1, 1.0, None, Vec::new()).unwrap().corrected(corrections).unwrap();
        differ(name, [&flight(projection(&spec)), &flight(Vec::new())], (1, 0.03), &[1e-6, 3e-7, 1e-7], 1e-4);
        // Contacts that close bend the cost, so steps are shorter. Where hundreds of constraints of all kinds contradict each other
        // nearly, five times over, what the solver leaves shows in differences.
        let (lengths, tolerance) = if name == "all" { (&[1e-7][..], 2e-3) } else { (&[1e-8, 1e-9][..], 1e-4) };
        let models = [&corrected(projection(&spec)), &corrected(Vec::new())];
        differ(name, models, (STEPS, 0.0), lengths, tolerance);
    }
}

/// Compares `steps` steps of `model` with differences, and with a model without the projection.
fn differ(
    name: &str,
    [model, free]: [&ParticleModel; 2],
    (steps, speed): (usize, f64),
    lengths: &[f64],
    tolerance: f64,
) {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut scene, mut controls, mut cost) = problem(&mut rng);
    scene.particles.velocities.iter_mut().for_each(|v| *v += speed * vector(&mut rng));
    controls.truncate(steps);
    cost.0.truncate(steps + 1);
    let problem = (scene, controls, cost);
    let gradient = model.gradient(&problem.0, &problem.1, &problem.2).unwrap();
    assert!(gradient.cost != free.gradient(&problem.0, &problem.1, &problem.2).unwrap().cost, "{name} does nothing");
    let trials: Vec<(f64, Vec<f64>)> = (0..8)
        .map(|k| {
            let part = |only: usize| if k % 4 == only || k % 4 == 3 { 1.0 } else { 0.0 };
            let direction = Direction::random(&mut rng, part(0), part(1), part(2));
            let cost = |h: f64| direction.cost(model, &problem, h);
            (direction.along(&gradient), lengths.iter().map(|&h| (cost(h) - cost(-h)) / (2.0 * h)).collect())
        })
        .collect();
    let typical = (trials.iter().map(|(_, d)| d[0] * d[0]).sum::<f64>() / trials.len() as f64).sqrt();
    assert!(typical > 0.1, "{name}: derivatives of about {typical} show nothing");
    for (exact, differences) in trials {
        let error = |d: f64| (exact - d).abs() / d.abs().max(typical);
        let best = differences.iter().map(|d| error(*d)).fold(f64::MAX, f64::min);
        assert!(best <= tolerance, "{name}, {steps} steps: {exact} against {differences:?}");
    }
}

#[test]
fn impossible_projections_are_sentences_that_name_the_key() {
    let refused = |spec: ProjectedSpec| spec.build().err().expect("an impossible projection").to_string();
    assert!(refused(ProjectedSpec { diameter: 0.0, ..SPEC }).contains("diameter"));
    assert!(refused(ProjectedSpec { limit: f64::NAN, ..SPEC }).contains("limit"));
    assert!(refused(ProjectedSpec { stretch: -0.1, ..SPEC }).contains("stretch"));
    assert!(refused(ProjectedSpec { clearance: -0.03, ..SPEC }).contains("clearance"));
}
