//! Expressions as instructions: every operation once, what depends on no variable computed beforehand.
use super::chain::{Chain, Inverse, chain};
use super::expression::{Expressions, Id, Node};
use super::interval::Interval;
use super::operation::Operation;
use super::rational::Rational;

/// A result that an instruction can use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    /// An input, by its place among the names.
    Name(u32),
    Constant(f64),
    /// The result of an instruction, by its place.
    Result(u32),
}

/// An operation on values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Instruction {
    pub(super) operation: Operation,
    pub(super) operands: [Value; 2],
}

/// Instructions in order, and the values asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Lowered {
    pub(super) instructions: Vec<Instruction>,
    pub(super) outputs: Vec<Value>,
}

struct Lowering<'a> {
    expressions: &'a Expressions,
    ranges: &'a [Interval],
    /// How often each node is an operand or a root.
    uses: Vec<u32>,
    values: Vec<Option<Value>>,
    instructions: Vec<Instruction>,
}

/// The instructions that compute `roots`; a name whose range is one value is a constant.
pub(super) fn lower(expressions: &Expressions, roots: &[Id], ranges: &[Interval]) -> Lowered {
    let nodes = expressions.below(roots);
    let mut uses = vec![0; expressions.nodes().len()];
    let operands = nodes.iter().flat_map(|id| expressions.node(*id).operands());
    operands.chain(roots.iter().copied()).for_each(|id| uses[id.index()] += 1);
    let mut lowering = Lowering { expressions, ranges, values: vec![None; uses.len()], uses, instructions: Vec::new() };
    let outputs = roots.iter().map(|root| lowering.value(*root)).collect();
    Lowered { instructions: lowering.instructions, outputs }
}

impl Lowering<'_> {
    /// The value of a node, computed when first asked for.
    fn value(&mut self, id: Id) -> Value {
        if let Some(value) = self.values[id.index()] {
            return value;
        }
        let value = match self.expressions.node(id) {
            Node::Number(number) => Value::Constant(number.value()),
            Node::Name(name) => self.ranges[name as usize].point().map_or(Value::Name(name), Value::Constant),
            Node::Sum(a, b) => match (self.opposite_of(a), self.opposite_of(b)) {
                (_, Some(b)) => self.binary(Operation::Subtract, a, b),
                (Some(a), None) => self.binary(Operation::Subtract, b, a),
                (None, None) => self.binary(Operation::Add, a, b),
            },
            Node::Product(a, b) => match (self.divisor(a), self.divisor(b)) {
                (_, Some((base, p))) => self.quotient(a, base, p),
                (Some((base, p)), None) => self.quotient(b, base, p),
                (None, None) => self.binary(Operation::Multiply, a, b),
            },
            Node::Power(a, p) => {
                let base = self.value(a);
                self.power(base, p)
            }
            Node::Max(a, b) => self.binary(Operation::Max, a, b),
            Node::Min(a, b) => self.binary(Operation::Min, a, b),
            Node::Apply(function, a) => {
                let a = self.value(a);
                self.emit(Operation::Apply(function), a, a)
            }
        };
        self.values[id.index()] = Some(value);
        value
    }

    /// x where the node is −x and nobody else needs that.
    fn opposite_of(&self, id: Id) -> Option<Id> {
        let Node::Product(a, x) = self.expressions.node(id) else { return None };
        let opposite = self.expressions.as_number(a) == Some(Rational::MINUS_ONE) && self.uses[id.index()] == 1;
        opposite.then_some(x)
    }

    /// (x, p) where the node is 1/xᵖ, varies, and nobody else needs it: dividing by xᵖ saves a product.
    fn divisor(&self, id: Id) -> Option<(Id, Rational)> {
        let Node::Power(base, exponent) = self.expressions.node(id) else { return None };
        let varies = self.expressions.below(&[base]).iter().any(|id| match self.expressions.node(*id) {
            Node::Name(name) => self.ranges[name as usize].point().is_none(),
            _ => false,
        });
        (exponent.sign() < 0 && varies && self.uses[id.index()] == 1)
            .then(|| exponent.negative().map(|p| (base, p)))
            .flatten()
    }

    fn quotient(&mut self, dividend: Id, base: Id, exponent: Rational) -> Value {
        let (a, base) = (self.value(dividend), self.value(base));
        let b = self.power(base, exponent);
        self.emit(Operation::Divide, a, b)
    }

    fn binary(&mut self, operation: Operation, a: Id, b: Id) -> Value {
        let (a, b) = (self.value(a), self.value(b));
        self.emit(operation, a, b)
    }

    fn power(&mut self, base: Value, exponent: Rational) -> Value {
        let (whole, quarters, inverse) = match chain(exponent) {
            Chain::General(p) => return self.emit(Operation::Power(p), base, base),
            Chain::Roots { whole, quarters, inverse } => (whole, quarters, inverse),
        };
        let mut factors = Vec::new();
        // The largest power of two first: xⁿ = x^(2^k) x^(n − 2^k), each square made of the one before.
        let mut square = base;
        for bit in 0..u32::BITS - whole.leading_zeros() {
            if bit > 0 {
                square = self.emit(Operation::Multiply, square, square);
            }
            if whole >> bit & 1 == 1 {
                factors.push(square);
            }
        }
        if quarters > 0 {
            let root = self.emit(Operation::Root, base, base);
            if quarters >= 2 {
                factors.push(root);
            }
            if quarters % 2 == 1 {
                factors.push(self.emit(Operation::Root, root, root));
            }
        }
        let product = factors.into_iter().reduce(|a, b| self.emit(Operation::Multiply, a, b));
        let product = product.unwrap_or(Value::Constant(1.0));
        match inverse {
            Inverse::Not => product,
            Inverse::Last => self.emit(Operation::Divide, Value::Constant(1.0), product),
        }
    }

    fn emit(&mut self, operation: Operation, a: Value, b: Value) -> Value {
        if let (Value::Constant(x), Value::Constant(y)) = (a, b) {
            return Value::Constant(operation.of(x, y));
        }
        let next = Value::Result(self.instructions.len() as u32);
        let instruction = Instruction { operation, operands: [a, b] };
        // A program is short: looking through it is quicker than hashing.
        match self.instructions.iter().position(|known| *known == instruction) {
            Some(place) => Value::Result(place as u32),
            None => {
                self.instructions.push(instruction);
                next
            }
        }
    }
}
