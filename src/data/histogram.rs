//! How far particles go in a control step, counted in logarithmic bins.
use super::Episode;
use serde::Serialize;

/// Upper ends of the bins but the last \[mm\]: two a decade.
const ENDS: [f64; 9] = [0.01, 0.0316, 0.1, 0.316, 1.0, 3.16, 10.0, 31.6, 100.0];

/// Counts of displacements per control step.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Histogram {
    /// Upper ends of the bins but the last \[mm\]; an end belongs to the bin above it.
    pub ends: [f64; 9],
    /// Particles times steps in each bin.
    pub counts: [u64; 10],
}

impl Histogram {
    /// Of all particles in all steps of `episodes`.
    pub fn of<'a>(episodes: impl IntoIterator<Item = &'a Episode>) -> Self {
        let mut counts = [0; 10];
        for pair in episodes.into_iter().flat_map(|e| e.states.windows(2)) {
            for (a, b) in pair[0].positions.iter().zip(&pair[1].positions) {
                let millimetres = 1e3 * a.distance(*b);
                counts[ENDS.partition_point(|end| *end <= millimetres)] += 1;
            }
        }
        Self { ends: ENDS, counts }
    }

    /// One line a bin: its range, its share, and a bar as long as the share.
    pub fn to_text(&self) -> String {
        let (total, most) =
            (self.counts.iter().sum::<u64>().max(1), self.counts.iter().max().map_or(1, |m| (*m).max(1)));
        let line = |(i, count): (usize, &u64)| {
            let range = match i {
                0 => format!("{:>7} – {:<6}", 0, self.ends[0]),
                _ if i == self.ends.len() => format!("{:>7} and more", self.ends[i - 1]),
                _ => format!("{:>7} – {:<6}", self.ends[i - 1], self.ends[i]),
            };
            // Rounded up, so that a bin with a single particle shows.
            let bar = "█".repeat((40 * count).div_ceil(most) as usize);
            let share = 100.0 * *count as f64 / total as f64;
            format!("  {range:<18} {share:5.1} %  {bar}").trim_end().to_owned() + "\n"
        };
        self.counts.iter().enumerate().map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::made_up;
    use super::*;

    #[test]
    fn displacements_fall_into_their_bins() {
        // Along z every particle goes 3 mm a step, along y the i-th another i mm: 3, √10, √13, √18 and 5 mm.
        let histogram = Histogram::of([&made_up(4)]);
        assert_eq!(histogram.counts, [0, 0, 0, 0, 0, 4, 16, 0, 0, 0]);
        let text = histogram.to_text();
        assert_eq!(text.lines().count(), 10);
        assert!(text.lines().nth(6).unwrap().contains("80.0 %") && text.contains("3.16 – 10"), "{text}");
        assert_eq!(text.matches('█').count(), 50);
    }
}
