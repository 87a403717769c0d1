//! Exact numbers of formulas: simplification must not round.
use std::fmt;
use std::str::FromStr;

/// `numerator / denominator` in lowest terms, the denominator positive; arithmetic that leaves 64 bits is `None`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Rational {
    numerator: i64,
    denominator: i64,
}

impl Rational {
    /// 0.
    pub const ZERO: Self = Self::whole(0);
    /// 1.
    pub const ONE: Self = Self::whole(1);
    /// −1.
    pub const MINUS_ONE: Self = Self::whole(-1);
    /// ½.
    pub const HALF: Self = Self { numerator: 1, denominator: 2 };

    /// An integer.
    pub const fn whole(numerator: i64) -> Self {
        Self { numerator, denominator: 1 }
    }

    fn reduced(numerator: i128, denominator: i128) -> Option<Self> {
        let (mut a, mut b) = (numerator.unsigned_abs(), denominator.unsigned_abs());
        while b != 0 {
            (a, b) = (b, a % b);
        }
        let divisor = i128::try_from(a).ok().filter(|d| *d != 0 && denominator != 0)? * denominator.signum();
        let part = |n: i128| i64::try_from(n / divisor).ok();
        Some(Self { numerator: part(numerator)?, denominator: part(denominator)? })
    }

    /// The sum.
    pub fn plus(self, other: Self) -> Option<Self> {
        let [a, b, c, d] = [self.numerator, self.denominator, other.numerator, other.denominator].map(i128::from);
        Self::reduced(a.checked_mul(d)?.checked_add(c.checked_mul(b)?)?, b * d)
    }

    /// The product.
    pub fn times(self, other: Self) -> Option<Self> {
        let [a, b, c, d] = [self.numerator, self.denominator, other.numerator, other.denominator].map(i128::from);
        Self::reduced(a * c, b * d)
    }

    /// `selfⁿ` for an integer n of at most 64, or of 0 and 1; `None` for any other, and for zero to a negative power.
    pub fn power(self, exponent: Self) -> Option<Self> {
        if self == Self::ONE || (self == Self::ZERO && exponent.sign() > 0) {
            return Some(self);
        }
        let n = exponent.integer().filter(|n| n.unsigned_abs() <= 64)?;
        let base = if n < 0 { Self::reduced(self.denominator.into(), self.numerator.into())? } else { self };
        (0..n.unsigned_abs()).try_fold(Self::ONE, |power, _| power.times(base))
    }

    /// The opposite.
    pub fn negative(self) -> Option<Self> {
        self.times(Self::MINUS_ONE)
    }

    /// The value, where it is an integer.
    pub fn integer(self) -> Option<i64> {
        (self.denominator == 1).then_some(self.numerator)
    }

    /// −1, 0 or 1.
    pub fn sign(self) -> i64 {
        self.numerator.signum()
    }

    /// The nearest double.
    pub fn value(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }

    /// Numerator and denominator.
    pub fn parts(self) -> (i64, i64) {
        (self.numerator, self.denominator)
    }
}

/// A decimal where that is exact and short, else a fraction.
impl fmt::Display for Rational {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimal = self.value().to_string();
        match decimal.parse::<Rational>() {
            Ok(read) if read == *self => f.write_str(&decimal),
            _ => write!(f, "{}/{}", self.numerator, self.denominator),
        }
    }
}

/// Reads `12`, `-0.5`, `5e-3` and `2/3` exactly.
impl FromStr for Rational {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        if let Some((a, b)) = text.split_once('/') {
            let [a, b] = [a, b].map(|part| part.parse::<i64>().map_err(|_| ()));
            return Self::reduced(a?.into(), b?.into()).ok_or(());
        }
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits: i128 = format!("{whole}{fraction}").parse().map_err(|_| ())?;
        let exponent = exponent.parse::<i32>().map_err(|_| ())?;
        let exponent = exponent.checked_sub(i32::try_from(fraction.len()).map_err(|_| ())?).ok_or(())?;
        let scale = 10i128.checked_pow(exponent.unsigned_abs()).ok_or(())?;
        let read = if exponent < 0 {
            Self::reduced(digits, scale)
        } else {
            digits.checked_mul(scale).and_then(|n| Self::reduced(n, 1))
        };
        read.ok_or(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Rational {
        text.parse().unwrap()
    }

    #[test]
    fn decimals_are_exact() {
        assert_eq!(read("0.1").plus(read("0.2")), Some(read("0.3")));
        assert_eq!(read("2.5e3"), Rational::whole(2500));
        assert_eq!(read("1e-3"), read("1/1000"));
        assert_eq!(read("-6/4"), read("-3/2"));
        assert_eq!(read("2/3").power(Rational::whole(-2)), Some(read("9/4")));
        assert_eq!((read("0.4").to_string(), read("2/3").to_string()), ("0.4".to_owned(), "2/3".to_owned()));
    }

    #[test]
    fn what_does_not_fit_is_refused_and_never_wraps() {
        assert!("1e-40".parse::<Rational>().is_err() && "1e30".parse::<Rational>().is_err());
        assert!("1/0".parse::<Rational>().is_err() && ".".parse::<Rational>().is_err());
        let large = Rational::whole(i64::MAX);
        assert_eq!((large.plus(Rational::ONE), large.times(Rational::whole(2))), (None, None));
        assert_eq!(Rational::whole(i64::MIN).negative(), None);
        assert_eq!(Rational::ZERO.power(Rational::MINUS_ONE), None);
    }
}
