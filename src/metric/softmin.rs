//! The soft minimum of distances: half an iteration of Sinkhorn's algorithm in the log domain.
use glam::DVec3;
use rayon::prelude::*;

/// Points handled at once: two registers of numbers on the machines this is built for.
pub(super) const LANES: usize = 8;
/// Rows of one parallel task.
pub(super) const TASK: usize = 16;
/// Terms below `e⁻⁴⁰` of the largest are not added: a million of them are less than one rounding error.
pub(super) const NEGLIGIBLE: f64 = -40.0;

/// A number for each of eight points.
pub(super) type Lanes = [f64; LANES];

/// Numbers in groups of eight, the last one filled up with `rest`.
pub(super) fn grouped(numbers: impl ExactSizeIterator<Item = f64>, rest: f64) -> Vec<Lanes> {
    let mut groups = vec![[rest; LANES]; numbers.len().div_ceil(LANES)];
    groups.as_flattened_mut().iter_mut().zip(numbers).for_each(|(place, number)| *place = number);
    groups
}

/// Points in groups of eight, axis by axis; the last group is filled up with the origin.
pub(super) fn grouped_points(points: &[DVec3]) -> Vec<[Lanes; 3]> {
    let axis = |group: &[DVec3], axis: usize| std::array::from_fn(|l| group.get(l).map_or(0.0, |p| p[axis]));
    points.chunks(LANES).map(|group| std::array::from_fn(|a| axis(group, a))).collect()
}

/// `softminⱼ(|xᵢ − yⱼ| − gⱼ) = −ε ln (1/M) Σⱼ exp((gⱼ − |xᵢ − yⱼ|)/ε)` \[m\] for every i, the
/// c-transform of entropic transport (Feydy et al. 2019).
///
/// Every row is summed by itself and in order: the same bits on any number of threads.
pub(super) fn softmin(x: &[DVec3], y: &[[Lanes; 3]], g: &[f64], epsilon: f64) -> Vec<f64> {
    let scaled = grouped(g.iter().map(|g| g / epsilon), f64::NEG_INFINITY);
    let mut out = vec![0.0; x.len()];
    out.par_chunks_mut(TASK).zip(x.par_chunks(TASK)).for_each(|(out, x)| {
        let mut z = vec![[0.0; LANES]; scaled.len()];
        for (out, x) in out.iter_mut().zip(x) {
            let most = exponents(*x, y, &scaled, 1.0 / epsilon, &mut z);
            *out = -epsilon * (most + (sum(&z, most) / g.len() as f64).ln());
        }
    });
    out
}

/// `zⱼ = gⱼ/ε − |x − yⱼ|/ε` and the largest of them.
pub(super) fn exponents(x: DVec3, y: &[[Lanes; 3]], scaled: &[Lanes], inverse: f64, z: &mut [Lanes]) -> f64 {
    let mut most = [f64::NEG_INFINITY; LANES];
    for ((y, g), z) in y.iter().zip(scaled).zip(z) {
        // One short loop for each operation: that is how the compiler keeps the root in registers of four.
        let mut s = [0.0; LANES];
        for l in 0..LANES {
            let (dx, dy, dz) = (x.x - y[0][l], x.y - y[1][l], x.z - y[2][l]);
            s[l] = dx * dx + dy * dy + dz * dz;
        }
        s.iter_mut().for_each(|s| *s = s.sqrt());
        for l in 0..LANES {
            s[l] = g[l] - inverse * s[l];
        }
        for l in 0..LANES {
            most[l] = if s[l] > most[l] { s[l] } else { most[l] };
        }
        *z = s;
    }
    most.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// `1/11! … 1/1!, 1/0!`.
const TAYLOR: [f64; 12] = {
    let mut terms = [1.0; 12];
    let mut n = 1;
    while n < 12 {
        terms[11 - n] = terms[12 - n] / n as f64;
        n += 1;
    }
    terms
};

/// Whether any of eight terms counts beside `e^most`.
pub(super) fn counts(z: &Lanes, most: f64) -> bool {
    z.iter().fold(false, |any, z| any | (z - most > NEGLIGIBLE))
}

/// `Σⱼ exp(zⱼ − most)`.
fn sum(z: &[Lanes], most: f64) -> f64 {
    let mut sum = [0.0; LANES];
    for z in z.iter().filter(|z| counts(z, most)) {
        let terms = exp(z, most);
        for l in 0..LANES {
            sum[l] += terms[l];
        }
    }
    sum.iter().sum()
}

/// `e^(z − most)` to 1e-14 for `z − most` at most a few hundred, 1e-304 below −700; in arithmetic alone, so that it is done for
/// four at once: `eˣ = 2ᵏ eʳ`, |r| ≤ ½ ln 2, eʳ by its Taylor series.
pub(super) fn exp(z: &Lanes, most: f64) -> Lanes {
    /// Added to a number it leaves the nearest integer in the lowest bits: 1.5 · 2⁵².
    const ROUND: f64 = 6_755_399_441_055_744.0;
    /// ln 2 in two parts, the first short enough that its product with k is exact.
    const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
    let mut out = [0.0; LANES];
    for l in 0..LANES {
        let x = z[l] - most;
        let x = if x > -700.0 { x } else { -700.0 };
        let shifted = x.mul_add(std::f64::consts::LOG2_E, ROUND);
        let k = shifted - ROUND;
        let r = k.mul_add(-LN_2[1], k.mul_add(-LN_2[0], x));
        let series = TAYLOR.iter().fold(0.0, |sum: f64, term| sum.mul_add(r, *term));
        let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
        out[l] = series * power;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::tests::cloud;

    #[test]
    fn the_exponential_is_that_of_the_standard_library() {
        for k in 0..100_000 {
            let x = 20.0 - 7.2e-3 * f64::from(k);
            let found = exp(&[x; LANES], 0.0)[3];
            assert!((found / x.max(-700.0).exp() - 1.0).abs() < 2e-14, "e^{x} = {found}");
        }
        assert_eq!(exp(&[f64::NEG_INFINITY; LANES], 3.0)[0], exp(&[-700.0; LANES], 0.0)[0]);
    }

    #[test]
    fn it_agrees_with_the_naive_sum_for_every_length_of_the_last_group() {
        let x = cloud(5, 1);
        for count in 1..=17 {
            let (y, g) = (cloud(count, 2), cloud(count, 3).iter().map(|p| p.x).collect::<Vec<_>>());
            for epsilon in [1.0, 0.1] {
                let found = softmin(&x, &grouped_points(&y), &g, epsilon);
                for (x, found) in x.iter().zip(found) {
                    let sum: f64 = y.iter().zip(&g).map(|(y, g)| ((g - x.distance(*y)) / epsilon).exp()).sum();
                    let expected = -epsilon * (sum / count as f64).ln();
                    assert!((found - expected).abs() < 1e-14, "{found} against {expected}");
                }
            }
        }
    }

    #[test]
    fn it_tends_to_the_minimum_and_overflows_nowhere() {
        let (x, y) = ([DVec3::ZERO], [DVec3::X, DVec3::Y * 3.0]);
        let least = softmin(&x, &grouped_points(&y), &[0.0, 0.0], 1e-9)[0];
        assert!((least - 1.0).abs() < 1e-8, "{least}");
        let far = softmin(&x, &grouped_points(&[DVec3::X * 1e6]), &[0.0], 1e-9)[0];
        assert!((far / 1e6 - 1.0).abs() < 1e-15, "{far}");
    }
}
