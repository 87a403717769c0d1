//! Behind a gate: the way to the goal leads away from it first.
use glam::DVec3;
use indexmap::IndexMap;
use pliant::chooser::{Choice, Chooser, ChooserSpec, ExhaustiveSpec, Lesson, OrderedSpec, RepeatedSpec, Task};
use pliant::config::fingerprint;
use pliant::model::Dynamics;
use pliant::problem::Budget;
use pliant::state::*;
use pliant::tool::{Motion, Tool, Workpiece};
use pliant::train::Split;
use pliant::watch::Watch;
use std::sync::Arc;

/// The particle goes where the tool carries it, but through the plane x = 5 mm only above y = 3 cm.
struct Gate;

impl Dynamics for Gate {
    type State = (DVec3, DVec3);

    fn encode(&self, scene: &Scene) -> Self::State {
        (scene.particles.positions[0], scene.poses[0].translation)
    }
    fn step(&self, (at, tool): &Self::State, control: &Control) -> Self::State {
        let mut to = *at + control.poses[0].translation - *tool;
        if (at.x < 0.005) != (to.x < 0.005) && to.y < 0.03 {
            to.x = at.x;
        }
        (to, control.poses[0].translation)
    }
    fn decode(&self, state: &Self::State) -> Particles {
        Particles::at_rest(vec![state.0])
    }
}

/// θ = (x, y): a straight way.
struct Carry(Arc<ToolShape>, f64);

impl Tool for Carry {
    fn shape(&self) -> &Arc<ToolShape> {
        &self.0
    }
    fn space(&self, _: &Workpiece) -> ActionSpace {
        ActionSpace { names: vec!["x".into(), "y".into()], low: vec![-self.1; 2], high: vec![self.1; 2] }
    }
    fn motion(&self, theta: &[f64], _: &Workpiece, steps: usize) -> Motion {
        let way = DVec3::new(theta[0], theta[1], 0.0);
        let at = |t: usize| vec![Pose { translation: t as f64 / steps as f64 * way, ..Pose::default() }];
        Motion { start: at(0), controls: (1..=steps).map(|t| Control { poses: at(t) }).collect() }
    }
}

fn tools(count: usize) -> IndexMap<String, Box<dyn Tool>> {
    let shape = Arc::new(ToolShape::from(vec![Part {
        solid: Solid::Cuboid { half: DVec3::splat(0.01) },
        surface: Vec::new(),
    }]));
    // The first one alone reaches far enough.
    let reach = |k: usize| if k == 0 { 0.04 } else { 0.012 };
    (0..count).map(|k| (format!("carry_{k}"), Box::new(Carry(shape.clone(), reach(k))) as Box<dyn Tool>)).collect()
}

fn choose(
    chooser: &dyn Chooser,
    tools: &IndexMap<String, Box<dyn Tool>>,
    lookahead: usize,
    action: u64,
    at: DVec3,
) -> anyhow::Result<Choice> {
    let particles = Particles::at_rest(vec![at]);
    chooser.choose(&Task {
        model: &Gate,
        tools,
        scene: &|shape, poses| Scene::open(particles.clone(), shape.clone(), poses.to_vec(), 0.1),
        piece: Workpiece::around(&particles),
        cost: &super::cost("chamfer", vec![DVec3::new(0.04, 0.0, 0.0)]),
        current: &[],
        goal: &[],
        policies: &IndexMap::new(),
        steps: 6,
        planner: super::planner("cem").as_ref(),
        budget: Budget { rollouts: 800, ..super::BUDGET },
        clock: &|| 0.0,
        seed: 3,
        action,
        lookahead,
    })
}

/// None of these has anything to learn.
fn kind(spec: ChooserSpec) -> Box<dyn Chooser> {
    let data = Split { train: Vec::new(), held_out: Vec::new(), tools: Default::default() };
    let (dataset, tools, watch) = (fingerprint(&0), tools(1), Watch::silent());
    let lesson = Lesson { data: &data, dataset: &dataset, tools: &tools, root: "".as_ref(), watch: &watch };
    spec.build().unwrap().make(&lesson).unwrap()
}

fn exhaustive() -> Box<dyn Chooser> {
    kind(ChooserSpec::Exhaustive(ExhaustiveSpec {}))
}

/// Where the particle is after the first action of a choice, and what it was promised.
fn carried(choice: &Choice, from: DVec3) -> (DVec3, f64) {
    let (_, plan, motion) = choice.best().unwrap();
    let mut state = (from, motion.start[0].translation);
    motion.controls.iter().for_each(|control| state = Gate.step(&state, control));
    (state.0, plan.cost)
}

#[test]
fn looking_one_action_ahead_stays_before_the_gate_and_two_ahead_goes_through() {
    let (tools, chooser) = (tools(1), exhaustive());
    let goal = DVec3::new(0.04, 0.0, 0.0);
    let mut greedy = DVec3::ZERO;
    for action in 0..4 {
        greedy = carried(&choose(&*chooser, &tools, 1, action, greedy).unwrap(), greedy).0;
    }
    assert!(greedy.x < 0.005 && greedy.distance(goal) > 0.03, "{greedy}");
    let choice = choose(&*chooser, &tools, 2, 0, DVec3::ZERO).unwrap();
    let (first, promised) = carried(&choice, DVec3::ZERO);
    // Chamfer counts the distance both ways.
    assert!(first.distance(goal) > 0.04 && promised < 0.03, "{first}, {promised}");
    let [next] = choice.rest() else { panic!("one action is left") };
    assert!(next.stroke.start[0].distance(first) < 1e-12, "the second starts where the first one ends");
    let (end, kept) = carried(&choose(&*chooser, &tools, 1, 1, first).unwrap(), first);
    assert!(end.distance(goal) < 0.005 && kept <= promised, "{end}");
}

#[test]
fn every_sequence_has_its_own_budget_and_random_numbers_and_too_many_are_refused() {
    let names = |choice: &Choice| -> Vec<Vec<String>> {
        let all = choice.alternatives.iter();
        all.map(|a| [a.tool.clone()].into_iter().chain(a.then.iter().map(|n| n.tool.clone())).collect()).collect()
    };
    let (two, chooser) = (tools(2), exhaustive());
    let choice = choose(&*chooser, &two, 2, 0, DVec3::ZERO).unwrap();
    let pairs = [["carry_0", "carry_0"], ["carry_0", "carry_1"], ["carry_1", "carry_0"], ["carry_1", "carry_1"]];
    assert_eq!(names(&choice), pairs);
    assert!(choice.alternatives.iter().all(|a| (100..=800).contains(&a.spent.rollouts) && a.spent.rollouts % 2 == 0));
    assert_eq!(choice, choose(&*chooser, &two, 2, 0, DVec3::ZERO).unwrap());
    assert_eq!(choice.chosen, Some(0), "only the long way leads around");
    let refused = choose(&*chooser, &tools(3), 4, 0, DVec3::ZERO).unwrap_err().to_string();
    assert!(refused.contains("4 actions of 3 tools") && refused.contains("repeated"), "{refused}");

    let repeated = kind(ChooserSpec::Repeated(RepeatedSpec {}));
    let same = names(&choose(&*repeated, &tools(3), 4, 0, DVec3::ZERO).unwrap());
    assert!(same.len() == 3 && same.iter().all(|tools| tools.len() == 4 && tools.iter().all(|t| *t == tools[0])));

    let list = ["carry_1", "carry_0", "carry_0"].map(String::from).to_vec();
    let ordered = kind(ChooserSpec::Ordered(OrderedSpec { tools: list }));
    let at = |action| names(&choose(&*ordered, &two, 2, action, DVec3::ZERO).unwrap());
    assert_eq!([at(0), at(1), at(2)], [[["carry_1", "carry_0"]], [["carry_0", "carry_0"]], [["carry_0", "carry_1"]]]);
    let strange = kind(ChooserSpec::Ordered(OrderedSpec { tools: vec!["spoon".into()] }));
    let refused = choose(&*strange, &two, 1, 0, DVec3::ZERO).unwrap_err().to_string();
    assert!(refused.contains("spoon") && refused.contains("carry_0, carry_1"), "{refused}");
}
