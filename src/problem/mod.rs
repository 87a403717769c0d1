//! A planning problem: model, tool, scene and goal, seen by a planner as an [`Objective`].
use crate::model::{Cost, WorldModel};
use crate::planner::Objective;
use crate::state::{ActionSpace, Particles, Scene};
use crate::tool::{Motion, Tool, Workpiece};
use crate::train::policy::Policy;
use anyhow::{Context, ensure};
use glam::DVec3;
use rayon::prelude::*;

mod metered;
mod sequence;

pub use metered::{Budget, Clock, Metered, Spent};
pub use sequence::{Sequence, Stroke};

/// Candidates rolled out at once: enough to fill a network's batch, few enough that their states fit in memory.
const BATCH: usize = 64;

/// `J(θ) = Σₜ ℓₜ(xₜ)` of the rollout that `model` predicts for the motion that `tool` makes of θ.
pub struct Problem<'a> {
    model: &'a dyn WorldModel,
    tool: &'a dyn Tool,
    scene: Scene,
    piece: Workpiece,
    space: ActionSpace,
    cost: &'a dyn Cost,
    steps: usize,
    learned: Option<(&'a Policy, &'a [DVec3])>,
}

impl<'a> Problem<'a> {
    /// A problem over the box that `tool` has for `piece`, each motion taking `steps` control steps from `scene`.
    ///
    /// The scene's tool poses only matter to whether the model accepts it: each motion begins at its own start.
    ///
    /// # Errors
    /// When the model does not accept the scene, there is no step, or a bound of the box is impossible.
    pub fn new(
        model: &'a dyn WorldModel,
        tool: &'a dyn Tool,
        scene: Scene,
        piece: Workpiece,
        cost: &'a dyn Cost,
        steps: usize,
    ) -> anyhow::Result<Self> {
        let space = begun(model, tool, &scene, &piece, steps)?;
        Ok(Self { model, tool, scene, piece, space, cost, steps, learned: None })
    }

    /// The same problem with proposals of a policy of its model and tool, which is shown the points of the goal \[m\].
    pub fn advised(self, policy: &'a Policy, goal: &'a [DVec3]) -> Self {
        Self { learned: Some((policy, goal)), ..self }
    }

    /// The path of `theta`: what the model is asked about, and what the world must execute.
    pub fn motion(&self, theta: &[f64]) -> Motion {
        self.tool.motion(theta, &self.piece, self.steps)
    }

    /// J of a rollout; `∞` when any state is not finite, even one that the cost does not look at.
    fn total(&self, rollout: &[Particles]) -> f64 {
        let cost = self.cost.total(rollout);
        if cost.is_finite() && rollout.iter().all(Particles::is_finite) { cost } else { f64::INFINITY }
    }
}

/// The box that `tool` has for `piece`, if `model` can move it in `steps` control steps from `scene`.
fn begun(
    model: &dyn WorldModel,
    tool: &dyn Tool,
    scene: &Scene,
    piece: &Workpiece,
    steps: usize,
) -> anyhow::Result<ActionSpace> {
    ensure!(steps > 0, "a motion needs at least one control step");
    let space = tool.space(piece);
    room(&space, piece)?;
    model.accepts(scene).context("the model cannot start from this scene")?;
    Ok(space)
}

/// Whether every bound of the box that a tool has for `piece` leaves room.
fn room(space: &ActionSpace, piece: &Workpiece) -> anyhow::Result<()> {
    for ((name, low), high) in space.names.iter().zip(&space.low).zip(&space.high) {
        ensure!(
            low.is_finite() && high.is_finite() && low <= high,
            "the action {name} has no room between its bounds [{low}, {high}] on a workpiece of extent {:?} m",
            piece.extent.to_array()
        );
    }
    Ok(())
}

impl Objective for Problem<'_> {
    fn space(&self) -> &ActionSpace {
        &self.space
    }

    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        let batch = |plans: &[Vec<f64>]| -> Vec<f64> {
            let motions: Vec<_> = plans.iter().map(|theta| self.motion(theta)).collect();
            let rollouts = self.model.rollouts(&self.scene, &motions);
            rollouts.par_iter().map(|rollout| self.total(rollout)).collect()
        };
        plans.chunks(BATCH).flat_map(batch).collect()
    }

    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)> {
        if !self.cost.has_gradient() {
            return None;
        }
        let motion = self.motion(plan);
        let scene = Scene { poses: motion.start, ..self.scene.clone() };
        let gradient = self.model.gradient(&scene, &motion.controls, self.cost)?;
        let cost = if gradient.cost.is_finite() { gradient.cost } else { f64::INFINITY };
        Some((cost, self.tool.motion_vjp(plan, &self.piece, &gradient.scene.poses, &gradient.controls)))
    }

    fn gradients(&self, plans: &[Vec<f64>]) -> Vec<Option<(f64, Vec<f64>)>> {
        plans.par_iter().map(|plan| self.gradient(plan)).collect()
    }

    fn proposals(&self, most: usize) -> Vec<Vec<f64>> {
        let propose = |(policy, goal): (&Policy, &[DVec3])| {
            policy.propose(&self.scene.particles.positions, goal, &self.space, most)
        };
        self.learned.map(propose).unwrap_or_default()
    }
}
