//! Some of many, at even distances.

/// The places of `count` of `all` things, or of all where there are fewer: the middle of each of as many equal shares, so that neither
/// the first nor the last are preferred.
pub(super) fn spread(count: usize, all: usize) -> impl Iterator<Item = usize> {
    let count = count.min(all);
    (0..count).map(move |i| (2 * i + 1) * all / (2 * count))
}
