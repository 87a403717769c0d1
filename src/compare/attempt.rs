//! One attempt: a model, a planner, a goal and a seed, from the first observation to the last action.
use super::run::Run;
use super::{Bench, Contender, Goal, Row};
use crate::planner::Planner;
use crate::world::World;
use anyhow::Context;
use glam::DVec3;
use indexmap::IndexMap;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A result row and the shapes behind it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// The numbers.
    pub row: Row,
    /// Particles before the first action \[m\].
    pub start: Vec<DVec3>,
    /// Points of the goal \[m\].
    pub goal: Vec<DVec3>,
    /// Particles after the last action \[m\].
    pub achieved: Vec<DVec3>,
}

/// Who attempts what.
pub(super) struct Entry<'a> {
    pub(super) contender: &'a Contender,
    pub(super) planner: (&'a str, &'a dyn Planner),
    pub(super) goal: (&'a str, &'a Goal),
    /// Every metric between two samplings of the goal, by name.
    pub(super) floors: &'a IndexMap<String, Option<f64>>,
    pub(super) seed: u64,
    pub(super) start: &'a World,
}

/// Observe, choose tool and motion, execute, and again for every action.
///
/// The entries plan one after the other, for their seconds are compared, and then execute side by side.
pub(super) fn attempt(bench: &Bench<'_>, entries: &[&Entry<'_>]) -> anyhow::Result<Vec<Attempt>> {
    let mut runs = entries.iter().map(|entry| Run::new(bench, entry)).collect::<anyhow::Result<Vec<_>>>()?;
    for action in 0..bench.spec.actions as u64 {
        let mut planned = Vec::new();
        for run in &mut runs {
            let next = run.plan(action).with_context(|| {
                let Entry { contender, planner, goal, .. } = run.entry;
                format!("planning with {} and {} to {}", contender.name, planner.0, goal.0)
            })?;
            planned.extend(next.map(|act| (run, act)));
        }
        planned.into_par_iter().for_each(|(run, act)| {
            run.act(&act);
            run.disturb(action);
        });
    }
    Ok(runs.iter().map(Run::result).collect())
}
