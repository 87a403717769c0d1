//! Training that leaves layers as they are.
use super::toy::{self, Toy};
use super::{TRUTH, run, spec};
use pliant::train::{Keep, TrainSpec};
use pliant::watch::Watch;

#[test]
fn layers_that_are_not_named_keep_their_weights_to_the_bit() {
    let split = toy::split(&Toy::new(TRUTH));
    let first = [0.4, 0.1, -0.0];
    for keep in [Keep::Best, Keep::Last] {
        let folder = tempfile::tempdir().unwrap();
        let mut model = Toy::new(first);
        let spec = TrainSpec { layers: vec!["push".to_owned()], keep, ..spec() };
        run(&spec, &mut model, &split, folder.path(), &Watch::silent()).unwrap();
        let same = |i: usize| model.weights[i].to_bits() == f32::to_bits(first[i]);
        assert_eq!([0, 1, 2].map(same), [true, false, true], "{keep:?}: {:?}", model.weights);
        assert!(
            (model.weights[1] - TRUTH[1]).abs() < 0.5 * (first[1] - TRUTH[1]).abs(),
            "what learns goes to the truth"
        );
    }
}

#[test]
fn a_layer_that_the_model_has_not_is_refused_with_those_that_it_has() {
    let (split, folder) = (toy::split(&Toy::new(TRUTH)), tempfile::tempdir().unwrap());
    let spec = TrainSpec { layers: vec!["push".to_owned(), "encoder".to_owned()], ..spec() };
    let refused = run(&spec, &mut Toy::new(TRUTH), &split, folder.path(), &Watch::silent()).unwrap_err().to_string();
    assert!(refused.contains("`encoder`") && refused.ends_with("keep, push, lift"), "{refused}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing has begun");
}
