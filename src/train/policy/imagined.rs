//! What a policy learns from: random actions as a model imagines them.
use super::PolicySpec;
use crate::data::{Episode, random_action};
use crate::model::WorldModel;
use crate::state::{Scene, stream};
use crate::tool::{Tool, Workpiece};
use crate::train::point_net::{Clouds, Example};
use crate::watch::Watch;

/// First word of every stream that actions are drawn from.
const IMAGINING: u64 = u64::from_le_bytes(*b"imagined");

/// The first state of an episode with the tool where its middle action begins.
fn scene(tool: &dyn Tool, start: &Episode, steps: usize) -> (Scene, Workpiece) {
    let scene = start.scene(0, tool.shape());
    let piece = Workpiece::around(&scene.particles);
    let space = tool.space(&piece);
    let poses = tool.motion(&space.at(&vec![0.5; space.dimension()]), &piece, steps).start;
    (Scene { poses, ..scene }, piece)
}

/// Number of the tool's coordinates; none where there is no start, or the model cannot begin there: the simulator, which must not be
/// learned from.
pub(super) fn dimension(model: &dyn WorldModel, tool: &dyn Tool, starts: &[Episode], steps: usize) -> Option<usize> {
    let (scene, piece) = scene(tool, starts.first()?, steps);
    model.accepts(&scene).ok()?;
    Some(tool.space(&piece).dimension())
}

/// Starts, what the model makes of them by random actions, and these as fractions of the tool's box; rollouts that are not finite are
/// left out. None where no action moves anything.
pub(super) fn examples(
    spec: &PolicySpec,
    model: &dyn WorldModel,
    tool: &dyn Tool,
    starts: &[Episode],
    steps: usize,
    watch: &Watch,
) -> anyhow::Result<Option<Vec<Example<Vec<f64>>>>> {
    let bar = watch.stage("imagine actions", spec.samples as u64);
    let (mut examples, mut moved) = (Vec::new(), false);
    for (k, start) in starts.iter().enumerate() {
        watch.go_on(|| "stopped while imagining actions; the same command begins them again".to_owned())?;
        let (scene, piece) = scene(tool, start, steps);
        model.accepts(&scene)?;
        let mut rng = stream(spec.network.seed, &[IMAGINING, k as u64]);
        // As equal shares as there are, so that together they are as many as were asked for.
        let count = (k + 1) * spec.samples / starts.len() - k * spec.samples / starts.len();
        let (actions, motions): (Vec<_>, Vec<_>) =
            (0..count).map(|_| random_action(tool, &scene.particles, steps, &mut rng)).unzip();
        let space = tool.space(&piece);
        let before = &scene.particles.positions;
        for (theta, rollout) in actions.iter().zip(model.rollouts(&scene, &motions)) {
            let Some(end) = rollout.last().filter(|end| end.is_finite()) else { continue };
            moved |= end.positions != *before;
            let clouds = Clouds::new(before, &end.positions, spec.network.extent);
            examples.push(Example { clouds, target: space.unit(theta) });
        }
        bar.inc(count as u64);
    }
    bar.finish_and_clear();
    Ok(moved.then_some(examples))
}
