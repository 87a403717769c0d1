//! Expression to text: what it prints is read back as the same expression.
use super::expression::{Expressions, FUNCTIONS, Id, Node};
use super::rational::Rational;

/// How tightly the operator of a text binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Sum,
    Product,
    Sign,
    Power,
    Whole,
}

impl Expressions {
    /// The expression in ordinary notation.
    pub fn print(&self, id: Id) -> String {
        self.text(id).0
    }

    /// The text within something that binds as tightly as `least`.
    fn within(&self, id: Id, least: Binding) -> String {
        let (text, binding) = self.text(id);
        if binding < least { format!("({text})") } else { text }
    }

    fn text(&self, id: Id) -> (String, Binding) {
        match self.node(id) {
            Node::Number(number) => written(number),
            Node::Name(name) => (self.names()[name as usize].clone(), Binding::Whole),
            Node::Sum(a, b) => {
                let a = self.within(a, Binding::Sum);
                let text = match self.opposite(b) {
                    Some(b) => format!("{a} - {b}"),
                    None => format!("{a} + {}", self.within(b, Binding::Product)),
                };
                (text, Binding::Sum)
            }
            Node::Product(a, b) if self.as_number(a) == Some(Rational::MINUS_ONE) => {
                (format!("-{}", self.within(b, Binding::Sign)), Binding::Sign)
            }
            Node::Product(a, b) => {
                let a = self.within(a, Binding::Product);
                let text = match self.node(b) {
                    Node::Power(base, p) if p.sign() < 0 => format!("{a}/{}", self.divisor(base, p)),
                    _ => format!("{a}*{}", self.within(b, Binding::Sign)),
                };
                (text, Binding::Product)
            }
            Node::Power(base, p) if p.sign() < 0 => (format!("1/{}", self.divisor(base, p)), Binding::Product),
            Node::Power(base, p) => self.raised(base, p),
            Node::Max(a, b) => (format!("max({}, {})", self.print(a), self.print(b)), Binding::Whole),
            Node::Min(a, b) => (format!("min({}, {})", self.print(a), self.print(b)), Binding::Whole),
            Node::Apply(function, a) => {
                let name = FUNCTIONS.iter().find(|(_, known)| *known == function).expect("a function of the table").0;
                (format!("{name}({})", self.print(a)), Binding::Whole)
            }
        }
    }

    /// −b without its sign, where it begins with one.
    fn opposite(&self, b: Id) -> Option<String> {
        match self.node(b) {
            Node::Number(number) if number.sign() < 0 => number.negative().map(|n| written(n).0),
            Node::Product(a, rest) => {
                let opposite = self.as_number(a).filter(|n| n.sign() < 0).and_then(Rational::negative)?;
                if opposite == Rational::ONE {
                    return Some(self.within(rest, Binding::Product));
                }
                let factor = written(opposite).0;
                Some(match self.node(rest) {
                    Node::Power(base, p) if p.sign() < 0 => format!("{factor}/{}", self.divisor(base, p)),
                    _ => format!("{factor}*{}", self.within(rest, Binding::Sign)),
                })
            }
            _ => None,
        }
    }

    /// What a quotient divides by: baseᵖ for the power −p.
    fn divisor(&self, base: Id, exponent: Rational) -> String {
        match exponent.negative() {
            Some(Rational::ONE) => self.within(base, Binding::Sign),
            Some(p) => self.raised(base, p).0,
            None => unreachable!("exponents are far below the largest integer"),
        }
    }

    fn raised(&self, base: Id, exponent: Rational) -> (String, Binding) {
        if exponent == Rational::HALF {
            return (format!("sqrt({})", self.print(base)), Binding::Whole);
        }
        let (text, binding) = written(exponent);
        let exponent = if binding < Binding::Power { format!("({text})") } else { text };
        (format!("{}^{exponent}", self.within(base, Binding::Whole)), Binding::Power)
    }
}

fn written(number: Rational) -> (String, Binding) {
    let text = number.to_string();
    let binding = match (text.contains('/'), number.sign() < 0) {
        (true, _) => Binding::Product,
        (false, true) => Binding::Sign,
        (false, false) => Binding::Whole,
    };
    (text, binding)
}
