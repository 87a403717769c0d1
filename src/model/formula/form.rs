//! The form of a formula: what is left of it when its constants are free, written the same way whichever way it came.
use super::expression::{Expressions, Id, Node};
use super::facts::Facts;
use super::interval::Interval;
use super::rational::Rational;
use super::rules::rules;
use super::term::{Domain, Graph, Term, expression, insert};
use egg::{Language, Rewrite, Runner};
use std::collections::HashMap;
use std::time::Duration;

/// Limits of saturation: forms are many, and the same limits give the same form to what they prove equal.
const NODES: usize = 160;
const SWEEPS: usize = 5;

/// A formula whose constants are free: every part that depends on constants alone, but 0, 1 and −1, is one of them.
#[derive(Clone, Debug)]
pub struct Form {
    /// Its nodes; the constants are the names `c0`, `c1` … in the order in which it is read.
    pub expressions: Expressions,
    /// Its root.
    pub root: Id,
    /// What the constants are in the formula that it was made of.
    pub constants: Vec<f64>,
    /// Number of variables, constants and operations, −x and max(0, x) being one operation each.
    pub complexity: usize,
}

impl Form {
    /// In ordinary notation.
    pub fn text(&self) -> String {
        self.expressions.print(self.root)
    }

    /// Whether it has a value wherever the names of [`Expressions::names`] lie in `ranges`, as far as intervals can tell.
    pub fn is_defined(&self, ranges: &[Interval]) -> bool {
        let mut known: HashMap<Id, Facts> = HashMap::new();
        for id in self.expressions.below(&[self.root]) {
            let of = |id: Id| known[&id];
            let facts = match self.expressions.node(id) {
                Node::Number(number) => Facts::number(number),
                Node::Name(place) => Facts::name(ranges[place as usize]),
                Node::Sum(a, b) => of(a).sum(of(b)),
                Node::Product(a, b) => of(a).product(of(b)),
                Node::Power(a, p) => of(a).power(p),
                Node::Max(a, b) => of(a).greater(of(b)),
                Node::Min(a, b) => of(a).lesser(of(b)),
                Node::Apply(function, a) => of(a).apply(function),
            };
            known.insert(id, facts);
        }
        known[&self.root].defined
    }

    /// The name of constant `k`.
    pub fn constant(k: usize) -> String {
        format!("c{k}")
    }
}

/// Finds forms by equality saturation (Willsey et al. 2021): of all equal formulas found the one with the least complexity, and
/// among those the first in the order of their texts.
pub struct Forms(Vec<Rewrite<Term, Domain>>);

/// Rules that only programs need: they make formulas longer for the sake of parts that are shared, or are about derivatives.
const OF_PROGRAMS: [&str; 5] = ["split", "step", "share", "abs-by-sign", "max-by-step"];

impl Default for Forms {
    fn default() -> Self {
        let needed =
            |rule: &Rewrite<Term, Domain>| !OF_PROGRAMS.iter().any(|name| rule.name.as_str().starts_with(name));
        Self(rules().into_iter().filter(needed).collect())
    }
}

/// How a class is written: by a free constant, or by a term.
#[derive(Clone)]
struct Written {
    complexity: usize,
    text: String,
    term: Option<Term>,
}

impl Forms {
    /// The form of `root`, a range of one value making a name a constant; `None` where a constant of it is no finite number.
    pub fn of(&self, expressions: &Expressions, root: Id, ranges: &[Interval]) -> Option<Form> {
        let mut graph = Graph::new(Domain(ranges.to_vec()));
        let (classes, _) = insert(&mut graph, expressions, &[root]);
        let runner = Runner::default()
            .with_egraph(graph)
            .with_node_limit(NODES)
            .with_iter_limit(SWEEPS)
            .with_time_limit(Duration::MAX)
            .run(&self.0);
        let graph = runner.egraph;
        let written = shortest(&graph, expressions);
        let class = graph.find(classes[0]);
        let mut form = Form {
            // Terms name names by their places, so the variables keep theirs.
            expressions: named(expressions),
            root: Expressions::default().number(Rational::ZERO),
            constants: Vec::new(),
            complexity: written.get(&class)?.complexity,
        };
        form.root = read(&graph, &written, class, &mut form)?;
        Some(form)
    }
}

/// No nodes but the names of `expressions`.
fn named(expressions: &Expressions) -> Expressions {
    let mut names = Expressions::default();
    expressions.names().iter().for_each(|name| {
        names.name(name);
    });
    names
}

/// Whether a class is written as a free constant.
fn is_free(graph: &Graph, class: egg::Id) -> bool {
    let facts = graph[class].data;
    let fixed = [Rational::ZERO, Rational::ONE, Rational::MINUS_ONE];
    facts.uniform && !facts.number.is_some_and(|number| fixed.contains(&number))
}

/// The shortest way to write each class that can be written.
fn shortest(graph: &Graph, expressions: &Expressions) -> HashMap<egg::Id, Written> {
    let mut found: HashMap<egg::Id, Written> = HashMap::new();
    loop {
        let mut changed = false;
        for class in graph.classes() {
            let ways: Vec<Written> = match is_free(graph, class.id) {
                true => vec![Written { complexity: 1, text: "c".to_owned(), term: None }],
                false => class.nodes.iter().filter_map(|term| way(graph, expressions, term, &found)).collect(),
            };
            for way in ways {
                let shorter = |old: &Written| (way.complexity, way.text.as_str()) < (old.complexity, old.text.as_str());
                if found.get(&class.id).is_none_or(shorter) {
                    found.insert(class.id, way);
                    changed = true;
                }
            }
        }
        if !changed {
            return found;
        }
    }
}

/// How a term is written when its operands are written as found so far.
fn way(graph: &Graph, expressions: &Expressions, term: &Term, found: &HashMap<egg::Id, Written>) -> Option<Written> {
    let operand = |id: &egg::Id| found.get(&graph.find(*id));
    let (complexity, text) = match term {
        // What stands in max(0, x) and −x is not counted.
        Term::Number(number) => (usize::from(*number == Rational::ONE), number.to_string()),
        Term::Name(name) => (1, expressions.names()[name.0 as usize].clone()),
        Term::Power([base, exponent]) => {
            let (base, exponent) = (operand(base)?, graph[*exponent].data.number?);
            (1 + base.complexity, format!("(pow {} {exponent})", base.text))
        }
        _ => {
            let operands = term.children().iter().map(operand).collect::<Option<Vec<_>>>()?;
            let below: usize = operands.iter().map(|one| one.complexity).sum();
            let texts: Vec<&str> = operands.iter().map(|one| one.text.as_str()).collect();
            (1 + below, format!("({term} {})", texts.join(" ")))
        }
    };
    Some(Written { complexity, text, term: Some(term.clone()) })
}

/// Adds what `class` is written as to the form, constants in the order in which they are met.
fn read(graph: &Graph, written: &HashMap<egg::Id, Written>, class: egg::Id, form: &mut Form) -> Option<Id> {
    let Some(term) = &written.get(&class)?.term else {
        let value = graph[class].data.interval.middle();
        form.constants.push(value);
        let name = Form::constant(form.constants.len() - 1);
        return value.is_finite().then(|| form.expressions.name(&name));
    };
    let mut operands: HashMap<egg::Id, Id> = HashMap::new();
    let exponent = if let Term::Power([_, exponent]) = term { Some(*exponent) } else { None };
    for operand in term.children().iter().filter(|operand| Some(**operand) != exponent) {
        // A constant that stands twice is two: each place is free by itself.
        let id = read(graph, written, graph.find(*operand), form)?;
        operands.insert(*operand, id);
    }
    Some(expression(&mut form.expressions, graph, term, |operand| operands[&operand]))
}

#[cfg(test)]
mod tests {
    use super::super::parse::Names;
    use super::*;

    /// The form of a text in which `k`, `m` and `n` are constants, the others variables above zero.
    fn form(text: &str) -> Form {
        let mut e = Expressions::default();
        let root = e.parse(text, Names::Any).unwrap();
        let range = |name: &String| match name.as_str() {
            "k" => Interval::closed(3.0, 3.0),
            "m" => Interval::closed(0.25, 0.25),
            "n" => Interval::closed(-0.5, -0.5),
            _ => Interval::open(0.0, 1.0),
        };
        let ranges: Vec<Interval> = e.names().iter().map(range).collect();
        Forms::default().of(&e, root, &ranges).unwrap()
    }

    #[test]
    fn equal_formulas_have_one_form_and_others_another() {
        let same = [
            vec!["x + x", "x*2", "k*x", "x/k + m*x", "(x + x)*m"],
            vec!["k*max(0, m - x)", "max(0, m - x)/k", "k*m*max(m - x, 0)"],
            vec!["k*x*x", "x^2*k", "(x + x)^2"],
            vec!["x + k", "k + m + x", "x - n"],
            vec!["x*y/y", "x", "max(x, n)"],
        ];
        for (at, texts) in same.iter().enumerate() {
            let forms: Vec<String> = texts.iter().map(|text| form(text).text()).collect();
            assert!(forms.iter().all(|text| *text == forms[0]), "{forms:?}");
            for other in &same[at + 1..] {
                assert_ne!(forms[0], form(other[0]).text());
            }
        }
    }

    #[test]
    fn a_form_with_its_constants_is_the_formula() {
        for text in ["k*max(0, m - x)^1.5*(1 - n*y)", "(x + x)*m + y/k", "exp(k*x - n) + tanh(y)/(x + k)"] {
            let form = form(text);
            let mut e = Expressions::default();
            let root = e.parse(text, Names::Any).unwrap();
            for (x, y) in [(0.1, 0.7), (0.2, 0.3), (0.9, 0.01)] {
                let value = |name: &String| match (name.as_str(), name.strip_prefix('c')) {
                    ("x", _) => x,
                    ("y", _) => y,
                    ("k", _) => 3.0,
                    ("m", _) => 0.25,
                    ("n", _) => -0.5,
                    (_, Some(k)) => form.constants[k.parse::<usize>().unwrap()],
                    _ => f64::NAN,
                };
                let at =
                    |e: &Expressions, root| e.evaluate(&[root], &e.names().iter().map(value).collect::<Vec<_>>())[0];
                let (own, given) = (at(&form.expressions, form.root), at(&e, root));
                assert!((own - given).abs() < 1e-9 * given.abs().max(1e-3), "{text} became {}", form.text());
            }
        }
    }

    #[test]
    fn complexity_counts_variables_constants_and_operations() {
        let counts = ["x", "-x", "max(0, x - m)", "k*x", "k*max(0, m - x)^1.5"].map(|text| form(text).complexity);
        assert_eq!(counts, [1, 2, 4, 3, 8]);
    }
}
