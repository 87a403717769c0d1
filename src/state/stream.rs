//! Random streams: one per purpose, all derived from one seed.
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// The random stream of one purpose: ChaCha8 keyed by SHA-256 of `seed` and the words of `purpose`, little-endian.
///
/// Begin `purpose` with a word that no other user of the seed begins with, such as `u64::from_le_bytes(*b"planning")`, then
/// count (episode, action, tool …). A stream depends on nothing else, so no other stream's use and no thread count moves it.
pub fn stream(seed: u64, purpose: &[u64]) -> ChaCha8Rng {
    let mut hash = Sha256::new();
    for word in std::iter::once(&seed).chain(purpose) {
        hash.update(word.to_le_bytes());
    }
    ChaCha8Rng::from_seed(hash.finalize().into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;
    use std::collections::BTreeSet;

    #[test]
    fn a_stream_repeats_and_no_two_purposes_share_one() {
        let first = |seed, purpose: &[u64]| stream(seed, purpose).random::<u64>();
        assert_eq!(first(3, &[1, 2]), first(3, &[1, 2]));
        let purposes: [&[u64]; 7] = [&[], &[0], &[0, 0], &[1], &[0, 1], &[1, 0], &[256]];
        let seeds = [0, 1, 256, u64::MAX];
        let distinct: BTreeSet<u64> = seeds.iter().flat_map(|&s| purposes.iter().map(move |p| first(s, p))).collect();
        assert_eq!(distinct.len(), seeds.len() * purposes.len());
    }

    #[test]
    fn words_are_uniform() {
        let mut rng = stream(7, &[1]);
        let mean = (0..10_000).map(|_| rng.random::<f64>()).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 4.0 * (1.0f64 / 12.0 / 10_000.0).sqrt(), "mean {mean}");
    }
}
