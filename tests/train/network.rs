//! Training a graph network: wherever it stops, and on however many threads it runs, it ends with the same bits.
use super::toy::{self, Toy};
use super::{TRUTH, journal, spec};
use pliant::model::{ModelSpec, WorldModel};
use pliant::train::{Keep, TrainSpec};
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::path::Path;

const STEPS: usize = 8;

fn untrained() -> Box<dyn WorldModel> {
    let edges = json!(["particle", "tool", "floor", "leaf_root", "root_root", "root_leaf"]);
    let law = json!({
        "kind": "learned", "width": 16, "rounds": 2, "sharing": "per_round", "history": 2, "edges": edges, "radius": 0.04,
        "scale": 0.002, "frame": "tool", "seed": 1,
    });
    let graph = json!({ "kind": "hierarchy", "radius": 0.04, "edges": edges, "roots": [3] });
    let spec = json!({ "kind": "particles", "substeps": 1, "keep": 0.0, "graph": graph, "laws": [law] });
    serde_json::from_value::<ModelSpec>(spec).unwrap().build().unwrap()
}

/// Weights and journal of a run in `folder`, which whoever holds `watch` may have asked to stop.
fn trained(folder: &Path, watch: &Watch) -> anyhow::Result<(Vec<u32>, Vec<Value>)> {
    let own = TrainSpec { steps: STEPS as u64, batch: 4, noise: 1e-4, turn: 3.0, rate: 4e-3, warm_up: 2, ..spec() };
    let own = TrainSpec { validate_every: 4, log_every: 2, keep: Keep::Last, ..own };
    let mut model = untrained();
    own.build()?.train(&mut *model, &toy::split(&Toy::new(TRUTH)), folder, watch)?;
    Ok((bits(&*model), journal(folder)))
}

fn bits(model: &dyn WorldModel) -> Vec<u32> {
    model.weights().iter().map(|w| w.to_bits()).collect()
}

#[test]
fn a_graph_network_stopped_after_every_step_ends_with_the_bits_of_one_that_was_not() {
    let [whole, parts] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let reference = trained(whole.path(), &Watch::silent()).unwrap();
    let first = bits(&*untrained());
    let moved = reference.0.iter().zip(&first).filter(|(a, b)| a != b).count();
    assert!(moved > first.len() / 2, "only {moved} of {} weights were trained", first.len());

    // Asked to stop beforehand, a run does one step and leaves the rest to the next.
    let stopped = Watch::silent();
    stopped.stop();
    for _ in 1..STEPS {
        let error = trained(parts.path(), &stopped).unwrap_err().to_string();
        assert!(error.contains("goes on"), "{error}");
    }
    assert!(trained(parts.path(), &stopped).unwrap() == reference);
}

#[test]
fn the_number_of_threads_changes_no_bit_of_a_graph_network() {
    let on = |threads: usize| {
        let folder = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trained(folder.path(), &Watch::silent())).unwrap()
    };
    let alone = on(1);
    assert!([2, 3].map(on).iter().all(|other| *other == alone));
}
