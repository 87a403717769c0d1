//! What is known about an expression on the stated domain, from what is known about its operands.
use super::expression::Function;
use super::interval::Interval;
use super::rational::Rational;

/// Facts that hold wherever the variables lie in their intervals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    /// Holds every value.
    pub(super) interval: Interval,
    /// Whether it has a value everywhere: no division by zero, no root or logarithm of what has none.
    pub(super) defined: bool,
    /// Its value, where it is an exact number.
    pub(super) number: Option<Rational>,
    /// Whether it depends on no variable, so that it is computed once for a whole array.
    pub(super) uniform: bool,
}

impl Facts {
    /// Of anything.
    pub(super) const UNKNOWN: Self = Self { interval: Interval::ALL, defined: false, number: None, uniform: false };

    /// Of an exact number.
    pub(super) fn number(number: Rational) -> Self {
        let (n, d) = number.parts();
        let value = number.value();
        // Rounded outward unless the quotient is exact.
        let exact = n.unsigned_abs() < 1 << 53 && value.mul_add(d as f64, -(n as f64)) == 0.0 && d < 1 << 53;
        let (low, high) = if exact { (value, value) } else { (value.next_down(), value.next_up()) };
        Self { interval: Interval::closed(low, high), defined: true, number: Some(number), uniform: true }
    }

    /// Of a name with this range; one value makes it a constant.
    pub(super) fn name(interval: Interval) -> Self {
        Self { interval, defined: true, number: None, uniform: interval.point().is_some() }
    }

    fn both(
        self,
        other: Self,
        interval: fn(Interval, Interval) -> Interval,
        number: fn(Rational, Rational) -> Option<Rational>,
    ) -> Self {
        Self {
            interval: interval(self.interval, other.interval),
            defined: self.defined && other.defined,
            number: self.number.zip(other.number).and_then(|(a, b)| number(a, b)),
            uniform: self.uniform && other.uniform,
        }
    }

    pub(super) fn sum(self, other: Self) -> Self {
        self.both(other, Interval::plus, Rational::plus)
    }

    pub(super) fn product(self, other: Self) -> Self {
        self.both(other, Interval::times, Rational::times)
    }

    pub(super) fn power(self, exponent: Rational) -> Self {
        let base = self.interval;
        let has_value = match exponent.integer() {
            Some(n) => n >= 0 || base.is_not_zero(),
            None => base.is_positive() || (base.is_not_negative() && exponent.sign() > 0),
        };
        Self {
            interval: base.power(exponent),
            defined: self.defined && has_value,
            number: self.number.and_then(|n| n.power(exponent)),
            uniform: self.uniform,
        }
    }

    pub(super) fn apply(self, function: Function) -> Self {
        let number = self.number.and_then(|x| match function {
            Function::Exp if x == Rational::ZERO => Some(Rational::ONE),
            Function::Log if x == Rational::ONE => Some(Rational::ZERO),
            Function::Tanh if x == Rational::ZERO => Some(Rational::ZERO),
            Function::Abs if x.sign() < 0 => x.negative(),
            Function::Abs => Some(x),
            Function::Sign => Some(Rational::whole(x.sign())),
            Function::Step => Some(Rational::whole(x.sign().max(0))),
            _ => None,
        });
        let defined = self.defined && (function != Function::Log || self.interval.is_positive());
        Self { interval: self.interval.apply(function), defined, number, uniform: self.uniform }
    }

    pub(super) fn greater(self, other: Self) -> Self {
        self.both(other, Interval::greater, |a, b| a.plus(b.negative()?).map(|gap| if gap.sign() < 0 { b } else { a }))
    }

    pub(super) fn lesser(self, other: Self) -> Self {
        self.both(other, Interval::lesser, |a, b| a.plus(b.negative()?).map(|gap| if gap.sign() < 0 { a } else { b }))
    }

    /// Adds what is known about an equal expression; returns whether that told anything new, to either side.
    ///
    /// An interval only gives way to one that is clearly narrower, or two expressions could narrow each other for ever.
    pub(super) fn learn(&mut self, other: Self) -> (bool, bool) {
        let (mine, theirs) = (*self, other);
        let both = mine.interval.and(theirs.interval);
        let gains = |from: Interval| {
            let signs = |x: Interval| (x.is_not_negative(), x.is_not_positive(), x.is_not_zero());
            let width = |x: Interval| x.high.at - x.low.at;
            signs(from) != signs(both)
                || width(both) < 0.5 * width(from)
                || (width(both).is_finite() && !width(from).is_finite())
        };
        if gains(mine.interval) {
            self.interval = both;
        }
        self.defined |= theirs.defined;
        self.uniform |= theirs.uniform;
        self.number = self.number.or(theirs.number);
        let flags = |x: &Self| (x.defined, x.uniform, x.number);
        (flags(self) != flags(&mine) || gains(mine.interval), flags(self) != flags(&theirs) || gains(theirs.interval))
    }
}
