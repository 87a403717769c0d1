//! Symbolic regression: islands of formulas that breed apart and meet now and then.
use super::DistilSpec;
use super::fitted::Fitted;
use super::front::Front;
use super::island::Island;
use super::samples::Samples;
use super::tree::{Gene, Tree};
use crate::model::formula::{Forms, Rational};
use crate::state::stream;
use crate::watch::Watch;
use anyhow::ensure;
use rayon::prelude::*;

/// Generations between two meetings of the islands.
const APART: usize = 5;
/// Samples that islands fit to; what they find is fitted to all in the end.
const FEW: usize = 256;
/// Steps of that last fit.
const LAST: usize = 60;
/// Rounds in which constants are taken out of what was found.
const ROUNDS: usize = 6;

/// The formulas that genetic programming finds for `samples`, none beaten by a simpler one; same spec and samples, same bits,
/// whatever the number of threads.
///
/// # Errors
/// When a sample is not finite, there are none, the target is zero, or `watch` asks to stop.
pub fn regress(spec: &DistilSpec, samples: &Samples, watch: &Watch) -> anyhow::Result<Front> {
    if let Some(at) = samples.flaw() {
        anyhow::bail!(
            "sample {at} holds a number that is not finite, so no formula can be found; look where it comes from"
        );
    }
    ensure!(samples.target.len() > 1, "there are {} samples; no formula can be found", samples.target.len());
    ensure!(samples.size() > 0.0, "every sample of the target is zero; there is nothing to find");
    let few = samples.thinned(FEW);
    let stream_of = |island: u64| stream(spec.seed, &[u64::from_le_bytes(*b"distil\0\0"), island]);
    let mut islands: Vec<Island<'_>> = (0..spec.islands as u64)
        .map(|island| Island::new(&few, spec.population, spec.complexity, stream_of(island)))
        .collect();
    let bar = watch.stage("distil", spec.generations as u64);
    for generation in 0..spec.generations {
        watch.go_on(|| "stopped; the same command begins this search again".to_owned())?;
        islands.par_iter_mut().for_each(Island::breed);
        if (generation + 1) % APART == 0 {
            let together = together(&islands);
            islands.iter_mut().for_each(|island| island.welcome(&together));
        }
        bar.inc(1);
    }
    bar.finish();
    let found = together(&islands);
    let last = |one: &Fitted| Fitted::new(&one.form, one.constants.clone(), samples, LAST);
    let all: Vec<Option<Fitted>> = found.formulas().par_iter().map(last).collect();
    let mut front = Front::default();
    all.into_iter().flatten().for_each(|one| front.offer(one));
    Ok(pruned(front, samples))
}

/// The front with every constant that can be 0, 1 or −1 at no more error made so: such formulas are simpler, and hard to meet
/// by chance.
fn pruned(mut front: Front, samples: &Samples) -> Front {
    for _ in 0..ROUNDS {
        let trees: Vec<Tree> = front.formulas().iter().flat_map(|one| simpler(one, samples)).collect();
        let fitted = |tree: &Tree| {
            let form = tree.form(samples, &Forms::default())?;
            let constants = form.constants.clone();
            Fitted::new(&form, constants, samples, LAST)
        };
        let all: Vec<Option<Fitted>> = trees.par_iter().map(fitted).collect();
        let before = front.formulas().len();
        let sum = |front: &Front| front.formulas().iter().map(|one| one.form.complexity).sum::<usize>();
        let complexity = sum(&front);
        all.into_iter().flatten().for_each(|one| front.offer(one));
        if front.formulas().len() == before && sum(&front) == complexity {
            break;
        }
    }
    front
}

/// A formula with one of its constants 0, 1 or −1.
fn simpler(one: &Fitted, samples: &Samples) -> Vec<Tree> {
    let tree = Tree::of(&one.form, samples.variables.len(), &one.constants);
    let places = (0..tree.0.len()).filter(|at| matches!(tree.0[*at], Gene::Constant(_)));
    let with = |at: usize| {
        let numbers = [Rational::ZERO, Rational::ONE, Rational::MINUS_ONE];
        numbers.map(|number| tree.replaced(at, &[Gene::Number(number)]))
    };
    places.flat_map(with).collect()
}

fn together(islands: &[Island<'_>]) -> Front {
    let mut front = Front::default();
    let all = islands.iter().flat_map(|island| island.front.formulas());
    all.for_each(|one| front.offer(one.clone()));
    front
}
