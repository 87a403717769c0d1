//! Edge counts by [`crate::graph`], for the page to compare its own with.
use super::Playback;
use crate::graph::{Nodes, near_kinds};
use crate::state::ToolShape;
use serde::Serialize;
use std::sync::Arc;

/// What `crate::graph` draws over one frame.
#[derive(Serialize)]
pub(super) struct Count {
    /// Which frame.
    frame: usize,
    /// Radius of the neighbourhood \[m\].
    radius: f64,
    /// Number of edges of each kind that needs no skeleton.
    edges: Vec<usize>,
}

/// Counts over the first, middle and last frame, within `radius` \[m\] and twice that.
pub(super) fn counts(recording: &Playback, radius: f64) -> Vec<Count> {
    let horizon = recording.episode.horizon();
    let frames = [0, horizon / 2, horizon];
    frames.into_iter().flat_map(|frame| [radius, 2.0 * radius].map(|r| count(recording, frame, r))).collect()
}

/// Counts over the particles of `frame` and the tool where it then is.
fn count(recording: &Playback, frame: usize, radius: f64) -> Count {
    let episode = &recording.episode;
    let none = ToolShape::from(Vec::new());
    let (tool, poses) = (recording.shape.as_deref().unwrap_or(&none), episode.poses(frame));
    let nodes =
        Nodes::gather(&episode.states[frame], &Arc::default(), &episode.walls, tool, poses, poses, episode.interval);
    let near = nodes.near(radius);
    let edges = near_kinds().map(|kind| kind.connect(&nodes, &near, radius).len()).collect();
    Count { frame, radius, edges }
}
