//! Several primitives in a row as one objective: each starts from what the model predicts after the one before.
use super::{BATCH, begun, room};
use crate::model::{Cost, Gradient, WorldModel};
use crate::planner::Objective;
use crate::state::{ActionSpace, Particles, ParticlesGrad, Scene};
use crate::tool::{Motion, Tool, Workpiece};
use anyhow::Context;
use glam::DVec3;

/// `J(θ₁, u₂ … u_k) = Σₜ ℓₜ(xₜ)` over the rollouts of k primitives, each with its own tool.
///
/// The first has its θ in the box that its tool has for the piece, as a [`super::Problem`] does; the boxes of later ones depend on
/// what is predicted before them, so that their coordinates are the fractions u ∈ \[0, 1\] of those boxes.
pub struct Sequence<'a> {
    model: &'a dyn WorldModel,
    tools: Vec<&'a dyn Tool>,
    scene: Scene,
    piece: Workpiece,
    space: ActionSpace,
    cost: &'a dyn Cost,
    steps: usize,
}

/// One primitive of a plan, and the prediction that it was made for.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// θ in the box that its tool has for the predicted piece.
    pub theta: Vec<f64>,
    /// Its path.
    pub motion: Motion,
    /// Where the particles are when it starts \[m\].
    pub start: Vec<DVec3>,
}

/// A primitive where the model has arrived.
struct Stage {
    scene: Scene,
    piece: Workpiece,
    theta: Vec<f64>,
    motion: Motion,
}

impl<'a> Sequence<'a> {
    /// A problem over one primitive of each of `tools`, in their order, each motion taking `steps` control steps; `scene` holds the
    /// first tool.
    ///
    /// # Errors
    /// When there is no tool, and as [`super::Problem::new`].
    pub fn new(
        model: &'a dyn WorldModel,
        tools: Vec<&'a dyn Tool>,
        scene: Scene,
        piece: Workpiece,
        cost: &'a dyn Cost,
        steps: usize,
    ) -> anyhow::Result<Self> {
        let (first, later) = tools.split_first().context("a sequence needs at least one tool")?;
        let mut space = begun(model, *first, &scene, &piece, steps)?;
        for (tool, number) in later.iter().zip(2..) {
            let names = tool.space(&piece).names;
            space.low.extend(names.iter().map(|_| 0.0));
            space.high.extend(names.iter().map(|_| 1.0));
            space.names.extend(names.iter().map(|name| format!("{name} of action {number}")));
        }
        Ok(Self { model, tools, scene, piece, space, cost, steps })
    }

    /// The primitives that `plan` describes, or `None` where the model's predictions between them are not finite.
    pub fn strokes(&self, plan: &[f64]) -> Option<Vec<Stroke>> {
        let stages = self.stages(plan)?.0;
        let stroke = |s: Stage| Stroke { theta: s.theta, motion: s.motion, start: s.scene.particles.positions };
        Some(stages.into_iter().map(stroke).collect())
    }

    /// What `plan` says of the primitive at `place`.
    fn part<'p>(&self, plan: &'p [f64], place: usize) -> &'p [f64] {
        let size = |tool: &&dyn Tool| tool.space(&self.piece).dimension();
        let from: usize = self.tools[..place].iter().map(size).sum();
        &plan[from..from + size(&self.tools[place])]
    }

    /// The primitive at `place` of `plan` in `scene`; `None` where its box has no room.
    fn stage(&self, plan: &[f64], place: usize, mut scene: Scene) -> Option<Stage> {
        let (tool, part) = (self.tools[place], self.part(plan, place));
        let (piece, theta) = if place == 0 {
            (self.piece, part.to_vec())
        } else {
            let piece = Workpiece::around(&scene.particles);
            let space = tool.space(&piece);
            room(&space, &piece).ok()?;
            (piece, space.at(part))
        };
        let motion = tool.motion(&theta, &piece, self.steps);
        scene.tool = tool.shape().clone();
        scene.poses.clone_from(&motion.start);
        Some(Stage { scene, piece, theta, motion })
    }

    /// Every primitive of `plan`, and the cost of all states before the last one's start, that start itself excluded.
    fn stages(&self, plan: &[f64]) -> Option<(Vec<Stage>, f64)> {
        let (mut stages, mut cost) = (Vec::new(), 0.0);
        let mut scene = self.scene.clone();
        for place in 0..self.tools.len() {
            let stage = self.stage(plan, place, scene.clone())?;
            if place + 1 < self.tools.len() {
                let ends = self.model.follow(std::slice::from_ref(&stage.scene), std::slice::from_ref(&stage.motion));
                let (rollout, snapshot) = ends.into_iter().next()?;
                cost += self.segment(place, &[]).total(&rollout);
                let end = rollout.last().filter(|_| rollout.iter().all(Particles::is_finite))?;
                scene = stage.scene.after(end, snapshot);
            }
            stages.push(stage);
        }
        Some((stages, cost))
    }

    fn segment<'s>(&'s self, place: usize, at_end: &'s [DVec3]) -> Segment<'s> {
        Segment { cost: self.cost, before: place * self.steps, horizon: self.tools.len() * self.steps, at_end }
    }

    /// Costs of few enough plans to keep in memory at once; those that broke are not followed further.
    fn batch(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        let mut costs = vec![0.0; plans.len()];
        let mut alive: Vec<(usize, Scene)> = (0..plans.len()).map(|i| (i, self.scene.clone())).collect();
        for place in 0..self.tools.len() {
            let mut staged = Vec::new();
            for (i, scene) in alive {
                match self.stage(&plans[i], place, scene) {
                    Some(stage) => staged.push((i, stage)),
                    None => costs[i] = f64::INFINITY,
                }
            }
            let (scenes, motions): (Vec<_>, Vec<_>) =
                staged.into_iter().map(|(i, stage)| ((i, stage.scene), stage.motion)).unzip();
            let (places, scenes): (Vec<usize>, Vec<Scene>) = scenes.into_iter().unzip();
            alive = Vec::new();
            for ((i, scene), (rollout, snapshot)) in
                places.into_iter().zip(scenes.iter()).zip(self.model.follow(&scenes, &motions))
            {
                costs[i] += self.segment(place, &[]).total(&rollout);
                let end = rollout.last().filter(|_| costs[i].is_finite() && rollout.iter().all(Particles::is_finite));
                match end {
                    Some(end) => alive.push((i, scene.after(end, snapshot))),
                    None => costs[i] = f64::INFINITY,
                }
            }
        }
        costs
    }

    /// `∂J/∂(part of the plan)` of one primitive, and what its path adds to `∂J/∂(positions at its start)`.
    fn pull(&self, place: usize, unit: &[f64], stage: &Stage, gradient: &Gradient) -> (Vec<f64>, Vec<DVec3>) {
        let (tool, start, controls) = (self.tools[place], &gradient.scene.poses, &gradient.controls);
        let slope = tool.motion_vjp(&stage.theta, &stage.piece, start, controls);
        if place == 0 {
            return (slope, Vec::new());
        }
        let by_piece = tool.piece_vjp(unit, &stage.piece, start, controls);
        (tool.space(&stage.piece).by_unit(&slope), Workpiece::around_vjp(&stage.scene.particles, &by_piece))
    }
}

impl Objective for Sequence<'_> {
    fn space(&self) -> &ActionSpace {
        &self.space
    }

    fn costs(&self, plans: &[Vec<f64>]) -> Vec<f64> {
        plans.chunks(BATCH).flat_map(|plans| self.batch(plans)).collect()
    }

    fn gradient(&self, plan: &[f64]) -> Option<(f64, Vec<f64>)> {
        if !self.cost.has_gradient() {
            return None;
        }
        let (stages, before) = self.stages(plan)?;
        let (mut cost, mut slope, mut at_end) = (before, Vec::new(), Vec::new());
        for (place, stage) in stages.iter().enumerate().rev() {
            let segment = self.segment(place, &at_end);
            let gradient = self.model.gradient(&stage.scene, &stage.motion.controls, &segment)?;
            if place + 1 == stages.len() {
                cost += gradient.cost;
            }
            let (part, by_path) = self.pull(place, self.part(plan, place), stage, &gradient);
            at_end = gradient.scene.particles.positions;
            at_end.iter_mut().zip(&by_path).for_each(|(a, b)| *a += *b);
            slope.splice(0..0, part);
        }
        Some((if cost.is_finite() { cost } else { f64::INFINITY }, slope))
    }

    fn price(&self) -> usize {
        self.tools.len()
    }
}

/// The part of a cost that one primitive's states bear, and the pull `⟨at_end, x⟩` of all that follows on its last one.
struct Segment<'a> {
    cost: &'a dyn Cost,
    /// Control steps before it.
    before: usize,
    /// Control steps of the whole sequence.
    horizon: usize,
    at_end: &'a [DVec3],
}

impl Cost for Segment<'_> {
    fn at(&self, t: usize, horizon: usize, particles: &Particles) -> f64 {
        // Where it starts another one has ended, and has counted that state.
        let own = if t == 0 && self.before > 0 { 0.0 } else { self.cost.at(self.before + t, self.horizon, particles) };
        let pull = self.at_end.iter().zip(&particles.positions).map(|(g, x)| g.dot(*x));
        if t == horizon && !self.at_end.is_empty() { own + pull.sum::<f64>() } else { own }
    }

    fn gradient(&self, t: usize, horizon: usize, particles: &Particles) -> ParticlesGrad {
        let mut own = if t == 0 && self.before > 0 {
            ParticlesGrad::zero(particles.len())
        } else {
            self.cost.gradient(self.before + t, self.horizon, particles)
        };
        if t == horizon {
            own.positions.iter_mut().zip(self.at_end).for_each(|(a, b)| *a += *b);
        }
        own
    }
}
