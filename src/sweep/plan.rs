//! Which trials a sweep consists of.
use super::SweepSpec;
use crate::config::assignment;

/// One trial before its config is resolved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trial {
    /// The overrides that lead from the base to it, seeds included.
    pub overrides: Vec<String>,
    /// The same without seeds and without what all trials share, as one name: repetitions of one trial share it.
    pub label: String,
}

/// All trials: the product of the grid, the baseline with its one-at-a-time changes, and the seeds.
pub fn plan(spec: &SweepSpec) -> Vec<Trial> {
    let mut points: Vec<Vec<String>> = vec![Vec::new()];
    for (key, values) in &spec.grid {
        let along = |point: Vec<String>| {
            values.iter().map(move |value| point.iter().cloned().chain([assignment(key, value)]).collect())
        };
        points = points.into_iter().flat_map(along).collect();
    }
    let baseline = Vec::new();
    let changes: Vec<&Vec<String>> = std::iter::once(&baseline).chain(&spec.changes).collect();
    let changed = points.iter().flat_map(|point| changes.iter().map(move |change| [&point[..], &change[..]].concat()));
    let repeated = changed.flat_map(|overrides| {
        let label = if overrides.is_empty() { "baseline".to_owned() } else { overrides.join(" ") };
        let seeds: Vec<Option<u64>> = match &spec.seeds[..] {
            [] => vec![None],
            seeds => seeds.iter().copied().map(Some).collect(),
        };
        seeds.into_iter().map(move |seed| {
            let seeded = seed.into_iter().flat_map(|seed| {
                let further = spec.seeded.iter().map(move |key| format!("{key}={seed}"));
                std::iter::once(format!("seeds=[{seed}]")).chain(further)
            });
            let overrides = spec.set.iter().chain(&overrides).cloned().chain(seeded).collect();
            Trial { overrides, label: label.clone() }
        })
    });
    repeated.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn spec(text: serde_json::Value) -> SweepSpec {
        serde_json::from_value(text).unwrap()
    }

    #[test]
    fn a_grid_is_every_combination_once_with_the_last_key_fastest() {
        let grid = json!({ "planner": ["cem", "true"], "x.y": [1, 0.5, [1, 2]] });
        let trials = plan(&spec(json!({ "base": "b", "grid": grid })));
        let labels: Vec<&str> = trials.iter().map(|trial| trial.label.as_str()).collect();
        assert_eq!(
            labels[..4],
            ["planner=cem x.y=1", "planner=cem x.y=0.5", "planner=cem x.y=[1, 2]", "planner=\"true\" x.y=1"]
        );
        assert_eq!(labels.len(), 6);
    }

    #[test]
    fn changes_stand_alone_beside_the_baseline_and_seeds_repeat_each() {
        let trials = plan(&spec(json!({ "base": "b", "changes": [["a=1"], ["b=2", "~c"]], "seeds": [3, 4] })));
        let overrides: Vec<String> = trials.iter().map(|trial| trial.overrides.join(" ")).collect();
        let wanted =
            ["seeds=[3]", "seeds=[4]", "a=1 seeds=[3]", "a=1 seeds=[4]", "b=2 ~c seeds=[3]", "b=2 ~c seeds=[4]"];
        assert_eq!(overrides, wanted);
        assert_eq!(trials[1].label, "baseline");
        assert_eq!(trials[4].label, trials[5].label);
    }

    #[test]
    fn further_keys_get_each_seed_and_no_place_in_the_name() {
        let trials = plan(&spec(json!({ "base": "b", "seeds": [3, 4], "seeded": ["fit.seed", "laws.0.seed"] })));
        let overrides: Vec<String> = trials.iter().map(|trial| trial.overrides.join(" ")).collect();
        assert_eq!(overrides, ["seeds=[3] fit.seed=3 laws.0.seed=3", "seeds=[4] fit.seed=4 laws.0.seed=4"]);
        assert!(trials.iter().all(|trial| trial.label == "baseline"));
    }
}
