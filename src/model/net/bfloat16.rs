//! Numbers rounded to bfloat16, by the processor's own instruction where it has one.
use super::squareplus::squareplus;
use numkong::bf16;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{_mm512_cvtneps_pbh, _mm512_loadu_ps};

/// `numbers`, each to nearest, ties to even; what is not a number stays none, and what is below 2⁻¹²⁶ may become zero.
pub(super) fn rounded(numbers: &[f32]) -> Vec<bf16> {
    let mut out = Vec::with_capacity(numbers.len());
    #[cfg(target_arch = "x86_64")]
    if has_instruction() {
        // SAFETY: the processor has just said that it knows the instructions.
        unsafe { append_by_instruction(numbers, &mut out) };
        return out;
    }
    out.extend(numbers.iter().map(|x| nearest(*x)));
    out
}

/// Appends `σ(x + p + q)`, rounded, of all triples of rows.
pub(super) fn activate<'a>(rows: impl Iterator<Item = [&'a [f32]; 3]>, out: &mut Vec<bf16>) {
    #[cfg(target_arch = "x86_64")]
    if has_instruction() {
        // SAFETY: the processor has just said that it knows the instructions.
        unsafe { activate_by_instruction(rows, out) };
        return;
    }
    rows.for_each(|row| append_nearest(row, out));
}

#[cfg(target_arch = "x86_64")]
fn has_instruction() -> bool {
    is_x86_feature_detected!("avx512bf16") && is_x86_feature_detected!("avx512f")
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bf16")]
fn append_by_instruction(numbers: &[f32], out: &mut Vec<bf16>) {
    let (sixteens, rest) = numbers.as_chunks::<16>();
    for sixteen in sixteens {
        out.extend_from_slice(&sixteen_by_instruction(sixteen));
    }
    out.extend(rest.iter().map(|x| nearest(*x)));
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bf16")]
fn activate_by_instruction<'a>(rows: impl Iterator<Item = [&'a [f32]; 3]>, out: &mut Vec<bf16>) {
    for row in rows {
        let [(x, x_rest), (p, p_rest), (q, q_rest)] = row.map(<[f32]>::as_chunks::<16>);
        for (x, (p, q)) in x.iter().zip(p.iter().zip(q)) {
            let active = std::array::from_fn(|k| squareplus(x[k] + p[k] + q[k]));
            out.extend_from_slice(&sixteen_by_instruction(&active));
        }
        append_nearest([x_rest, p_rest, q_rest], out);
    }
}

#[cfg(target_arch = "x86_64")]
#[inline]
#[target_feature(enable = "avx512f,avx512bf16")]
fn sixteen_by_instruction(numbers: &[f32; 16]) -> [bf16; 16] {
    // SAFETY: what is read are the sixteen numbers, and every bit pattern of half their bytes is sixteen of `bf16`, a `u16`.
    unsafe { std::mem::transmute(_mm512_cvtneps_pbh(_mm512_loadu_ps(numbers.as_ptr()))) }
}

#[inline]
fn append_nearest([x, p, q]: [&[f32]; 3], out: &mut Vec<bf16>) {
    out.extend(x.iter().zip(p.iter().zip(q)).map(|(x, (p, q))| nearest(squareplus(x + p + q))));
}

/// NumKong's own cast turns some of what is not a number into zero.
fn nearest(x: f32) -> bf16 {
    let bits = x.to_bits();
    if x.is_nan() { bf16::NAN } else { bf16(((bits + 0x7fff + (bits >> 16 & 1)) >> 16) as u16) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nearest number whose last sixteen bits are zero.
    fn by_distance(x: f32) -> f32 {
        let below = x.to_bits() & 0xffff_0000;
        let [low, high] = [below, below + 0x1_0000].map(|bits| f64::from(f32::from_bits(bits)));
        let (down, up) = ((f64::from(x) - low).abs(), (high - f64::from(x)).abs());
        if down < up || (down == up && below & 0x1_0000 == 0) { low as f32 } else { high as f32 }
    }

    fn numbers() -> Vec<f32> {
        let ties = [0x3f80_8000, 0x3f81_8000, 0xbf80_8000, 0x3f80_7fff, 0x3f80_8001].map(f32::from_bits);
        let spread = (0..1000).map(|i| (i as f32 * 0.37).sin() * 10f32.powi(i % 60 - 30));
        spread.chain(ties).chain([0.0, -0.0, 1.0]).collect()
    }

    #[test]
    fn numbers_are_rounded_to_the_nearest_with_and_without_the_instruction() {
        let numbers = numbers();
        for (x, y) in numbers.iter().zip(rounded(&numbers)) {
            assert_eq!((y.0, nearest(*x).0), ((by_distance(*x).to_bits() >> 16) as u16, y.0), "{x:e}");
        }
    }

    #[test]
    fn what_is_not_a_number_or_infinite_stays_so() {
        for bad in [f32::NAN, f32::from_bits(0x7fff_ffff), f32::from_bits(0xffff_ffff)] {
            for half in rounded(&[bad; 17]).into_iter().chain([nearest(bad)]) {
                assert!(f32::from_bits(u32::from(half.0) << 16).is_nan(), "{bad} became {half:?}");
            }
        }
        for half in rounded(&[f32::NEG_INFINITY; 17]) {
            assert_eq!(f32::from_bits(u32::from(half.0) << 16), f32::NEG_INFINITY);
        }
    }

    #[test]
    fn activations_are_those_that_are_computed_first_and_rounded_then() {
        let row = |step: f32, width: usize| -> Vec<f32> { (0..width).map(|i| 3.0 * (i as f32 * step).sin()).collect() };
        for width in [1, 16, 23, 64, 150] {
            let rows = [0.3, 0.7, 1.1].map(|step| row(step, width));
            let [x, p, q] = rows.each_ref().map(Vec::as_slice);
            let mut made = Vec::new();
            activate([[x, p, q], [q, x, p]].into_iter(), &mut made);
            let sums = [[x, p, q], [q, x, p]].into_iter().flat_map(|[x, p, q]| (0..width).map(|k| x[k] + p[k] + q[k]));
            let expected = rounded(&sums.map(squareplus).collect::<Vec<_>>());
            assert_eq!(made.iter().map(|x| x.0).collect::<Vec<_>>(), expected.iter().map(|x| x.0).collect::<Vec<_>>());
        }
    }
}
