//! Blocks on the table, pressed and let go.
use super::*;

fn low(particles: &Particles) -> f64 {
    particles.positions.iter().map(|x| x.z).fold(f64::INFINITY, f64::min)
}

fn top(particles: &Particles) -> f64 {
    particles.positions.iter().map(|x| x.z).fold(0.0, f64::max)
}

fn height(particles: &Particles) -> f64 {
    top(particles) - low(particles)
}

/// A block of 4 × 4 × 3 cm squeezed by a flat head to less than two thirds, let go, and left alone.
fn press(spec: MpmSpec) -> (Scene, Vec<Particles>, Vec<f64>) {
    let scene = under(Particles::at_rest(block(0.0025)), 0.042);
    let mut heights: Vec<f64> = (1..=10).map(|t| 0.042 - 0.0014 * f64::from(t)).collect();
    heights.extend((1..=5).map(|t| 0.028 + 0.008 * f64::from(t)));
    heights.resize(25, 0.068);
    let controls: Vec<Control> = heights.iter().map(|z| Control { poses: vec![at(*z)] }).collect();
    let rollout = model(spec).rollout(&scene, &controls);
    (scene, rollout, heights)
}

#[test]
fn an_elastic_block_regains_its_shape_and_a_plastic_one_does_not() {
    let soft = MpmSpec { viscosity: 5.0, gravity: 1.0, ..elastic() };
    let (_, spring, _) = press(soft.clone());
    let (start, least, end) = (height(&spring[0]), height(&spring[10]), height(&spring[25]));
    assert!(least < 0.8 * start, "pressed from {start} to {least} only");
    assert!((end - start).abs() < 0.05 * start, "{start} became {end}");
    let (_, dough, _) = press(MpmSpec { yield_stress: 40.0, ..soft });
    let (least, end) = (height(&dough[10]), height(&dough[25]));
    assert!(least < 0.8 * start && end < 0.8 * start, "{start} was pressed to {least} and became {end}");
    let wide = |x: &Particles| x.positions.iter().map(|x| x.x).fold(0.0, f64::max);
    assert!(wide(&dough[25]) > 1.08 * wide(&dough[0]), "what is pressed down goes to the sides");
}

#[test]
fn pressed_dough_stays_between_tool_and_table() {
    for spec in [shipped(), MpmSpec { yield_stress: 40.0, gravity: 9.81, ..elastic() }] {
        let (cell, (_, rollout, heights)) = (spec.cell, press(spec));
        assert!(rollout.iter().all(Particles::is_finite));
        for (state, z) in rollout[1..].iter().zip(&heights) {
            let low = state.positions.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
            assert!(low > -0.1 * cell, "a particle sank {low} into the table");
            assert!(
                height(state) < z - 0.01 + 0.5 * cell,
                "{} is above the head's face at {}",
                height(state),
                z - 0.01
            );
        }
    }
}

#[test]
fn sticky_surfaces_hold_and_slippery_ones_let_slide() {
    let slid = |table: SurfaceSpec| {
        let spec = MpmSpec { table, gravity: 1.0, viscosity: 5.0, ..elastic() };
        let mut particles = Particles::at_rest(block(0.0));
        particles.velocities.fill(0.1 * DVec3::X);
        let (mut scene, controls) = alone(particles, 4);
        scene.walls = Arc::default();
        let end = model(spec).rollout(&scene, &controls).pop().unwrap();
        let mean = |rows: &[DVec3]| rows.iter().map(|x| x.x).sum::<f64>() / rows.len() as f64;
        mean(&end.positions)
    };
    let [sticky, rough, smooth] = [
        slid(SurfaceSpec::Sticky {}),
        slid(SurfaceSpec::Coulomb { friction: 0.4 }),
        slid(SurfaceSpec::Coulomb { friction: 0.0 }),
    ];
    assert!((smooth - 0.04).abs() < 1e-4, "without friction it goes on, to {smooth}");
    // v²/(2 μ g) = 12.5 mm.
    assert!((rough - 0.0125).abs() < 0.002, "Coulomb's friction stops it at {rough}");
    assert!(sticky.abs() < 0.004, "what sticks went {sticky}");
}
