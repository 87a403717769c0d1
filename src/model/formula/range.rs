//! Where a name lies, as it is written on the command line.
use super::interval::Interval;
use std::str::FromStr;

/// A name and its interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// The name.
    pub name: String,
    /// Where it lies.
    pub interval: Interval,
}

/// Reads `r=0..0.02`, ends included; `r=0..` and `r=..1` without end; `k=5e4` for a constant.
impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let advice = || format!("`{text}` is no range; write r=0..0.02, r=0.. or, for a constant, k=5e4");
        let (name, range) = text.split_once('=').ok_or_else(advice)?;
        let number = |part: &str, otherwise: f64| match part.trim() {
            "" => Ok(otherwise),
            part => part.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(advice),
        };
        let (low, high) = match range.split_once("..") {
            Some((low, high)) => (number(low, f64::NEG_INFINITY)?, number(high, f64::INFINITY)?),
            None => {
                let value = number(range, f64::NAN)?;
                (value, value)
            }
        };
        if low.is_nan() || low > high || name.trim().is_empty() {
            return Err(advice());
        }
        Ok(Self { name: name.trim().to_owned(), interval: Interval::closed(low, high) })
    }
}
