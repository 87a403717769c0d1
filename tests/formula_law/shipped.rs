//! The shipped formulas beside the laws in Rust.
use super::*;
use pliant::model::Cost;
use pliant::model::formula::Verdict;
use pliant::model::law::formula::Programs;
use pliant::state::{Control, ControlGrad, Scene};
use std::sync::Arc;

#[test]
fn formulas_accelerate_as_the_laws_in_rust_do() {
    let (written, formulas) = (spec("analytic").laws, spec("formula").laws);
    assert_eq!(written.len(), formulas.len());
    for (place, (hand, formula)) in written.into_iter().zip(formulas).enumerate() {
        let name = format!("law {place}");
        let (hand, formula) = (hand.build().unwrap(), formula.build().unwrap());
        assert_eq!(hand.reach(), formula.reach(), "{name}");
        for seed in 0..3 {
            let bench = Bench::new(seed);
            let (a, b) = (bench.accelerations(&*hand), bench.accelerations(&*formula));
            close(&a, &b, 1e-12, &name);
            let mut rng = ChaCha8Rng::seed_from_u64(seed + 10);
            let at: Vec<DVec3> = a.iter().map(|_| vector(&mut rng)).collect();
            if place + 1 < 6 {
                close(&bench.gradient(&*hand, &at), &bench.gradient(&*formula, &at), 1e-11, &name);
            }
        }
    }
}

/// `J = Σₜ Σᵢ aᵢ·x + |v|²`, different at every step.
struct Mixed(Vec<Vec<DVec3>>);

impl Cost for Mixed {
    fn at(&self, t: usize, _: usize, x: &Particles) -> f64 {
        let rows = x.positions.iter().zip(&x.velocities).zip(&self.0[t]);
        rows.map(|((x, v), a)| a.dot(*x) + v.length_squared()).sum()
    }
    fn gradient(&self, t: usize, _: usize, x: &Particles) -> ParticlesGrad {
        ParticlesGrad { positions: self.0[t].clone(), velocities: x.velocities.iter().map(|v| 2.0 * *v).collect() }
    }
}

#[test]
fn a_rollout_and_its_gradient_are_those_of_the_analytical_model() {
    let bench = Bench::new(5);
    let (analytic, formula) = (spec("analytic"), spec("formula"));
    assert_eq!((analytic.substeps, analytic.keep), (formula.substeps, formula.keep));
    let down = |t: usize| {
        let lower = |pose: &Pose| Pose { translation: pose.translation - 0.001 * t as f64 * DVec3::Z, ..*pose };
        Control { poses: bench.poses.iter().map(lower).collect() }
    };
    let controls: Vec<Control> = (1..=3).map(down).collect();
    let velocities = bench.particles.velocities.iter().map(|v| 0.05 * *v).collect();
    let particles = Particles { velocities, ..bench.particles.clone() };
    let scene = Scene::open(particles, Arc::new(bench.tool.clone()), bench.poses.clone(), 0.1);
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let cost = Mixed((0..4).map(|_| (0..75).map(|_| vector(&mut rng)).collect()).collect());
    let [a, b] = [analytic, formula].map(|spec| {
        let model = ModelSpec::Particles(spec).build().unwrap();
        (model.rollout(&scene, &controls), model.gradient(&scene, &controls, &cost).unwrap())
    });
    close(&a.0[3].positions, &b.0[3].positions, 1e-9, "positions");
    assert_ne!(a.0[0].positions, a.0[3].positions, "nothing moved");
    close(&a.1.scene.particles.positions, &b.1.scene.particles.positions, 1e-6, "by positions");
    close(&a.1.scene.particles.velocities, &b.1.scene.particles.velocities, 1e-6, "by velocities");
    for (a, b) in a.1.controls.iter().zip(&b.1.controls) {
        let rows = |u: &ControlGrad| u.poses.iter().flat_map(|p| [p.translation, p.rotation]).collect::<Vec<_>>();
        close(&rows(a), &rows(b), 1e-6, "by controls");
    }
}

#[test]
fn simplified_programs_of_the_shipped_laws_are_believed_and_save_a_third() {
    for law in spec("formula").laws {
        let LawSpec::Formula(spec) = law else { continue };
        let programs = Programs::new(&spec).unwrap();
        for verdict in programs.verdicts() {
            assert!(matches!(verdict, Verdict::Agrees { points } if *points >= 1000), "{:?}: {verdict:?}", spec.name);
        }
        // Instructions for every pair of the values and all slopes, what depends on constants alone not counted: as
        // differentiation writes them with repeated parts repeated, with each part once, and simplified.
        let counts = programs.adjoint().operations;
        println!("{}: {counts:?}", spec.name.as_deref().unwrap_or("formula"));
        assert!(10 * counts.simplified as u64 <= 7 * counts.written, "{:?}: {counts:?}", spec.name);
        assert!(counts.simplified < counts.shared, "{:?}: {counts:?}", spec.name);
    }
}
