//! Claim: `∂J/∂θ` of every differentiable model points the way that the world's own central differences do, both where the tool
//! hardly works the dough and where contacts come and go.
//!
//! Command: `cargo run --release --bin experiments -- gradient_quality`, about ten minutes. Table:
//! `paper/tables/gradient_quality.tex`.
use crate::adjudge::{adjudge, lower};
use crate::claim::{Experiment, Rows, Size, median, number};
use anyhow::Context;
use pliant::compare::{self, CompareSpec, Contender, Source};
use pliant::config;
use pliant::metric::GoalCost;
use pliant::model::Cost;
use pliant::planner::Objective;
use pliant::problem::Problem;
use pliant::state::stream;
use pliant::table::{Grid, Interval};
use pliant::tool::{Motion, Tool, Workpiece};
use pliant::watch::Watch;
use pliant::world::World;
use rand::Rng;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::Path;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "gradient_quality",
    claim: "the gradient of every differentiable model points the way that the world's differences do",
    duration: "about 10 minutes",
    rows: Rows::Measured(measure),
    table,
};

const MODELS: &str = "model=[analytic,mpm,learned,hybrid,residual,output_residual,feature,projected,neural_constants,latent,linear,unet]";
/// Step of the world's differences as a fraction of the action box; they are taken at twice that too.
const STEP: f64 = 0.02;
/// An action is as far from the box's walls as the greatest step.
const MARGIN: f64 = 2.0 * STEP;

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (words, seeds, actions) = match size {
        Size::Paper => (vec![MODELS], 5, 4),
        Size::Smoke => {
            (vec!["model=[analytic]", "dataset=smoke", "model.analytic.train.identify.evaluations=12"], 1, 1)
        }
    };
    let words: Vec<String> = words.into_iter().map(str::to_owned).collect();
    let spec = config::load::<CompareSpec>("configs/compare/quickstart.toml".as_ref(), &words)?.spec;
    let (contenders, _) = compare::fit(&spec, watch)?;
    let goal = spec.goal.get("disc").context("the comparison has no goal `disc`")?.clone().build()?;
    let mut rows = Vec::new();
    for seed in 0..seeds {
        let start = World::new(&spec.dataset.scene, seed)?;
        let goal = goal.make(&Source { start: &start, dataset: &spec.dataset, root: &spec.data.root, seed })?;
        let cost = GoalCost::new(spec.cost.clone().build()?, goal.points)?;
        for (name, tool) in &spec.dataset.tool {
            let bench = Bench { start: &start, tool: tool.clone().build()?, cost: &cost, steps: spec.dataset.steps };
            let mut rng = stream(seed, &[u64::from_le_bytes(*b"gradient")]);
            for action in 0..actions {
                watch.go_on(|| "stopped; nothing is kept of the measurement".to_owned())?;
                let dimension = bench.tool.space(&bench.piece()).dimension();
                let unit: Vec<f64> = (0..dimension).map(|_| rng.random_range(MARGIN..1.0 - MARGIN)).collect();
                let truth = bench.differences(&unit, STEP);
                let own = cosine(&truth, &bench.differences(&unit, 2.0 * STEP));
                let moved = bench.moved(&unit);
                let key = json!({ "seed": seed, "tool": name, "action": action, "moved": moved });
                let row = |model: &str, cosine: Option<f64>, length: Option<f64>| {
                    let mut row = key.clone();
                    row["model"] = json!(model);
                    row["cosine"] = json!(cosine);
                    row["length"] = json!(length);
                    row
                };
                rows.push(row("world, twice the step", own, Some(norm(&truth))));
                for contender in &contenders {
                    let Some(gradient) = bench.gradient(contender, &unit)? else { continue };
                    rows.push(row(&contender.name, cosine(&truth, &gradient), Some(norm(&gradient))));
                }
            }
        }
    }
    Ok(rows)
}

/// One tool at one start of the world.
struct Bench<'a> {
    start: &'a World,
    tool: Box<dyn Tool>,
    cost: &'a GoalCost,
    steps: usize,
}

impl Bench<'_> {
    fn piece(&self) -> Workpiece {
        Workpiece::around(&self.start.particles())
    }

    /// Root mean square distance that the world moves a particle by an action, given as fractions of the box \[m\].
    fn moved(&self, unit: &[f64]) -> f64 {
        let piece = self.piece();
        let motion = self.tool.motion(&self.tool.space(&piece).at(unit), &piece, self.steps);
        let rollout = self.start.clone().execute(self.tool.shape(), &motion);
        let (start, end) = (&rollout[0].positions, &rollout[self.steps].positions);
        let squares: f64 = start.iter().zip(end).map(|(x, y)| x.distance_squared(*y)).sum();
        (squares / start.len() as f64).sqrt()
    }

    /// `(J(u + h eₖ) − J(u − h eₖ)) / 2h` of the world for every k \[m\].
    fn differences(&self, unit: &[f64], h: f64) -> Vec<f64> {
        let piece = self.piece();
        let side = |k: usize, h: f64| {
            let mut moved = unit.to_vec();
            moved[k] += h;
            (self.start.clone(), self.tool.motion(&self.tool.space(&piece).at(&moved), &piece, self.steps))
        };
        // A world belongs to one thread, its clones to others.
        let sides: Vec<_> = (0..unit.len()).flat_map(|k| [side(k, h), side(k, -h)]).collect();
        let cost = |(mut world, motion): (World, Motion)| self.cost.total(&world.execute(self.tool.shape(), &motion));
        let costs: Vec<f64> = sides.into_par_iter().map(cost).collect();
        costs.chunks(2).map(|two| (two[0] - two[1]) / (2.0 * h)).collect()
    }

    /// `∂J/∂u` through a model, none where it has no derivative or none that is finite.
    fn gradient(&self, contender: &Contender, unit: &[f64]) -> anyhow::Result<Option<Vec<f64>>> {
        let piece = self.piece();
        let space = self.tool.space(&piece);
        let theta = space.at(unit);
        let scene = self.start.scene(self.tool.shape(), &self.tool.motion(&theta, &piece, self.steps).start);
        let problem = Problem::new(contender.model.as_ref(), self.tool.as_ref(), scene, piece, self.cost, self.steps)?;
        let gradient = problem.gradient(&theta).map(|(_, gradient)| space.by_unit(&gradient));
        Ok(gradient.filter(|gradient| gradient.iter().all(|g| g.is_finite())))
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Of the angle between two directions; none where one of them is zero.
fn cosine(x: &[f64], y: &[f64]) -> Option<f64> {
    let lengths = norm(x) * norm(y);
    (lengths > 0.0).then(|| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() / lengths)
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let mut models: Vec<&str> = Vec::new();
    for model in rows.iter().filter_map(|row| row["model"].as_str()) {
        if !models.contains(&model) {
            models.push(model);
        }
    }
    let middle = |tool: &Value| {
        let same = rows.iter().filter(|row| row["tool"] == *tool && row["model"] == models[0]);
        median(same.map(|row| number(row, "moved")).collect())
    };
    let firm = |row: &Value| number(row, "moved") > middle(&row["tool"]);
    let line = |model: &&str| {
        let mut cells = vec![(*model).to_owned()];
        for wanted in [false, true] {
            let mine: Vec<&Value> = rows.iter().filter(|row| row["model"] == **model && firm(row) == wanted).collect();
            let cosines = mine.iter().filter_map(|row| Some((row["seed"].as_u64()?, row["cosine"].as_f64()?)));
            let all: Vec<f64> = cosines.clone().map(|(_, cosine)| cosine).collect();
            let downhill = all.iter().filter(|cosine| **cosine > 0.0).count();
            cells.push(Interval::shares(Interval::over_seeds(cosines)));
            cells.push(format!("{downhill} of {}", all.len()));
        }
        let lengths: Vec<f64> =
            rows.iter().filter(|row| row["model"] == **model).map(|row| number(row, "length")).collect();
        cells.push(format!("{:.2}", 1e3 * median(lengths)));
        cells
    };
    let uphill = |model: &str, wanted: bool| {
        let mine = rows.iter().filter(|row| row["model"] == model && firm(row) == wanted);
        Interval::over_seeds(mine.filter_map(|row| Some((row["seed"].as_u64()?, -row["cosine"].as_f64()?))))
    };
    // The first are the world's own.
    let claims = models.iter().skip(1).flat_map(|model| {
        [("light", false), ("firm", true)]
            .map(|(how, wanted)| (format!("{model}, {how}"), lower(uphill(model, wanted))))
    });
    let claims = adjudge("a cosine above zero with the world's differences", claims);
    let header = ["model", "light: cosine", "downhill", "firm: cosine", "downhill", "length [mm]"];
    Ok(Grid {
        title: "Gradients of the cost by the action, against the world's central differences".into(),
        header: header.map(String::from).to_vec(),
        rows: models.iter().map(line).collect(),
        notes: vec![
            format!(
                "cosine of the angle to the world's central differences with {STEP} of the action box to either side, mean ± 95 % interval \
                 over seeds; downhill: how often it is positive"
            ),
            "light, firm: actions that move the world's dough less or more than the tool's median action does".into(),
            format!(
                "world, twice the step: its differences with {} against those with {STEP}, the ceiling; its length is that of the \
                     differences",
                2.0 * STEP
            ),
            "length: median over all actions of |∂J/∂u|, u the action as fractions of its box".into(),
            claims,
        ],
    })
}
