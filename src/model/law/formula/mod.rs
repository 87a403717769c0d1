//! Laws written as formulas in a config.
//!
//! A particle meets another particle, the table, a wall or a part of the tool; the formulas give its acceleration from a few
//! invariants of the meeting, so the law commutes with turns and shifts of the scene whatever they say.
mod meeting;
mod pairs;
mod plane;
mod programs;
mod spec;
mod touch;

use super::{Law, View, ViewGrad};
use glam::DVec3;

pub use programs::Programs;
pub use spec::{Between, FormulaSpec, Reach, Wall};

/// The law of a [`FormulaSpec`], whatever a particle meets in it.
pub struct Formula(Box<dyn Law>);

impl Law for Formula {
    fn reach(&self) -> f64 {
        self.0.reach()
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        self.0.accelerate(view, out);
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        self.0.accelerate_vjp(view, out, grad);
    }

    fn constants(&self) -> Vec<&str> {
        self.0.constants()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        self.0.constants_vjp(view, out, constants);
    }
}
