//! The learned law: exact derivatives through particles, tool poses, twists and weights, and the symmetries it promises.
use glam::{DQuat, DVec3};
use moment::*;
use pliant::model::law::{FrameSpec, Law, Learned, LearnedSpec, Rate, ViewGrad};
use pliant::model::net::Aggregation;
use pliant::state::{ParticlesGrad, Pose, PoseGrad, Scene, ToolShape, Twist};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

mod moment;
mod reach;
mod relabel;
mod roots;

/// Moves one quantity of a tool part by a vector.
type Nudge = fn(&mut Moment, usize, DVec3);

fn cotangent(count: usize) -> Vec<DVec3> {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    (0..count).map(|_| vector(&mut rng, 1.0)).collect()
}

/// Fourth-order central difference along one line.
fn along(h: f64, cost: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (cost(h) - cost(-h)) - (cost(2.0 * h) - cost(-2.0 * h))) / (12.0 * h)
}

#[test]
fn derivatives_agree_with_central_differences_in_every_frame() {
    for frame in [FrameSpec::World, FrameSpec::Tool] {
        derivatives_agree_with_central_differences(&shaken(frame), &Moment::random(40));
    }
}

#[test]
fn derivatives_agree_with_central_differences_where_messages_are_averaged() {
    let law = shake(LearnedSpec { aggregation: Aggregation::Mean, ..spec(16) });
    derivatives_agree_with_central_differences(&law, &Moment::random(40));
}

#[test]
fn derivatives_agree_with_central_differences_between_walls_and_bodies_with_a_memory() {
    let here = Moment::random(40).walled().remembering(2);
    for frame in [FrameSpec::World, FrameSpec::Tool] {
        let law = shake(LearnedSpec { frame, bodies: 2, history: 3, ..spec(16) });
        let alone = Moment { walls: Vec::new(), ..here.clone() }.acceleration(&law);
        assert!(here.acceleration(&law).iter().zip(&alone).filter(|(a, b)| a != b).count() > 20, "walls matter");
        let alike = Moment { body: vec![0; 40], ..here.clone() }.acceleration(&law);
        assert!(here.acceleration(&law).iter().zip(&alike).all(|(a, b)| a != b), "bodies matter");
        derivatives_agree_with_central_differences(&law, &here);
    }
}

#[test]
fn a_constant_is_told_to_every_particle_as_a_share_of_its_range_and_must_be_known() {
    let stiffness = "material.young_modulus".to_owned();
    let law = shake(LearnedSpec { constants: [(stiffness.clone(), [2e3, 6e3])].into(), ..spec(16) });
    let told = |value: f64| Moment { constants: [(stiffness.clone(), value)].into(), ..Moment::random(30) };
    let [soft, middle, stiff] = [2e3, 4e3, 6e3].map(|value| told(value).acceleration(&law));
    assert!(soft.iter().zip(&stiff).all(|(a, b)| a != b), "the constant matters to every particle");
    // Whatever is told about something else, or in the middle of its range, changes nothing.
    let other = Moment { constants: [("spacing".to_owned(), 5.0)].into(), ..Moment::random(30) };
    assert_eq!(other.acceleration(&law), middle);

    let mut scene = Scene::open(Moment::random(30).particles, ToolShape::from(Vec::new()).into(), Vec::new(), 0.1);
    let refusal = law.accepts(&scene).unwrap_err().to_string();
    assert!(refusal.contains("material.young_modulus") && refusal.contains("`vary`"), "{refusal}");
    scene.constants = Arc::new([(stiffness, 3e3)].into());
    law.accepts(&scene).unwrap();
    scene.body = [0, 2, 1].repeat(10).into();
    let two = shake(LearnedSpec { bodies: 2, ..spec(16) });
    let refusal = two.accepts(&scene).unwrap_err().to_string();
    assert!(refusal.contains("`bodies`") && refusal.ends_with('3'), "{refusal}");
    scene.body = [0, 1].repeat(15).into();
    two.accepts(&scene).unwrap();
}

#[test]
fn derivatives_agree_with_central_differences_along_bonds_of_any_length() {
    let law = shake(LearnedSpec { edges: [kinds(3), vec!["bond".to_owned()]].concat(), ..spec(16) });
    let here = Moment::random(40).bonded();
    let free = Moment::random(40).acceleration(&law);
    assert!(here.acceleration(&law).iter().zip(&free).all(|(a, b)| a != b), "bonds matter");
    derivatives_agree_with_central_differences(&law, &here);
}

fn derivatives_agree_with_central_differences(law: &Learned, here: &Moment) {
    let at = cotangent(40);
    let cost = |law: &Learned, m: &Moment| -> f64 { m.acceleration(law).iter().zip(&at).map(|(a, g)| a.dot(*g)).sum() };
    let graph = here.graph();
    let mut weights = vec![0.0; law.weights().len()];
    let mut grad = ViewGrad {
        particles: ParticlesGrad::zero(40),
        past: vec![vec![DVec3::ZERO; 40]; here.past.len()],
        poses: vec![PoseGrad::default(); 2],
        twists: vec![Twist::default(); 2],
        history: Vec::new(),
        weights: &mut weights,
    };
    law.accelerate_vjp(&here.view(&graph), &at, &mut grad);
    // Steps are fractions of what each quantity is measured in, small because the window's curvature jumps at the radius;
    // tolerances are relative to the largest of its kind.
    let close = |name: &str, exact: &[f64], found: &[f64], floor: f64| {
        let size = exact.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!(size > floor, "{name}: a trivial derivative, {size}");
        for (k, (e, f)) in exact.iter().zip(found).enumerate() {
            assert!((e - f).abs() < 1e-3 * size, "{name} {k}: {e} against {f}");
        }
    };

    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let directions: Vec<Vec<DVec3>> = (0..6).map(|_| (0..40).map(|_| vector(&mut rng, 1.0)).collect()).collect();
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let moved = |x: &[DVec3], d: &[DVec3], s: f64| x.iter().zip(d).map(|(x, d)| *x + s * *d).collect::<Vec<_>>();
    let exact = |g: &[DVec3], unit: f64| directions.iter().map(|d| unit * dot(g, d)).collect::<Vec<_>>();
    let found = directions.iter().map(|d| {
        along(1e-3, |s| {
            let mut m = here.clone();
            m.particles.positions = moved(&m.particles.positions, d, s * RADIUS);
            cost(law, &m)
        })
    });
    close("positions", &exact(&grad.particles.positions, RADIUS), &found.collect::<Vec<_>>(), 0.1);
    let found = directions.iter().map(|d| {
        along(3e-2, |s| {
            let mut m = here.clone();
            m.particles.velocities = moved(&m.particles.velocities, d, s * SCALE / INTERVAL);
            cost(law, &m)
        })
    });
    close("velocities", &exact(&grad.particles.velocities, SCALE / INTERVAL), &found.collect::<Vec<_>>(), 0.1);

    for (k, at) in grad.past.iter().enumerate() {
        let found = directions.iter().map(|d| {
            along(3e-2, |s| {
                let mut m = here.clone();
                m.past[k] = moved(&m.past[k], d, s * SCALE / INTERVAL);
                cost(law, &m)
            })
        });
        close("past", &exact(at, SCALE / INTERVAL), &found.collect::<Vec<_>>(), 0.01);
    }

    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let tool_motions: [(&str, f64, f64, Nudge); 4] = [
        ("translation", RADIUS, 3e-3, |m, k, d| m.poses[k].translation += d),
        ("rotation", 1.0, 3e-3, |m, k, d| m.poses[k].rotation = DQuat::from_scaled_axis(d) * m.poses[k].rotation),
        ("linear", SCALE / INTERVAL, 3e-2, |m, k, d| m.twists[k].linear += d),
        ("angular", SCALE / INTERVAL / 0.02, 3e-2, |m, k, d| m.twists[k].angular += d),
    ];
    for (name, unit, h, nudge) in tool_motions {
        let (mut exact, mut found) = (Vec::new(), Vec::new());
        for (k, axis) in (0..2).flat_map(|k| axes.map(|axis| (k, axis))) {
            let g = match name {
                "translation" => grad.poses[k].translation,
                "rotation" => grad.poses[k].rotation,
                "linear" => grad.twists[k].linear,
                _ => grad.twists[k].angular,
            };
            exact.push(unit * g.dot(axis));
            found.push(along(h, |s| {
                let mut m = here.clone();
                nudge(&mut m, k, s * unit * axis);
                cost(law, &m)
            }));
        }
        close(name, &exact, &found, 0.01);
    }

    let before = law.weights();
    let (mut exact, mut found) = (Vec::new(), Vec::new());
    for _ in 0..6 {
        let d: Vec<f32> = before.iter().map(|_| rng.random_range(-1.0..1.0)).collect();
        exact.push(weights.iter().zip(&d).map(|(g, d)| f64::from(g * d)).sum());
        found.push(along(1e-3, |s| {
            let mut law = law.clone();
            law.set_weights(&before.iter().zip(&d).map(|(w, d)| w + s as f32 * d).collect::<Vec<_>>());
            cost(&law, here)
        }));
    }
    close("weights", &exact, &found, 1.0);
}

#[test]
fn shifting_along_the_table_and_relabelling_change_nothing_else() {
    let (law, here) = (shaken(FrameSpec::World), Moment::random(50));
    let base = here.acceleration(&law);
    let size = base.iter().fold(0.0f64, |m, a| m.max(a.length()));
    let mut shifted = here.clone();
    let shift = DVec3::new(0.37, -1.2, 0.0);
    shifted.particles.positions.iter_mut().for_each(|x| *x += shift);
    shifted.poses.iter_mut().for_each(|p| p.translation += shift);
    let order: Vec<usize> = (0..50).map(|i| (i * 17 + 5) % 50).collect();
    let mut relabelled = here.clone();
    relabelled.particles.positions = order.iter().map(|&i| here.particles.positions[i]).collect();
    relabelled.particles.velocities = order.iter().map(|&i| here.particles.velocities[i]).collect();
    let (shifted, relabelled) = (shifted.acceleration(&law), relabelled.acceleration(&law));
    for i in 0..50 {
        assert!(shifted[i].distance(base[i]) < 3e-6 * size, "shift {i}");
        assert!(relabelled[i].distance(base[order[i]]) < 3e-6 * size, "relabel {i}");
    }
    let mut raised = here.clone();
    raised.particles.positions.iter_mut().for_each(|x| x.z += 0.01);
    assert!(raised.acceleration(&law)[0].distance(base[0]) > 1e-3 * size, "height matters");
}

#[test]
fn an_edge_appears_without_a_jump_or_a_kink() {
    let (law, mut here) = (shaken(FrameSpec::World), Moment::random(2));
    here.tool.parts.clear();
    let at = |x: f64| {
        let mut m = here.clone();
        m.particles.positions = vec![DVec3::Z, DVec3::new(x, 0.0, 1.0)];
        m.acceleration(&law)[0]
    };
    let (far, inside) = (at(1.1 * RADIUS), at(0.5 * RADIUS));
    let whole = inside.distance(far);
    assert!(whole > 1e-3, "the edge matters: {whole}");
    // (1 − (r/R)²)² is 4e-6 at r = 0.999 R, so both the jump and the slope have gone.
    assert!(at(0.999 * RADIUS).distance(far) < 1e-4 * whole);
    assert_eq!(at(1.001 * RADIUS), far);
}

#[test]
fn what_is_behind_a_wall_still_sees_it_and_crosses_it_without_a_jump_or_a_kink() {
    let (law, mut here) = (shaken(FrameSpec::World), Moment::random(1).walled());
    here.tool.parts.clear();
    here.walls.truncate(1);
    let wall = here.walls[0];
    let at = |distance: f64| {
        let mut m = here.clone();
        m.particles.positions = vec![DVec3::Z + (distance - wall.distance(DVec3::Z)) * wall.normal];
        m.acceleration(&law)[0]
    };
    let free = at(1.5 * RADIUS);
    let size = at(0.0).distance(free);
    assert!(size > 1e-3, "the wall matters: {size}");
    for depth in [0.5, 0.99, 3.0] {
        assert!(at(-depth * RADIUS).distance(free) > 0.1 * size, "lost at a depth of {depth} radii");
    }
    let h = 1e-3 * RADIUS;
    let (before, middle, after) = (at(h), at(0.0), at(-h));
    assert!(before.distance(after) < 0.05 * size, "a jump");
    assert!((before + after - 2.0 * middle).length() < 1e-3 * size, "a kink");
}

#[test]
fn threads_share_a_law_and_an_untrained_one_is_zero() {
    let (law, here) = (shaken(FrameSpec::World), Moment::random(60));
    let alone = here.acceleration(&law);
    std::thread::scope(|scope| {
        let others: Vec<_> = (0..4).map(|_| scope.spawn(|| here.acceleration(&law))).collect();
        assert!(others.into_iter().all(|other| other.join().unwrap() == alone));
    });
    assert_eq!((law.rate(), law.reach()), (Rate::Step, RADIUS));
    assert!(here.acceleration(&spec(16).build().unwrap()).iter().all(|a| *a == DVec3::ZERO));
    assert!(Moment::random(0).acceleration(&law).is_empty());
}

#[test]
fn in_the_frame_of_the_tool_a_turn_of_the_scene_turns_the_accelerations() {
    let here = Moment::random(40).walled().remembering(1);
    let mut there = here.clone();
    let turn = DQuat::from_rotation_z(1.1);
    let Moment { particles, past, poses, twists, walls, .. } = &mut there;
    past.iter_mut().flatten().for_each(|v| *v = turn * *v);
    walls.iter_mut().for_each(|wall| wall.normal = turn * wall.normal);
    particles.positions.iter_mut().chain(&mut particles.velocities).for_each(|v| *v = turn * *v);
    poses.iter_mut().for_each(|p| *p = Pose { translation: turn * p.translation, rotation: turn * p.rotation });
    twists.iter_mut().for_each(|t| *t = Twist { linear: turn * t.linear, angular: turn * t.angular });
    let error = |frame| {
        let law = shake(LearnedSpec { frame, history: 2, ..spec(16) });
        let (before, after) = (here.acceleration(&law), there.acceleration(&law));
        let size = before.iter().map(|a| a.length()).fold(0.0, f64::max);
        before.iter().zip(&after).map(|(a, b)| (turn * *a).distance(*b)).fold(0.0, f64::max) / size
    };
    assert!(error(FrameSpec::Tool) < 1e-5, "{}", error(FrameSpec::Tool));
    assert!(error(FrameSpec::World) > 1e-2, "the world's frame has a preferred direction");
}
