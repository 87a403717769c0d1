//! Laws whose friction remembers: everyone who touches has a spring, forgotten when the contact ends.
use super::compliant::{CompliantSpec, ContactGrad};
use super::history::{History, Remember};
use super::tangential::{SpringGrad, Touch};
use super::{View, ViewGrad};
use glam::{DMat3, DVec3};

/// One contact, and whose it is.
pub(super) struct Meeting {
    /// What its spring is remembered by.
    pub(super) pair: [u32; 2],
    /// The particle that it pushes, and the one that gets the opposite, where that is a particle.
    pub(super) pushed: usize,
    pub(super) opposite: Option<usize>,
    pub(super) touch: Touch,
    /// The axes in which its stretch is kept: those of the surface, as far as it turns.
    pub(super) frame: DMat3,
}

/// What pulls back onto a contact, and onto the turn of its axes.
pub(super) struct MeetingGrad {
    pub(super) contact: ContactGrad,
    pub(super) turn: DVec3,
}

/// A law of compliant contacts, each with a tangential spring (Cundall & Strack 1979).
pub(super) trait Touching: Send + Sync {
    /// How often the overlap has the radius.
    const RADII: f64;
    /// The constants.
    fn spec(&self) -> &CompliantSpec;
    /// Calls `visit` with every contact, pairs ascending.
    fn meet(&self, view: &View<'_>, visit: &mut dyn FnMut(&Meeting));
    /// The same, and adds to `grad` what `visit` says.
    fn pull(&self, view: &View<'_>, grad: &mut ViewGrad<'_>, visit: &mut dyn FnMut(&Meeting) -> MeetingGrad);
}

/// Numbers of a spring: its stretch.
const STRETCH: usize = 3;

impl Meeting {
    /// The stretch that is remembered, in the world, and its place; none where this has just begun.
    fn remembered(&self, history: &History) -> (DVec3, Option<usize>) {
        let place = history.place(self.pair);
        let stretch = place.map_or(DVec3::ZERO, |place| DVec3::from_array(history.row::<STRETCH>(place)));
        (self.frame * stretch, place)
    }

    fn at(&self, out: &[DVec3]) -> DVec3 {
        self.opposite.map_or(out[self.pushed], |j| out[self.pushed] - out[j])
    }

    /// Adds a derivative by the stretch in the world to those of what is remembered.
    fn add(&self, place: Option<usize>, by: DVec3, history: &mut [f64]) {
        let own = (self.frame.transpose() * by).to_array();
        let Some(place) = place else { return };
        history[STRETCH * place..][..STRETCH].iter_mut().zip(own).for_each(|(sum, by)| *sum += by);
    }
}

/// As [`super::Law::accelerate`].
pub(super) fn accelerate(law: &impl Touching, view: &View<'_>, out: &mut [DVec3]) {
    law.meet(view, &mut |meeting| {
        let push = law.spec().sprung(&meeting.touch, meeting.remembered(view.history).0);
        out[meeting.pushed] += push;
        if let Some(j) = meeting.opposite {
            out[j] -= push;
        }
    });
}

/// As [`super::Law::accelerate_vjp`].
pub(super) fn accelerate_vjp(law: &impl Touching, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
    let mut history = std::mem::take(&mut grad.history);
    law.pull(view, grad, &mut |meeting| {
        let (stretch, place) = meeting.remembered(view.history);
        let by = law.spec().sprung_vjp(&meeting.touch, stretch, meeting.at(out));
        meeting.add(place, by.stretch, &mut history);
        MeetingGrad { contact: by.contact, turn: stretch.cross(by.stretch) }
    });
    grad.history = history;
}

/// As [`super::Law::constants_vjp`].
pub(super) fn constants_vjp(law: &impl Touching, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
    law.meet(view, &mut |meeting| {
        let stretch = meeting.remembered(view.history).0;
        add(law, &law.spec().sprung_vjp(&meeting.touch, stretch, meeting.at(out)), constants);
    });
}

fn add<T: Touching>(_: &T, by: &SpringGrad, constants: &mut [f64]) {
    constants.iter_mut().zip(by.constants).for_each(|(sum, by)| *sum += by);
    constants[0] += (T::RADII - 1.0) * by.constants[0];
}

impl<T: Touching> Remember for T {
    fn advance(&self, view: &View<'_>, duration: f64) -> History {
        let mut next = History::default();
        self.meet(view, &mut |meeting| {
            let before = meeting.remembered(view.history).0;
            let stretch = self.spec().stretch(&meeting.touch, before, duration);
            next.push(meeting.pair, &(meeting.frame.transpose() * stretch).to_array());
        });
        next
    }

    fn advance_vjp(&self, view: &View<'_>, duration: f64, at: &[f64], grad: &mut ViewGrad<'_>) {
        let mut history = std::mem::take(&mut grad.history);
        let mut rows = at.chunks_exact(STRETCH);
        self.pull(view, grad, &mut |meeting| {
            let at = meeting.frame * rows.next().map_or(DVec3::ZERO, DVec3::from_slice);
            let (before, place) = meeting.remembered(view.history);
            let by = self.spec().stretch_vjp(&meeting.touch, before, duration, at);
            meeting.add(place, by.stretch, &mut history);
            let stretch = self.spec().stretch(&meeting.touch, before, duration);
            MeetingGrad { contact: by.contact, turn: before.cross(by.stretch) - stretch.cross(at) }
        });
        grad.history = history;
    }

    fn advance_constants_vjp(&self, view: &View<'_>, duration: f64, at: &[f64], constants: &mut [f64]) {
        let mut rows = at.chunks_exact(STRETCH);
        self.meet(view, &mut |meeting| {
            let at = meeting.frame * rows.next().map_or(DVec3::ZERO, DVec3::from_slice);
            let before = meeting.remembered(view.history).0;
            add(self, &self.spec().stretch_vjp(&meeting.touch, before, duration, at), constants);
        });
    }
}
