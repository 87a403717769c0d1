//! What a config may say, and the substeps that follow from it.
use super::*;

#[test]
fn impossible_values_are_sentences_that_name_the_key() {
    let refused = |spec: MpmSpec| format!("{:#}", MpmModel::new(spec).err().expect("this config is impossible"));
    assert!(refused(MpmSpec { cell: 0.0, ..elastic() }).contains("dynamics.cell"));
    assert!(refused(MpmSpec { poisson_ratio: 0.5, ..elastic() }).contains("poisson_ratio"));
    assert!(refused(MpmSpec { yield_stress: -1.0, ..elastic() }).contains("yield_stress"));
    assert!(refused(MpmSpec { courant: 2.0, ..elastic() }).contains("courant"));
    assert!(
        refused(MpmSpec { table: SurfaceSpec::Coulomb { friction: f64::NAN }, ..elastic() }).contains("table.friction")
    );
    let text = toml_edit::ser::to_string(&ModelSpec::Mpm(shipped())).unwrap();
    assert_eq!(toml_edit::de::from_str::<ModelSpec>(&text).unwrap(), ModelSpec::Mpm(shipped()));
    assert!(toml_edit::de::from_str::<ModelSpec>(&text.replace("courant", "courante")).is_err());
    assert!(!text.contains("precision"), "what is double may say so, and is the same config when it does not");
    let single = ModelSpec::Mpm(MpmSpec { precision: Precision::Single, ..shipped() });
    let text = toml_edit::ser::to_string(&single).unwrap();
    assert_eq!(toml_edit::de::from_str::<ModelSpec>(&text).unwrap(), single);
    assert!(toml_edit::de::from_str::<ModelSpec>(&text.replace("single", "half")).is_err());
}

#[test]
fn substeps_follow_the_speed_of_sound() {
    // c = √((1 − ν)/((1 + ν)(1 − 2ν)) E/ρ).
    let sound = (0.7 / (1.3 * 0.4) * 5e3 / 1200.0_f64).sqrt();
    assert_eq!(model(elastic()).substeps(0.1), (0.1 * sound / (0.3 * 0.01)).ceil() as usize);
    let hard = model(MpmSpec { young_modulus: 5e11, ..elastic() });
    let (scene, _) = alone(Particles::at_rest(block(0.0)), 0);
    let sentence = Dynamics::accepts(&hard, &scene).unwrap_err().to_string();
    assert!(sentence.contains("substeps") && sentence.contains("dynamics.young_modulus"), "{sentence}");
    assert!(Dynamics::accepts(&model(elastic()), &scene).is_ok());
    assert!(Dynamics::accepts(&model(elastic()), &Scene { poses: Vec::new(), ..scene }).is_err());
}
