//! The formulas of a law as programs over the invariants of a block of meetings.
use super::spec::{Between, FormulaSpec, Reach};
use crate::model::formula::{
    Compiled, Direction, Expressions, Id, Interval, Names, Program, Rational, Verdict, compile,
};
use anyhow::{anyhow, ensure};
use indexmap::IndexMap;
use std::sync::OnceLock;

/// Inputs of every program, in this order: r, overlap, v·n, |v_t|². The last is in no config; `vt` is its root.
const INPUTS: [&str; 4] = ["r", "overlap", "vn", "vt2"];
/// Names that mean something already.
const RESERVED: [&str; 7] = ["r", "overlap", "vn", "vt", "vt2", "normal", "reach"];

/// What each program puts out, and what the adjoint's puts out after it: their slopes along r, v·n and |v_t|².
pub(super) const OUTPUTS: usize = 2;
/// Along r the overlap shrinks.
const ALONG: [&Direction<'static>; 3] =
    [&[("r", Rational::ONE), ("overlap", Rational::MINUS_ONE)], &[("vn", Rational::ONE)], &[("vt2", Rational::ONE)]];

/// Below the square of any speed that matters: keeps T/|v_t| and its slopes quotients of numbers at rest, where their third power
/// is still a number.
pub(super) const REST: f64 = 1e-100;

/// Whether a law looks at velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Motion {
    /// It does not.
    None,
    /// At the separating speed only.
    Normal,
    /// At the sliding velocity too.
    Sliding,
}

/// The formulas of one law, compiled: `N`, the acceleration along the normal, and `T/|v_t|`.
#[derive(Debug)]
pub struct Programs {
    expressions: Expressions,
    formulas: [Id; OUTPUTS],
    ranges: IndexMap<String, Interval>,
    forward: Compiled,
    /// Compiled when a gradient is first asked for.
    adjoint: OnceLock<Compiled>,
    /// Compiled when a gradient by constants is first asked for.
    slopes: OnceLock<Compiled>,
    /// Every constant with the derivative of the reach by it.
    constants: Vec<(String, f64)>,
    pub(super) reach: f64,
    pub(super) motion: Motion,
}

impl Programs {
    /// Parses and compiles the formulas of a config.
    ///
    /// # Errors
    /// A sentence naming the key and, inside a formula, the column.
    pub fn new(spec: &FormulaSpec) -> anyhow::Result<Self> {
        let mut e = Expressions::default();
        for (name, value) in &spec.constants {
            ensure!(value.is_finite(), "constants.{name} must be finite, got {value}");
            ensure!(!RESERVED.contains(&name.as_str()), "constants.{name} hides what `{name}` means; rename it");
            let word = e.parse(name, Names::Any).is_ok_and(|id| e.print(id) == *name && e.mentions(id, name));
            ensure!(word, "constants.{name} is no name: letters, digits and _, a letter first");
        }
        let constants: Vec<&str> = spec.constants.keys().map(String::as_str).collect();
        let (reach, of_constants) = reach(spec, &mut e, &constants)?;
        let reaches = reach_slopes(spec, &mut e, of_constants);

        let mut parse = |key: &str, text: &Option<String>, invariants: &[&str]| -> anyhow::Result<Option<Id>> {
            let names = [invariants, &["reach"], &constants].concat();
            let found = text.as_ref().map(|text| e.parse(text, Names::Only(&names)));
            found.transpose().map_err(|error| anyhow!("{key}: {error}"))
        };
        let energy = parse("energy", &spec.energy, &INPUTS[..2])?;
        let normal = parse("normal_force", &spec.normal_force, &["r", "overlap", "vn", "vt"])?;
        let tangential = parse("tangential_force", &spec.tangential_force, &["r", "overlap", "vn", "vt", "normal"])?;
        let given = [energy, normal, tangential];
        ensure!(given.iter().any(Option::is_some), "give it an energy, a normal_force or a tangential_force");
        for name in constants {
            let used = given.iter().chain([&of_constants]).flatten().any(|id| e.mentions(*id, name));
            ensure!(used, "constants.{name} is in no formula; remove it, or use it");
        }
        let formulas = formulas(&mut e, energy, normal, tangential);

        let mut ranges: IndexMap<String, Interval> =
            spec.constants.iter().map(|(name, value)| (name.clone(), Interval::closed(*value, *value))).collect();
        let (distance, overlap) = match spec.between {
            Between::Particles => (Interval::open(0.0, reach), Interval::open(0.0, reach)),
            _ => (Interval::open(f64::NEG_INFINITY, reach), Interval::open(0.0, f64::INFINITY)),
        };
        let known = [distance, overlap, Interval::ALL, Interval::open(0.0, f64::INFINITY)];
        ranges.extend(INPUTS.map(str::to_owned).into_iter().zip(known));
        ranges.insert("reach".into(), Interval::closed(reach, reach));

        let says = |name: &str| formulas.iter().any(|id| e.mentions(*id, name));
        let motion = match (spec.tangential_force.is_some() || says("vt2"), says("vn")) {
            (true, _) => Motion::Sliding,
            (false, true) => Motion::Normal,
            (false, false) => Motion::None,
        };
        let forward = compiled(&mut e.clone(), &formulas, &[], &ranges);
        let (adjoint, slopes) = (OnceLock::new(), OnceLock::new());
        Ok(Self { expressions: e, formulas, ranges, forward, adjoint, slopes, constants: reaches, reach, motion })
    }

    /// N and T \[m/s²\] in meetings of distance r \[m\], separating speed v_n and sliding speed |v_t| \[m/s\]; zero beyond
    /// the reach.
    pub fn forces(&self, meetings: &[[f64; 3]]) -> Vec<[f64; 2]> {
        let column = |of: &dyn Fn(&[f64; 3]) -> f64| meetings.iter().map(of).collect::<Vec<f64>>();
        let inputs = [
            column(&|[r, ..]| *r),
            column(&|[r, ..]| self.reach - r),
            column(&|[_, vn, _]| *vn),
            column(&|[.., vt]| vt * vt + REST),
        ];
        let inputs: Vec<&[f64]> = inputs.iter().map(Vec::as_slice).collect();
        let found = self.forward.program.evaluate(meetings.len(), &inputs);
        let one = |(k, [r, _, vt]): (usize, &[f64; 3])| {
            if *r < self.reach { [found[0][k], found[1][k] * vt] } else { [0.0, 0.0] }
        };
        meetings.iter().enumerate().map(one).collect()
    }

    /// The program of the accelerations.
    pub fn forward(&self) -> &Compiled {
        &self.forward
    }

    /// The program of the accelerations and all slopes that the adjoint needs.
    pub fn adjoint(&self) -> &Compiled {
        self.adjoint.get_or_init(|| compiled(&mut self.expressions.clone(), &self.formulas, &ALONG, &self.ranges))
    }

    /// The program of the accelerations and their slopes along every constant, at a fixed reach, and along the reach.
    pub fn slopes(&self) -> &Compiled {
        self.slopes.get_or_init(|| {
            let named: Vec<[(&str, Rational); 1]> =
                self.constants.iter().map(|(name, _)| [(name.as_str(), Rational::ONE)]).collect();
            let reach = [("reach", Rational::ONE), ("overlap", Rational::ONE)];
            // The reach itself is a constant where it is a number: along it, nothing is fixed.
            let fixed = |name: &[(&str, Rational); 1]| name[0].0 == "reach";
            let nothing: &Direction<'_> = &[];
            let each = named.iter().map(|name| if fixed(name) { nothing } else { &name[..] });
            let along: Vec<&Direction<'_>> = each.chain([&reach[..]]).collect();
            compiled(&mut self.expressions.clone(), &self.formulas, &along, &self.ranges)
        })
    }

    /// The names of the constants, in the order of the slopes.
    pub(super) fn constants(&self) -> Vec<&str> {
        self.constants.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// The derivative of the reach by each of them.
    pub(super) fn reach_slopes(&self) -> impl ExactSizeIterator<Item = f64> {
        self.constants.iter().map(|(_, slope)| *slope)
    }

    pub(super) fn slopes_program(&self) -> &Program {
        &self.slopes().program
    }

    pub(super) fn forward_program(&self) -> &Program {
        &self.forward.program
    }

    pub(super) fn adjoint_program(&self) -> &Program {
        &self.adjoint().program
    }

    /// Whether both programs are the simplified ones.
    pub fn verdicts(&self) -> [&Verdict; 2] {
        [&self.forward.verdict, &self.adjoint().verdict]
    }
}

fn compiled(
    e: &mut Expressions,
    formulas: &[Id],
    along: &[&Direction<'_>],
    ranges: &IndexMap<String, Interval>,
) -> Compiled {
    compile(e, formulas, along, &INPUTS, |name| ranges.get(name).copied().unwrap_or(Interval::ALL))
}

/// N and T/|v_t|, the sliding speed as the root of its square: dividing by it then needs no case of its own at rest.
fn formulas(e: &mut Expressions, energy: Option<Id>, normal: Option<Id>, tangential: Option<Id>) -> [Id; OUTPUTS] {
    let zero = e.number(Rational::ZERO);
    let pull = energy.map(|energy| {
        let slope = e.derivatives(&[energy], ALONG[0])[0];
        e.negative(slope)
    });
    let normal = match (pull, normal) {
        (Some(pull), Some(normal)) => e.sum(pull, normal),
        (one, None) | (None, one) => one.unwrap_or(zero),
    };
    let square = e.name("vt2");
    let speed = e.power(square, Rational::HALF);
    let normal = e.substituted(normal, "vt", speed);
    let tangential = tangential.map_or(zero, |force| {
        let force = e.substituted(force, "normal", normal);
        let force = e.substituted(force, "vt", speed);
        e.quotient(force, speed)
    });
    [normal, tangential]
}

/// The reach \[m\], and its formula where it has one.
fn reach(spec: &FormulaSpec, e: &mut Expressions, constants: &[&str]) -> anyhow::Result<(f64, Option<Id>)> {
    let (reach, formula) = match &spec.reach {
        Reach::Number(reach) => (*reach, None),
        Reach::Formula(text) => {
            let id = e.parse(text, Names::Only(constants)).map_err(|error| anyhow!("reach: {error}"))?;
            let values: Vec<f64> =
                e.names().iter().map(|name| spec.constants.get(name).copied().unwrap_or(f64::NAN)).collect();
            (e.evaluate(&[id], &values)[0], Some(id))
        }
    };
    ensure!(reach > 0.0 && reach.is_finite(), "reach must be a positive length, got {reach}");
    Ok((reach, formula))
}

/// The constants with the derivative of the reach by each: the formulas' own, and the reach where it is a number.
fn reach_slopes(spec: &FormulaSpec, e: &mut Expressions, formula: Option<Id>) -> Vec<(String, f64)> {
    let mut along = |name: &str| {
        let Some(id) = formula else { return 0.0 };
        let slope = e.derivatives(&[id], &[(name, Rational::ONE)]);
        let values: Vec<f64> =
            e.names().iter().map(|name| spec.constants.get(name).copied().unwrap_or(f64::NAN)).collect();
        e.evaluate(&slope, &values)[0]
    };
    let mut all: Vec<(String, f64)> = spec.constants.keys().map(|name| (name.clone(), along(name))).collect();
    if matches!(spec.reach, Reach::Number(_)) {
        all.push(("reach".to_owned(), 1.0));
    }
    all
}
