//! Formulas: what is read is what is printed, derivatives are slopes, and simplification changes no value and no domain.
use pliant::model::formula::{
    Expressions, FUNCTIONS, Id, Interval, Names, POINTS, Rational, Verdict, compile, simplify,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The names of random expressions.
const NAMES: [&str; 3] = ["x", "y", "k"];

fn parse(expressions: &mut Expressions, text: &str) -> Id {
    expressions.parse(text, Names::Any).unwrap_or_else(|error| panic!("{error}"))
}

/// An expression of about two to the power of `depth` words.
fn random(e: &mut Expressions, rng: &mut ChaCha8Rng, depth: u32) -> Id {
    if depth == 0 || rng.random_range(0..8) == 0 {
        return match rng.random_range(0..3) {
            0 => e.number(["2", "-1", "0.5", "3", "-2/3"][rng.random_range(0..5)].parse().unwrap()),
            _ => e.name(NAMES[rng.random_range(0..3)]),
        };
    }
    let (a, b) = (random(e, rng, depth - 1), random(e, rng, depth - 1));
    if [a, b].iter().any(|id| e.as_number(*id) == Some(Rational::ZERO)) {
        // Nobody may write 1/0.
        return e.name("x");
    }
    match rng.random_range(0..11) {
        0 | 1 => e.sum(a, b),
        2 => e.difference(a, b),
        3 | 4 => e.product(a, b),
        5 => e.quotient(a, b),
        6 => e.max(a, b),
        7 => e.min(a, b),
        8 => e.apply(FUNCTIONS[rng.random_range(0..FUNCTIONS.len())].1, a),
        _ => {
            let exponents = ["2", "-1", "1/2", "3/2", "3", "-2", "-1/2", "1/3", "5/2"];
            e.power(a, exponents[rng.random_range(0..exponents.len())].parse::<Rational>().unwrap())
        }
    }
}

/// Expressions with their random streams.
fn cases(count: u64, depth: u32) -> impl Iterator<Item = (Expressions, Id, ChaCha8Rng)> {
    (0..count).map(move |seed| {
        let (mut e, mut rng) = (Expressions::default(), ChaCha8Rng::seed_from_u64(seed));
        NAMES.iter().for_each(|name| {
            e.name(name);
        });
        let id = random(&mut e, &mut rng, depth);
        (e, id, rng)
    })
}

#[test]
fn what_is_printed_is_read_back_as_itself() {
    for (mut e, id, _) in cases(3000, 5) {
        let text = e.print(id);
        let read = parse(&mut e, &text);
        assert_eq!(read, id, "{text} was read as {}", e.print(read));
    }
}

#[test]
fn precedence_is_that_of_mathematics() {
    let mut e = Expressions::default();
    let cases = [
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("8 - 4 - 2", 2.0),
        ("8 / 4 / 2", 1.0),
        ("8 / 4 * 2", 4.0),
        ("2 * -3 + 1", -5.0),
        ("4^-0.5", 0.5),
        ("2e-1 + .5", 0.7),
        ("max(1, 2) * min(3, 4) - sqrt(9)", 3.0),
        ("abs(-3) + sign(-2) + step(0) + step(1e-9)", 3.0),
        ("exp(0) + log(1) + tanh(0)", 1.0),
        ("0 - -x", 1.5),
    ];
    for (text, value) in cases {
        let id = parse(&mut e, text);
        assert_eq!(e.evaluate(&[id], &[1.5])[0], value, "{text}");
    }
}

#[test]
fn derivatives_are_slopes() {
    let mut compared = 0;
    for (mut e, id, mut rng) in cases(1500, 4) {
        for name in ["x", "y"] {
            let slope = e.derivatives(&[id], &[(name, Rational::ONE)])[0];
            let at = [rng.random_range(0.3..2.0), rng.random_range(-2.0..2.0), 0.7];
            let place = NAMES.iter().position(|n| *n == name).unwrap();
            let value = |h: f64| {
                let mut point = at;
                point[place] += h;
                e.evaluate(&[id], &point)[0]
            };
            // Richardson's extrapolation of two central differences; where those disagree, a corner or a pole is near.
            let central = |h: f64| (value(h) - value(-h)) / (2.0 * h);
            let (wide, narrow) = (central(2e-4), central(1e-4));
            let difference = (4.0 * narrow - wide) / 3.0;
            let size = value(0.0).abs().max(difference.abs()).max(1.0);
            let exact = e.evaluate(&[slope], &at)[0];
            // A root of rounding errors has no slope.
            let nothing = exact.is_nan() && (value(0.0).is_nan() || value(0.0).abs() < 1e-12);
            if !difference.is_finite() || (wide - narrow).abs() > 1e-5 * size || nothing {
                continue;
            }
            assert!(
                (exact - difference).abs() <= 1e-6 * size,
                "{} by {name} at {at:?}: {exact}, {difference}",
                e.print(id)
            );
            compared += usize::from(difference != 0.0);
        }
    }
    assert!(compared > 800, "only {compared} slopes showed anything");
}

/// The ranges of the names, of three kinds, all with zero in them or at an end.
fn ranges(kind: u64) -> impl Fn(&str) -> Interval + Copy {
    move |name| match (name, kind % 3) {
        ("k", _) => Interval::closed(0.7, 0.7),
        (_, 0) => Interval::closed(-2.0, 2.0),
        (_, 1) => Interval::closed(0.0, 2.0),
        _ => Interval::open(0.0, 2.0),
    }
}

#[test]
fn simplified_programs_agree_with_the_formula_and_its_slopes() {
    let (mut agreed, mut before, mut after) = (0, 0, 0);
    for (kind, (mut e, id, _)) in cases(120, 4).enumerate() {
        let text = e.print(id);
        let compiled = compile(&mut e, &[id], &[&[("x", Rational::ONE)]], &["x", "y"], ranges(kind as u64));
        match compiled.verdict {
            Verdict::Agrees { points } => {
                assert_eq!(points, POINTS);
                agreed += 1;
                before += compiled.operations.shared;
                after += compiled.operations.simplified;
            }
            Verdict::Kept(why) => assert!(why.contains("has a value at"), "{text}: {why}"),
        }
    }
    assert!(agreed > 70, "only {agreed} formulas were compared");
    assert!(after < before * 7 / 10, "{before} operations became {after}");
}

#[test]
fn simplification_neither_takes_nor_gives_a_value() {
    let mut without = 0;
    for (kind, (mut e, id, _)) in cases(300, 3).enumerate() {
        let range = ranges(kind as u64);
        let intervals: Vec<Interval> = e.names().iter().map(|name| range(name)).collect();
        let short = simplify(&mut e, &[id], &intervals)[0];
        // Where poles and corners are: zero, ends, and numbers that cancel.
        let ends: &[f64] = match kind % 3 {
            0 => &[-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0],
            1 => &[0.0, 0.5, 1.0, 2.0],
            _ => &[0.5, 1.0, 1.5],
        };
        for x in ends {
            for y in ends {
                let [plain, simple] = [id, short].map(|id| e.evaluate(&[id], &[*x, *y, 0.7])[0]);
                let shown = || format!("{} and {} at {x}, {y}", e.print(id), e.print(short));
                assert_eq!(plain.is_finite(), simple.is_finite(), "{}: {plain} and {simple}", shown());
                without += usize::from(!plain.is_finite());
            }
        }
    }
    assert!(without > 100, "only {without} points had no value");
}

/// The simplified text of `text` where x lies in `range`.
fn simplified(text: &str, range: Interval) -> String {
    let mut e = Expressions::default();
    let id = parse(&mut e, text);
    let short = simplify(&mut e, &[id], &[range])[0];
    e.print(short)
}

#[test]
fn what_cancels_depends_on_the_domain() {
    let (around, from_zero, above) =
        (Interval::closed(-1.0, 1.0), Interval::closed(0.0, 1.0), Interval::open(0.0, 1.0));
    assert_eq!(simplified("x / x", above), "1");
    for range in [around, from_zero] {
        assert!(simplified("x / x", range).contains('/'), "{range:?}");
    }
    assert_eq!(simplified("sqrt(x^2)", around), "abs(x)");
    assert_eq!(simplified("sqrt(x^2)", from_zero), "x");
    assert_eq!(simplified("sqrt(x)^2", from_zero), "x");
    assert_eq!(simplified("sqrt(x)^2", around), "sqrt(x)^2");
    assert_eq!(simplified("max(0, x)", from_zero), "x");
    assert_eq!(simplified("max(0, x)", around), "max(0, x)");
    assert_eq!(simplified("step(x)", above), "1");
    assert_eq!(simplified("step(x)", from_zero), "step(x)");
    assert_eq!(simplified("x - x", around), "0");
    assert_ne!(simplified("1/x - 1/x", around), "0");
    assert_eq!(simplified("1/x - 1/x", above), "0");
    assert_eq!(simplified("max(0, 2 - x) - step(2 - x) * (2 - x)", around), "0");
    assert_ne!(simplified("0 * log(x)", around), "0");
}

#[test]
fn mistakes_are_pointed_at() {
    let refused = |text: &str| {
        let names = Names::Only(&["r", "overlap", "stiffness"]);
        Expressions::default().parse(text, names).unwrap_err()
    };
    let typo = refused("2 * stifness * r");
    assert_eq!(typo.column(), 5);
    assert!(typo.to_string().contains("did you mean `stiffness`?"));
    assert!(typo.to_string().ends_with("\n  2 * stifness * r\n      ^^^^^^^^"), "{typo}");
    assert!(refused("sqr(r)").to_string().contains("did you mean `sqrt`?"));
    let cases = [
        ("r + ", 5, "the formula ends"),
        ("(r + 1", 1, "never closed"),
        ("r) + 1", 2, "closes nothing"),
        ("2 r", 3, "operator is missing"),
        ("r ^ overlap", 5, "exponent must be a number"),
        ("r ^ 100", 5, "exponent must be a number"),
        ("max(r)", 6, "two operands"),
        ("exp(r, 2)", 6, "one operand"),
        ("r * * 2", 5, "must stand here"),
        ("r # 2", 3, "means nothing"),
        ("1e99", 1, "18 digits"),
        ("1.2.3 + r", 1, "no number"),
        ("r / 0", 5, "divides by zero"),
        ("äß", 1, "unknown name"),
        ("", 1, "the formula ends"),
    ];
    for (text, column, said) in cases {
        let error = refused(text);
        assert!(error.to_string().contains(said) && error.column() == column, "{text}: {error}");
    }
    for hostile in ["(".repeat(100_000), "-".repeat(100_000), "1+".repeat(100_000), "2^".repeat(100_000)] {
        assert!(refused(&hostile).to_string().contains("split it"));
    }
}
