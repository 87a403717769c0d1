//! The constants of a form, fitted to samples.
use super::samples::Samples;
use crate::model::formula::{Form, Interval, Program, Rational};
use crate::train::search::Cholesky;

/// A form with its constants.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The form.
    pub form: Form,
    /// Its constants c0, c1 ….
    pub constants: Vec<f64>,
    /// `√(Σ (f − y)²/Σ y²)` on the samples that it was fitted to.
    pub error: f64,
}

/// λ of the first step, and beyond which there is nothing to gain.
const DAMPED: f64 = 1e-3;
const HEAVY: f64 = 1e8;
/// Relative gain below which a fit has arrived.
const ARRIVED: f64 = 1e-9;

impl Fitted {
    /// By damped Gauss–Newton steps (Levenberg 1944, Marquardt 1963) with exact slopes, from `constants`; `None` where the form has
    /// no value there or not in all scenes.
    pub(super) fn new(form: &Form, constants: Vec<f64>, samples: &Samples, steps: usize) -> Option<Self> {
        let count = constants.len();
        let mut e = form.expressions.clone();
        let mut roots = vec![form.root];
        for k in 0..count {
            roots.push(e.derivatives(&[form.root], &[(&Form::constant(k), Rational::ONE)])[0]);
        }
        // Variables are the first names, and constants the next.
        let inputs: Vec<u32> = (0..(samples.variables.len() + count) as u32).collect();
        let anywhere = vec![Interval::ALL; e.names().len()];
        let slopes = Program::new(&e, &roots, &inputs, &anywhere);
        let plain = Program::new(&e, &roots[..1], &inputs, &anywhere);

        let (mut here, mut damping) = (constants, DAMPED);
        let mut error = samples.error(&samples.run(&plain, 1, &here)[0]);
        if !error.is_finite() {
            return None;
        }
        'steps: for _ in 0..if count == 0 { 0 } else { steps } {
            let outputs = samples.run(&slopes, 1 + count, &here);
            let gap: Vec<f64> = outputs[0].iter().zip(&samples.target).map(|(f, y)| f - y).collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let curvature: Vec<f64> =
                (0..count * count).map(|at| dot(&outputs[1 + at / count], &outputs[1 + at % count])).collect();
            let slope: Vec<f64> = outputs[1..].iter().map(|by| -dot(by, &gap)).collect();
            if !curvature.iter().chain(&slope).all(|x| x.is_finite()) {
                break;
            }
            loop {
                // A constant without effect still has something on its diagonal.
                let entry = |i: usize, j: usize| {
                    let own = curvature[i * count + j];
                    if i == j { own * (1.0 + damping) + damping * 1e-12 } else { own }
                };
                let change = Cholesky::new(count, entry).map(|factor| factor.backward(factor.forward(&slope)));
                let next: Option<Vec<f64>> = change.map(|change| here.iter().zip(change).map(|(c, d)| c + d).collect());
                let reached = next.as_ref().map_or(f64::INFINITY, |c| samples.error(&samples.run(&plain, 1, c)[0]));
                match next {
                    Some(next) if reached < error => {
                        let gain = (error - reached) / error;
                        (here, error, damping) = (next, reached, (0.2 * damping).max(1e-12));
                        if gain < ARRIVED {
                            break 'steps;
                        }
                        break;
                    }
                    _ if damping > HEAVY => break 'steps,
                    _ => damping *= 10.0,
                }
            }
        }
        let fitted = Self { form: form.clone(), constants: here, error };
        fitted.is_defined(samples).then_some(fitted)
    }

    /// Whether it has a value wherever the variables may lie.
    fn is_defined(&self, samples: &Samples) -> bool {
        let constants = self.constants.iter().map(|c| Interval::closed(*c, *c));
        let mut ranges: Vec<Interval> =
            samples.variables.iter().map(|variable| variable.range).chain(constants).collect();
        ranges.resize(self.form.expressions.names().len().max(ranges.len()), Interval::ALL);
        self.form.is_defined(&ranges)
    }

    /// Its error on other samples.
    pub fn error_on(&self, samples: &Samples) -> f64 {
        let inputs: Vec<u32> = (0..(samples.variables.len() + self.constants.len()) as u32).collect();
        let e = &self.form.expressions;
        let program = Program::new(e, &[self.form.root], &inputs, &vec![Interval::ALL; e.names().len()]);
        samples.error(&samples.run(&program, 1, &self.constants)[0])
    }
}
