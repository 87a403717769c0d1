//! Observing, imagining, and keeping to a plan while it holds: what a whole comparison makes of each.
use pliant::compare::{self, CompareSpec, Journey, Row, Step};
use pliant::config;
use pliant::data::Dataset;
use pliant::table::write_journey;
use pliant::view::Playback;
use pliant::watch::Watch;
use std::path::Path;

const QUICKSTART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/compare/quickstart.toml");
const SMALL: [&str; 8] = [
    "dataset=smoke",
    "model=[oracle,still]",
    "~planner.descent",
    "goal=[disc]",
    "seeds=[7]",
    "budget.rollouts=2",
    "chooser={kind=ordered,tools=[press_square,gripper_rod]}",
    "actions=2",
];

fn load(changes: &[&str], folder: &Path) -> anyhow::Result<config::Loaded<CompareSpec>> {
    let mut words: Vec<String> = SMALL.iter().chain(changes).map(|word| (*word).to_owned()).collect();
    words.push(format!("+artifacts={}", folder.display()));
    Ok(config::load(QUICKSTART.as_ref(), &words)?)
}

/// The rows of the simulator and of the model in which nothing moves.
fn rows(changes: &[&str], folder: &Path) -> [Row; 2] {
    let comparison = compare::compare(&load(changes, folder).unwrap(), "", &Watch::silent()).unwrap();
    comparison.rows().try_into().unwrap()
}

const DISTURBED: &str = "+disturbance=displace";

#[test]
fn the_simulator_left_alone_needs_no_observation_and_disturbed_it_does() {
    let folder = tempfile::tempdir().unwrap();
    let [closed, still] = rows(&[], folder.path());
    let [open, _] = rows(&["+control=open"], folder.path());
    assert!(closed.tools.len() == 2 && still.tools.len() == 2);
    assert_eq!((closed.achieved, &closed.actions), (open.achieved, &open.actions), "what it imagines is what happens");
    assert!((closed.predicted.unwrap() - closed.achieved.unwrap()).abs() < 1e-9);
    let [seen, _] = rows(&[DISTURBED], folder.path());
    let [unseen, _] = rows(&[DISTURBED, "+control=open"], folder.path());
    assert_eq!(unseen.actions, open.actions, "open loop knows of no disturbance");
    assert_eq!(seen.actions[0], closed.actions[0], "it comes after the first action");
    assert_ne!(seen.actions[1], closed.actions[1], "closed loop sees it");
    assert!((seen.predicted.unwrap() - seen.achieved.unwrap()).abs() < 1e-9, "and plans from what it sees");
    assert!((unseen.predicted.unwrap() - unseen.achieved.unwrap()).abs() > 1e-4);
}

#[test]
fn a_plan_is_kept_while_the_world_is_where_it_was_predicted_and_made_anew_where_not() {
    let folder = tempfile::tempdir().unwrap();
    let plans = |threshold: &str, change: Option<&str>| {
        let control = format!("+control={{triggered={{threshold={threshold}}}}}");
        let words = [&control[..], "+lookahead=2"];
        let rows = rows(&[&words[..], change.as_slice()].concat(), folder.path());
        assert!(rows.iter().all(|row| row.tools.len() == 2 && row.actions.len() == 2));
        rows.map(|row| row.plans.unwrap())
    };
    assert_eq!(plans("0.0", None), [1, 2], "only the simulator predicts to the last bit");
    assert_eq!(plans("1.0", None), [1, 1]);
    assert_eq!(plans("0.0005", Some(DISTURBED)), [2, 2]);
    let [closed, _] = rows(&[], folder.path());
    assert_eq!(closed.plans, None);
    assert!(!serde_json::to_string(&closed).unwrap().contains("plans"), "rows of other ways of control are as before");
}

#[test]
fn who_is_there_acts_no_more_and_impossible_ways_of_control_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [there, _] = rows(&["+until=1.0"], folder.path());
    assert!(there.tools.is_empty() && there.rollouts == 0);
    assert_eq!(
        (there.predicted, there.achieved),
        (None, Some(there.start)),
        "what is reached is achieved, though nobody planned"
    );
    assert!(there.metrics.values().any(Option::is_some));
    for (changes, word) in [
        (&["+control={triggered={threshold=-1.0}}", "+lookahead=2"][..], "threshold"),
        (&["+lookahead=5"], "lookahead"),
        (&["+control={triggered={threshold=0.1}}"], "lookahead"),
        (&["+planner.policy={extends=policy}", "+lookahead=2"], "policy"),
        (&["+disturbance={kind=push,speed=[2.0,1.0],radius=0.01,blows=1,rest=0}"], "speed"),
    ] {
        let loaded = load(changes, folder.path());
        let refused = loaded.and_then(|loaded| compare::compare(&loaded, "", &Watch::silent())).unwrap_err();
        assert!(format!("{refused:#}").contains(word), "{refused:#}");
    }
}

#[test]
fn a_plan_is_told_action_by_action_and_leaves_episodes_that_follow_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = load(&["+until=0.001"], folder.path()).unwrap();
    let mut told: Vec<Step> = Vec::new();
    let mut tell = |step: &Step| {
        told.push(step.clone());
        Ok(())
    };
    let journey: Journey = compare::plan(&loaded, &Watch::silent(), &mut tell).unwrap();
    assert_eq!(journey.names, ["oracle", "cem", "disc"]);
    assert_eq!((told.len(), &told), (2, &journey.steps));
    let lines = std::fs::read_to_string(journey.folder.join("plan.jsonl")).unwrap();
    let read: Vec<Step> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(read, told);
    for step in &told {
        assert!((step.predicted - step.achieved).abs() < 1e-9, "the simulator keeps its promise: {step:?}");
        assert!(step.rollouts == 2 && step.gradients == 0 && step.theta.contains_key("rotation"));
    }
    let episodes = journey.folder.join("episodes");
    let dataset = Dataset::load(&episodes).unwrap();
    let [first, second] = &dataset.episodes[..] else { panic!("two actions are two episodes") };
    assert_eq!(first.states.last().unwrap().positions, second.states[0].positions);
    assert_eq!([&first.tool, &second.tool], [&format!("1_{}", told[0].tool), &format!("2_{}", told[1].tool)]);
    assert_eq!(Playback::open(&episodes.join("episode_00001.npz")).unwrap().episode.tool, second.tool);
    let table = write_journey(&journey, "").unwrap();
    assert_eq!((table.rows.len(), journey.shapes.len()), (2, 3));
    assert!(std::fs::read_to_string(journey.folder.join("report.html")).unwrap().matches("<svg").count() == 4);
}
