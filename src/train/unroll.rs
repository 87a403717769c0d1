//! How much of a window's rollout is differentiated.
use super::Window;
use crate::model::WorldModel;
use crate::state::{MEMORY, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Which steps of a window the loss and its derivative see.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Unroll {
    /// All of them: the derivative goes back to the window's start.
    #[default]
    Whole,
    /// The last alone, from where the model's own steps before it lead: it learns from its own errors at the price of one
    /// differentiated step (pushforward, Brandstetter, Worrall & Welling 2022, §3.1).
    LastStep,
}

impl Unroll {
    /// Whether a config may leave the key out.
    pub(super) fn is_whole(&self) -> bool {
        *self == Self::Whole
    }

    /// What of `window` is differentiated.
    pub(super) fn part<'a>(self, model: &dyn WorldModel, window: Window<'a>) -> Window<'a> {
        let count = window.controls.len();
        if self == Self::Whole || count < 2 {
            return window;
        }
        let Window { scene, controls, targets } = window;
        let mut reached = model.rollout(&scene, &controls[..count - 1]);
        let particles = reached.pop().expect("a rollout holds its start");
        let past = reached.into_iter().rev().map(|x| x.velocities).chain(scene.past).take(MEMORY).collect();
        let scene = Scene { particles, past, poses: controls[count - 2].poses.clone(), ..scene };
        let (controls, targets) = (tail(controls, count - 1), tail(targets, count - 1));
        Window { scene, controls, targets }
    }
}

/// What stands at `from` and behind it.
fn tail<T: Clone>(list: Cow<'_, [T]>, from: usize) -> Cow<'_, [T]> {
    match list {
        Cow::Borrowed(list) => Cow::Borrowed(&list[from..]),
        Cow::Owned(mut list) => Cow::Owned(list.split_off(from)),
    }
}
