//! Intervals: what is known about the values of an expression on a stated domain.
use super::expression::Function;
use super::rational::Rational;

/// All numbers between two ends, each of which may belong to it (closed) or not (open).
///
/// Arithmetic rounds outward wherever it rounds at all, so an interval always holds every value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub(super) low: End,
    pub(super) high: End,
}

/// An end of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct End {
    pub(super) at: f64,
    pub(super) open: bool,
}

impl End {
    fn new(at: f64, open: bool) -> Self {
        Self { at, open: open || at.is_infinite() }
    }
}

impl Interval {
    /// All reals.
    pub const ALL: Self =
        Self { low: End { at: f64::NEG_INFINITY, open: true }, high: End { at: f64::INFINITY, open: true } };

    /// `[low, high]`; infinite ends are open.
    pub fn closed(low: f64, high: f64) -> Self {
        Self { low: End::new(low, false), high: End::new(high, false) }
    }

    /// `(low, high)`.
    pub fn open(low: f64, high: f64) -> Self {
        Self { low: End::new(low, true), high: End::new(high, true) }
    }

    /// The only number, where there is but one.
    pub fn point(self) -> Option<f64> {
        (self.low.at == self.high.at).then_some(self.low.at)
    }

    /// Halfway between its ends.
    pub(super) fn middle(self) -> f64 {
        0.5 * self.low.at + 0.5 * self.high.at
    }

    /// Whether every number is above zero.
    pub fn is_positive(self) -> bool {
        self.low.at > 0.0 || (self.low.at == 0.0 && self.low.open)
    }

    /// Whether no number is below zero.
    pub fn is_not_negative(self) -> bool {
        self.low.at >= 0.0
    }

    /// Whether no number is above zero.
    pub fn is_not_positive(self) -> bool {
        self.high.at <= 0.0
    }

    /// Whether zero is none of them.
    pub fn is_not_zero(self) -> bool {
        self.is_positive() || self.opposite().is_positive()
    }

    /// Whether every number is at least any of `other`.
    pub(super) fn is_at_least(self, other: Self) -> bool {
        self.low.at >= other.high.at
    }

    /// What both hold; the narrower of the two where rounding has left nothing.
    pub(super) fn and(self, other: Self) -> Self {
        let low = if (other.low.at, other.low.open) > (self.low.at, self.low.open) { other.low } else { self.low };
        let high =
            if (-other.high.at, other.high.open) > (-self.high.at, self.high.open) { other.high } else { self.high };
        if low.at <= high.at { Self { low, high } } else { self }
    }

    /// An end that overflowed is still no further than the greatest double.
    fn new(low: End, high: End) -> Self {
        Self { low: End { at: low.at.min(f64::MAX), ..low }, high: End { at: high.at.max(f64::MIN), ..high } }
    }

    fn opposite(self) -> Self {
        let turned = |end: End| End { at: -end.at, open: end.open };
        Self { low: turned(self.high), high: turned(self.low) }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        let end = |a: End, b: End, out: fn(f64) -> f64| {
            let sum = a.at + b.at;
            // Two-sum (Knuth 1969): what rounding took.
            let back = sum - a.at;
            let lost = (a.at - (sum - back)) + (b.at - back);
            End::new(if lost == 0.0 || sum.is_infinite() { sum } else { out(sum) }, a.open || b.open)
        };
        Self::new(end(self.low, other.low, f64::next_down), end(self.high, other.high, f64::next_up))
    }

    pub(super) fn times(self, other: Self) -> Self {
        let pairs = [(self.low, other.low), (self.low, other.high), (self.high, other.low), (self.high, other.high)];
        let end = |(a, b): (End, End), out: fn(f64) -> f64| {
            let attained = |x: End| x.at == 0.0 && !x.open;
            if a.at == 0.0 || b.at == 0.0 {
                return End::new(0.0, !(attained(a) || attained(b)) && (a.open || b.open));
            }
            let product = a.at * b.at;
            let exact = product.is_infinite() || (a.at.mul_add(b.at, -product) == 0.0 && product.abs() > 1e-250);
            End::new(if exact { product } else { out(product) }, a.open || b.open)
        };
        let (mut low, mut high) = (end(pairs[0], f64::next_down), end(pairs[0], f64::next_up));
        for pair in &pairs[1..] {
            let (l, h) = (end(*pair, f64::next_down), end(*pair, f64::next_up));
            low = if (l.at, l.open) < (low.at, low.open) { l } else { low };
            high = if (-h.at, h.open) < (-high.at, high.open) { h } else { high };
        }
        Self::new(low, high)
    }

    pub(super) fn power(self, exponent: Rational) -> Self {
        let p = exponent.value();
        let rising = |x: Self| {
            let end = |e: End, out: fn(f64) -> f64| {
                let exact = e.at == 0.0 || e.at == 1.0 || e.at.is_infinite();
                End::new(if exact { e.at } else { out(e.at.powf(p.abs())) }, e.open)
            };
            let [low, high]: [fn(f64) -> f64; 2] = [|y| y * (1.0 - 1e-14), |y| (y * (1.0 + 1e-14)).next_up()];
            Self::new(end(x.low, low), end(x.high, high))
        };
        let positive = |x: Self| if p > 0.0 { rising(x) } else { rising(x).inverse() };
        match exponent.integer() {
            _ if self.is_not_negative() => positive(self),
            Some(n) if n % 2 == 0 => positive(self.absolute()),
            Some(_) if self.is_not_positive() => positive(self.opposite()).opposite(),
            Some(n) if n > 0 => {
                let below = rising(Self { low: End::new(0.0, false), high: End::new(-self.low.at, self.low.open) });
                let above = rising(Self { low: End::new(0.0, false), high: self.high });
                Self { low: below.opposite().low, high: above.high }
            }
            Some(_) => Self::ALL,
            None if self.high.at <= 0.0 => Self::ALL,
            None => positive(self.and(Self::closed(0.0, f64::INFINITY))),
        }
    }

    /// 1/x of numbers that are not negative.
    fn inverse(self) -> Self {
        let low =
            End::new(if self.high.at.is_infinite() { 0.0 } else { (1.0 / self.high.at).next_down() }, self.high.open);
        let high =
            End::new(if self.low.at > 0.0 { (1.0 / self.low.at).next_up() } else { f64::INFINITY }, self.low.open);
        Self { low, high }
    }

    fn absolute(self) -> Self {
        if self.is_not_negative() {
            self
        } else if self.is_not_positive() {
            self.opposite()
        } else {
            let (a, b) = (self.opposite().high, self.high);
            let high = if (a.at, !a.open) > (b.at, !b.open) { a } else { b };
            Self { low: End::new(0.0, false), high }
        }
    }

    pub(super) fn greater(self, other: Self) -> Self {
        let pick = |a: End, b: End| if (b.at, !b.open) > (a.at, !a.open) { b } else { a };
        let low = if (other.low.at, other.low.open) > (self.low.at, self.low.open) { other.low } else { self.low };
        Self { low, high: pick(self.high, other.high) }
    }

    pub(super) fn lesser(self, other: Self) -> Self {
        self.opposite().greater(other.opposite()).opposite()
    }

    pub(super) fn apply(self, function: Function) -> Self {
        let rising = |f: fn(f64) -> f64| {
            let end = |e: End, out: f64| {
                let y = f(e.at);
                End::new(if y.is_finite() { y + out * (y.abs() * 1e-14 + f64::MIN_POSITIVE) } else { y }, e.open)
            };
            Self::new(end(self.low, -1.0), end(self.high, 1.0))
        };
        match function {
            Function::Exp => rising(f64::exp).and(Self::open(0.0, f64::INFINITY)),
            Function::Log if self.is_positive() => rising(f64::ln),
            Function::Log => Self::ALL,
            Function::Tanh => rising(f64::tanh).and(Self::closed(-1.0, 1.0)),
            Function::Abs => self.absolute(),
            Function::Sign if self.is_positive() => Self::closed(1.0, 1.0),
            Function::Sign if self.opposite().is_positive() => Self::closed(-1.0, -1.0),
            Function::Sign => Self::closed(
                if self.is_not_negative() { 0.0 } else { -1.0 },
                if self.is_not_positive() { 0.0 } else { 1.0 },
            ),
            Function::Step if self.is_positive() => Self::closed(1.0, 1.0),
            Function::Step if self.is_not_positive() => Self::closed(0.0, 0.0),
            Function::Step => Self::closed(0.0, 1.0),
        }
    }
}
