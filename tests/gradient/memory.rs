//! A law that looks at velocities of the past: `a = Σₖ cₖ v₋ₖ`.
use glam::DVec3;
use pliant::model::law::{Law, Rate, View, ViewGrad};

/// c₁, c₂ … \[1/s\].
pub(crate) struct Memory(pub(crate) Vec<f64>);

impl Law for Memory {
    fn rate(&self) -> Rate {
        Rate::Step
    }
    fn memory(&self) -> usize {
        self.0.len()
    }
    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        for (c, velocities) in self.0.iter().zip(view.past) {
            out.iter_mut().zip(velocities).for_each(|(a, v)| *a += *c * *v);
        }
    }
    fn accelerate_vjp(&self, _: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        for (c, own) in self.0.iter().zip(&mut grad.past) {
            own.iter_mut().zip(out).for_each(|(g, a)| *g += *c * *a);
        }
    }
}
