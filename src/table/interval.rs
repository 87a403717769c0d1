//! Mean and 95 % confidence interval of a small sample.
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::collections::BTreeMap;

/// `mean ± half` of n numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Arithmetic mean.
    pub mean: f64,
    /// Half width of the 95 % interval, `t₀.₉₇₅(n − 1) s / √n` (Student 1908); infinite for one number.
    pub half: f64,
    /// Sample size n.
    pub count: usize,
}

impl Interval {
    /// The interval of `values`, or `None` when there are none or one is not finite.
    pub fn of(values: &[f64]) -> Option<Self> {
        if values.is_empty() || values.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let half = if values.len() == 1 {
            f64::INFINITY
        } else {
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let student = StudentsT::new(0.0, 1.0, n - 1.0).expect("at least one degree of freedom");
            student.inverse_cdf(0.975) * (variance / n).sqrt()
        };
        Some(Self { mean, half, count: values.len() })
    }

    /// The interval over seeds of (seed, value) pairs: values of one seed share its start, so they are averaged first.
    pub fn over_seeds(values: impl IntoIterator<Item = (u64, f64)>) -> Option<Self> {
        let mut seeds: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
        values.into_iter().for_each(|(seed, value)| seeds.entry(seed).or_default().push(value));
        let means: Vec<f64> = seeds.values().map(|all| all.iter().sum::<f64>() / all.len() as f64).collect();
        Self::of(&means)
    }

    /// An interval of lengths \[m\] as millimetres for a table: `mean ± half`, the mean alone for one number, a dash for none.
    pub fn millimetres(interval: Option<Self>) -> String {
        Self::scaled(interval, 1e3)
    }

    /// An interval of shares for a table, likewise.
    pub fn shares(interval: Option<Self>) -> String {
        Self::scaled(interval, 1.0)
    }

    fn scaled(interval: Option<Self>, scale: f64) -> String {
        match interval {
            Some(i) if i.half.is_finite() => format!("{:.2} ± {:.2}", scale * i.mean, scale * i.half).replace('-', "−"),
            Some(i) => format!("{:.2}", scale * i.mean).replace('-', "−"),
            None => "–".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    #[test]
    fn covers_the_true_mean_in_ninety_five_of_a_hundred_samples() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let trials = 4000;
        let covered = (0..trials)
            .filter(|_| {
                let sample: Vec<f64> = (0..5).map(|_| 2.0 + rng.sample::<f64, _>(StandardNormal)).collect();
                let interval = Interval::of(&sample).expect("five finite numbers");
                (interval.mean - 2.0).abs() <= interval.half
            })
            .count() as f64;
        assert!((covered / trials as f64 - 0.95).abs() < 0.012, "covered {covered} of {trials}");
    }

    #[test]
    fn repeating_every_value_of_a_seed_makes_no_interval_narrower() {
        let values = [(0, 1.0), (1, 2.0), (2, 4.0)];
        let once = Interval::over_seeds(values);
        assert_eq!(once, Interval::of(&[1.0, 2.0, 4.0]));
        assert_eq!(once, Interval::over_seeds(values.iter().chain(&values).copied()));
    }

    #[test]
    fn says_nothing_about_nothing() {
        assert_eq!(Interval::of(&[]), None);
        assert_eq!(Interval::of(&[1.0, f64::NAN]), None);
        assert_eq!(Interval::of(&[1.0]).map(|i| i.half), Some(f64::INFINITY));
    }
}
