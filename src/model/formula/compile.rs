//! From formulas to a program: differentiate, simplify, check, compile.
use super::check::{Verdict, check};
use super::count::unshared;
use super::derivative::Direction;
use super::expression::{Expressions, Id};
use super::interval::Interval;
use super::program::Program;
use super::simplify::simplify;

/// Operations for every element of an array; what depends on constants alone is computed once and not counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Operations {
    /// As differentiation writes it, every repeated part computed again.
    pub written: u64,
    /// The same with every repeated part computed once.
    pub shared: usize,
    /// Of the simplified program.
    pub simplified: usize,
}

/// A program for formulas and their derivatives.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// Outputs: the formulas, then for each direction the derivatives of all formulas along it.
    pub program: Program,
    /// The same as expressions: the simplified ones, unless the check kept the others.
    pub outputs: Vec<Id>,
    /// The operations before and after.
    pub operations: Operations,
    /// Whether the simplified program is used.
    pub verdict: Verdict,
}

/// Compiles `formulas` and their derivatives along each of `along`.
///
/// `inputs` are the names that are arrays, and `ranges` where each of [`Expressions::names`] lies; a range of one value makes a
/// constant, any other must belong to an input. Formulas are simplified before they are differentiated and again together with
/// their derivatives.
pub fn compile(
    expressions: &mut Expressions,
    formulas: &[Id],
    along: &[&Direction<'_>],
    inputs: &[&str],
    ranges: impl Fn(&str) -> Interval,
) -> Compiled {
    let with_derivatives = |expressions: &mut Expressions, formulas: &[Id]| {
        let mut all = formulas.to_vec();
        for direction in along {
            all.extend(expressions.derivatives(formulas, direction));
        }
        all
    };
    let plain = with_derivatives(expressions, formulas);
    inputs.iter().for_each(|name| {
        expressions.name(name);
    });
    let ranges: Vec<Interval> = expressions.names().iter().map(|name| ranges(name)).collect();
    let place = |name: &&str| expressions.names().iter().position(|n| n == name).expect("just named") as u32;
    let inputs: Vec<u32> = inputs.iter().map(place).collect();

    let short = simplify(expressions, formulas, &ranges);
    let whole = if along.is_empty() {
        short
    } else {
        let whole = with_derivatives(expressions, &short);
        simplify(expressions, &whole, &ranges)
    };
    let unsimplified = Program::new(expressions, &plain, &inputs, &ranges);
    let simplified = Program::new(expressions, &whole, &inputs, &ranges);
    let operations = Operations {
        written: unshared(expressions, &plain, &ranges),
        shared: unsimplified.operations(),
        simplified: simplified.operations(),
    };
    let verdict = check(expressions, &plain, &simplified, &inputs, &ranges);
    match verdict {
        Verdict::Agrees { .. } => Compiled { program: simplified, outputs: whole, operations, verdict },
        Verdict::Kept(_) => Compiled { program: unsimplified, outputs: plain, operations, verdict },
    }
}
