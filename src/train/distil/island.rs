//! A population of formulas that breeds by itself.
use super::fitted::Fitted;
use super::front::Front;
use super::samples::Samples;
use super::tree::{Gene, Tree};
use super::variation::{Variation, normal};
use crate::model::formula::Forms;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

/// Formulas that a tournament is held between.
const TOURNAMENT: usize = 5;
/// Most that a unit of complexity weighs against ln(error) in a tournament.
const THRIFT: f64 = 0.15;
/// Steps that constants are fitted by.
const STEPS: usize = 8;
/// Starts of a fit beside the constants that a formula comes with: errors have more than one valley.
const ELSEWHERE: usize = 2;
/// How often a form is fitted.
const TRIES: u32 = 3;
/// Operations on top of each other in the first formulas.
const DEPTH: usize = 4;

/// Formulas, their random stream, the best of them, and the forms that were seen.
pub(super) struct Island<'a> {
    samples: &'a Samples,
    complexity: usize,
    size: usize,
    rng: ChaCha8Rng,
    forms: Forms,
    /// How often each form was fitted, and each formula met, whatever its constants.
    seen: HashMap<String, u32>,
    written: HashMap<String, u32>,
    population: Vec<(Tree, usize, f64)>,
    pub(super) front: Front,
}

impl<'a> Island<'a> {
    /// `size` formulas of at most `complexity`, which nothing has bred yet.
    pub(super) fn new(samples: &'a Samples, size: usize, complexity: usize, rng: ChaCha8Rng) -> Self {
        let (forms, seen, written, population, front) = Default::default();
        Self { samples, complexity, size, rng, forms, seen, written, population, front }
    }

    /// Replaces the population by its children, or by random formulas where there is none yet.
    pub(super) fn breed(&mut self) {
        let variation = Variation { variables: self.samples.variables.len() };
        let mut next = Vec::with_capacity(self.size);
        // What is refused counts too, or a population that has seen everything would never end.
        for _ in 0..4 * self.size {
            let tree = if self.population.is_empty() {
                variation.random(DEPTH, &mut self.rng)
            } else {
                let (mother, father) = (self.parent(), self.parent());
                variation.child(&mother, &father, &mut self.rng)
            };
            if let Some(fitted) = self.fitted(&tree) {
                next.push(self.member(&fitted));
                self.front.offer(fitted);
            }
            if next.len() == self.size {
                break;
            }
        }
        if next.len() > 1 {
            self.population = next;
        }
    }

    /// Takes over what others have found.
    pub(super) fn welcome(&mut self, front: &Front) {
        front.formulas().iter().for_each(|one| self.front.offer(one.clone()));
    }

    fn member(&self, fitted: &Fitted) -> (Tree, usize, f64) {
        let tree = Tree::of(&fitted.form, self.samples.variables.len(), &fitted.constants);
        (tree, fitted.form.complexity, fitted.error)
    }

    /// One of the front, or the winner of a tournament in which complexity weighs as chance has it.
    fn parent(&mut self) -> Tree {
        let front = self.front.formulas();
        if !front.is_empty() && self.rng.random_range(0..3) == 0 {
            let at = self.rng.random_range(0..front.len());
            return self.member(&self.front.formulas()[at]).0;
        }
        let thrift = self.rng.random::<f64>() * THRIFT;
        let score = |(_, complexity, error): &(Tree, usize, f64)| error.ln() + thrift * *complexity as f64;
        let some = (0..TOURNAMENT).map(|_| self.rng.random_range(0..self.population.len())).collect::<Vec<_>>();
        let best = some.into_iter().min_by(|a, b| score(&self.population[*a]).total_cmp(&score(&self.population[*b])));
        self.population[best.expect("a tournament of several")].0.clone()
    }

    /// The form of `c · tree` with its constants fitted, unless it is too complex, puts functions into each other, was seen
    /// often enough, or has no value somewhere.
    ///
    /// The factor is free because scale is fitted more easily than found (Keijzer 2003).
    fn fitted(&mut self, tree: &Tree) -> Option<Fitted> {
        let scaled = Tree([&[Gene::Product, Gene::Constant(1.0)], &tree.0[..]].concat());
        // A form is at most a few parts shorter than what it comes from.
        if scaled.0.len() > 3 * self.complexity || tree.nests() {
            return None;
        }
        let written = self.written.entry(scaled.skeleton()).or_default();
        *written += 1;
        if *written > TRIES {
            return None;
        }
        let form = scaled.form(self.samples, &self.forms).filter(|form| form.complexity <= self.complexity)?;
        let tries = self.seen.entry(form.text()).or_default();
        *tries += 1;
        if *tries > TRIES {
            return None;
        }
        let mut starts = vec![form.constants.clone()];
        for _ in 0..ELSEWHERE {
            starts.push(form.constants.iter().map(|_| normal(&mut self.rng)).collect());
        }
        let found = starts.into_iter().filter_map(|start| Fitted::new(&form, start, self.samples, STEPS));
        found.min_by(|a, b| a.error.total_cmp(&b.error))
    }
}
