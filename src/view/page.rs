//! The page: assets of this folder around the numbers of one recording.
use super::edges::{Count, counts};
use super::facets::facets;
use super::{Playback, Prediction};
use crate::graph::near_kinds;
use crate::state::{Part, Particles, Pose, Wall};
use base64::Engine;
use base64::engine::general_purpose::STANDARD_NO_PAD;
use glam::DVec3;
use serde::Serialize;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// One scope, in this order.
const SCRIPTS: [&str; 9] = [
    include_str!("numbers.js"),
    include_str!("graph.js"),
    include_str!("forces.js"),
    include_str!("camera.js"),
    include_str!("shaders.js"),
    include_str!("renderer.js"),
    include_str!("scene.js"),
    include_str!("plot.js"),
    include_str!("player.js"),
];

/// Everything the page's scripts are told; numbers are base64 of little-endian floats, rows one after the other.
#[derive(Serialize)]
struct Data<'a> {
    /// File name of the episode.
    title: String,
    /// Duration of a control step \[s\].
    interval: f64,
    /// H + 1.
    frames: usize,
    /// N.
    particles: usize,
    /// (H + 1, N, 3) float32 \[m\].
    positions: String,
    /// Runs of particles of one material, in order.
    bodies: Vec<Body>,
    /// Median distance of a particle to its nearest neighbour in the first frame \[m\].
    spacing: f64,
    tool: Tool<'a>,
    graph: Graph,
    prediction: Option<Predicted<'a>>,
}

#[derive(Serialize)]
struct Body {
    material: String,
    particles: usize,
}

#[derive(Serialize)]
struct Tool<'a> {
    name: &'a str,
    /// (H + 1, parts, 7) float64: x y z \[m\] and the quaternion x y z w; doubles, so that the page's edges are exactly ours.
    poses: String,
    /// As many as a frame has poses.
    parts: Vec<Shape>,
}

/// One part in its own frame; empty where its shape is unknown.
#[derive(Default, Serialize)]
struct Shape {
    /// (V, 3) float32 \[m\].
    vertices: String,
    /// (T, 3) uint32.
    triangles: String,
    /// (S, 3) float64 \[m\], the points that graphs join.
    samples: String,
}

#[derive(Serialize)]
struct Graph {
    /// Names of the edge kinds.
    kinds: Vec<&'static str>,
    /// The walls and, last, the floor: normal and offset \[m\].
    planes: Vec<[f64; 4]>,
    /// Radius that the page starts with \[0.1 mm\].
    radius: u32,
    /// For the page to compare its own with.
    counts: Vec<Count>,
}

#[derive(Serialize)]
struct Predicted<'a> {
    model: &'a str,
    /// (H + 1, N, 3) float32 \[m\].
    positions: String,
    /// Of each frame \[m\]; null where it is infinite.
    rmse: Vec<f64>,
}

/// The page as HTML; nothing in it is loaded from elsewhere, and no string of a file is ever markup.
pub(super) fn html(recording: &Playback, prediction: Option<&Prediction>) -> String {
    let data = serde_json::to_string(&Data::of(recording, prediction)).expect("plain data");
    // Inside JSON `<` occurs in strings only; escaped there, nothing can end the element that holds it.
    let data = data.replace('<', "\\u003c");
    let fill = |text: String, (hole, with): (&str, &str)| {
        let (before, after) = text.split_once(hole).expect("a hole of the template");
        format!("{before}{with}{after}")
    };
    // The data goes in last, so that nothing in it is taken for a hole.
    [("{{style}}", STYLE), ("{{script}}", &SCRIPTS.concat()), ("{{data}}", &data)]
        .into_iter()
        .fold(TEMPLATE.to_owned(), fill)
}

impl<'a> Data<'a> {
    fn of(recording: &'a Playback, prediction: Option<&'a Prediction>) -> Self {
        let Playback { path, episode, shape, pieces } = recording;
        let poses = || (0..=episode.horizon()).flat_map(|t| episode.poses(t));
        let parts = match shape {
            Some(shape) => shape.parts.iter().map(Shape::of).collect(),
            None => episode.start.iter().map(|_| Shape::default()).collect(),
        };
        let start = &episode.states[0].positions;
        let spacing = recording.spacing();
        let radius = (1.5e4 * spacing).round().clamp(10.0, 1e4) as u32;
        Self {
            title: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            interval: episode.interval,
            frames: episode.states.len(),
            particles: start.len(),
            positions: points(&episode.states),
            bodies: bodies(&episode.body, pieces),
            spacing,
            tool: Tool { name: &episode.tool, poses: doubles(poses().flat_map(row)), parts },
            graph: Graph {
                kinds: near_kinds().map(|kind| kind.name()).collect(),
                planes: episode.walls.iter().chain([&Wall::FLOOR]).map(|wall| wall.to_array()).collect(),
                radius,
                counts: counts(recording, f64::from(radius) / 1e4),
            },
            prediction: prediction.map(|p| Predicted {
                model: &p.model,
                positions: points(&p.rollout),
                rmse: p.errors(recording),
            }),
        }
    }
}

/// Runs of particles of one piece; one that has no name gets its number.
fn bodies(body: &[u32], pieces: &[String]) -> Vec<Body> {
    let name = |number: u32| match pieces.get(number as usize) {
        Some(name) => name.clone(),
        None if number == 0 => "particles".to_owned(),
        None => format!("body {number}"),
    };
    body.chunk_by(|a, b| a == b).map(|run| Body { material: name(run[0]), particles: run.len() }).collect()
}

impl Shape {
    fn of(part: &Part) -> Self {
        let (vertices, triangles) = facets(&part.solid);
        let corners = triangles.iter().flatten().flat_map(|i| i.to_le_bytes());
        Self {
            vertices: singles(&vertices),
            triangles: STANDARD_NO_PAD.encode(corners.collect::<Vec<u8>>()),
            samples: doubles(part.surface.iter().flat_map(|p| p.position.to_array())),
        }
    }
}

fn row(pose: &Pose) -> impl Iterator<Item = f64> {
    pose.translation.to_array().into_iter().chain(pose.rotation.to_array())
}

fn points(states: &[Particles]) -> String {
    let all: Vec<DVec3> = states.iter().flat_map(|x| x.positions.iter().copied()).collect();
    singles(&all)
}

// Without padding, so that no number ends in what looks like an attribute.
fn singles(points: &[DVec3]) -> String {
    let numbers = points.iter().flat_map(|p| p.as_vec3().to_array());
    STANDARD_NO_PAD.encode(numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

fn doubles(numbers: impl Iterator<Item = f64>) -> String {
    STANDARD_NO_PAD.encode(numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_named_by_their_dataset_and_otherwise_counted() {
        let told = |pieces: &[&str]| -> Vec<(String, usize)> {
            let pieces: Vec<String> = pieces.iter().map(|name| (*name).to_owned()).collect();
            bodies(&[0, 0, 1, 2], &pieces).into_iter().map(|body| (body.material, body.particles)).collect()
        };
        let named = |names: [&str; 3]| names.map(String::from).into_iter().zip([2, 1, 1]).collect::<Vec<_>>();
        assert_eq!(told(&["fluid", "cube"]), named(["fluid", "cube", "body 2"]));
        assert_eq!(told(&[]), named(["particles", "body 1", "body 2"]));
    }
}
