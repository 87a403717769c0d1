//! What paired differences say of who is lower than whom.
use super::Interval;

/// Sorts labelled intervals of differences into those below zero, above zero, and those that zero lies in, in one sentence.
///
/// A claim "lower than" holds for the first, fails for the second and is undecided for the rest.
pub fn verdict(differences: impl IntoIterator<Item = (String, Option<Interval>)>) -> String {
    let mut sorted: [(&str, Vec<String>); 3] = [("lower", vec![]), ("higher", vec![]), ("undecided", vec![])];
    for (label, interval) in differences {
        let Some(Interval { mean, half, .. }) = interval else { continue };
        let place = if mean + half < 0.0 { 0 } else { usize::from(mean - half <= 0.0) + 1 };
        sorted[place].1.push(label);
    }
    let said = sorted.iter().filter(|(_, labels)| !labels.is_empty());
    said.map(|(word, labels)| format!("{word}: {}", labels.join(", "))).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_intervals_that_exclude_zero_decide() {
        let of = |label: &str, values: &[f64]| (label.to_owned(), Interval::of(values));
        let all = [
            of("a", &[-1.0, -1.1, -0.9]),
            of("b", &[-1.0, 1.0, 0.1]),
            of("c", &[2.0, 2.1, 1.9]),
            of("one number", &[-1.0]),
            of("nothing", &[]),
        ];
        assert_eq!(verdict(all), "lower: a; higher: c; undecided: b, one number");
    }
}
