//! Contact between particles: they push when they overlap, and rub when they slide.
use super::compliant::CompliantSpec;
use super::history::Remember;
use super::pair::{Pair, Pairwise, visit};
use super::tangential::Touch;
use super::touching::{self, Meeting, MeetingGrad, Touching};
use super::{Law, View, ViewGrad};
use glam::{DMat3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Contact`]: two particles overlap by `δ = 2 R − r`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct ContactSpec(pub CompliantSpec);

impl ContactSpec {
    pub(crate) fn build(self) -> anyhow::Result<Contacts> {
        self.0.check("contact")?;
        Ok(Contacts(Pairwise(Contact(self.0))))
    }
}

/// The compliant contact of two equal balls; `n` points from j to i.
pub struct Contact(CompliantSpec);

impl Pair for Contact {
    fn reach(&self) -> f64 {
        2.0 * self.0.radius
    }

    fn stable(&self) -> f64 {
        self.0.stable()
    }

    #[inline]
    fn acceleration(&self, offset: DVec3, square: f64, velocity: DVec3) -> DVec3 {
        let distance = square.sqrt();
        self.0.acceleration(2.0 * self.0.radius - distance, offset / distance, velocity)
    }

    #[inline]
    fn pull(&self, offset: DVec3, square: f64, velocity: DVec3, at: DVec3) -> (DVec3, DVec3) {
        let distance = square.sqrt();
        let normal = offset / distance;
        let by = self.0.pull(2.0 * self.0.radius - distance, normal, velocity, at);
        let turning = (by.normal - normal * normal.dot(by.normal)) / distance;
        (turning - by.overlap * normal, by.velocity)
    }

    fn constants(&self) -> &[&'static str] {
        self.0.constants()
    }

    fn pull_constants(&self, offset: DVec3, square: f64, velocity: DVec3, at: DVec3, constants: &mut [f64]) {
        let distance = square.sqrt();
        let mut by = self.0.pull_constants(2.0 * self.0.radius - distance, offset / distance, velocity, at);
        by[0] *= 2.0;
        constants.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
    }
}

/// The law of all contacts between particles, by pairs alone or, where friction has a spring, by what each pair remembers.
pub struct Contacts(Pairwise<Contact>);

impl Contacts {
    fn balls(&self) -> &Contact {
        &self.0.0
    }
}

impl Law for Contacts {
    fn remembers(&self) -> Option<&dyn Remember> {
        self.balls().0.springs().then_some(self.balls() as &dyn Remember)
    }

    fn reach(&self) -> f64 {
        self.0.reach()
    }

    fn stable(&self) -> f64 {
        self.0.stable()
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        match self.remembers() {
            Some(_) => touching::accelerate(self.balls(), view, out),
            None => self.0.accelerate(view, out),
        }
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        match self.remembers() {
            Some(_) => touching::accelerate_vjp(self.balls(), view, out, grad),
            None => self.0.accelerate_vjp(view, out, grad),
        }
    }

    fn into_pair(self: Box<Self>) -> Option<Box<dyn Pair>> {
        // What a pair remembers is not in a pair's acceleration.
        if self.remembers().is_some() { None } else { Some(Box::new(self.0.0)) }
    }

    fn constants(&self) -> Vec<&str> {
        self.0.constants()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        match self.remembers() {
            Some(_) => touching::constants_vjp(self.balls(), view, out, constants),
            None => self.0.constants_vjp(view, out, constants),
        }
    }
}

impl Contact {
    fn meeting(&self, view: &View<'_>, [i, j]: [usize; 2], offset: DVec3, square: f64) -> (Meeting, f64) {
        let distance = square.sqrt();
        let velocity = view.particles.velocities[i] - view.particles.velocities[j];
        let touch = Touch { overlap: 2.0 * self.0.radius - distance, normal: offset / distance, velocity };
        let pair = [i as u32, j as u32];
        (Meeting { pair, pushed: i, opposite: Some(j), touch, frame: DMat3::IDENTITY }, distance)
    }
}

impl Touching for Contact {
    const RADII: f64 = 2.0;

    fn spec(&self) -> &CompliantSpec {
        &self.0
    }

    fn meet(&self, view: &View<'_>, each: &mut dyn FnMut(&Meeting)) {
        visit(view, self.reach(), |i, j, offset, square| each(&self.meeting(view, [i, j], offset, square).0));
    }

    fn pull(&self, view: &View<'_>, grad: &mut ViewGrad<'_>, each: &mut dyn FnMut(&Meeting) -> MeetingGrad) {
        let grad = &mut grad.particles;
        visit(view, self.reach(), |i, j, offset, square| {
            let (meeting, distance) = self.meeting(view, [i, j], offset, square);
            let (by, normal) = (each(&meeting).contact, meeting.touch.normal);
            let x = (by.normal - normal * normal.dot(by.normal)) / distance - by.overlap * normal;
            grad.positions[i] += x;
            grad.positions[j] -= x;
            grad.velocities[i] += by.velocity;
            grad.velocities[j] -= by.velocity;
        });
    }
}
