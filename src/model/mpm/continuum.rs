//! A control step and its adjoint in numbers of one precision.
use super::adjoint::Backward;
use super::interval::{Interval, Tape};
use super::material::Material;
use super::real::Real;
use super::state::StateGrad;
use super::{MpmModel, MpmState, Points};
use crate::state::{Control, ControlGrad};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;

/// Numbers that a control step is computed in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// f64.
    #[default]
    Double,
    /// f32, but for places, contacts and what lies between control steps.
    Single,
}

impl Precision {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The material given, in numbers of this precision.
    pub(super) fn continuum(self, material: &Material<f64>, viscosity: f64) -> Box<dyn Stepping> {
        match self {
            Self::Double => Box::new(Continuum::<f64>::new(material, viscosity)),
            Self::Single => Box::new(Continuum::<f32>::new(material, viscosity)),
        }
    }
}

/// A control step in numbers that are nobody else's business.
pub(super) trait Stepping: Send + Sync {
    /// The points at the end of a control step.
    fn step(&self, model: &MpmModel, state: &MpmState, control: &Control) -> Points<f64>;
    /// `(∂J/∂state, ∂J/∂control)` from `∂J/∂next`.
    fn step_vjp(
        &self,
        model: &MpmModel,
        state: &MpmState,
        control: &Control,
        next: StateGrad,
    ) -> (StateGrad, ControlGrad);
}

/// What flows and is strained, per unit of density.
pub(super) struct Continuum<R: Real> {
    pub(super) material: Material<R>,
    /// η/ρ \[m²/s\].
    pub(super) viscosity: R,
    /// Tapes that no gradient is being taken on: their memory costs more to get than to fill.
    tapes: Mutex<Vec<Tape<R>>>,
}

impl<R: Real> Continuum<R> {
    fn new(material: &Material<f64>, viscosity: f64) -> Self {
        let Material { shear, lame, yields } = material;
        let material = Material { shear: R::of(*shear), lame: R::of(*lame), yields: R::of(*yields) };
        Self { material, viscosity: R::of(viscosity), tapes: Mutex::default() }
    }
}

impl<R: Real> Stepping for Continuum<R> {
    fn step(&self, model: &MpmModel, state: &MpmState, control: &Control) -> Points<f64> {
        Interval::new(model, self, state, control).advance(None).wide()
    }

    fn step_vjp(
        &self,
        model: &MpmModel,
        state: &MpmState,
        control: &Control,
        next: StateGrad,
    ) -> (StateGrad, ControlGrad) {
        let interval = Interval::new(model, self, state, control);
        let mut tape = self.tapes.lock().expect("no thread panics with it").pop().unwrap_or_default();
        tape.clear();
        let end = interval.advance(Some(&mut tape));
        tape.points.extend(&end);
        let at = Backward::new(&interval, next).pull(&tape);
        self.tapes.lock().expect("no thread panics with it").push(tape);
        at
    }
}
