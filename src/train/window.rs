//! Windows: K consecutive control steps of an episode, the examples that every model is fitted to.
use crate::data::Episode;
use crate::state::{Control, Particles, Pose, Scene, ToolShape, Wall};
use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::borrow::Cow;
use std::sync::Arc;

/// What a model is told at the start of a window, and what the world did next.
#[derive(Clone, Debug)]
pub struct Window<'a> {
    /// The start: particles and tool poses at step t.
    pub scene: Scene,
    /// K controls.
    pub controls: Cow<'a, [Control]>,
    /// The K states that followed in the world.
    pub targets: Cow<'a, [Particles]>,
}

impl<'a> Window<'a> {
    /// Steps `start` to `start + length` of an episode; the range lies inside it.
    pub fn of(episode: &'a Episode, start: usize, length: usize, shape: &Arc<ToolShape>) -> Self {
        Self {
            scene: episode.scene(start, shape),
            controls: Cow::Borrowed(&episode.controls[start..start + length]),
            targets: Cow::Borrowed(&episode.states[start + 1..=start + length]),
        }
    }

    /// Turns everything by `angle` \[rad\] about the vertical through the origin, which no law of the world notices.
    pub fn turn(&mut self, angle: f64) {
        let turn = DQuat::from_rotation_z(angle);
        let particles = |x: &mut Particles| {
            x.positions.iter_mut().chain(&mut x.velocities).for_each(|v| *v = turn * *v);
        };
        let poses = |poses: &mut [Pose]| {
            for pose in poses {
                *pose = Pose { translation: turn * pose.translation, rotation: turn * pose.rotation };
            }
        };
        particles(&mut self.scene.particles);
        self.scene.past.iter_mut().flatten().for_each(|v| *v = turn * *v);
        poses(&mut self.scene.poses);
        let wall = |wall: &Wall| Wall { normal: turn * wall.normal, ..*wall };
        self.scene.walls = self.scene.walls.iter().map(wall).collect();
        self.controls.to_mut().iter_mut().for_each(|c| poses(&mut c.poses));
        self.targets.to_mut().iter_mut().for_each(particles);
    }

    /// Keeps the first `length` control steps.
    pub fn shorten(&mut self, length: usize) {
        fn head<T: Clone>(list: &mut Cow<'_, [T]>, length: usize) {
            match list {
                Cow::Borrowed(rows) => *rows = &rows[..length.min(rows.len())],
                Cow::Owned(rows) => rows.truncate(length),
            }
        }
        head(&mut self.controls, length);
        head(&mut self.targets, length);
    }

    /// Adds random-walk noise to the start, the targets staying true.
    ///
    /// Two steps of a walk `n₋₁ ~ N(0, σ²/2)`, `n₀ = n₋₁ + N(0, σ²/2)` per coordinate shift the previous and the present
    /// position; the velocity, their backward difference, shifts by `(n₀ − n₋₁)/interval`, and so do earlier velocities by steps of
    /// their own. `sigma` in \[m\] is the deviation of the present position, and √2 times that of every velocity's step.
    ///
    /// Simpler than Sanchez-Gonzalez et al. (2020), appendix B, whose velocities walk: there noise adds up over the history until the
    /// last velocity's deviation is the stated one, positions are sums of the noisy velocities, and targets move with the last of them.
    pub fn disturb(&mut self, sigma: f64, rng: &mut ChaCha8Rng) {
        let share = sigma * 0.5_f64.sqrt();
        // The past has a stream of its own: what a model without memory is trained on does not depend on it.
        let mut far = rng.clone();
        far.set_stream(!rng.get_stream());
        let interval = self.scene.interval;
        for velocity in self.scene.past.iter_mut().flatten() {
            *velocity += DVec3::from_array(std::array::from_fn(|_| share * normal(&mut far))) / interval;
        }
        let mut step = || DVec3::from_array(std::array::from_fn(|_| share * normal(rng)));
        let particles = &mut self.scene.particles;
        for (position, velocity) in particles.positions.iter_mut().zip(&mut particles.velocities) {
            let (before, now) = (step(), step());
            *position += before + now;
            *velocity += now / interval;
        }
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::train::split::Tools;
    use rand::SeedableRng;

    /// Three particles over six steps; the last moves at steps 3 and 4 only.
    pub(in crate::train) fn episode() -> Episode {
        let place = |t: usize| DVec3::X * [0.0, 0.0, 0.0, 0.01, 0.03, 0.03, 0.03][t];
        let state = |t| Particles::at_rest(vec![DVec3::ZERO, DVec3::Y, place(t)]);
        let pose = |t: usize| Pose { translation: DVec3::Z * t as f64, ..Pose::default() };
        Episode {
            tool: "press".into(),
            theta: Vec::new(),
            interval: 0.1,
            start: vec![pose(0)],
            controls: (1..=6).map(|t| Control { poses: vec![pose(t)] }).collect(),
            states: (0..=6).map(state).collect(),
            body: [0; 3].into(),
            walls: [Wall { normal: DVec3::X, offset: -0.5 }].into(),
            constants: Arc::default(),
        }
    }

    pub(in crate::train) fn tools() -> Tools {
        Tools::from([("press".to_owned(), Arc::new(ToolShape::from(Vec::new())))])
    }

    #[test]
    fn a_shortened_window_is_its_beginning() {
        let (list, tools) = ([episode()], tools());
        let mut window = Window::of(&list[0], 1, 4, &tools["press"]);
        let mut turned = window.clone();
        turned.turn(0.3);
        for window in [&mut window, &mut turned] {
            let whole = window.clone();
            window.shorten(9);
            assert_eq!((&window.controls, &window.targets), (&whole.controls, &whole.targets));
            window.shorten(2);
            assert_eq!((&*window.controls, &*window.targets), (&whole.controls[..2], &whole.targets[..2]));
        }
    }

    #[test]
    fn a_turned_window_is_the_same_seen_from_another_side() {
        let (mut episode, tools) = (episode(), tools());
        episode.states[1].velocities[2] = DVec3::new(0.3, -0.2, 0.1);
        let straight = Window::of(&episode, 2, 2, &tools["press"]);
        let mut turned = straight.clone();
        turned.turn(0.7);
        assert_ne!(turned.targets, straight.targets);
        let place = |w: &Window<'_>, x: DVec3| w.controls[1].poses[0].inverse_apply(x);
        for i in 0..3 {
            let (a, b) = (turned.targets[1].positions[i], straight.targets[1].positions[i]);
            assert!(place(&turned, a).distance(place(&straight, b)) < 1e-15, "the tool sees the same");
            assert_eq!(a.z, b.z);
            let gap = |w: &Window<'_>, x: DVec3| w.scene.walls[0].distance(x);
            assert!((gap(&turned, a) - gap(&straight, b)).abs() < 1e-15, "walls turn as well");
        }
        let speed = |w: &Window<'_>| w.scene.past[0][2];
        let back = DQuat::from_rotation_z(-0.7) * speed(&turned);
        assert!(speed(&straight).length() > 0.0 && back.distance(speed(&straight)) < 1e-15, "the past turns as well");
        turned.turn(-0.7);
        for (a, b) in turned.scene.particles.positions.iter().zip(&straight.scene.particles.positions) {
            assert!(a.distance(*b) < 1e-15);
        }
    }

    #[test]
    fn noise_on_the_past_is_a_step_of_its_own_each_and_changes_nothing_else() {
        let (mut episode, tools, sigma) = (episode(), tools(), 2e-3);
        episode.states.iter_mut().for_each(|s| *s = Particles::at_rest(vec![DVec3::ZERO; 4000]));
        let mut windows = [3, 3].map(|start| Window::of(&episode, start, 2, &tools["press"]));
        windows[1].scene.past.clear();
        windows.iter_mut().for_each(|window| window.disturb(sigma, &mut ChaCha8Rng::seed_from_u64(5)));
        let [remembering, other] = windows;
        assert_eq!(remembering.scene.particles, other.scene.particles);
        let past = &remembering.scene.past;
        assert_eq!(past.len(), 3);
        let mean = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>() / (3.0 * 4000.0);
        for (k, a) in past.iter().enumerate() {
            let deviation = 0.1 * mean(a, a).sqrt() / sigma;
            assert!((deviation - 0.5_f64.sqrt()).abs() < 0.03, "{k}: {deviation}");
            let others = past[..k].iter().chain([&remembering.scene.particles.velocities]);
            assert!(
                others.map(|b| (0.01 * mean(a, b) / sigma.powi(2)).abs()).all(|c| c < 0.02),
                "{k} is no step of its own"
            );
        }
    }

    #[test]
    fn noise_shifts_position_and_velocity_as_a_walk_of_two_steps() {
        let (mut episode, tools, sigma) = (episode(), tools(), 2e-3);
        episode.states.iter_mut().for_each(|s| *s = Particles::at_rest(vec![DVec3::ZERO; 4000]));
        let mut window = Window::of(&episode, 0, 2, &tools["press"]);
        let targets = window.targets.to_vec();
        window.disturb(sigma, &mut ChaCha8Rng::seed_from_u64(5));
        assert_eq!(window.targets, targets);
        let Particles { positions, velocities } = &window.scene.particles;
        let mean = |f: &dyn Fn(usize) -> f64| (0..4000).map(f).sum::<f64>() / (3.0 * 4000.0);
        let position = mean(&|i| positions[i].length_squared()).sqrt();
        let last = mean(&|i| (velocities[i] * 0.1).length_squared()).sqrt();
        let both = mean(&|i| positions[i].dot(velocities[i] * 0.1));
        assert!((position / sigma - 1.0).abs() < 0.03, "σ of the position is {position}");
        assert!((last / sigma - 0.5_f64.sqrt()).abs() < 0.03, "σ of the last step is {last}");
        assert!((both / sigma.powi(2) - 0.5).abs() < 0.05, "the position contains the last step");
    }
}
