//! What a formula is fitted to: columns of variables without unit, and what it should be.
use crate::model::formula::{BLOCK, Interval, Program};
use crate::train::spread::spread;

/// A variable of the formulas: its name, where it may lie in any scene, and its value in every sample.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Name in formulas.
    pub name: &'static str,
    /// Every value that it can have.
    pub range: Interval,
    /// Value in every sample \[1\].
    pub values: Vec<f64>,
}

/// Samples of a function of variables.
#[derive(Clone, Debug)]
pub struct Samples {
    /// The variables.
    pub variables: Vec<Variable>,
    /// Value of the function in every sample \[1\].
    pub target: Vec<f64>,
}

impl Samples {
    /// Root mean square of the target.
    pub fn size(&self) -> f64 {
        (self.target.iter().map(|y| y * y).sum::<f64>() / self.target.len().max(1) as f64).sqrt()
    }

    /// `√(Σ (f − y)²/Σ y²)`; infinite where f has no value.
    pub(super) fn error(&self, found: &[f64]) -> f64 {
        let gaps: f64 = found.iter().zip(&self.target).map(|(f, y)| (f - y).powi(2)).sum();
        let error = (gaps / self.target.iter().map(|y| y * y).sum::<f64>()).sqrt();
        if error.is_finite() { error } else { f64::INFINITY }
    }

    pub(super) fn names(&self) -> Vec<&'static str> {
        self.variables.iter().map(|variable| variable.name).collect()
    }

    /// So many samples at even distances, or all.
    pub(super) fn thinned(&self, count: usize) -> Self {
        let thin = |values: &[f64]| spread(count, self.target.len()).map(|i| values[i]).collect();
        let of = |variable: &Variable| Variable { values: thin(&variable.values), ..variable.clone() };
        Self { variables: self.variables.iter().map(of).collect(), target: thin(&self.target) }
    }

    /// The first sample in which a number is not finite.
    pub(super) fn flaw(&self) -> Option<usize> {
        let columns = || self.variables.iter().map(|variable| &variable.values).chain([&self.target]);
        (0..self.target.len()).find(|i| columns().any(|values| !values[*i].is_finite()))
    }

    /// Every output of a program whose inputs are the variables and then `constants`.
    pub(super) fn run(&self, program: &Program, outputs: usize, constants: &[f64]) -> Vec<Vec<f64>> {
        let count = self.target.len();
        let mut workspace = program.workspace();
        for (k, constant) in constants.iter().enumerate() {
            workspace.input(self.variables.len() + k).fill(*constant);
        }
        let mut found = vec![Vec::with_capacity(count); outputs];
        for start in (0..count).step_by(BLOCK) {
            let size = BLOCK.min(count - start);
            for (place, variable) in self.variables.iter().enumerate() {
                workspace.input(place)[..size].copy_from_slice(&variable.values[start..start + size]);
            }
            program.run(&mut workspace);
            for (place, out) in found.iter_mut().enumerate() {
                out.extend_from_slice(&program.output(&workspace, place)[..size]);
            }
        }
        found
    }
}
