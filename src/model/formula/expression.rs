//! Expressions as one directed acyclic graph: equal operations on equal operands are one node.
use super::rational::Rational;
use std::collections::HashMap;

/// A node of [`Expressions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id(u32);

impl Id {
    /// Its place among the nodes; operands stand before what is made of them.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Function {
    /// eˣ.
    Exp,
    /// ln x.
    Log,
    /// Hyperbolic tangent.
    Tanh,
    /// |x|.
    Abs,
    /// −1, 0 or 1.
    Sign,
    /// 1 above zero, else 0: the slope of max(0, x).
    Step,
}

/// Every function and its name in formulas.
pub const FUNCTIONS: &[(&str, Function)] = &[
    ("exp", Function::Exp),
    ("log", Function::Log),
    ("tanh", Function::Tanh),
    ("abs", Function::Abs),
    ("sign", Function::Sign),
    ("step", Function::Step),
];

/// An operation and its operands. Differences, quotients and roots are sums, products and powers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A number.
    Number(Rational),
    /// A variable or constant, by its place among the names.
    Name(u32),
    /// a + b.
    Sum(Id, Id),
    /// a b.
    Product(Id, Id),
    /// aᵖ.
    Power(Id, Rational),
    /// The greater.
    Max(Id, Id),
    /// The lesser.
    Min(Id, Id),
    /// A function of one operand.
    Apply(Function, Id),
}

impl Node {
    /// Its operands, none of which may be another's.
    pub fn operands(self) -> impl Iterator<Item = Id> {
        let (a, b) = match self {
            Self::Number(_) | Self::Name(_) => (None, None),
            Self::Power(a, _) | Self::Apply(_, a) => (Some(a), None),
            Self::Sum(a, b) | Self::Product(a, b) | Self::Max(a, b) | Self::Min(a, b) => (Some(a), Some(b)),
        };
        a.into_iter().chain(b)
    }
}

/// Nodes and the names that occur in them.
///
/// Constructors fold numbers with numbers and drop 0 +, 1 · and ¹, nothing else: everything further is for simplification, which
/// knows where it is sound.
#[derive(Clone, Debug, Default)]
pub struct Expressions {
    nodes: Vec<Node>,
    places: HashMap<Node, Id>,
    names: Vec<String>,
}

impl Expressions {
    fn add(&mut self, node: Node) -> Id {
        let next = Id(self.nodes.len() as u32);
        *self.places.entry(node).or_insert_with(|| {
            self.nodes.push(node);
            next
        })
    }

    /// The operation of a node.
    pub fn node(&self, id: Id) -> Node {
        self.nodes[id.index()]
    }

    /// Every node, operands first.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The names, in the order of their first use.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The number, if the node is one.
    pub fn as_number(&self, id: Id) -> Option<Rational> {
        match self.node(id) {
            Node::Number(number) => Some(number),
            _ => None,
        }
    }

    /// A number.
    pub fn number(&mut self, number: Rational) -> Id {
        self.add(Node::Number(number))
    }

    /// A variable or constant.
    pub fn name(&mut self, name: &str) -> Id {
        let place = self.names.iter().position(|known| known == name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        self.add(Node::Name(place as u32))
    }

    /// a + b.
    pub fn sum(&mut self, a: Id, b: Id) -> Id {
        match (self.as_number(a), self.as_number(b)) {
            (Some(Rational::ZERO), _) => b,
            (_, Some(Rational::ZERO)) => a,
            (Some(x), Some(y)) if let Some(sum) = x.plus(y) => self.number(sum),
            _ => self.add(Node::Sum(a, b)),
        }
    }

    /// a b; a number stands first.
    pub fn product(&mut self, a: Id, b: Id) -> Id {
        match (self.as_number(a), self.as_number(b)) {
            (Some(Rational::ONE), _) => b,
            (_, Some(Rational::ONE)) => a,
            (Some(x), Some(y)) if let Some(product) = x.times(y) => self.number(product),
            (None, Some(_)) => self.product(b, a),
            (Some(x), None) => {
                if let Node::Product(c, rest) = self.node(b)
                    && let Some(product) = self.as_number(c).and_then(|y| x.times(y))
                {
                    let product = self.number(product);
                    return self.product(product, rest);
                }
                self.add(Node::Product(a, b))
            }
            _ => self.add(Node::Product(a, b)),
        }
    }

    /// aᵖ.
    pub fn power(&mut self, base: Id, exponent: Rational) -> Id {
        if exponent == Rational::ONE {
            return base;
        }
        if exponent == Rational::ZERO {
            return self.number(Rational::ONE);
        }
        match self.node(base) {
            Node::Number(number) if let Some(power) = number.power(exponent) => self.number(power),
            // Undefined for the same numbers, or it could not be merged here.
            Node::Power(inner, p)
                if exponent == Rational::MINUS_ONE
                    && p.sign() > 0
                    && let Some(p) = p.negative() =>
            {
                self.add(Node::Power(inner, p))
            }
            _ => self.add(Node::Power(base, exponent)),
        }
    }

    /// −a.
    pub fn negative(&mut self, a: Id) -> Id {
        let minus = self.number(Rational::MINUS_ONE);
        self.product(minus, a)
    }

    /// a − b.
    pub fn difference(&mut self, a: Id, b: Id) -> Id {
        let b = self.negative(b);
        self.sum(a, b)
    }

    /// a / b.
    pub fn quotient(&mut self, a: Id, b: Id) -> Id {
        let b = self.power(b, Rational::MINUS_ONE);
        self.product(a, b)
    }

    /// The greater; a number stands first.
    pub fn max(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = self.number_first(a, b);
        self.add(Node::Max(a, b))
    }

    /// The lesser; a number stands first.
    pub fn min(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = self.number_first(a, b);
        self.add(Node::Min(a, b))
    }

    fn number_first(&self, a: Id, b: Id) -> (Id, Id) {
        if self.as_number(a).is_none() && self.as_number(b).is_some() { (b, a) } else { (a, b) }
    }

    /// A function of one number.
    pub fn apply(&mut self, function: Function, a: Id) -> Id {
        self.add(Node::Apply(function, a))
    }

    /// A node of the same operation with other operands, through the constructors.
    pub fn rebuilt(&mut self, node: Node, with: impl Fn(Id) -> Id) -> Id {
        match node {
            Node::Number(_) | Node::Name(_) => self.add(node),
            Node::Sum(a, b) => self.sum(with(a), with(b)),
            Node::Product(a, b) => self.product(with(a), with(b)),
            Node::Power(a, p) => self.power(with(a), p),
            Node::Max(a, b) => self.max(with(a), with(b)),
            Node::Min(a, b) => self.min(with(a), with(b)),
            Node::Apply(f, a) => self.apply(f, with(a)),
        }
    }

    /// `root` with `by` in place of a name.
    pub fn substituted(&mut self, root: Id, name: &str, by: Id) -> Id {
        let name = self.name(name);
        let mut made: HashMap<Id, Id> = HashMap::new();
        for id in self.below(&[root]) {
            let new = if id == name { by } else { self.rebuilt(self.node(id), |operand| made[&operand]) };
            made.insert(id, new);
        }
        made[&root]
    }

    /// Whether `root` contains a name.
    pub fn mentions(&self, root: Id, name: &str) -> bool {
        let is = |id: &Id| matches!(self.node(*id), Node::Name(place) if self.names[place as usize] == name);
        self.below(&[root]).iter().any(is)
    }

    /// The nodes that `roots` are made of, operands first.
    pub fn below(&self, roots: &[Id]) -> Vec<Id> {
        let mut needed = vec![false; self.nodes.len()];
        roots.iter().for_each(|root| needed[root.index()] = true);
        for (at, node) in self.nodes.iter().enumerate().rev() {
            if needed[at] {
                node.operands().for_each(|id| needed[id.index()] = true);
            }
        }
        (0..self.nodes.len()).filter(|at| needed[*at]).map(|at| Id(at as u32)).collect()
    }
}
