//! Laws that remember pairs: bonds that flow and break, and friction with a tangential spring.
use crate::physics::{built, kept, with};
use crate::slopes::{RELATIVE, STEP, constants, slopes};
use anyhow::Context;
use pliant::train::replace;
use serde_json::{Value, json};

/// Strain at which bonds break here, so little that some do.
const BRITTLE: f64 = 0.1;
/// Tangential stiffness over a particle's mass [s^-2].
const TANGENTIAL: f64 = 500.0;

/// Steps of differences, of those of other laws: where one contact in a hundred starts to slide within a step the cost bends there,
/// and the error falls to rounding once the step is so short.
const SHORT: f64 = 0.03;

/// Takes the model, what was measured of it, the value and its bounds.
type Add<'a> = dyn FnMut(&str, &str, f64, f64, f64) -> anyhow::Result<()> + 'a;

/// Momentum and gradients through what laws remember.
pub(crate) fn remembering(
    particles: &Value,
    bonds: &Value,
    directions: usize,
    add: &mut Add<'_>,
) -> anyhow::Result<()> {
    let bonds = replace(bonds, [("laws.bonds.breaking_strain", BRITTLE)])?;
    let springs = sprung(particles)?;
    let inner = with(&bonds, &["bonds", "viscosity"], &[("keep", 1.0)])?;
    let (p, l) = kept(&*built(&inner)?);
    add("bonds", "linear momentum, off by [1]", p, 0.0, 1e-10)?;
    add("bonds", "angular momentum, off by [1]", l, 0.0, 1e-10)?;
    let (p, _) = kept(&*built(&with(&springs, &["contact"], &[("keep", 1.0)])?)?);
    add("springs", "linear momentum, off by [1]", p, 0.0, 1e-10)?;
    let greatest = |errors: Vec<f64>| errors.into_iter().fold(0.0, f64::max);
    for (name, config) in [("bonds", &bonds), ("springs", &springs)] {
        let model = built(config)?;
        let by_state = greatest(slopes(&*model, directions, [1.0, 0.0], SHORT * STEP)?);
        add(name, "gradient by state, greatest error [1]", by_state, 0.0, 1e-4)?;
        let by_control = greatest(slopes(&*model, directions, [0.0, 1.0], SHORT * STEP)?);
        add(name, "gradient by control, greatest error [1]", by_control, 0.0, 1e-4)?;
        let by_constants = greatest(constants(config, directions, SHORT * RELATIVE)?);
        add(name, "gradient by constants, greatest error [1]", by_constants, 0.0, 1e-4)?;
    }
    Ok(())
}

/// The model with a tangential spring in every law that has friction.
fn sprung(model: &Value) -> anyhow::Result<Value> {
    let mut model = model.clone();
    let laws = model["laws"].as_array_mut().context("the model has no laws")?;
    for law in laws.iter_mut().filter(|law| law.get("friction").is_some()) {
        law["tangential_stiffness"] = json!(TANGENTIAL);
    }
    Ok(model)
}
