//! A formula as genetic programming sees it: its nodes in the order in which it is read, operations before their operands (Koza
//! 1992).
use super::samples::Samples;
use crate::model::formula::{Expressions, Form, Forms, Function, Id, Interval, Node, Rational};
use std::ops::Range;

/// A node; which operation it is decides how many of the next nodes' trees are its operands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Gene {
    /// A number that stays as it is.
    Number(Rational),
    /// A variable, by its place.
    Variable(usize),
    /// A constant that is fitted, and where that begins.
    Constant(f64),
    Sum,
    Product,
    Max,
    Min,
    Power(Rational),
    Apply(Function),
}

impl Gene {
    fn operands(self) -> usize {
        match self {
            Self::Number(_) | Self::Variable(_) | Self::Constant(_) => 0,
            Self::Power(_) | Self::Apply(_) => 1,
            Self::Sum | Self::Product | Self::Max | Self::Min => 2,
        }
    }
}

/// A whole formula.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree(pub(super) Vec<Gene>);

impl Tree {
    /// Where the tree that begins at `start` stands.
    pub(super) fn branch(&self, start: usize) -> Range<usize> {
        let (mut end, mut missing) = (start, 1);
        while missing > 0 {
            missing = missing + self.0[end].operands() - 1;
            end += 1;
        }
        start..end
    }

    /// Whether a function other than |x| stands within another, which no law of nature is known to ask for.
    pub(super) fn nests(&self) -> bool {
        let curved = |at: &usize| matches!(self.0[*at], Gene::Apply(function) if function != Function::Abs);
        (0..self.0.len()).filter(curved).any(|at| self.branch(at).skip(1).any(|below| curved(&below)))
    }

    /// What it is whatever its constants are.
    pub(super) fn skeleton(&self) -> String {
        let word = |gene: &Gene| match gene {
            Gene::Constant(_) => "c ".to_owned(),
            other => format!("{other:?} "),
        };
        self.0.iter().map(word).collect()
    }

    /// The formula with another tree in place of the branch at `start`.
    pub(super) fn replaced(&self, start: usize, by: &[Gene]) -> Self {
        let Range { start, end } = self.branch(start);
        Self([&self.0[..start], by, &self.0[end..]].concat())
    }

    /// Its nodes, the names of the variables first, and what the constants `c0`, `c1` … are.
    fn expression(&self, variables: &[&str]) -> (Expressions, Id, Vec<f64>) {
        let mut e = Expressions::default();
        variables.iter().for_each(|name| {
            e.name(name);
        });
        let mut constants = Vec::new();
        let root = node(&mut &self.0[..], &mut e, variables, &mut constants);
        (e, root, constants)
    }

    /// Its form, over the variables of `samples`.
    pub(super) fn form(&self, samples: &Samples, forms: &Forms) -> Option<Form> {
        let (e, root, constants) = self.expression(&samples.names());
        let variables = samples.variables.iter().map(|variable| variable.range);
        let ranges: Vec<Interval> = variables.chain(constants.iter().map(|c| Interval::closed(*c, *c))).collect();
        forms.of(&e, root, &ranges)
    }

    /// Of a form with these constants.
    pub(super) fn of(form: &Form, variables: usize, constants: &[f64]) -> Self {
        let mut genes = Vec::new();
        write(&form.expressions, form.root, variables, constants, &mut genes);
        Self(genes)
    }
}

/// The node of the tree that `genes` begins with; `genes` then begins behind it.
fn node(genes: &mut &[Gene], e: &mut Expressions, variables: &[&str], constants: &mut Vec<f64>) -> Id {
    let (first, rest) = genes.split_first().expect("a tree has as many nodes as its operations ask for");
    *genes = rest;
    let mut operand = |e: &mut Expressions| node(genes, e, variables, constants);
    match *first {
        Gene::Number(number) => e.number(number),
        Gene::Variable(place) => e.name(variables[place]),
        Gene::Constant(value) => {
            constants.push(value);
            e.name(&Form::constant(constants.len() - 1))
        }
        Gene::Sum => {
            let (a, b) = (operand(e), operand(e));
            e.sum(a, b)
        }
        Gene::Product => {
            let (a, b) = (operand(e), operand(e));
            e.product(a, b)
        }
        Gene::Max => {
            let (a, b) = (operand(e), operand(e));
            e.max(a, b)
        }
        Gene::Min => {
            let (a, b) = (operand(e), operand(e));
            e.min(a, b)
        }
        Gene::Power(p) => {
            let base = operand(e);
            e.power(base, p)
        }
        Gene::Apply(function) => {
            let of = operand(e);
            e.apply(function, of)
        }
    }
}

fn write(e: &Expressions, id: Id, variables: usize, constants: &[f64], genes: &mut Vec<Gene>) {
    let node = e.node(id);
    genes.push(match node {
        Node::Number(number) => Gene::Number(number),
        Node::Name(place) if (place as usize) < variables => Gene::Variable(place as usize),
        Node::Name(place) => Gene::Constant(constants[place as usize - variables]),
        Node::Sum(..) => Gene::Sum,
        Node::Product(..) => Gene::Product,
        Node::Power(_, p) => Gene::Power(p),
        Node::Max(..) => Gene::Max,
        Node::Min(..) => Gene::Min,
        Node::Apply(function, _) => Gene::Apply(function),
    });
    node.operands().for_each(|operand| write(e, operand, variables, constants, genes));
}
