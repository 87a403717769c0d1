//! Simplification by equality saturation (Willsey et al. 2021).
use super::expression::{Expressions, Id};
use super::extract::extract;
use super::interval::Interval;
use super::rules::rules;
use super::term::{Domain, Graph, insert};
use egg::Runner;
use std::time::Duration;

/// Rounds of saturation and extraction, each beginning with what the last found.
const ROUNDS: usize = 3;
/// Limits of a round. There is none of time: the result must not depend on the machine.
const NODES: usize = 2000;
const SWEEPS: usize = 12;

/// Expressions equal to `roots` wherever every name lies in its range, cheaper together or the same.
///
/// `ranges` are those of [`Expressions::names`]; a range of one value makes the name a constant, whose operations count as free.
pub fn simplify(expressions: &mut Expressions, roots: &[Id], ranges: &[Interval]) -> Vec<Id> {
    let rules = rules();
    let mut found = roots.to_vec();
    for _ in 0..ROUNDS {
        let mut graph = Graph::new(Domain(ranges.to_vec()));
        let (classes, given) = insert(&mut graph, expressions, &found);
        let runner = Runner::default()
            .with_egraph(graph)
            .with_node_limit(NODES)
            .with_iter_limit(SWEEPS)
            .with_time_limit(Duration::MAX)
            .run(&rules);
        let next = extract(&runner.egraph, &classes, given.into_iter(), expressions);
        if next == found {
            break;
        }
        found = next;
    }
    found
}
