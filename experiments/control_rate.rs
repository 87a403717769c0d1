//! Claims: at RoboCook's size (300 particles, 15 control steps, one tool) one plan by CEM with forty samples in each of twenty rounds takes
//! at most 5 s with the graph network on two threads, a policy's proposal at most 50 ms, a plan by the planner `policy`, which rolls
//! proposals out, at most 50 ms too, and the gradient of a rollout at most five times the rollout.
//!
//! Command: `cargo run --release --bin experiments -- control_rate`, about fifteen minutes. Table: `paper/tables/control_rate.tex`. Linux
//! only: CPU time and load are read from `/proc`.
use crate::claim::{Experiment, Rows, Size, median, number, read, verdict};
use crate::cpu::{cpu_seconds, process_seconds};
use crate::speaking::shaken;
use anyhow::{Context, ensure};
use indexmap::IndexSet;
use pliant::compare::{Artifacts, CompareSpec, RUNS, Source};
use pliant::config;
use pliant::data::{Episode, record};
use pliant::metric::GoalCost;
use pliant::model::WorldModel;
use pliant::planner::Planner;
use pliant::problem::{Budget, Metered, Problem};
use pliant::state::{Control, Scene, stream};
use pliant::table::Grid;
use pliant::tool::{Tool, Workpiece};
use pliant::train::policy::Policy;
use pliant::watch::Watch;
use pliant::world::World;
use rayon::ThreadPool;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "control_rate",
    claim: "at RoboCook's size CEM plans in 5 s by the network on two threads, a policy proposes and plans in 50 ms, a gradient takes 5 rollouts",
    duration: "about 15 minutes",
    rows: Rows::Measured(measure),
    table,
};

/// The search of the first claim, and what it may take \[s\] with the graph network; no other model is planned with by it.
const CLAIMED: (&str, f64) = ("cem_40_20", 5.0);
/// What a proposal may take \[s\], the plan of the planner that rolls proposals out likewise, and a gradient \[rollouts\].
const PROPOSAL: (&str, f64) = ("a policy's proposal", 0.05);
const POLICY: &str = "policy";
const GRADIENT: f64 = 5.0;
/// Rollouts and gradients in a row between two looks at the clock of a thread, which ticks every few milliseconds.
const PASSES: usize = 8;
/// The graph network, which all searches plan with, and others of its kind, which only that of the first claim plans with.
const NETWORKS: [&str; 6] =
    ["learned", "learned_bfloat16", "learned_near", "learned_near_bfloat16", "learned_150", "learned_150_bfloat16"];
const SMOKE: [&str; 3] = ["dataset.scene.particles=40", "dataset.steps=4", "policy.samples=4"];

fn measure(size: Size, _: &Path, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (words, repeats, rollouts) = match size {
        Size::Paper => (Vec::new(), 3, usize::MAX),
        Size::Smoke => (SMOKE.map(str::to_owned).to_vec(), 1, 4),
    };
    let spec = config::load::<CompareSpec>("configs/compare/control_rate.toml".as_ref(), &words)?.spec;
    let episode = record(&spec.dataset, 0)?;
    let pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let bench = Bench { spec: &spec, start: World::new(&spec.dataset.scene, 0)?, pools: [pool(1)?, pool(2)?] };
    let models = spec.model.iter().map(|(name, model)| {
        let model = shaken(model.dynamics.clone().build()?, b"control\0");
        Ok((name.as_str(), bench.posed(name, model, std::slice::from_ref(&episode), watch)?))
    });
    let models = models.collect::<anyhow::Result<Vec<_>>>()?;
    let mut rows = Vec::new();
    for repeat in 0..repeats {
        for (name, posed) in &models {
            let mut made = bench.passes(posed)?;
            for (planner, search) in &spec.planner {
                watch.go_on(|| "stopped between two measurements; nothing is kept of them".into())?;
                let wanted = match planner == CLAIMED.0 {
                    true => NETWORKS.contains(name),
                    false => !NETWORKS[1..].contains(name),
                };
                if wanted {
                    let budget = Budget { rollouts, ..spec.budget };
                    made.extend(bench.plan(posed, (planner, &*search.clone().build()?), budget, repeat)?);
                }
            }
            rows.extend(made.into_iter().map(|mut row| {
                (row["model"], row["repeat"]) = (json!(name), json!(repeat));
                row
            }));
        }
    }
    Ok(rows)
}

/// What all measurements share.
struct Bench<'a> {
    spec: &'a CompareSpec,
    start: World,
    /// Of one thread and of two.
    pools: [ThreadPool; 2],
}

/// A model before one tool's problem.
struct Posed {
    model: Box<dyn WorldModel>,
    tool: Box<dyn Tool>,
    policy: Option<Policy>,
    scene: Scene,
    cost: GoalCost,
    goal: Vec<glam::DVec3>,
    /// Of the motion in the middle of the tool's box.
    controls: Vec<Control>,
}

impl Bench<'_> {
    fn posed(
        &self,
        name: &str,
        model: Box<dyn WorldModel>,
        episodes: &[Episode],
        watch: &Watch,
    ) -> anyhow::Result<Posed> {
        let Self { spec, start, .. } = self;
        let (_, tool) = spec.dataset.tool.first().context("the comparison has no tool")?;
        let (tool, maker) = (tool.clone().build()?, spec.goal[0].clone().build()?);
        let source = Source { start, dataset: &spec.dataset, root: &spec.data.root, seed: 0 };
        let goal = maker.make(&source)?.points;
        let (folder, _) = Artifacts::below(RUNS.as_ref()).folder("control_rate", &(spec, name));
        let policy = spec.policy.fit(&*model, &*tool, episodes, spec.dataset.steps, &folder, watch)?;
        let piece = self.piece();
        let space = tool.space(&piece);
        let motion = tool.motion(&space.at(&vec![0.5; space.dimension()]), &piece, spec.dataset.steps);
        let scene = start.scene(tool.shape(), &motion.start);
        let cost = GoalCost::new(spec.cost.clone().build()?, goal.clone())?;
        Ok(Posed { model, tool, policy, scene, cost, goal, controls: motion.controls })
    }

    fn piece(&self) -> Workpiece {
        Workpiece::around(&self.start.particles())
    }

    /// A rollout and its gradient on one thread, and what a policy proposes.
    fn passes(&self, posed: &Posed) -> anyhow::Result<Vec<Value>> {
        let Posed { model, tool, policy, scene, cost, goal, controls } = posed;
        let space = tool.space(&self.piece());
        self.pools[0].install(|| {
            let (mut rollout, mut gradient) = (Vec::new(), None);
            let often = |work: &mut dyn FnMut()| timed(cpu_seconds, || (0..PASSES).for_each(|_| work()));
            let (_, _, forward) = often(&mut || rollout = model.rollout(scene, controls))?;
            let moved = rollout.last().context("a rollout has a start")?;
            ensure!(moved.is_finite() && moved.positions != scene.particles.positions, "nothing moves, or all is lost");
            let (_, _, backward) = often(&mut || gradient = model.gradient(scene, controls, cost))?;
            gradient.context("the model has lost its adjoint")?;
            let policy = policy.as_ref().context("no policy was learned")?;
            let current = &scene.particles.positions;
            let (proposed, seconds, cpu) = timed(cpu_seconds, || policy.propose(current, goal, &space, 1))?;
            ensure!(proposed.len() == 1, "the policy proposes nothing");
            let points = scene.tool.surface_at(&scene.poses).count();
            Ok(vec![
                json!({ "what": "rollout", "cpu": forward / PASSES as f64, "tool_points": points, "gradient": backward / forward }),
                json!({ "what": PROPOSAL.0, "seconds": seconds, "cpu": cpu, "load": load()? }),
            ])
        })
    }

    /// One plan on two threads, and what it takes.
    fn plan(
        &self,
        posed: &Posed,
        (name, planner): (&str, &dyn Planner),
        budget: Budget,
        repeat: u64,
    ) -> anyhow::Result<Option<Value>> {
        let Posed { model, tool, policy, scene, cost, goal, .. } = posed;
        let problem = Problem::new(&**model, &**tool, scene.clone(), self.piece(), cost, self.spec.dataset.steps)?;
        let problem = match policy {
            Some(policy) => problem.advised(policy, goal),
            None => problem,
        };
        let began = Instant::now();
        let clock = move || began.elapsed().as_secs_f64();
        let metered = Metered::new(&problem, budget, &clock);
        let mut rng = stream(repeat, &[u64::from_le_bytes(*b"control\0")]);
        let load = load()?;
        let search = || self.pools[1].install(|| planner.plan(&metered, &mut rng));
        let (plan, seconds, cpu) = timed(process_seconds, search)?;
        let spent = metered.spent();
        Ok(plan.map(|_| {
            json!({ "what": name, "seconds": seconds, "cpu": cpu, "load": load, "rollouts": spent.rollouts,
                "gradients": spent.gradients, "not_finite": spent.not_finite })
        }))
    }
}

/// What `work` gives, its wall time, and its time by another clock \[s\].
fn timed<T>(clock: fn() -> anyhow::Result<f64>, work: impl FnOnce() -> T) -> anyhow::Result<(T, f64, f64)> {
    let (wall, cpu) = (Instant::now(), clock()?);
    let made = work();
    let seconds = wall.elapsed().as_secs_f64();
    Ok((made, seconds, clock()? - cpu))
}

/// Threads that computed or waited to, on the mean of the last minute.
fn load() -> anyhow::Result<f64> {
    let text = read("/proc/loadavg".as_ref())?;
    let first = text.split_whitespace().next().and_then(|n| n.parse().ok());
    first.context("/proc/loadavg holds no number")
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let of = |model: &str, what: &str, key: &str| -> Vec<f64> {
        let own = rows.iter().filter(|row| row["model"] == model && row["what"] == what);
        own.map(|row| number(row, key)).collect()
    };
    let distinct = |key: &str| rows.iter().filter_map(|row| row[key].as_str()).collect::<IndexSet<_>>();
    let (models, plans) = (distinct("model"), distinct("what"));
    let mut lines = Vec::new();
    for (model, what) in models.iter().flat_map(|model| plans.iter().map(move |what| (*model, *what))) {
        let seconds = of(model, what, "seconds");
        let middle = median(seconds.clone());
        if !middle.is_finite() {
            continue;
        }
        let [least, most] = [f64::min, f64::max].map(|end| seconds.iter().copied().fold(f64::NAN, end));
        let spent = ["rollouts", "gradients"].map(|key| median(of(model, what, key)));
        lines.push(vec![
            model.to_owned(),
            what.to_owned(),
            if spent[0].is_finite() { format!("{:.0} + {:.0}", spent[0], spent[1]) } else { "–".to_owned() },
            format!("{middle:.3} ({least:.3}–{most:.3})"),
            format!("{:.3}", median(of(model, what, "cpu"))),
            format!("{:.3}", middle.recip()),
        ]);
    }
    let prices = models.iter().map(|model| {
        let price = median(of(model, "rollout", "gradient"));
        format!("{model} {price:.2} ({})", verdict(price <= GRADIENT))
    });
    let (search, most) = CLAIMED;
    let plans_by = NETWORKS.map(|model| {
        let [plan, work] = ["seconds", "cpu"].map(|key| median(of(model, search, key)));
        format!("{model} {plan:.1} s, {work:.1} CPU seconds ({})", verdict(plan <= most))
    });
    let plans_by = plans_by.join("; ");
    let proposals = models.iter().map(|model| median(of(model, PROPOSAL.0, "seconds"))).fold(f64::NAN, f64::max);
    let planned = models.iter().filter_map(|model| {
        let plan = median(of(model, POLICY, "seconds"));
        plan.is_finite().then(|| format!("{model} {:.1} ms ({})", 1e3 * plan, verdict(plan <= PROPOSAL.1)))
    });
    let planned = planned.collect::<Vec<_>>().join("; ");
    let all = |key: &str| rows.iter().map(|row| number(row, key)).filter(|x| x.is_finite()).collect::<Vec<f64>>();
    let rollouts = models.iter().map(|model| format!("{model} {:.1}", 1e3 * median(of(model, "rollout", "cpu"))));
    let header = [
        "model",
        "search",
        "rollouts + gradients",
        "seconds a plan (least–most)",
        "CPU seconds",
        "plans a second [Hz]",
    ];
    Ok(Grid {
        title: "What each search takes at RoboCook's size, and the rate it controls at".into(),
        header: header.map(String::from).to_vec(),
        rows: lines,
        notes: vec![
            format!(
                "300 particles, {:.0} points of the tool, 15 control steps, one tool, every search at the sizes of its own file and on two \
                 threads of two cores; medians of {:.0} repeats in which all take their turns; weights that nobody trained. The machine's load \
                 before a search, this program's own threads included, was {:.1} on the median: above two, wall times are too long, CPU \
                 times are not",
                median(all("tool_points")),
                all("repeat").into_iter().fold(0.0, f64::max) + 1.0,
                median(all("load"))
            ),
            format!("CPU milliseconds of one rollout: {}", rollouts.collect::<Vec<_>>().join(", ")),
            format!(
                "{search}, claimed {most} s with the graph network: {plans_by}; near: a radius at which the graph has about as many edges as \
                 RoboCook's, whose price in prediction is in the table of `radius`, and that of bfloat16 in the table of `rounding`"
            ),
            format!(
                "{}, the policy's network alone: {:.1} ms at most (claim: {:.0} ms; {})",
                PROPOSAL.0,
                1e3 * proposals,
                1e3 * PROPOSAL.1,
                verdict(proposals <= PROPOSAL.1)
            ),
            format!(
                "a plan by `{POLICY}`, which also rolls proposals out with the model, claimed {:.0} ms: {planned}",
                1e3 * PROPOSAL.1
            ),
            format!(
                "CPU time of a rollout with its gradient over that of a rollout, claimed {GRADIENT}: {}",
                prices.collect::<Vec<_>>().join(", ")
            ),
        ],
    })
}
