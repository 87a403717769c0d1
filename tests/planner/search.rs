//! What must hold of every planner, and of the descents.
use crate::field::*;
use pliant::planner::Objective;
use pliant::problem::{Budget, Metered};
use std::sync::Mutex;

#[test]
fn every_planner_of_the_configs_is_tested_here() {
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/planner")).unwrap();
    let mut stems: Vec<_> =
        files.map(|f| f.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned()).collect();
    let mut all: Vec<String> = ALL.into_iter().chain(BY_PROPOSAL).map(String::from).collect();
    stems.sort();
    all.sort();
    assert_eq!(stems, all);
}

#[test]
fn a_bowl_of_mixed_units_is_solved_with_its_optimum_on_the_boundary() {
    for (stem, overrides) in [
        ("cem", format!("{LONG_CEM}\nleast_spread = 0.0")),
        ("descent", LONG_DESCENT.into()),
        ("lbfgs", LONG_LBFGS.into()),
    ] {
        let plan = run(&named(stem, &overrides), &bowl(), 3).unwrap();
        let error = [(plan.theta[0] - 0.013) / 0.05, (plan.theta[1] + 1.1) / 5.0];
        assert!(error.iter().all(|e| e.abs() < 1e-4), "{stem}: {plan:?}");
        assert_eq!(plan.theta[2], 200.0, "{stem}: the bound nearest to the centre is the optimum");
    }
}

#[test]
fn the_curved_valley_is_followed_to_its_end() {
    // A Gaussian without correlations cannot lie along the valley: it arrives by jitter, and less far.
    let wide = format!("{LONG_CEM}\nleast_spread = 0.02");
    for (stem, overrides, close) in
        [("cem", wide.as_str(), 0.05), ("descent", LONG_DESCENT, 1e-4), ("lbfgs", LONG_LBFGS, 1e-12)]
    {
        let plan = run(&named(stem, overrides), &rosenbrock(), 4).unwrap();
        assert!(plan.cost < close, "{stem}: {plan:?}");
    }
}

#[test]
fn the_planners_of_configs_reach_a_bowl_within_a_hundredth_of_its_range() {
    for stem in ["cem", "mppi", "covo", "descent", "lbfgs", "refine"] {
        for seed in 0..5 {
            let objective = bowl();
            let plan = run(&named(stem, ""), &objective, seed).unwrap();
            let least = 1e-4 * 100.0f64.powi(2);
            assert!(plan.cost - least < 0.01 * 16.0, "{stem}, seed {seed}: {plan:?}");
        }
    }
}

#[test]
fn equal_seeds_give_equal_plans_and_the_promised_cost_is_the_cost() {
    for stem in ALL {
        let spec = named(stem, "");
        let plan = run(&spec, &rosenbrock(), 5).unwrap();
        assert_eq!(Some(plan.clone()), run(&spec, &rosenbrock(), 5));
        // A grid is the same for every seed, and L-BFGS ends in the minimum.
        if !["grid", "lbfgs"].contains(&stem) {
            assert_ne!(plan.theta, run(&spec, &rosenbrock(), 6).unwrap().theta, "{stem}");
        }
        assert_eq!(rosenbrock().costs(std::slice::from_ref(&plan.theta)), [plan.cost]);
        assert!(plan.cost <= rosenbrock().costs(&[vec![0.0, 1.0]])[0], "{stem}: the middle is among the plans seen");
    }
}

#[test]
fn plans_whose_cost_is_not_a_number_never_win_and_are_counted() {
    for bad in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let half = Field {
            space: space(&[0.0], &[1.0]),
            value: |x: &[f64]| if x[0] < 0.3 { bad } else { x[0] },
            slope: Some(|_: &[f64]| vec![1.0]),
        };
        for stem in ALL {
            let metered = Metered::new(&half, Budget { rollouts: 10_000, gradient_price: 3, seconds: None }, &|| 0.0);
            let plan = run(&named(stem, ""), &metered, 1).unwrap();
            assert!(plan.theta[0] >= 0.3 && plan.cost < 0.4, "{stem} with {bad}: {plan:?}");
            assert!(metered.spent().not_finite > 0, "{stem} with {bad}");
            let bare = run(&named(stem, ""), &half, 1).unwrap();
            assert_eq!(bare, plan, "{stem} with {bad}: planners refuse such costs themselves");
        }
    }
    let never = Field { space: space(&[0.0], &[1.0]), value: |_: &[f64]| f64::NAN, slope: Some(|_: &[f64]| vec![1.0]) };
    for stem in ALL {
        assert_eq!(run(&named(stem, ""), &never, 1), None, "{stem}");
    }
}

#[test]
fn a_middle_without_a_cost_does_not_keep_other_starts_from_descending() {
    for bad in [f64::NAN, f64::INFINITY] {
        let broken = Field {
            space: space(&[0.0], &[1.0]),
            value: |x: &[f64]| if (x[0] - 0.5).abs() < 0.1 { bad } else { (x[0] - 0.8).powi(2) },
            slope: Some(|x: &[f64]| vec![2.0 * (x[0] - 0.8)]),
        };
        for stem in ["descent", "lbfgs"] {
            let plan = run(&named(stem, ""), &broken, 1).unwrap();
            assert!((plan.theta[0] - 0.8).abs() < 0.02, "{stem} with {bad}: {plan:?}");
        }
    }
}

#[test]
fn the_budget_is_never_exceeded_and_ends_the_search_with_its_best() {
    for stem in ALL {
        for rollouts in [0, 1, 7, 40, 41, 60, 99] {
            let objective = rosenbrock();
            let metered = Metered::new(&objective, Budget { rollouts, gradient_price: 4, seconds: None }, &|| 0.0);
            let plan = run(&named(stem, ""), &metered, 2);
            let spent = metered.spent();
            assert!(spent.rollouts + 4 * spent.gradients <= rollouts, "{stem}: {spent:?} of {rollouts}");
            let least = if BY_GRADIENT.contains(&stem) { 4 } else { 1 };
            assert_eq!(plan.is_some(), rollouts >= least, "{stem} with {rollouts}");
            if let Some(plan) = plan {
                assert_eq!(objective.costs(std::slice::from_ref(&plan.theta)), [plan.cost]);
            }
        }
    }
}

#[test]
fn without_a_gradient_descents_have_no_plan_and_spend_nothing_on_finding_out() {
    let flat = Field { space: space(&[0.0], &[1.0]), value: |x: &[f64]| x[0], slope: None::<fn(&[f64]) -> Vec<f64>> };
    for stem in ALL {
        let metered = Metered::new(&flat, Budget { rollouts: 1000, gradient_price: 4, seconds: None }, &|| 0.0);
        let plan = run(&named(stem, ""), &metered, 1);
        assert_eq!(metered.spent().gradients, 0, "{stem}");
        assert_eq!(plan.is_none(), BY_GRADIENT.contains(&stem), "{stem}");
        assert_eq!(metered.spent().rollouts == 0, BY_GRADIENT.contains(&stem), "{stem}");
        assert!(plan.is_none_or(|plan| plan.cost < 0.05), "{stem}");
    }
}

#[test]
fn descent_starts_from_the_middle_and_the_cheapest_candidates_and_its_last_step_counts() {
    let asked = Mutex::new(Vec::new());
    let line = Field {
        space: space(&[0.0], &[1.0]),
        value: |x: &[f64]| x[0],
        slope: Some(|x: &[f64]| {
            asked.lock().unwrap().push(x[0]);
            vec![1.0]
        }),
    };
    let spec = named("descent", "candidates = 50\nstarts = 3\nsteps = 1\nrate = 0.01\nlast_rate = 0.01");
    let plan = run(&spec, &line, 1).unwrap();
    let asked = asked.into_inner().unwrap();
    assert_eq!((asked.len(), asked[0]), (3, 0.5));
    assert!(asked[1] < asked[2] && asked[2] < 0.2, "two of 49 uniform draws: {asked:?}");
    assert!((plan.theta[0] - (asked[1] - 0.01).max(0.0)).abs() < 1e-15);
}

#[test]
fn impossible_configs_are_sentences_that_name_the_key() {
    let cases = [
        ("cem", "elites = 1", "elites"),
        ("cem", "fewest = 3", "fewest"),
        ("cem", "samples = 15", "samples"),
        ("cem", "spread = 0.0", "spread"),
        ("cem", "decay = 1.5", "decay"),
        ("cem", "smoothing = nan", "smoothing"),
        ("cem", "rounds = 0", "rounds"),
        ("descent", "starts = 17", "candidates"),
        ("descent", "rate = 0.0", "rate"),
        ("descent", "last_rate = 0.5", "last_rate"),
        ("descent", "momentum = 1.0", "momentum"),
        ("descent", "steps = 0", "steps"),
        ("random", "samples = 0", "samples"),
        ("grid", "samples = 0", "samples"),
        ("mppi", "shrink = 0.0", "shrink"),
        ("mppi", "temperature = { kind = 'adapted', share = 1.0 }", "temperature.share"),
        ("mppi", "temperature = { kind = 'fixed', value = 0.0 }", "temperature.value"),
        ("covo", "reach = 0.5", "reach"),
        ("covo", "floor = { kind = 'relative', share = 0.0 }", "floor.share"),
        ("lbfgs", "memory = 0", "memory"),
        ("policy", "proposals = 0", "proposals"),
    ];
    for (stem, overrides, key) in cases {
        let error = named(stem, overrides).build().err().unwrap_or_else(|| panic!("{overrides} was accepted"));
        assert!(error.to_string().contains(&format!("planner.{key}")), "{overrides}: {error}");
    }
}
