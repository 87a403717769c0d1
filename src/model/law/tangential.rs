//! Friction that holds: a spring along the surface that touching stretches and the Coulomb limit caps.
use super::compliant::{CompliantSpec, ContactGrad, ramp};
use glam::DVec3;

/// A compliant contact at one instant.
pub(super) struct Touch {
    /// Overlap δ, above zero \[m\].
    pub(super) overlap: f64,
    /// Outward normal n.
    pub(super) normal: DVec3,
    /// Relative velocity v \[m/s\].
    pub(super) velocity: DVec3,
}

/// What pulls back onto a contact with a spring: `∂J/∂(contact, ξ)`, and by all six constants.
pub(super) struct SpringGrad {
    pub(super) contact: ContactGrad,
    pub(super) stretch: DVec3,
    pub(super) constants: [f64; 6],
}

/// The normal force N over a particle's mass, the sliding velocity, and the derivatives of N.
struct Normal {
    push: f64,
    separating: f64,
    sliding: DVec3,
    by_overlap: f64,
    by_separating: f64,
    by_stiffness: f64,
    by_damping: f64,
}

/// Derivatives by N, v_t, n (where it stands by itself), ξ, μ, v_s and k_t.
#[derive(Default)]
struct Inner {
    push: f64,
    sliding: DVec3,
    normal: DVec3,
    stretch: DVec3,
    friction: f64,
    slip: f64,
    tangential: f64,
}

impl CompliantSpec {
    fn normal(&self, touch: &Touch) -> Normal {
        let separating = touch.velocity.dot(touch.normal);
        let (rest, slope) = ramp(1.0 - self.damping * separating);
        let root = touch.overlap.sqrt();
        let base = self.stiffness * touch.overlap * root;
        Normal {
            push: base * rest,
            separating,
            sliding: touch.velocity - separating * touch.normal,
            by_overlap: 1.5 * self.stiffness * root * rest,
            by_separating: -self.damping * base * slope,
            by_stiffness: touch.overlap * root * rest,
            by_damping: -separating * base * slope,
        }
    }

    /// k_t, where there is a spring.
    fn tangential(&self) -> f64 {
        self.tangential_stiffness.unwrap_or_default()
    }

    /// The spring's stretch ξ after `duration` \[s\] from what it was: turned into the surface, lengthened by what slides, and no longer
    /// than `μ N/k_t`.
    pub(super) fn stretch(&self, touch: &Touch, before: DVec3, duration: f64) -> DVec3 {
        let Normal { push, sliding, .. } = self.normal(touch);
        let trial = before - before.dot(touch.normal) * touch.normal + duration * sliding;
        let (length, limit) = (trial.length(), self.friction * push / self.tangential());
        if length > limit { trial * (limit / length) } else { trial }
    }

    /// Pulls `at` = `∂J/∂ξ` back through [`CompliantSpec::stretch`].
    pub(super) fn stretch_vjp(&self, touch: &Touch, before: DVec3, duration: f64, at: DVec3) -> SpringGrad {
        let (normal, n, k) = (self.normal(touch), touch.normal, self.tangential());
        let trial = before - before.dot(n) * n + duration * normal.sliding;
        let (length, limit) = (trial.length(), self.friction * normal.push / k);
        let mut by = Inner::default();
        let by_trial = if length > limit {
            let along = trial / length;
            let by_limit = at.dot(along);
            by.push = by_limit * self.friction / k;
            by.friction = by_limit * normal.push / k;
            by.tangential = -by_limit * limit / k;
            (limit / length) * (at - by_limit * along)
        } else {
            at
        };
        by.stretch = by_trial - by_trial.dot(n) * n;
        by.normal = -(before.dot(n) * by_trial + by_trial.dot(n) * before);
        by.sliding = duration * by_trial;
        normal.pull(touch, &by)
    }

    /// Spring and dashpot along the surface, `−k_t ξ − μ N v_t/v_s`, before the Coulomb limit.
    fn trial(&self, normal: &Normal, stretch: DVec3) -> DVec3 {
        -self.tangential() * stretch - (self.friction * normal.push / self.slip) * normal.sliding
    }

    /// The acceleration with the spring stretched by ξ: `N n + T`, T being the trial force cut off at `μ N`.
    pub(super) fn sprung(&self, touch: &Touch, stretch: DVec3) -> DVec3 {
        let normal = self.normal(touch);
        let trial = self.trial(&normal, stretch);
        let (size, limit) = (trial.length(), self.friction * normal.push);
        let drag = if size > limit { trial * (limit / size) } else { trial };
        normal.push * touch.normal + drag
    }

    /// Pulls `at` = `∂J/∂acceleration` back through [`CompliantSpec::sprung`].
    pub(super) fn sprung_vjp(&self, touch: &Touch, stretch: DVec3, at: DVec3) -> SpringGrad {
        let normal = self.normal(touch);
        let trial = self.trial(&normal, stretch);
        let (size, limit) = (trial.length(), self.friction * normal.push);
        let mut by = Inner { push: at.dot(touch.normal), normal: normal.push * at, ..Inner::default() };
        let by_trial = if size > limit {
            let along = trial / size;
            let by_limit = at.dot(along);
            by.push += self.friction * by_limit;
            by.friction += normal.push * by_limit;
            (limit / size) * (at - by_limit * along)
        } else {
            at
        };
        let slid = by_trial.dot(normal.sliding) / self.slip;
        by.push -= self.friction * slid;
        by.friction -= normal.push * slid;
        by.slip = limit * slid / self.slip;
        by.tangential = -stretch.dot(by_trial);
        by.stretch = -self.tangential() * by_trial;
        by.sliding = -(limit / self.slip) * by_trial;
        normal.pull(touch, &by)
    }
}

impl Normal {
    fn pull(&self, touch: &Touch, by: &Inner) -> SpringGrad {
        let by_separating = by.push * self.by_separating - by.sliding.dot(touch.normal);
        let by_overlap = by.push * self.by_overlap;
        let contact = ContactGrad {
            overlap: by_overlap,
            normal: by.normal - self.separating * by.sliding + by_separating * touch.velocity,
            velocity: by.sliding + by_separating * touch.normal,
        };
        let (stiffness, damping) = (by.push * self.by_stiffness, by.push * self.by_damping);
        let constants = [by_overlap, stiffness, damping, by.friction, by.slip, by.tangential];
        SpringGrad { contact, stretch: by.stretch, constants }
    }
}
