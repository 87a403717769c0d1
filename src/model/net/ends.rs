//! The nodes at one end of some edges.
use std::borrow::Cow;
use std::ops::Range;

/// The rows of nodes that edges start or end at: products with the rest would be products for nobody.
pub(super) struct Ends {
    /// Each row once, in order; where few are missing between the first and the last, those too, as that saves copies.
    rows: Vec<u32>,
    /// Of each edge the place of its node in `rows`.
    places: Vec<u32>,
}

impl Ends {
    /// Of edges whose nodes are `of`.
    pub(super) fn new(of: &[u32]) -> Self {
        let (low, high) = of.iter().fold((u32::MAX, 0), |(low, high), &row| (low.min(row), high.max(row + 1)));
        let mut place = vec![0; high.saturating_sub(low) as usize];
        of.iter().for_each(|row| place[(row - low) as usize] = 1);
        let few_missing = 4 * place.iter().sum::<u32>() as usize >= 3 * place.len();
        let mut rows = Vec::with_capacity(place.len());
        for (row, place) in (low..).zip(&mut place) {
            if few_missing || *place == 1 {
                *place = rows.len() as u32;
                rows.push(row);
            }
        }
        Self { rows, places: of.iter().map(|row| place[(row - low) as usize]).collect() }
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Places of the nodes of the edges in `range`.
    pub(super) fn places(&self, range: Range<usize>) -> impl Iterator<Item = usize> + '_ {
        self.places[range].iter().map(|&place| place as usize)
    }

    /// Their rows of `x`, of `width` numbers each.
    pub(super) fn gather<'a>(&self, x: &'a [f32], width: usize) -> Cow<'a, [f32]> {
        if let Some(run) = self.run() {
            return Cow::Borrowed(&x[run.start * width..run.end * width]);
        }
        let mut rows = Vec::with_capacity(self.len() * width);
        self.own(width).for_each(|row| rows.extend_from_slice(&x[row]));
        Cow::Owned(rows)
    }

    /// Has `add` add to their rows of `x`, of `width` numbers each.
    pub(super) fn scatter(&self, x: &mut [f32], width: usize, add: impl FnOnce(&mut [f32])) {
        if let Some(run) = self.run() {
            return add(&mut x[run.start * width..run.end * width]);
        }
        let mut rows = vec![0.0; self.len() * width];
        add(&mut rows);
        for (to, from) in self.own(width).zip(rows.chunks_exact(width)) {
            x[to].iter_mut().zip(from).for_each(|(to, from)| *to += from);
        }
    }

    /// The rows where they are next to each other.
    fn run(&self) -> Option<Range<usize>> {
        let (first, last) = (*self.rows.first()? as usize, *self.rows.last()? as usize);
        (last - first + 1 == self.len()).then_some(first..last + 1)
    }

    fn own(&self, width: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        self.rows.iter().map(move |&row| row as usize * width..(row as usize + 1) * width)
    }
}
