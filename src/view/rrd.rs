//! The same for the Rerun viewer (`rerun FILE`), behind the Cargo feature `rerun`.
use super::facets::facets;
use super::{Playback, Prediction};
use crate::state::Particles;
use anyhow::Context;
use glam::DVec3;
use rerun::{
    Arrows3D, Mesh3D, Points3D, Quaternion, RecordingStream, RecordingStreamBuilder, Scalars, Transform3D,
    TransformAxes3D, ViewCoordinates,
};

/// Colours of bodies 0, 1, … and over again.
const BODIES: [[u8; 3]; 6] =
    [[222, 158, 77], [77, 158, 173], [168, 122, 191], [140, 168, 77], [217, 120, 120], [153, 128, 102]];
const PREDICTED: [u8; 3] = [43, 107, 217];
/// Translucent, as it hides what it touches.
const TOOL: [u8; 4] = [128, 140, 158, 160];
const FORCE: [u8; 3] = [204, 18, 64];
/// Drawn length of the axes of a part whose shape is unknown \[m\].
const AXES: f32 = 0.02;

/// The bytes of an `.rrd` file: particles, forces, tool and prediction on the timelines `frame` and `time` \[s\].
///
/// A force is drawn as x_{t+1} − 2 x_t + x_{t−1} \[m\], what it moves its particle by in one control interval.
///
/// # Errors
/// When Rerun cannot encode them.
pub(super) fn bytes(recording: &Playback, prediction: Option<&Prediction>) -> anyhow::Result<Vec<u8>> {
    let encoded = encode(recording, prediction);
    encoded.with_context(|| format!("{} cannot be written as a Rerun recording", recording.path.display()))
}

fn encode(recording: &Playback, prediction: Option<&Prediction>) -> anyhow::Result<Vec<u8>> {
    let episode = &recording.episode;
    let name = recording.path.file_stem().unwrap_or_default().to_string_lossy();
    // Enabled, or else the environment could silently turn it into an empty file.
    let builder = RecordingStreamBuilder::new("pliant").recording_name(name).enabled(true);
    let (stream, storage) = builder.memory()?;
    // When it was written says nothing of when it happened.
    stream.set_log_time_enabled(false);
    unchanging(&stream, recording)?;
    let errors = prediction.map(|p| p.errors(recording));
    for (t, state) in episode.states.iter().enumerate() {
        stream.set_time_sequence("frame", t as i64);
        stream.set_duration_secs("time", t as f64 * episode.interval);
        stream.log("particles", &Points3D::new(rows(&state.positions)))?;
        stream.log("forces", &forces(&episode.states, t))?;
        for (k, pose) in episode.poses(t).iter().enumerate() {
            let rotation = Quaternion::from_xyzw(pose.rotation.as_quat().to_array());
            let translation = pose.translation.as_vec3().to_array();
            stream.log(part(k), &Transform3D::from_translation_rotation(translation, rotation))?;
        }
        if let Some(predicted) = prediction.and_then(|p| p.rollout.get(t)) {
            stream.log("predicted", &Points3D::new(rows(&predicted.positions)))?;
        }
        // A plot has no room for infinity.
        if let Some(error) = errors.as_ref().and_then(|e| e.get(t)).filter(|e| e.is_finite()) {
            stream.log("rmse", &Scalars::single(*error))?;
        }
    }
    Ok(storage.drain_as_bytes()?)
}

/// What holds in all frames: which way is up, colours, sizes, and the tool's shape.
fn unchanging(stream: &RecordingStream, recording: &Playback) -> anyhow::Result<()> {
    let radius = 0.5 * recording.spacing() as f32;
    let colours = recording.episode.body.iter().map(|body| BODIES[*body as usize % BODIES.len()]);
    let balls = Points3D::update_fields;
    stream.log_static("/", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    stream.log_static("particles", &balls().with_radii([radius]).with_colors(colours))?;
    stream.log_static("predicted", &balls().with_radii([0.8 * radius]).with_colors([PREDICTED]))?;
    stream.log_static("forces", &Arrows3D::update_fields().with_colors([FORCE]))?;
    for k in 0..recording.episode.start.len() {
        match &recording.shape {
            Some(shape) => {
                let (vertices, triangles) = facets(&shape.parts[k].solid);
                let mesh = Mesh3D::new(rows(&vertices)).with_triangle_indices(triangles);
                stream.log_static(part(k), &mesh.with_albedo_factor(TOOL))?;
            }
            None => stream.log_static(part(k), &TransformAxes3D::new(AXES))?,
        }
    }
    Ok(())
}

/// Nothing in the first and last frame, which lack a neighbour.
fn forces(states: &[Particles], t: usize) -> Arrows3D {
    let (Some(before), Some(after)) = (t.checked_sub(1), states.get(t + 1)) else {
        return Arrows3D::from_vectors(rows(&[])).with_origins(rows(&[]));
    };
    let now = &states[t].positions;
    let neighbours = states[before].positions.iter().zip(&after.positions);
    let pushes: Vec<DVec3> = now.iter().zip(neighbours).map(|(x, (b, a))| *a - 2.0 * *x + *b).collect();
    Arrows3D::from_vectors(rows(&pushes)).with_origins(rows(now))
}

fn part(k: usize) -> String {
    format!("tool/{k}")
}

fn rows(points: &[DVec3]) -> impl Iterator<Item = [f32; 3]> {
    points.iter().map(|p| p.as_vec3().to_array())
}
