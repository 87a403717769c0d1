//! Distillation: formulas are found in what they made, and a network's messages become a written model.
use pliant::model::formula::Interval;
use pliant::train::distil::{DistilSpec, Front, Samples, Variable, regress};
use pliant::watch::Watch;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeSet;

mod messages;
mod stage;

/// Samples of a function of `r` in (0.3, 1), `vn` and `vt`.
fn samples(count: usize, of: impl Fn(f64, f64, f64) -> f64) -> Samples {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let rows: Vec<[f64; 3]> = (0..count)
        .map(|_| [rng.random_range(0.3..1.0), rng.random_range(-2.0..2.0), rng.random_range(0.0..2.0)])
        .collect();
    let column = |name, range, k: usize| Variable { name, range, values: rows.iter().map(|row| row[k]).collect() };
    Samples {
        variables: vec![
            column("r", Interval::open(0.0, 1.0), 0),
            column("vn", Interval::ALL, 1),
            column("vt", Interval::open(0.0, f64::INFINITY), 2),
        ],
        target: rows.iter().map(|[r, vn, vt]| of(*r, *vn, *vt)).collect(),
    }
}

fn noisy(count: usize) -> Samples {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut samples = samples(count, |r, vn, _| 5.0 * (0.8 - r).max(0.0).powf(1.5) * (1.0 - 0.3 * vn));
    samples.target.iter_mut().for_each(|y| *y += 0.02 * noise());
    samples
}

fn small(generations: usize) -> DistilSpec {
    DistilSpec { generations, population: 32, complexity: 14, ..DistilSpec::default() }
}

fn texts(front: &Front) -> Vec<String> {
    front.formulas().iter().map(|one| one.form.text()).collect()
}

#[test]
fn formulas_are_found_in_exact_samples_of_theirs() {
    type Known = (&'static str, fn(f64, f64, f64) -> f64, usize);
    let known: [Known; 2] = [
        ("contact", |r, _, _| 5.0 * (0.7 - r).max(0.0).powf(1.5), 8),
        ("viscosity", |r, vn, _| -3.0 * (1.0 - r * r).powi(2) * vn, 9),
    ];
    for (name, law, most) in known {
        let front = regress(&small(30), &samples(300, law), &Watch::silent()).unwrap();
        let exact = front.formulas().iter().find(|one| one.error < 1e-6);
        let exact = exact.unwrap_or_else(|| panic!("{name} is not among {:?}", texts(&front)));
        let (text, complexity) = (exact.form.text(), exact.form.complexity);
        assert!(complexity <= most, "{name} is found as {text}, of complexity {complexity}");
    }
}

#[test]
fn no_formula_of_a_front_is_beaten_by_a_simpler_one_and_none_stands_twice() {
    let samples = noisy(300);
    let front = regress(&small(12), &samples, &Watch::silent()).unwrap();
    assert!(front.formulas().len() > 4, "{:?}", texts(&front));
    for pair in front.formulas().windows(2) {
        assert!(pair[0].form.complexity < pair[1].form.complexity && pair[0].error > pair[1].error);
    }
    let forms: BTreeSet<String> = texts(&front).into_iter().collect();
    assert_eq!(forms.len(), front.formulas().len());
    for one in front.formulas() {
        let error = one.error_on(&samples);
        assert!((error - one.error).abs() <= 1e-12, "{} claims {} and has {error}", one.form.text(), one.error);
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_whatever_the_number_of_threads() {
    let samples = noisy(200);
    let with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let spec = DistilSpec { seed, ..small(8) };
        let front = pool.install(|| regress(&spec, &samples, &Watch::silent())).unwrap();
        let bits = |one: &pliant::train::distil::Fitted| {
            (one.form.text(), one.error.to_bits(), one.constants.iter().map(|c| c.to_bits()).collect::<Vec<_>>())
        };
        front.formulas().iter().map(bits).collect::<Vec<_>>()
    };
    let once = with(1, 5);
    assert_eq!(once, with(3, 5));
    assert_ne!(once, with(1, 6), "the seed does nothing");
}

#[test]
fn what_is_not_finite_or_says_nothing_is_refused_with_a_sentence() {
    let good = noisy(50);
    let refused = |samples: &Samples| regress(&small(1), samples, &Watch::silent()).unwrap_err().to_string();
    let mut broken = good.clone();
    broken.target[7] = f64::NAN;
    assert!(refused(&broken).contains("sample 7 holds a number that is not finite"), "{}", refused(&broken));
    let mut broken = good.clone();
    broken.variables[1].values[3] = f64::INFINITY;
    assert!(refused(&broken).contains("sample 3"), "{}", refused(&broken));
    let silent = Samples { target: vec![0.0; 50], ..good };
    assert!(refused(&silent).contains("every sample of the target is zero"));
}
