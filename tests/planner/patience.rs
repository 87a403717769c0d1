//! How many plans a round of the cross-entropy method has, and after how many rounds it gives up.
use crate::field::*;
use pliant::planner::Objective;
use pliant::problem::{Budget, Metered};
use std::sync::atomic::{AtomicUsize, Ordering};

const WIDE: Budget = Budget { rollouts: 1_000_000, gradient_price: 1, seconds: None };

/// Rollouts that CEM spends on `objective`.
fn rollouts(objective: &dyn Objective, overrides: &str) -> usize {
    let metered = Metered::new(objective, WIDE, &|| 0.0);
    run(&named("cem", overrides), &metered, 3);
    metered.spent().rollouts
}

#[test]
fn plans_of_a_round_decay_down_to_the_fewest() {
    let mut shapes = Vec::new();
    for (samples, decay, fewest) in [(100, 0.8, 20), (50, 1.0, 10), (64, 0.5, 2), (30, 0.0, 7)] {
        let until = |rounds: usize| {
            let config = format!(
                "samples = {samples}\ndecay = {decay:?}\nfewest = {fewest}\nelites = 2\nrounds = {rounds}\npatience = 1000"
            );
            rollouts(&rosenbrock(), &config)
        };
        let of_round: Vec<usize> = (0..12).map(|k| until(k + 1) - if k == 0 { 0 } else { until(k) }).collect();
        for (k, count) in of_round.iter().enumerate() {
            let decayed = f64::from(samples) * f64::powf(decay, k as f64);
            let expected = decayed.max(fewest as f64);
            // A count is whole.
            assert!((*count as f64 - expected).abs() <= 0.5, "round {k}: {count} plans for {expected}");
        }
        shapes.push(of_round);
    }
    assert!(shapes.iter().any(|shape| shape[11] < shape[5]) && shapes.iter().any(|shape| shape[0] == shape[11]));
}

/// Rounds of ten plans that CEM searches on costs that are `start` · `factor`ᵏ all through round k.
fn rounds(start: f64, factor: f64, patience: usize, tolerance: f64) -> usize {
    let seen = AtomicUsize::new(0);
    let falling = Field {
        space: space(&[0.0], &[1.0]),
        value: |_: &[f64]| start * factor.powf((seen.fetch_add(1, Ordering::Relaxed) / 10) as f64),
        slope: None::<fn(&[f64]) -> Vec<f64>>,
    };
    let spent = rollouts(
        &falling,
        &format!(
            "samples = 10\ndecay = 1.0\nfewest = 10\nelites = 3\nrounds = 25\npatience = {patience}\ntolerance = {tolerance:?}"
        ),
    );
    assert_eq!(spent % 10, 0);
    spent / 10
}

#[test]
fn on_a_plateau_the_search_stops_after_its_patience_and_one_round_to_compare_with() {
    for patience in [1, 2, 5, 24] {
        for start in [3.0, -3.0, 0.0] {
            for tolerance in [0.0, 1e-3] {
                assert_eq!(rounds(start, 1.0, patience, tolerance), patience + 1, "at {start}, tolerance {tolerance}");
            }
        }
    }
    assert_eq!(rounds(3.0, 1.0, 30, 0.1), 25, "who is more patient than there are rounds has them all");
}

#[test]
fn only_a_relative_fall_above_the_tolerance_counts_as_improvement() {
    // Two rounds of halving are a fall by three quarters, whatever the cost's unit.
    for start in [1e-9, 1.0, 1e9] {
        assert_eq!(rounds(start, 0.5, 2, 0.7), 25, "from {start}");
        assert_eq!(rounds(start, 0.5, 2, 0.8), 3, "from {start}");
        // What rises is no improvement.
        assert_eq!(rounds(start, 2.0, 2, 0.0), 3, "from {start}");
    }
    // A cost below zero falls by growing.
    assert_eq!(rounds(-1.0, 1.5, 1, 0.4), 25);
    assert_eq!(rounds(-1.0, 1.5, 1, 0.6), 2);
}

#[test]
fn where_no_plan_has_a_cost_yet_the_search_goes_on() {
    assert_eq!(rounds(f64::INFINITY, 1.0, 1, 1.0), 25);
}
