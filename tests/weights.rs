//! Weights on disk and the learned law's config: what is written comes back, and what cannot be used is a sentence.
use pliant::compare::ContenderSpec;
use pliant::config;
use pliant::model::law::{FrameSpec, Law, Learned, LearnedSpec};
use pliant::model::net::{Aggregation, Sharing};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use safetensors::{SafeTensors, serialize};
use std::collections::HashMap;

fn spec(width: usize) -> LearnedSpec {
    LearnedSpec {
        history: 1,
        bodies: 1,
        constants: Default::default(),
        precision: Default::default(),
        shared_edges: false,
        layer_norm: false,
        width,
        rounds: 2,
        sharing: Sharing::Shared,
        aggregation: Aggregation::Sum,
        edges: ["particle", "tool", "floor"].map(str::to_owned).to_vec(),
        radius: 0.02,
        scale: 0.004,
        frame: FrameSpec::default(),
        seed: 1,
        weights: None,
    }
}

/// A law that was shaken out of its zero start.
fn shaken() -> Learned {
    let mut law = spec(16).build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let weights: Vec<f32> = law.weights().iter().map(|w| w + rng.random_range(-0.15..0.15)).collect();
    law.set_weights(&weights);
    law
}

#[test]
fn weights_survive_the_disk_and_bad_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.safetensors");
    let law = shaken();
    law.save_weights(&path).unwrap();
    let from = |width: usize, path: &std::path::Path| LearnedSpec { weights: Some(path.into()), ..spec(width) }.build();
    let loaded = from(16, &path).unwrap();
    assert_eq!(loaded.weights(), law.weights());
    let bytes = std::fs::read(&path).unwrap();
    loaded.save_weights(&path).unwrap();
    assert_eq!(bytes, std::fs::read(&path).unwrap(), "the same weights are the same bytes");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no half file is left");

    let complaint = |width, path: &std::path::Path| format!("{:#}", from(width, path).unwrap_err());
    let other = complaint(24, &path);
    for part in ["w.safetensors", "width 16", "width 24", "[10, 24]", "[10, 16]"] {
        assert!(other.contains(part), "{part} in {other}");
    }
    let rounds = LearnedSpec { weights: Some(path.clone()), rounds: 3, ..spec(16) }.build().unwrap_err();
    assert!(format!("{rounds:#}").contains("3 rounds"), "{rounds:#}");
    let greatest = LearnedSpec { weights: Some(path.clone()), aggregation: Aggregation::Max, ..spec(16) };
    let greatest = format!("{:#}", greatest.build().unwrap_err());
    assert!(
        greatest.contains("Max") && greatest.contains("Sum"),
        "equal shapes do not make equal networks: {greatest}"
    );
    let bad = folder.path().join("bad.safetensors");
    assert!(complaint(16, &bad).contains("bad.safetensors"));
    let mut not_a_number = bytes.clone();
    let last = bytes.len() - 4;
    not_a_number[last..].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut hostile = bytes.clone();
    hostile[..8].copy_from_slice(&u64::MAX.to_le_bytes());
    let mut longer = bytes.clone();
    longer.extend([0; 16]);
    let cut = [0, 7, 8, 50, bytes.len() / 2, bytes.len() - 1].map(|n| bytes[..n].to_vec());
    for damaged in cut.into_iter().chain([not_a_number, hostile, longer]) {
        std::fs::write(&bad, &damaged).unwrap();
        assert!(complaint(16, &bad).contains("bad.safetensors"));
    }
}

#[test]
fn a_file_that_speaks_of_its_architecture_in_riddles_is_refused_and_one_that_is_silent_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.safetensors");
    let law = shaken();
    law.save_weights(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let tensors = SafeTensors::deserialize(&bytes).unwrap().tensors();
    let from = |metadata: Option<(&str, &str)>| {
        let metadata = metadata.map(|(key, text)| HashMap::from([(key.to_owned(), text.to_owned())]));
        let views = tensors.iter().map(|(name, view)| (name, view));
        std::fs::write(&path, serialize(views, metadata).unwrap()).unwrap();
        LearnedSpec { weights: Some(path.clone()), ..spec(16) }.build()
    };
    for silent in [None, Some(("format", "pt"))] {
        assert_eq!(from(silent).unwrap().weights(), law.weights(), "its matrices fit by name and shape");
    }
    let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
    let own = header.metadata().as_ref().unwrap()["architecture"].clone();
    assert_eq!(from(Some(("architecture", &own))).unwrap().weights(), law.weights());
    let mut riddles = ["", "16", "null", "[]", "{}", "{\"width\":16}", "a graph network"].map(str::to_owned).to_vec();
    riddles.push(own[..own.len() - 1].to_owned());
    riddles.push("[".repeat(100_000));
    for (word, other) in [("\"width\"", "\"wodth\""), ("\"sum\"", "\"som\""), (":16", ":-16"), (":16", ":1e99")] {
        assert!(own.contains(word), "{word} in {own}");
        riddles.push(own.replace(word, other));
    }
    for riddle in riddles {
        let sentence = format!("{:#}", from(Some(("architecture", &riddle))).unwrap_err());
        for part in ["w.safetensors", "config asks for width 16", "architecture makes no sense"] {
            assert!(sentence.contains(part), "{part} in {sentence}");
        }
    }
}

#[test]
fn impossible_configs_are_sentences() {
    let complaint = |change: &dyn Fn(&mut LearnedSpec)| {
        let mut spec = spec(16);
        change(&mut spec);
        format!("{:#}", spec.build().unwrap_err())
    };
    assert!(complaint(&|s| s.edges = vec!["flor".into()]).contains("floor"));
    assert!(complaint(&|s| s.edges.push("tool".into())).contains("twice"));
    assert!(complaint(&|s| s.scale = 0.0).contains("scale"));
    assert!(complaint(&|s| s.radius = f64::NAN).contains("radius"));
    assert!(complaint(&|s| s.width = 0).contains("width"));
    assert!(complaint(&|s| s.rounds = 0).contains("rounds"));
}

#[test]
fn every_model_calls_its_weights_what_their_file_calls_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.safetensors");
    let mut named = 0;
    for entry in std::fs::read_dir("configs/model").unwrap() {
        let file = entry.unwrap().path();
        let mut model = config::load::<ContenderSpec>(&file, &[]).unwrap().spec.dynamics.build().unwrap();
        let count = model.weights().len();
        if count == 0 {
            assert_eq!(model.matrices(), [], "{}", file.display());
            continue;
        }
        // No number twice, so that one in another place is noticed.
        let weights: Vec<f32> = (0..count).map(|k| k as f32).collect();
        model.set_weights(&weights);
        model.save_weights(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let stored = SafeTensors::deserialize(&bytes).unwrap();
        let mut end = 0;
        for (name, size) in model.matrices() {
            let own: Vec<u8> = weights[end..end + size].iter().flat_map(|w| w.to_le_bytes()).collect();
            assert_eq!(stored.tensor(&name).unwrap().data(), own, "{name} of {}", file.display());
            end += size;
        }
        assert_eq!((end, stored.len()), (count, model.matrices().len()), "{}", file.display());
        named += 1;
    }
    assert!(named > 8, "only {named} models have weights");
}
