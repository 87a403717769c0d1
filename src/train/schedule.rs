//! How the learning rate changes over training.

/// Learning rate of step `step` ∈ 1..=`steps`: linear warm-up to `peak` over `warm_up` steps, then half a cosine down to
/// `last · peak` at the end (Loshchilov & Hutter 2017, eq. 5, one cycle).
pub fn rate_at(step: u64, steps: u64, warm_up: u64, peak: f64, last: f64) -> f64 {
    if step < warm_up {
        return peak * step as f64 / warm_up as f64;
    }
    let done = (step - warm_up) as f64 / steps.saturating_sub(warm_up).max(1) as f64;
    peak * (last + (1.0 - last) * 0.5 * (1.0 + (std::f64::consts::PI * done.min(1.0)).cos()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rises_to_the_peak_and_falls_to_the_last_rate() {
        let rates: Vec<f64> = (1..=100).map(|s| rate_at(s, 100, 10, 2.0, 0.1)).collect();
        assert!((rates[9] - 2.0).abs() < 1e-12 && (rates[99] - 0.2).abs() < 1e-12);
        assert!(rates[..10].windows(2).all(|r| r[0] < r[1]) && rates[9..].windows(2).all(|r| r[0] > r[1]));
        assert_eq!(rate_at(7, 10, 0, 3.0, 1.0), 3.0, "no warm-up and no decay: constant");
    }
}
