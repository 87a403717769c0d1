//! Expressions as egg sees them, and back.
use super::expression::{Expressions, Function, Id, Node};
use super::facts::Facts;
use super::interval::Interval;
use super::rational::Rational;
use egg::{Analysis, DidMerge, EGraph, define_language};
use std::fmt;
use std::str::FromStr;

define_language! {
    /// An operation on e-classes; a power's exponent is an operand, which rules only ever match as a number.
    pub(super) enum Term {
        Number(Rational),
        Name(Name),
        "+" = Sum([egg::Id; 2]),
        "*" = Product([egg::Id; 2]),
        "pow" = Power([egg::Id; 2]),
        "max" = Max([egg::Id; 2]),
        "min" = Min([egg::Id; 2]),
        "exp" = Exp(egg::Id),
        "log" = Log(egg::Id),
        "tanh" = Tanh(egg::Id),
        "abs" = Abs(egg::Id),
        "sign" = Sign(egg::Id),
        "step" = Step(egg::Id),
    }
}

/// A name by its place; rules have none, so none is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Name(pub(super) u32);

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "name{}", self.0)
    }
}

impl FromStr for Name {
    type Err = ();
    fn from_str(_: &str) -> Result<Self, ()> {
        Err(())
    }
}

impl Term {
    /// The function that it applies, if it does.
    pub(super) fn function(&self) -> Option<(Function, egg::Id)> {
        Some(match self {
            Self::Exp(a) => (Function::Exp, *a),
            Self::Log(a) => (Function::Log, *a),
            Self::Tanh(a) => (Function::Tanh, *a),
            Self::Abs(a) => (Function::Abs, *a),
            Self::Sign(a) => (Function::Sign, *a),
            Self::Step(a) => (Function::Step, *a),
            _ => return None,
        })
    }

    fn applying(function: Function, a: egg::Id) -> Self {
        match function {
            Function::Exp => Self::Exp(a),
            Function::Log => Self::Log(a),
            Function::Tanh => Self::Tanh(a),
            Function::Abs => Self::Abs(a),
            Function::Sign => Self::Sign(a),
            Function::Step => Self::Step(a),
        }
    }
}

/// The facts about every e-class, from the ranges of the names.
#[derive(Clone, Debug, Default)]
pub(super) struct Domain(pub(super) Vec<Interval>);

pub(super) type Graph = EGraph<Term, Domain>;

impl Analysis<Term> for Domain {
    type Data = Facts;

    fn make(graph: &mut Graph, term: &Term, _: egg::Id) -> Facts {
        let facts = |id: &egg::Id| graph[*id].data;
        match term {
            Term::Number(number) => Facts::number(*number),
            Term::Name(name) => Facts::name(graph.analysis.0[name.0 as usize]),
            Term::Sum([a, b]) => facts(a).sum(facts(b)),
            Term::Product([a, b]) => facts(a).product(facts(b)),
            // In the middle of a sweep a product of exponents may not know yet that it is a number.
            Term::Power([a, p]) => facts(p).number.map_or(Facts::UNKNOWN, |p| facts(a).power(p)),
            Term::Max([a, b]) => facts(a).greater(facts(b)),
            Term::Min([a, b]) => facts(a).lesser(facts(b)),
            _ => {
                let (function, a) = term.function().expect("what is left are functions");
                facts(&a).apply(function)
            }
        }
    }

    fn merge(&mut self, a: &mut Facts, b: Facts) -> DidMerge {
        let (mine, theirs) = a.learn(b);
        DidMerge(mine, theirs)
    }

    fn modify(graph: &mut Graph, id: egg::Id) {
        if let Facts { number: Some(number), defined: true, .. } = graph[id].data {
            let exact = graph.add(Term::Number(number));
            graph.union(id, exact);
        }
    }
}

/// Adds what `roots` are made of to the e-graph; returns their classes, and every term with the class it was put in.
pub(super) fn insert(
    graph: &mut Graph,
    expressions: &Expressions,
    roots: &[Id],
) -> (Vec<egg::Id>, Vec<(egg::Id, Term)>) {
    let mut terms = Vec::new();
    let mut classes = vec![None; expressions.nodes().len()];
    for id in expressions.below(roots) {
        let class = |id: Id| classes[id.index()].expect("operands come first");
        let term = match expressions.node(id) {
            Node::Number(number) => Term::Number(number),
            Node::Name(name) => Term::Name(Name(name)),
            Node::Sum(a, b) => Term::Sum([class(a), class(b)]),
            Node::Product(a, b) => Term::Product([class(a), class(b)]),
            Node::Power(a, p) => Term::Power([class(a), graph.add(Term::Number(p))]),
            Node::Max(a, b) => Term::Max([class(a), class(b)]),
            Node::Min(a, b) => Term::Min([class(a), class(b)]),
            Node::Apply(function, a) => Term::applying(function, class(a)),
        };
        let class = graph.add(term.clone());
        terms.push((class, term));
        classes[id.index()] = Some(class);
    }
    (roots.iter().map(|root| classes[root.index()].expect("every root was added")).collect(), terms)
}

/// The expression of a term whose operands' expressions are known.
pub(super) fn expression(expressions: &mut Expressions, graph: &Graph, term: &Term, of: impl Fn(egg::Id) -> Id) -> Id {
    match term {
        Term::Number(number) => expressions.number(*number),
        Term::Name(name) => {
            let name = expressions.names()[name.0 as usize].clone();
            expressions.name(&name)
        }
        Term::Sum([a, b]) => expressions.sum(of(*a), of(*b)),
        Term::Product([a, b]) => expressions.product(of(*a), of(*b)),
        Term::Power([a, p]) => expressions.power(of(*a), graph[*p].data.number.expect("exponents are numbers")),
        Term::Max([a, b]) => expressions.max(of(*a), of(*b)),
        Term::Min([a, b]) => expressions.min(of(*a), of(*b)),
        _ => {
            let (function, a) = term.function().expect("what is left are functions");
            expressions.apply(function, of(a))
        }
    }
}
