//! An episode as a row of the contact sheet.
use pliant::data::Episode;
use pliant::state::{Particles, ToolShape};
use pliant::table::{Frame, Strip};

/// Number of pictures of an action.
const FRAMES: usize = 5;

/// `states` of an episode's particles from its start to its end, evenly in time, its tool beside them.
pub(crate) fn film(title: &str, episode: &Episode, shape: &ToolShape, states: &[Particles]) -> Strip {
    let frame = |k: usize| {
        let t = k * episode.horizon() / (FRAMES - 1);
        let positions = states[t].positions.iter().copied();
        Frame {
            particles: positions.zip(episode.body.iter().copied()).collect(),
            tool: shape.surface_at(episode.poses(t)).collect(),
        }
    };
    Strip { title: title.to_owned(), frames: (0..FRAMES).map(frame).collect() }
}
