//! A limit in seconds, by a clock that the plans themselves move on.
use crate::field::space;
use pliant::planner::Objective;
use pliant::problem::{Budget, Metered, Spent};
use pliant::state::ActionSpace;
use std::sync::Mutex;

/// Takes one second a plan, and remembers how many plans it was asked for at a time.
struct Slow {
    space: ActionSpace,
    batches: Mutex<Vec<usize>>,
}

impl Slow {
    fn new() -> Self {
        Self { space: space(&[0.0], &[1.0]), batches: Mutex::default() }
    }

    fn now(&self) -> f64 {
        self.batches.lock().unwrap().iter().sum::<usize>() as f64
    }

    fn begin(&self, plans: &[Vec<f64>]) {
        self.batches.lock().unwrap().push(plans.len());
    }
}

impl Objective for Slow {
    fn space(&self) -> &ActionSpace {
        &self.space
    }
    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        self.begin(plans);
        plans.iter().map(|plan| plan[0]).collect()
    }
    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)> {
        Some((plan[0], vec![1.0]))
    }
    fn gradients(&self, plans: &[Vec<f64>]) -> Vec<Option<(f64, Vec<f64>)>> {
        self.begin(plans);
        plans.iter().map(|plan| self.gradient(plan)).collect()
    }
}

const PLANS: usize = 100;

/// What a batch of `PLANS` plans was answered, by `threads` threads, with what was spent and how many were begun at a time.
fn asked(
    threads: usize,
    by_gradient: bool,
    seconds: Option<f64>,
    rollouts: usize,
) -> (Vec<Option<f64>>, Spent, Vec<usize>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let slow = Slow::new();
    let clock = || slow.now();
    let metered = Metered::new(&slow, Budget { rollouts, gradient_price: 2, seconds }, &clock);
    let plans: Vec<Vec<f64>> = (0..PLANS).map(|i| vec![i as f64 / PLANS as f64]).collect();
    let answers: Vec<Option<f64>> = pool.install(|| match by_gradient {
        true => metered.gradients(&plans).into_iter().map(|answer| answer.map(|(cost, _)| cost)).collect(),
        false => metered.costs(&plans).into_iter().map(|cost| cost.is_finite().then_some(cost)).collect(),
    });
    let spent = metered.spent();
    let batches = slow.batches.lock().unwrap().iter().copied().filter(|count| *count > 0).collect();
    (answers, spent, batches)
}

/// The first `served` plans have their own costs, and the others none.
fn assert_served_in_order(answers: &[Option<f64>], served: usize) {
    for (i, answer) in answers.iter().enumerate() {
        assert_eq!(*answer, (i < served).then_some(i as f64 / PLANS as f64), "plan {i} of {served} served");
    }
    assert_eq!(answers.len(), PLANS);
}

#[test]
fn a_batch_ends_within_one_slice_of_its_limit_in_seconds() {
    for (threads, by_gradient) in [(1, false), (1, true), (3, false), (3, true), (7, false), (7, true)] {
        let limit = 20.0;
        let (answers, spent, batches) = asked(threads, by_gradient, Some(limit), 1000);
        let overrun = spent.seconds - limit;
        assert!(
            (0.0..threads as f64).contains(&overrun),
            "{threads} threads, gradients {by_gradient}: {overrun} s too long"
        );
        let served = if by_gradient { spent.gradients } else { spent.rollouts };
        assert_eq!(
            (served as f64, spent.gradients + spent.rollouts),
            (spent.seconds, served),
            "what took time is what counts"
        );
        assert_served_in_order(&answers, served);
        assert!(batches.iter().all(|count| *count == threads), "no thread waits for the clock: {batches:?}");
    }
}

#[test]
fn rollouts_end_a_batch_at_the_same_plan_however_it_is_sliced() {
    for (by_gradient, served) in [(false, 41), (true, 20)] {
        for (threads, seconds) in [(1, None), (1, Some(1e9)), (3, Some(1e9)), (7, Some(1e9))] {
            let (answers, spent, _) = asked(threads, by_gradient, seconds, 41);
            assert_eq!(
                if by_gradient { spent.gradients } else { spent.rollouts },
                served,
                "{threads} threads, {seconds:?}"
            );
            assert_served_in_order(&answers, served);
        }
    }
}

#[test]
fn without_a_limit_in_seconds_a_batch_is_one() {
    for by_gradient in [false, true] {
        assert_eq!(asked(3, by_gradient, None, 1000).2, [PLANS]);
    }
}
