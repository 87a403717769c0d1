//! What becomes of a formula, as text.
use super::check::Verdict;
use super::compile::compile;
use super::expression::Expressions;
use super::interval::Interval;
use super::parse::{Names, unknown};
use super::range::Range;
use super::rational::Rational;
use anyhow::{bail, ensure};

/// The derivative of `text` by `wrt`, both simplified, and the operations before and after; a name without a range may be any
/// number.
///
/// # Errors
/// The formula's own, and where `wrt` or a range names what is not in it.
pub fn explain(text: &str, wrt: &str, ranges: &[Range]) -> anyhow::Result<String> {
    let mut e = Expressions::default();
    let formula = e.parse(text, Names::Any)?;
    let names = e.names().to_vec();
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    for name in ranges.iter().map(|range| range.name.as_str()).chain([wrt]) {
        ensure!(known.contains(&name), "the formula {text:?}: {}", unknown("name", name, &known));
    }
    let range = |name: &str| {
        let stated = ranges.iter().rev().find(|range| range.name == name);
        stated.map_or(Interval::ALL, |range| range.interval)
    };
    if range(wrt).point().is_some() {
        bail!("{wrt} is a constant by its range, and nothing changes with it; give it a range such as {wrt}=0..1");
    }
    let slope = e.derivatives(&[formula], &[(wrt, Rational::ONE)])[0];
    let inputs: Vec<&str> = known.iter().copied().filter(|name| range(name).point().is_none()).collect();
    let compiled = compile(&mut e, &[formula], &[&[(wrt, Rational::ONE)]], &inputs, range);
    let operations = compiled.operations;
    let verdict = match &compiled.verdict {
        Verdict::Agrees { points } => format!("the simplified program agrees with the formula at {points} points"),
        Verdict::Kept(why) => format!("not simplified: {why}"),
    };
    Ok(format!(
        "formula     {}\nderivative  {}\nsimplified  {}\n            {}\noperations  {} as written, {} with each repeated part \
         once, {} simplified\ncheck       {verdict}\n",
        e.print(formula),
        e.print(slope),
        e.print(compiled.outputs[0]),
        e.print(compiled.outputs[1]),
        operations.written,
        operations.shared,
        operations.simplified,
    ))
}
