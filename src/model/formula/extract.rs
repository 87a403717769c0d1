//! The cheapest program in an e-graph, each shared operation paid once.
use super::expression::{Expressions, Id};
use super::term::{Graph, Term, expression};
use egg::Language;
use std::collections::HashMap;

/// Sweeps over the chosen classes; one that changes nothing is the last.
const SWEEPS: usize = 12;
/// What is computed once for a whole array is nearly free.
const UNIFORM: f64 = 0.01;

/// A term for every class that has been reached.
type Choice = HashMap<egg::Id, Term>;

/// The expressions of `roots`: from each class's cheapest tree, and again from the terms `given`, any single exchange that makes
/// the whole cheaper, until none does; the better of the two, so never worse than what was given.
pub(super) fn extract(
    graph: &Graph,
    roots: &[egg::Id],
    given: impl Iterator<Item = (egg::Id, Term)>,
    expressions: &mut Expressions,
) -> Vec<Id> {
    let roots: Vec<egg::Id> = roots.iter().map(|root| graph.find(*root)).collect();
    let trees = trees(graph);
    let mut own = trees.clone();
    own.extend(given.map(|(class, term)| (graph.find(class), term)));
    let (first, second) = (improved(graph, &roots, own), improved(graph, &roots, trees));
    let better = [second, first].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, choice) = better.expect("cheapest trees have no cycles");
    let (_, order) = cost(graph, &choice, &roots).expect("only choices without cycles are kept");
    let mut made: HashMap<egg::Id, Id> = HashMap::new();
    for class in order {
        let id = expression(expressions, graph, &choice[&class], |operand| made[&graph.find(operand)]);
        made.insert(class, id);
    }
    roots.iter().map(|root| made[root]).collect()
}

/// The choice after every single exchange that makes it cheaper, and its cost; `None` where it goes in circles.
fn improved(graph: &Graph, roots: &[egg::Id], mut choice: Choice) -> Option<(f64, Choice)> {
    let (mut best, mut order) = cost(graph, &choice, roots)?;
    for _ in 0..SWEEPS {
        let before = best;
        for class in order {
            for term in &graph[class].nodes {
                let old = choice.insert(class, term.clone()).expect("every class in use has a term");
                match cost(graph, &choice, roots) {
                    Some((total, _)) if total < best - 1e-9 => best = total,
                    _ => {
                        choice.insert(class, old);
                    }
                }
            }
        }
        if best >= before {
            break;
        }
        order = cost(graph, &choice, roots)?.1;
    }
    Some((best, choice))
}

/// The term of each class whose tree is cheapest.
fn trees(graph: &Graph) -> Choice {
    let mut least: HashMap<egg::Id, f64> = HashMap::new();
    let mut choice = Choice::new();
    loop {
        let mut changed = false;
        for class in graph.classes() {
            for term in &class.nodes {
                let below =
                    term.fold(Some(own(graph, term)), |sum, operand| Some(sum? + least.get(&graph.find(operand))?));
                if let Some(total) = below
                    && least.get(&class.id).is_none_or(|old| total < *old)
                {
                    least.insert(class.id, total);
                    choice.insert(class.id, term.clone());
                    changed = true;
                }
            }
        }
        if !changed {
            return choice;
        }
    }
}

/// Cost of all that `roots` need, and those classes with operands first; `None` where a class needs itself.
fn cost(graph: &Graph, choice: &Choice, roots: &[egg::Id]) -> Option<(f64, Vec<egg::Id>)> {
    let mut done: HashMap<egg::Id, bool> = HashMap::new();
    let (mut total, mut order) = (0.0, Vec::new());
    let mut stack: Vec<(egg::Id, bool)> = roots.iter().map(|root| (*root, false)).collect();
    while let Some((class, left)) = stack.pop() {
        let term = choice.get(&class)?;
        if left {
            total += own(graph, term);
            order.push(class);
            done.insert(class, true);
            continue;
        }
        match done.get(&class) {
            Some(true) => continue,
            // Met again before it was left: it lies below itself.
            Some(false) => return None,
            None => {}
        }
        done.insert(class, false);
        stack.push((class, true));
        for operand in term.children() {
            let operand = graph.find(*operand);
            match done.get(&operand) {
                Some(true) => {}
                Some(false) => return None,
                None => stack.push((operand, false)),
            }
        }
    }
    Some((total, order))
}

/// Cost of one operation, in additions.
fn own(graph: &Graph, term: &Term) -> f64 {
    let number = |id: &egg::Id| graph[*id].data.number;
    let uniform = term.all(|operand| graph[operand].data.uniform);
    match term {
        Term::Number(_) | Term::Name(_) => 0.0,
        _ if uniform => UNIFORM,
        // A difference is one operation.
        Term::Product(of) if of.iter().any(|id| number(id).is_some_and(|n| n.value() == -1.0)) => 0.3,
        Term::Sum(_) | Term::Product(_) | Term::Max(_) | Term::Min(_) => 1.0,
        Term::Abs(_) | Term::Sign(_) | Term::Step(_) => 1.0,
        Term::Exp(_) | Term::Log(_) | Term::Tanh(_) => 20.0,
        Term::Power([_, exponent]) => number(exponent).map_or(f64::INFINITY, |p| super::chain::price(p).1),
    }
}
