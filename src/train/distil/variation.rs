//! Random formulas, and new ones from old.
use super::tree::{Gene, Tree};
use crate::model::formula::{Function, Rational};
use rand::Rng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Exponents that formulas may have; contact of spheres has 3/2 (Hertz 1882).
const EXPONENTS: [(i64, i64); 7] = [(2, 1), (3, 2), (1, 2), (3, 1), (5, 2), (-1, 1), (-1, 2)];
/// Functions that formulas may have.
const FUNCTIONS: [Function; 3] = [Function::Exp, Function::Tanh, Function::Abs];

/// Draws formulas of so many variables.
pub(super) struct Variation {
    pub(super) variables: usize,
}

fn one<T: Copy>(of: &[T], rng: &mut ChaCha8Rng) -> T {
    *of.choose(rng).expect("a list of something")
}

fn exponent(rng: &mut ChaCha8Rng) -> Rational {
    let (n, d) = one(&EXPONENTS, rng);
    format!("{n}/{d}").parse().expect("a fraction")
}

/// A standard normal number.
pub(super) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

impl Variation {
    fn leaf(&self, rng: &mut ChaCha8Rng) -> Vec<Gene> {
        match rng.random_range(0..5) {
            0 | 1 => vec![Gene::Constant(normal(rng))],
            _ => vec![Gene::Variable(rng.random_range(0..self.variables))],
        }
    }

    /// At most so many operations on top of each other.
    pub(super) fn random(&self, depth: usize, rng: &mut ChaCha8Rng) -> Tree {
        if depth == 0 || rng.random_range(0..6) == 0 {
            return Tree(self.leaf(rng));
        }
        let inner = self.random(depth - 1, rng);
        self.around(&inner.0, depth - 1, rng)
    }

    /// An operation on `inner` and, where it asks for another, on a random formula.
    fn around(&self, inner: &[Gene], depth: usize, rng: &mut ChaCha8Rng) -> Tree {
        let minus = [Gene::Product, Gene::Number(Rational::MINUS_ONE)];
        let over = [Gene::Power(Rational::MINUS_ONE)];
        let kind = rng.random_range(0..16);
        let other = if kind < 10 { self.random(depth, rng).0 } else { Vec::new() };
        let (a, b) = if rng.random() { (inner, &other[..]) } else { (&other[..], inner) };
        Tree(match kind {
            0..=3 => [&[Gene::Product], a, b].concat(),
            4 | 5 => [&[Gene::Sum], a, b].concat(),
            6 | 7 => [&[Gene::Sum], a, &minus, b].concat(),
            8 => [&[Gene::Product], a, &over, b].concat(),
            9 => [&[one(&[Gene::Max, Gene::Min], rng)], a, b].concat(),
            10..=12 => [&[Gene::Max, Gene::Number(Rational::ZERO)], inner].concat(),
            13 | 14 => [&[Gene::Power(exponent(rng))], inner].concat(),
            _ => [&[Gene::Apply(one(&FUNCTIONS, rng))], inner].concat(),
        })
    }

    /// A child of `mother`, mostly with something of `father`.
    pub(super) fn child(&self, mother: &Tree, father: &Tree, rng: &mut ChaCha8Rng) -> Tree {
        let at = rng.random_range(0..mother.0.len());
        let own = &mother.0[mother.branch(at)];
        match rng.random_range(0..20) {
            0..=5 => {
                let from = rng.random_range(0..father.0.len());
                mother.replaced(at, &father.0[father.branch(from)])
            }
            6..=8 => mother.replaced(at, &self.random(2, rng).0),
            9..=13 => mother.replaced(at, &self.around(own, 1, rng).0),
            14 | 15 => {
                let below = at + rng.random_range(0..own.len());
                mother.replaced(at, &mother.0[mother.branch(below)])
            }
            16..=18 => {
                let mut child = mother.clone();
                child.0[at] = self.exchanged(child.0[at], rng);
                child
            }
            _ => {
                let shaken = |gene: &Gene, rng: &mut ChaCha8Rng| match gene {
                    Gene::Constant(value) => Gene::Constant(value * normal(rng).exp() + 0.1 * normal(rng)),
                    other => *other,
                };
                Tree(mother.0.iter().map(|gene| shaken(gene, rng)).collect())
            }
        }
    }

    /// Another node of as many operands.
    fn exchanged(&self, gene: Gene, rng: &mut ChaCha8Rng) -> Gene {
        match gene {
            Gene::Constant(value) if rng.random() => Gene::Number(Rational::whole(if value < 0.0 { -1 } else { 1 })),
            Gene::Variable(_) | Gene::Constant(_) => self.leaf(rng)[0],
            // It is what makes max(0, x) and −x.
            Gene::Number(_) => gene,
            Gene::Sum | Gene::Product => one(&[Gene::Sum, Gene::Product], rng),
            Gene::Max | Gene::Min => one(&[Gene::Max, Gene::Min], rng),
            Gene::Power(_) => Gene::Power(exponent(rng)),
            Gene::Apply(_) => Gene::Apply(one(&FUNCTIONS, rng)),
        }
    }
}
