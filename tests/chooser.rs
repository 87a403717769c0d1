//! Choosing between tools, one of which made the goal.
mod drag;

use drag::*;
use indexmap::IndexMap;
use pliant::chooser::{Choice, Chooser, Exhaustive, Task};
use pliant::model::{Cost, Dynamics, Gradient, WorldModel};
use pliant::planner::Planner;
use pliant::problem::Budget;
use pliant::state::*;
use pliant::tool::{Motion, Tool};
use std::sync::Mutex;

fn tools(list: &[(&str, f64)]) -> IndexMap<String, Box<dyn Tool>> {
    list.iter().map(|(name, length)| ((*name).to_owned(), Box::new(slide(*length)) as Box<dyn Tool>)).collect()
}

fn choose(
    model: &dyn WorldModel,
    list: &[(&str, f64)],
    planner: &dyn Planner,
    budget: Budget,
    action: u64,
) -> anyhow::Result<Choice> {
    let task = Task {
        model,
        tools: &tools(list),
        scene: &scene,
        piece: piece(),
        cost: &cost("chamfer", goal(0.03, &[0.01, -0.01, 1.0])),
        current: &scene(slide(0.03).shape(), &[]).particles.positions,
        goal: &goal(0.03, &[0.01, -0.01, 1.0]),
        policies: &IndexMap::new(),
        steps: 6,
        planner,
        budget,
        clock: &|| 0.0,
        seed: 3,
        action,
        lookahead: 1,
    };
    Exhaustive.choose(&task)
}

const LENGTHS: [(&str, f64); 3] = [("short", 0.005), ("right", 0.03), ("long", 0.12)];

#[test]
fn the_tool_that_made_the_goal_is_chosen_and_the_others_are_reported() {
    let cem = planner("cem");
    let choice = choose(&Drag, &LENGTHS, cem.as_ref(), BUDGET, 0).unwrap();
    let (name, plan, motion) = choice.best().unwrap();
    assert_eq!(name, "right");
    assert_eq!(*motion, slide(0.03).motion(&plan.theta, &piece(), 6));
    let names: Vec<_> = choice.alternatives.iter().map(|a| a.tool.as_str()).collect();
    assert_eq!(names, ["short", "right", "long"]);
    for other in &choice.alternatives {
        assert!(other.found.as_ref().unwrap().0.cost >= plan.cost);
        assert!(other.spent.rollouts > 40 && other.spent.rollouts <= BUDGET.rollouts, "each search has a whole budget");
    }
    assert_eq!(choice.spent().rollouts, choice.alternatives.iter().map(|a| a.spent.rollouts).sum::<usize>());
    assert_eq!(choice, choose(&Drag, &LENGTHS, cem.as_ref(), BUDGET, 0).unwrap());
    assert_ne!(choice, choose(&Drag, &LENGTHS, cem.as_ref(), BUDGET, 1).unwrap(), "every action has its own stream");
}

#[test]
fn equal_tools_tie_and_the_first_wins() {
    // A budget of one plan, the middle of the box, leaves nothing to chance.
    let budget = Budget { rollouts: 1, ..BUDGET };
    let list = [("long", 0.12), ("one", 0.03), ("two", 0.03)];
    let choice = choose(&Drag, &list, planner("cem").as_ref(), budget, 0).unwrap();
    let costs: Vec<f64> = choice.alternatives.iter().map(|a| a.found.as_ref().unwrap().0.cost).collect();
    assert!(costs[1] == costs[2] && costs[0] > costs[1], "{costs:?}");
    assert_eq!(choice.chosen, Some(1));
}

#[test]
fn without_a_gradient_no_tool_is_chosen_and_a_scene_that_is_refused_names_the_tool() {
    let none = choose(&Broken, &LENGTHS, planner("descent").as_ref(), BUDGET, 0).unwrap();
    assert!(none.best().is_none() && none.alternatives.len() == 3);
    assert_eq!((none.spent().rollouts, none.spent().gradients), (0, 0));
    let refused = choose(&Refuses, &LENGTHS, planner("cem").as_ref(), BUDGET, 0).err().unwrap();
    assert!(format!("{refused:#}").contains("tool short") && format!("{refused:#}").contains("a snapshot"));
}

#[test]
fn every_model_is_offered_the_same_first_samples_and_every_tool_its_own() {
    let first_batches = |model: &dyn WorldModel| -> Vec<Vec<Motion>> {
        let seen = Recorder { model, asked: Mutex::default() };
        choose(&seen, &[("one", 0.03), ("two", 0.03)], planner("cem").as_ref(), BUDGET, 0).unwrap();
        // Only a first round, drawn before any cost is known, has forty plans.
        seen.asked.into_inner().unwrap().into_iter().filter(|motions| motions.len() == 40).collect()
    };
    let batches = first_batches(&Drag);
    assert_eq!(batches.len(), 2);
    assert_eq!(batches, first_batches(&Broken));
    assert!(batches[0][0] == batches[1][0] && batches[0][1] != batches[1][1], "only the middle is shared by tools");
}

/// A model that wants what the scene has not.
struct Refuses;

impl Dynamics for Refuses {
    type State = Particles;
    fn accepts(&self, _: &Scene) -> anyhow::Result<()> {
        anyhow::bail!("this model needs a snapshot")
    }
    fn encode(&self, scene: &Scene) -> Particles {
        scene.particles.clone()
    }
    fn step(&self, state: &Particles, _: &Control) -> Particles {
        state.clone()
    }
    fn decode(&self, state: &Particles) -> Particles {
        state.clone()
    }
}

/// Notes what a model is asked.
struct Recorder<'a> {
    model: &'a dyn WorldModel,
    asked: Mutex<Vec<Vec<Motion>>>,
}

impl WorldModel for Recorder<'_> {
    fn accepts(&self, scene: &Scene) -> anyhow::Result<()> {
        self.model.accepts(scene)
    }
    fn rollout(&self, scene: &Scene, controls: &[Control]) -> Rollout {
        self.model.rollout(scene, controls)
    }
    fn rollouts(&self, scene: &Scene, motions: &[Motion]) -> Vec<Rollout> {
        self.asked.lock().unwrap().push(motions.to_vec());
        self.model.rollouts(scene, motions)
    }
    fn gradient(&self, _: &Scene, _: &[Control], _: &dyn Cost) -> Option<Gradient> {
        None
    }
    fn weight_gradient(&self, _: &Scene, _: &[Control], _: &dyn Cost) -> Option<Gradient> {
        None
    }
    fn weights(&self) -> Vec<f32> {
        Vec::new()
    }
    fn set_weights(&mut self, _: &[f32]) {}
    fn save_weights(&self, path: &std::path::Path) -> anyhow::Result<()> {
        self.model.save_weights(path)
    }
}
