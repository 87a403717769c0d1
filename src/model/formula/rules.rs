//! Rewrites that hold for real numbers wherever the variables lie in their intervals.
//!
//! Both sides of a rule have a value at the same points: none divides by what may be zero, forgets a part that may have no value,
//! or takes a root of what may be negative. What a rule needs for that is its condition, a question to [`Facts`].
use super::facts::Facts;
use super::rational::Rational;
use super::term::{Domain, Graph, Term};
use egg::{Id, Rewrite, Subst, Var, rewrite};

/// A condition on what `names` stand for.
fn given<const N: usize>(
    names: [&str; N],
    holds: fn([Facts; N]) -> bool,
) -> impl Fn(&mut Graph, Id, &Subst) -> bool + use<N> {
    let vars: [Var; N] = names.map(|name| name.parse().expect("a variable of a rule"));
    move |graph, _, subst| holds(vars.map(|var| graph[subst[var]].data))
}

/// Every rule.
pub(super) fn rules() -> Vec<Rewrite<Term, Domain>> {
    [sums(), powers(), corners(), exponentials()].into_iter().flatten().collect()
}

fn sums() -> Vec<Rewrite<Term, Domain>> {
    vec![
        rewrite!("sum-commutes"; "(+ ?a ?b)" => "(+ ?b ?a)"),
        rewrite!("sum-associates"; "(+ (+ ?a ?b) ?c)" => "(+ ?a (+ ?b ?c))"),
        rewrite!("sum-with-zero"; "(+ 0 ?a)" => "?a"),
        rewrite!("product-commutes"; "(* ?a ?b)" => "(* ?b ?a)"),
        rewrite!("product-associates"; "(* (* ?a ?b) ?c)" => "(* ?a (* ?b ?c))"),
        rewrite!("product-with-one"; "(* 1 ?a)" => "?a"),
        rewrite!("product-with-zero"; "(* 0 ?a)" => "0" if given(["?a"], |[a]| a.defined)),
        rewrite!("distribute"; "(* ?a (+ ?b ?c))" => "(+ (* ?a ?b) (* ?a ?c))"),
        rewrite!("factor"; "(+ (* ?a ?b) (* ?a ?c))" => "(* ?a (+ ?b ?c))"),
        rewrite!("factor-one"; "(+ ?a (* ?a ?b))" => "(* ?a (+ 1 ?b))"),
        rewrite!("double"; "(+ ?a ?a)" => "(* 2 ?a)"),
    ]
}

fn powers() -> Vec<Rewrite<Term, Domain>> {
    vec![
        rewrite!("square"; "(* ?a ?a)" => "(pow ?a 2)"),
        rewrite!("power-one"; "(pow ?a 1)" => "?a"),
        rewrite!("power-zero"; "(pow ?a 0)" => "1" if given(["?a"], |[a]| a.defined)),
        rewrite!("merge-one"; "(* ?a (pow ?a ?n))" => "(pow ?a (+ 1 ?n))"
            if given(["?a", "?n"], |[a, n]| merges(a, Some(Rational::ONE), n.number))),
        rewrite!("merge"; "(* (pow ?a ?m) (pow ?a ?n))" => "(pow ?a (+ ?m ?n))"
            if given(["?a", "?m", "?n"], |[a, m, n]| merges(a, m.number, n.number))),
        rewrite!("nest"; "(pow (pow ?a ?m) ?n)" => "(pow ?a (* ?m ?n))"
            if given(["?a", "?m", "?n"], |[a, m, n]| nests(a, m.number, n.number))),
        rewrite!("nest-even"; "(pow (pow ?a ?m) ?n)" => "(pow (abs ?a) (* ?m ?n))"
            if given(["?m", "?n"], |[m, n]| is_even(m) && is_positive(m) && both(m.number, n.number, Rational::times))),
        rewrite!("spread"; "(pow (* ?a ?b) ?n)" => "(* (pow ?a ?n) (pow ?b ?n))"
            if given(["?a", "?b", "?n"], |[a, b, n]| spreads(a, b, n))),
        rewrite!("gather"; "(* (pow ?a ?n) (pow ?b ?n))" => "(pow (* ?a ?b) ?n)"
            if given(["?a", "?b", "?n"], |[a, b, n]| spreads(a, b, n))),
        rewrite!("split"; "(pow ?a ?n)" => "(* ?a (pow ?a (+ ?n -1)))"
            if given(["?n"], |[n]| n.number.is_some_and(|n| n.value() > 1.0 && n.plus(Rational::MINUS_ONE).is_some()))),
        rewrite!("split-inverse"; "(pow ?a ?n)" => "(* (pow ?a -1) (pow ?a (+ ?n 1)))"
            if given(["?n"], |[n]| n.number.is_some_and(|n| n.value() < -1.0 && n.plus(Rational::ONE).is_some()))),
        rewrite!("share-inverse-root"; "(* (pow ?a -1) (pow ?a -0.5))" => "(* (pow ?a -0.5) (pow (pow ?a -0.5) 2))"
            if given(["?a"], |[a]| a.interval.is_not_negative())),
    ]
}

fn corners() -> Vec<Rewrite<Term, Domain>> {
    vec![
        rewrite!("max-commutes"; "(max ?a ?b)" => "(max ?b ?a)"),
        rewrite!("max-of-equals"; "(max ?a ?a)" => "?a"),
        rewrite!("max-is-one"; "(max ?a ?b)" => "?a"
            if given(["?a", "?b"], |[a, b]| a.interval.is_at_least(b.interval) && b.defined)),
        rewrite!("min-commutes"; "(min ?a ?b)" => "(min ?b ?a)"),
        rewrite!("min-of-equals"; "(min ?a ?a)" => "?a"),
        rewrite!("min-is-one"; "(min ?a ?b)" => "?b"
            if given(["?a", "?b"], |[a, b]| a.interval.is_at_least(b.interval) && a.defined)),
        rewrite!("abs-above"; "(abs ?a)" => "?a" if given(["?a"], |[a]| a.interval.is_not_negative())),
        rewrite!("abs-below"; "(abs ?a)" => "(* -1 ?a)" if given(["?a"], |[a]| a.interval.is_not_positive())),
        rewrite!("abs-even"; "(pow (abs ?a) ?n)" => "(pow ?a ?n)" if given(["?n"], |[n]| is_even(n))),
        rewrite!("abs-of-product"; "(abs (* ?a ?b))" => "(* (abs ?a) (abs ?b))"),
        rewrite!("abs-by-sign"; "(* ?a (sign ?a))" => "(abs ?a)"),
        rewrite!("sign-of-abs"; "(* (abs ?a) (sign ?a))" => "?a"),
        rewrite!("sign-above"; "(sign ?a)" => "1" if given(["?a"], |[a]| a.interval.is_positive() && a.defined)),
        rewrite!("step-above"; "(step ?a)" => "1" if given(["?a"], |[a]| a.interval.is_positive() && a.defined)),
        rewrite!("step-below"; "(step ?a)" => "0" if given(["?a"], |[a]| a.interval.is_not_positive() && a.defined)),
        rewrite!("step-scaled"; "(step (* ?a ?b))" => "(step ?b)"
            if given(["?a"], |[a]| a.interval.is_positive() && a.defined)),
        rewrite!("step-twice"; "(pow (step ?a) ?n)" => "(step ?a)" if given(["?n"], |[n]| is_positive(n))),
        rewrite!("step-of-max"; "(step (max ?a ?b))" => "(step ?a)"
            if given(["?b"], |[b]| b.interval.is_not_positive() && b.defined)),
        rewrite!("step-below-level"; "(step (+ ?c (* -1 (max 0 ?a))))" => "(step (+ ?c (* -1 ?a)))"
            if given(["?c"], |[c]| c.interval.is_positive())),
        rewrite!("max-by-step"; "(* ?a (step ?a))" => "(max 0 ?a)"),
        rewrite!("step-in-max"; "(* (max 0 ?a) (step ?a))" => "(max 0 ?a)"),
        rewrite!("step-in-power"; "(* (pow (max 0 ?a) ?n) (step ?a))" => "(pow (max 0 ?a) ?n)"
            if given(["?n"], |[n]| is_positive(n))),
        rewrite!("step-in-clamp"; "(* (min ?c (max 0 ?a)) (step ?a))" => "(min ?c (max 0 ?a))"
            if given(["?c"], |[c]| c.interval.is_not_negative())),
    ]
}

fn exponentials() -> Vec<Rewrite<Term, Domain>> {
    vec![
        rewrite!("exp-of-sum"; "(* (exp ?a) (exp ?b))" => "(exp (+ ?a ?b))"),
        rewrite!("exp-to-power"; "(pow (exp ?a) ?n)" => "(exp (* ?n ?a))"),
        rewrite!("exp-of-double"; "(exp (* 2 ?a))" => "(pow (exp ?a) 2)"),
    ]
}

fn is_even(n: Facts) -> bool {
    n.number.and_then(Rational::integer).is_some_and(|n| n % 2 == 0)
}

fn is_positive(n: Facts) -> bool {
    n.number.is_some_and(|n| n.sign() > 0)
}

fn both(m: Option<Rational>, n: Option<Rational>, combine: fn(Rational, Rational) -> Option<Rational>) -> bool {
    m.zip(n).and_then(|(m, n)| combine(m, n)).is_some()
}

fn integers(m: Rational, n: Rational) -> bool {
    m.integer().is_some() && n.integer().is_some()
}

/// Whether aᵐ aⁿ is aᵐ⁺ⁿ, with a value at the same points.
fn merges(a: Facts, m: Option<Rational>, n: Option<Rational>) -> bool {
    let Some((m, n)) = m.zip(n).filter(|(m, n)| m.plus(*n).is_some()) else { return false };
    let real = a.interval.is_not_negative() || integers(m, n);
    real && (a.interval.is_not_zero() || m.sign() * n.sign() > 0)
}

/// Whether (aᵐ)ⁿ is aᵐⁿ, with a value at the same points.
fn nests(a: Facts, m: Option<Rational>, n: Option<Rational>) -> bool {
    let Some((m, n)) = m.zip(n).filter(|(m, n)| m.times(*n).is_some()) else { return false };
    let real = a.interval.is_not_negative() || integers(m, n);
    real && (a.interval.is_not_zero() || m.sign() > 0 || n.sign() > 0)
}

/// Whether (a b)ⁿ is aⁿ bⁿ, with a value at the same points.
fn spreads(a: Facts, b: Facts, n: Facts) -> bool {
    let integer = n.number.is_some_and(|n| n.integer().is_some());
    integer || (a.interval.is_not_negative() && b.interval.is_not_negative())
}
