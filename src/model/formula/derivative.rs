//! Symbolic derivatives, rule by rule on the graph, before any simplification.
use super::expression::{Expressions, Function, Id, Node};
use super::rational::Rational;

/// A direction in the space of names: how fast each of these grows, and nothing else.
pub type Direction<'a> = [(&'a str, Rational)];

impl Expressions {
    /// The derivative of each root along `direction`, `Σ growthₖ ∂root/∂nameₖ`; almost everywhere, where the root has corners.
    ///
    /// At a corner of max and min the slope is that of the first operand, numbers standing first; that of |x| at zero is zero.
    pub fn derivatives(&mut self, roots: &[Id], direction: &Direction<'_>) -> Vec<Id> {
        let growth: Vec<(Id, Id)> =
            direction.iter().map(|(name, growth)| (self.name(name), self.number(*growth))).collect();
        let zero = self.number(Rational::ZERO);
        let nodes = self.below(roots);
        // Nothing stands for zero, so that rules do not write what surely vanishes.
        let mut slopes: Vec<Option<Id>> = vec![None; self.nodes().len()];
        for id in nodes {
            slopes[id.index()] = match growth.iter().find(|(name, _)| *name == id) {
                Some((_, growth)) => Some(*growth),
                None => self.rule(id, self.node(id), |operand| slopes[operand.index()]),
            };
        }
        roots.iter().map(|root| slopes[root.index()].unwrap_or(zero)).collect()
    }

    fn rule(&mut self, id: Id, node: Node, slope: impl Fn(Id) -> Option<Id>) -> Option<Id> {
        match node {
            Node::Number(_) | Node::Name(_) => None,
            Node::Sum(a, b) => self.both(slope(a), slope(b)),
            Node::Product(a, b) => {
                let first = slope(a).map(|by_a| self.product(by_a, b));
                let second = slope(b).map(|by_b| self.product(a, by_b));
                self.both(first, second)
            }
            Node::Power(a, p) => {
                let by_a = slope(a)?;
                let less = p.plus(Rational::MINUS_ONE).expect("exponents are small");
                let (p, rest) = (self.number(p), self.power(a, less));
                let outer = self.product(p, rest);
                Some(self.product(outer, by_a))
            }
            Node::Max(a, b) => self.choice(b, a, slope(a), slope(b)),
            Node::Min(a, b) => self.choice(a, b, slope(a), slope(b)),
            Node::Apply(function, a) => {
                let by_a = slope(a)?;
                let outer = match function {
                    Function::Exp => id,
                    Function::Log => self.power(a, Rational::MINUS_ONE),
                    Function::Tanh => {
                        let (one, square) = (self.number(Rational::ONE), self.power(id, Rational::whole(2)));
                        self.difference(one, square)
                    }
                    Function::Abs => self.apply(Function::Sign, a),
                    // Constant but for their jumps.
                    Function::Sign | Function::Step => return None,
                };
                Some(self.product(outer, by_a))
            }
        }
    }

    fn both(&mut self, a: Option<Id>, b: Option<Id>) -> Option<Id> {
        match (a, b) {
            (Some(a), Some(b)) => Some(self.sum(a, b)),
            (one, None) | (None, one) => one,
        }
    }

    /// The slope of the second operand where `above` > `below`, else that of the first.
    fn choice(&mut self, above: Id, below: Id, first: Option<Id>, second: Option<Id>) -> Option<Id> {
        if first.is_none() && second.is_none() {
            return None;
        }
        let gap = self.difference(above, below);
        let step = self.apply(Function::Step, gap);
        let second = second.map(|slope| self.product(step, slope));
        let first = first.map(|slope| {
            let one = self.number(Rational::ONE);
            let other = self.difference(one, step);
            self.product(other, slope)
        });
        self.both(first, second)
    }
}
