//! The analytical dough as configured, pressed and left alone.
use super::*;

/// Heights and widths below which 95 % of the particles lie \[m\].
fn extent(particles: &Particles) -> (f64, f64) {
    let quantile = |mut of: Vec<f64>| {
        of.sort_by(f64::total_cmp);
        of[of.len() * 95 / 100]
    };
    let positions = || particles.positions.iter();
    (quantile(positions().map(|x| x.z).collect()), 2.0 * quantile(positions().map(|x| x.x.abs()).collect()))
}

#[test]
fn pressed_dough_spreads_and_keeps_its_shape() {
    let start = scene(Particles::at_rest(block()), vec![cuboid(0.05, 0.05, 0.01)], vec![at(0.046)]);
    let to = |z: f64| Control { poses: vec![at(z)] };
    let mut controls: Vec<Control> = (1..=10).map(|t| to(0.046 - 0.002 * f64::from(t))).collect();
    controls.extend((1..=5).map(|t| to(0.026 + 0.006 * f64::from(t))));
    controls.resize(30, to(0.056));
    let rollout = analytic_model().rollout(&start, &controls);
    let [(h0, w0), pressed, lifted, end] = [0, 10, 15, 30].map(|t| extent(&rollout[t]));
    assert!(rollout.iter().all(Particles::is_finite));
    assert!(pressed.0 < 0.55 * h0, "height {h0} pressed to {}", pressed.0);
    assert!(end.0 < 0.75 * h0, "height {h0} went back to {}", end.0);
    assert!((end.0 - lifted.0).abs() < 0.1 * h0, "height {} went on to {} after the head left", lifted.0, end.0);
    assert!(end.1 > 1.1 * w0, "width {w0} became only {}", end.1);
    assert!((end.1 - lifted.1).abs() < 0.1 * w0, "width {} went on to {} after the head left", lifted.1, end.1);
    let top = |x: &Particles| x.positions.iter().map(|x| x.z).fold(0.0, f64::max);
    assert!(top(&rollout[30]) < 1.05 * top(&rollout[0]), "nothing is thrown up");
    let mean = rollout[30].velocities.iter().map(|v| v.length()).sum::<f64>() / rollout[30].len() as f64;
    assert!(mean < 0.001, "it comes to rest, not to {mean} m/s");
    let low = rollout.iter().flat_map(|x| &x.positions).map(|x| x.z).fold(1.0, f64::min);
    assert!(low > -0.001, "a particle's centre sank {low} m into the table");
}

#[test]
fn untouched_dough_keeps_its_shape() {
    let (start, controls) = alone(Particles::at_rest(block()), 15);
    let rollout = analytic_model().rollout(&start, &controls);
    let (before, after) = (extent(&rollout[0]), extent(&rollout[15]));
    assert!(
        (after.0 / before.0 - 1.0).abs() < 0.1 && (after.1 / before.1 - 1.0).abs() < 0.1,
        "{before:?} to {after:?}"
    );
}
