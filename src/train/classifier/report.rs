//! How well a classifier tells tools apart, and how far its probabilities can be believed.
use serde::{Deserialize, Serialize};

/// What was said of some episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The tools, in the order of the matrix.
    pub tools: Vec<String>,
    /// Number of episodes.
    pub episodes: usize,
    /// Episodes by the tool that made them (rows) and the most probable one (columns).
    pub confusion: Vec<Vec<usize>>,
    /// Share of episodes whose tool is the most probable one.
    pub top_1: f64,
    /// Share of episodes whose tool is among the three most probable ones.
    pub top_3: f64,
    /// Expected calibration error: mean over episodes of |accuracy − confidence| of their bin (Guo et al. 2017, eq. 3).
    pub calibration_error: f64,
    /// Reliability: episodes by the probability of the most probable tool, in ten bins of equal width; empty ones are left out.
    pub reliability: Vec<Share>,
}

/// Episodes about which a classifier was equally sure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Mean probability of the most probable tool.
    pub confidence: f64,
    /// Share of them whose tool that is.
    pub accuracy: f64,
    /// Number of episodes.
    pub count: usize,
}

/// Bins of confidence.
const BINS: usize = 10;

impl Report {
    /// Of the true tool and the probability of each of `tools`, episode by episode.
    pub fn of(tools: &[String], judged: &[(usize, Vec<f64>)]) -> Self {
        let mut confusion = vec![vec![0; tools.len()]; tools.len()];
        let mut bins = vec![(0.0, 0usize, 0usize); BINS];
        let (mut first, mut three) = (0usize, 0usize);
        for (truth, probabilities) in judged {
            let order = ranked(probabilities);
            let (said, rank) = (order[0], order.iter().position(|tool| tool == truth).unwrap_or(order.len()));
            confusion[*truth][said] += 1;
            first += usize::from(rank < 1);
            three += usize::from(rank < 3);
            let sure = probabilities[said];
            let bin = &mut bins[((sure * BINS as f64) as usize).min(BINS - 1)];
            *bin = (bin.0 + sure, bin.1 + usize::from(rank < 1), bin.2 + 1);
        }
        let share = |count: usize| count as f64 / judged.len() as f64;
        let filled = bins.into_iter().filter(|(_, _, count)| *count > 0);
        let reliability: Vec<Share> = filled
            .map(|(sure, right, count)| {
                let mean = |sum: f64| sum / count as f64;
                Share { confidence: mean(sure), accuracy: mean(right as f64), count }
            })
            .collect();
        let gap = |bin: &Share| share(bin.count) * (bin.accuracy - bin.confidence).abs();
        Self {
            tools: tools.to_vec(),
            episodes: judged.len(),
            confusion,
            top_1: share(first),
            top_3: share(three),
            calibration_error: reliability.iter().map(gap).sum(),
            reliability,
        }
    }
}

/// Places of probabilities, the greatest first; of equals the first.
fn ranked(probabilities: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|&a, &b| probabilities[b].total_cmp(&probabilities[a]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_calibration_are_those_of_a_case_done_by_hand() {
        let tools = ["a", "b", "c", "d"].map(String::from);
        let judged = [
            (0, vec![0.9, 0.1, 0.0, 0.0]),
            (0, vec![0.3, 0.65, 0.03, 0.02]),
            (1, vec![0.2, 0.7, 0.05, 0.05]),
            (3, vec![0.4, 0.3, 0.2, 0.1]),
        ];
        let report = Report::of(&tools, &judged);
        assert_eq!(report.confusion, [[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0]]);
        assert_eq!((report.top_1, report.top_3), (0.5, 0.75));
        let counts: Vec<usize> = report.reliability.iter().map(|bin| bin.count).collect();
        assert_eq!(counts, [1, 1, 1, 1]);
        let expected = (0.1 + 0.65 + 0.3 + 0.4) / 4.0;
        assert!((report.calibration_error - expected).abs() < 1e-12, "{report:?}");
    }

    #[test]
    fn who_is_always_right_and_sure_has_no_calibration_error() {
        let sure = |k: usize| vec![f64::from(u8::from(k == 0)), f64::from(u8::from(k == 1))];
        let judged: Vec<_> = (0..20).map(|k| (k % 2, sure(k % 2))).collect();
        let report = Report::of(&["a", "b"].map(String::from), &judged);
        assert_eq!((report.top_1, report.calibration_error), (1.0, 0.0));
        assert_eq!(report.reliability.len(), 1);
    }
}
