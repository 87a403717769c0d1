//! Models that adapt to the scene that is planned in.
use pliant::compare::{CompareSpec, Contender, compare, fit};
use pliant::config;
use pliant::data::Dataset;
use pliant::watch::Watch;
use std::path::Path;

const SMALL: [&str; 10] = [
    "dataset=smoke",
    "model=[analytic_adapted, learned, learned_adapted, learned_first_layers]",
    "model.analytic_adapted.train.identify.evaluations=12",
    "model.analytic_adapted.adapt.identify_again.evaluations=12",
    "model.learned.train.network.steps=4",
    "model.learned_adapted.train.network.steps=4",
    "model.learned_adapted.adapt.fine_tune.steps=3",
    "model.learned_first_layers.train.network.steps=4",
    "model.learned_first_layers.adapt.first_layers.steps=3",
    "seeds=[0]",
];

fn spec(more: &[&str], root: &Path) -> CompareSpec {
    load(&[&SMALL, more].concat(), root)
}

fn load(words: &[&str], root: &Path) -> CompareSpec {
    let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
    let mut spec = config::load::<CompareSpec>("configs/compare/materials.toml".as_ref(), &words).unwrap().spec;
    spec.artifacts = root.to_owned();
    spec
}

fn named<'a>(contenders: &'a [Contender], name: &str) -> &'a Contender {
    contenders.iter().find(|contender| contender.name == name).unwrap()
}

#[test]
fn a_model_that_adapts_goes_on_from_its_fit_with_episodes_of_the_scene_that_is_planned_in() {
    let folder = tempfile::tempdir().unwrap();
    let watch = Watch::silent();
    let (contenders, _) = fit(&spec(&["interactions=5"], folder.path()), &watch).unwrap();
    let (learned, adapted) = (named(&contenders, "learned"), named(&contenders, "learned_adapted"));
    let stages = |contender: &Contender| contender.stages.keys().cloned().collect::<Vec<_>>();
    assert_eq!(
        (stages(learned), stages(adapted)),
        (vec!["network".into()], vec!["network".into(), "fine_tune".into()])
    );
    assert_eq!(learned.stages["network"], adapted.stages["network"], "one fit for both");
    assert_ne!(learned.model.weights(), adapted.model.weights());
    let first = named(&contenders, "learned_first_layers");
    let (before, after) = (learned.model.weights(), first.model.weights());
    let mut end = 0;
    for (name, count) in first.model.matrices() {
        let own = end..end + count;
        end = own.end;
        let learns = name.starts_with("node.") || name.starts_with("round.0.");
        // What sends messages over edges that are nowhere in the data has nothing to learn from.
        let may_stay = learns && name.contains(".edge.");
        assert!(may_stay || (before[own.clone()] != after[own]) == learns, "{name}");
    }
    assert_eq!(end, after.len());
    let again = named(&contenders, "analytic_adapted").stages.keys().cloned().collect::<Vec<_>>();
    assert_eq!(again, ["identify", "identify_again"]);

    // Another material there, and only what was adapted is another.
    let (elsewhere, _) = fit(&spec(&["interactions=5", "scene.material=play_doh"], folder.path()), &watch).unwrap();
    assert_eq!(named(&elsewhere, "learned").model.weights(), learned.model.weights());
    assert_ne!(named(&elsewhere, "learned_adapted").model.weights(), adapted.model.weights());
}

#[test]
fn interactions_are_as_many_as_were_asked_for_and_begin_as_no_episode_of_the_dataset_does() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["dataset=smoke", "model=[still]", "interactions=5", "~scene", "seeds=[0]"];
    fit(&load(&words, folder.path()), &Watch::silent()).unwrap();
    let starts = |path: &Path| -> Vec<Vec<_>> {
        let dataset = Dataset::load(path).unwrap();
        dataset.episodes.iter().map(|episode| episode.states[0].positions.clone()).collect()
    };
    let folders = std::fs::read_dir(folder.path().join("dataset")).unwrap();
    let mut sets: Vec<_> = folders.map(|entry| starts(&entry.unwrap().path())).collect();
    sets.sort_by_key(Vec::len);
    assert_eq!(sets.iter().map(Vec::len).collect::<Vec<_>>(), [5, 6]);
    assert!(sets[0].iter().all(|start| !sets[1].contains(start)), "a start that was learned from already");
}

#[test]
fn another_draw_of_interactions_teaches_something_else() {
    let folder = tempfile::tempdir().unwrap();
    let drawn = |seed: &str| {
        let words = [
            "dataset=smoke",
            "model=[learned_adapted, still]",
            "model.learned_adapted.train.network.steps=4",
            "model.learned_adapted.adapt.fine_tune.steps=3",
            "seeds=[0]",
            "interactions=5",
            seed,
        ];
        let words = words.map(str::to_owned);
        let mut spec = config::load::<CompareSpec>("configs/compare/materials.toml".as_ref(), &words).unwrap().spec;
        spec.artifacts = folder.path().to_owned();
        let (contenders, predictions) = fit(&spec, &Watch::silent()).unwrap();
        let errors = predictions.iter().map(|prediction| prediction.held_out.clone()).collect::<Vec<_>>();
        (named(&contenders, "learned_adapted").model.weights(), errors)
    };
    let (first, second) = (drawn("interactions_seed=0"), drawn("interactions_seed=1"));
    assert_ne!(first.0, second.0, "fitted to other episodes");
    assert_ne!(first.1[0], second.1[0], "and judged on others");
    // Where nothing moves and nothing is learned, errors differ by the episodes alone.
    assert_ne!(first.1[1], second.1[1], "judged on other episodes");
    assert_eq!(first, drawn("interactions_seed=0"));
}

#[test]
fn who_adapts_needs_something_to_adapt_to() {
    let folder = tempfile::tempdir().unwrap();
    let refused = fit(&spec(&["~interactions"], folder.path()), &Watch::silent()).err().unwrap().to_string();
    assert!(refused.contains("model.analytic_adapted") && refused.contains("interactions=12"), "{refused}");
}

#[test]
fn a_policy_is_learned_anew_where_its_model_adapted_to_other_interactions() {
    let folder = tempfile::tempdir().unwrap();
    let policies = |seed: &str| {
        let change = [
            "model=[analytic_adapted]",
            "planner=[policy]",
            "goal=[disc]",
            "interactions=5",
            "+policy={samples=3,network={steps=2}}",
            "chooser={kind=fixed,tool=press_square}",
            seed,
        ];
        let words = [&SMALL[..1], &SMALL[2..4], &SMALL[9..], &change].concat();
        let mut words: Vec<String> = words.into_iter().map(str::to_owned).collect();
        words.push(format!("+artifacts={}", folder.path().display()));
        let loaded = config::load::<CompareSpec>("configs/compare/materials.toml".as_ref(), &words).unwrap();
        compare(&loaded, "", &Watch::silent()).unwrap();
        std::fs::read_dir(folder.path().join("policy")).unwrap().count()
    };
    let first = policies("+interactions_seed=0");
    assert_eq!(policies("+interactions_seed=1"), 2 * first);
    std::fs::remove_dir_all(folder.path().join("compare")).unwrap();
    assert_eq!(policies("+interactions_seed=1"), 2 * first, "what is there is used again");
}
