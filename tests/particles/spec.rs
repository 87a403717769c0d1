//! What a config may and may not say.
use super::*;

fn refused(text: &str) -> String {
    let built = toml_edit::de::from_str::<ModelSpec>(text).map_err(anyhow::Error::from).and_then(ModelSpec::build);
    format!("{:#}", built.err().expect("this config is impossible"))
}

#[test]
fn impossible_values_are_sentences_that_name_the_key() {
    let law = "[[laws]]\nkind = \"cohesion\"\nstrength = 1.0\ncontact = 0.008\nreach = ";
    let negative = refused(&format!("kind = \"particles\"\nsubsteps = 4\nkeep = 0.5\n{law}-1.0"));
    assert!(negative.contains("dynamics.laws[0]") && negative.contains("reach") && negative.contains("cohesion"));
    assert!(refused(&format!("kind = \"particles\"\nsubsteps = 4\nkeep = 0.5\n{law}0.004")).contains("exceed"));
    assert!(refused("kind = \"particles\"\nsubsteps = 0\nkeep = 0.5").contains("substeps"));
    assert!(refused("kind = \"particles\"\nsubsteps = 4\nkeep = 1.5").contains("keep"));
    assert!(refused("kind = \"particles\"\nsubsteps = 4\nkeep = 0.5\nsubstep = 3").contains("substep"));
    assert!(refused("kind = \"still\"\nspeed = 3").contains("speed"));
}

#[test]
fn every_config_reads_back_as_itself() {
    let spec = ModelSpec::Particles(analytic());
    let text = toml_edit::ser::to_string(&spec).unwrap();
    assert_eq!(toml_edit::de::from_str::<ModelSpec>(&text).unwrap(), spec);
}

#[test]
fn scenes_that_cannot_start_are_refused() {
    let model = analytic_model();
    let (start, _) = alone(Particles::at_rest(block()), 0);
    assert!(model.accepts(&start).is_ok());
    let no_pose = Scene { poses: Vec::new(), ..start.clone() };
    assert!(model.accepts(&no_pose).unwrap_err().to_string().contains("poses"));
    let mut hole = start;
    hole.particles.positions[3].x = f64::NAN;
    assert!(model.accepts(&hole).unwrap_err().to_string().contains("finite"));
}

#[test]
fn nothing_moves_in_the_still_model() {
    let model = toml_edit::de::from_str::<ModelSpec>("kind = \"still\"").unwrap().build().unwrap();
    let (start, controls) = alone(Particles::at_rest(block()), 3);
    assert!(model.rollout(&start, &controls).iter().all(|x| *x == start.particles));
}

#[test]
fn the_hybrid_is_the_analytical_model_and_a_learned_law() {
    let laws = |name: &str| -> Vec<String> {
        let path = format!("{}/configs/model/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let config: toml_edit::DocumentMut = std::fs::read_to_string(path).unwrap().parse().unwrap();
        config["dynamics"]["laws"].as_array_of_tables().unwrap().iter().map(|law| law.to_string()).collect()
    };
    let hybrid = laws("hybrid");
    let (learned, written) = hybrid.split_last().unwrap();
    assert_eq!(written, laws("analytic"));
    assert!(learned.contains("learned"));
}
