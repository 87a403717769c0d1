//! What expressions mean, one point at a time and without cleverness: what compiled programs are checked against.
use super::expression::{Expressions, Function, Id, Node};

impl Expressions {
    /// The values of `roots` where the names have these values; NaN where any part of them has none, or none that a double holds.
    pub fn evaluate(&self, roots: &[Id], names: &[f64]) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.nodes().len()];
        for id in self.below(roots) {
            let of = |id: Id| values[id.index()];
            let value = match self.node(id) {
                Node::Number(number) => number.value(),
                Node::Name(name) => names[name as usize],
                Node::Sum(a, b) => of(a) + of(b),
                Node::Product(a, b) => of(a) * of(b),
                Node::Power(a, p) => match p.integer().and_then(|n| i32::try_from(n).ok()) {
                    Some(n) => of(a).powi(n),
                    None => of(a).powf(p.value()),
                },
                // Unlike `f64::max`, no value stays no value.
                Node::Max(a, b) | Node::Min(a, b) if of(a).is_nan() || of(b).is_nan() => f64::NAN,
                Node::Max(a, b) => of(a).max(of(b)),
                Node::Min(a, b) => of(a).min(of(b)),
                Node::Apply(function, a) => match (function, of(a)) {
                    (Function::Exp, x) => x.exp(),
                    (Function::Log, x) => x.ln(),
                    (Function::Tanh, x) => x.tanh(),
                    (Function::Abs, x) => x.abs(),
                    (Function::Sign, 0.0) => 0.0,
                    (Function::Sign, x) => x.signum(),
                    (Function::Step, x) if x.is_nan() => x,
                    (Function::Step, x) => f64::from(u8::from(x > 0.0)),
                },
            };
            values[id.index()] = if value.is_finite() { value } else { f64::NAN };
        }
        roots.iter().map(|root| values[root.index()]).collect()
    }

    /// How far rounding may have moved each of `roots`, in units of the rounding error of one operation, to first order
    /// (Higham 2002, ch. 3), where the names have these values.
    pub(super) fn rounding(&self, roots: &[Id], names: &[f64]) -> Vec<f64> {
        let nodes = self.below(roots);
        let mut values = vec![0.0; self.nodes().len()];
        nodes.iter().zip(self.evaluate(&nodes, names)).for_each(|(id, value)| values[id.index()] = value);
        let mut errors = vec![0.0; values.len()];
        for id in nodes {
            let (x, e) = (|id: Id| values[id.index()], |id: Id| errors[id.index()]);
            let carried = match self.node(id) {
                Node::Number(_) | Node::Name(_) => 0.0,
                Node::Sum(a, b) => e(a) + e(b),
                Node::Product(a, b) => x(a).abs() * e(b) + x(b).abs() * e(a),
                Node::Power(a, _) if e(a) == 0.0 => 0.0,
                Node::Power(a, p) => (p.value() * x(a).powf(p.value() - 1.0)).abs() * e(a),
                Node::Max(a, b) | Node::Min(a, b) => e(a).max(e(b)),
                Node::Apply(Function::Exp, a) => x(id) * e(a),
                Node::Apply(Function::Log, a) => e(a) / x(a).abs(),
                Node::Apply(Function::Tanh | Function::Abs, a) => e(a),
                Node::Apply(Function::Sign | Function::Step, _) => 0.0,
            };
            errors[id.index()] = carried + x(id).abs();
        }
        roots.iter().map(|root| errors[root.index()]).collect()
    }
}
