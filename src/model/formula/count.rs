//! How many operations expressions take when nothing is shared.
use super::chain::price;
use super::expression::{Expressions, Id, Node};
use super::interval::Interval;
use super::rational::Rational;

/// Operations of all `roots` together, each repeated part counted every time; parts that depend on constants alone count nothing.
///
/// As in a program, a difference and a quotient are one operation, and a power is the products, roots and reciprocals it is made of.
pub(super) fn unshared(expressions: &Expressions, roots: &[Id], ranges: &[Interval]) -> u64 {
    let mut counts: Vec<(u64, bool)> = vec![(0, false); expressions.nodes().len()];
    for id in expressions.below(roots) {
        let node = expressions.node(id);
        let of = |id: Id| counts[id.index()];
        let varies = match node {
            Node::Name(name) => ranges[name as usize].point().is_none(),
            _ => node.operands().any(|id| of(id).1),
        };
        let below = node.operands().fold(0u64, |sum, id| sum.saturating_add(of(id).0));
        let minus = |id: Id| match expressions.node(id) {
            Node::Product(a, _) => of(id).1 && expressions.as_number(a) == Some(Rational::MINUS_ONE),
            _ => false,
        };
        let divides = |id: Id| match expressions.node(id) {
            Node::Power(_, p) => of(id).1 && p.sign() < 0,
            _ => false,
        };
        let own = match node {
            _ if !varies => 0,
            Node::Number(_) | Node::Name(_) => 0,
            // The sign belongs to the difference, the reciprocal to the quotient.
            Node::Sum(a, b) => 1 - u64::from(minus(a) || minus(b)),
            Node::Product(a, b) => 1 - u64::from(divides(a) || divides(b)),
            Node::Power(_, p) => u64::from(price(p).0),
            _ => 1,
        };
        counts[id.index()] = (if varies { below.saturating_add(own) } else { 0 }, varies);
    }
    roots.iter().fold(0, |sum, root| sum.saturating_add(counts[root.index()].0))
}
