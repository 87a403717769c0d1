//! What the curvature that CoVO follows costs where there is no gradient to take it from.
use crate::field::*;
use pliant::problem::{Budget, Metered};

#[test]
fn a_hessian_without_gradients_costs_twice_the_square_of_the_dimension_and_one() {
    for dimension in 1..7_usize {
        for rounds in [1, 3] {
            let objective = |with_slope: bool| Field {
                space: space(&vec![-1.0; dimension], &vec![2.0; dimension]),
                value: |x: &[f64]| x.iter().enumerate().map(|(i, x)| (1 + i) as f64 * x * x).sum::<f64>(),
                slope: with_slope.then_some(|x: &[f64]| {
                    x.iter().enumerate().map(|(i, x)| 2.0 * (1 + i) as f64 * x).collect::<Vec<f64>>()
                }),
            };
            let spent = |with_slope: bool| {
                let objective = objective(with_slope);
                let budget = Budget { rollouts: 100_000, gradient_price: 3, seconds: None };
                let metered = Metered::new(&objective, budget, &|| 0.0);
                let config = format!(
                    "[mppi]\nsamples = 10\nrounds = {rounds}\nspread = 0.1\nshrink = 1.0\n\
                     temperature = {{ kind = 'adapted', share = 0.2 }}"
                );
                run(&named("covo", &config), &metered, 1).unwrap();
                (metered.spent().rollouts, metered.spent().gradients)
            };
            let hessian = 2 * dimension * dimension + 1;
            assert_eq!(spent(false), (rounds * (hessian + 10), 0), "{dimension} dimensions, {rounds} rounds");
            assert_eq!(spent(true), (rounds * 10, rounds * 2 * dimension), "{dimension} dimensions, {rounds} rounds");
        }
    }
}
