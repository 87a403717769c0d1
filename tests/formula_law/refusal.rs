//! What a law in formulas may not say, and where its constants are found.
use super::*;

fn refused(text: &str) -> String {
    let text = format!("kind = \"formula\"\n{text}");
    let built = toml_edit::de::from_str::<LawSpec>(&text).map_err(anyhow::Error::from).and_then(LawSpec::build);
    format!("{:#}", built.err().expect("this law is impossible"))
}

#[test]
fn impossible_formulas_are_sentences_that_name_the_key() {
    let pairs = "between = \"particles\"\nreach = 0.01\n";
    let typo = refused(&format!("name = \"glue\"\n{pairs}energy = \"k * rr\"\nconstants = {{ k = 1.0 }}"));
    assert!(typo.contains("glue") && typo.contains("energy") && typo.contains("did you mean"), "{typo}");
    assert!(typo.contains("  k * rr\n      ^^"), "{typo}");
    let cases = [
        ("", "give it an energy"),
        ("energy = \"r * vn\"", "unknown name `vn`"),
        ("normal_force = \"normal\"", "unknown name `normal`"),
        ("normal_force = \"r\"\nconstants = { vn = 1.0 }", "hides what `vn` means"),
        ("normal_force = \"r\"\nconstants = { k = 1.0 }", "is in no formula"),
        ("normal_force = \"r\"\nconstants = { \"2k\" = 1.0 }", "is no name"),
        ("normal_force = \"k\"\nconstants = { k = inf }", "must be finite"),
        ("normal_force = \"r\"\nwall = { normal = [1.0, 0.0, 0.0], offset = 0.0 }", "`wall` is given exactly where"),
    ];
    for (rest, said) in cases {
        let error = refused(&format!("{pairs}{rest}"));
        assert!(error.contains(said), "{rest}: {error}");
    }
    assert!(refused("between = \"floor\"\nreach = \"r\"\nenergy = \"r\"").contains("reach"));
    assert!(refused("between = \"floor\"\nreach = \"0 - 1\"\nenergy = \"r\"").contains("positive length"));
    assert!(refused("between = \"wall\"\nreach = 1.0\nenergy = \"r\"").contains("wall = {"));
    let flat = "between = \"wall\"\nwall = { normal = [0.0, 0.0, 0.0], offset = 0.0 }\nreach = 1.0\nenergy = \"r\"";
    assert!(refused(flat).contains("wall.normal"));
}

#[test]
fn identification_finds_the_constants_of_formulas_where_those_of_laws_in_rust_are() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/train/identify.toml")).unwrap();
    let train: toml_edit::DocumentMut = text.parse().unwrap();
    let [written, formulas] = ["analytic", "formula"].map(|name| serde_json::to_value(spec(name)).unwrap());
    let paths: Vec<&str> = train["constants"].as_table().unwrap().iter().map(|(path, _)| path).collect();
    assert!(paths.len() > 8);
    for path in paths {
        let [a, b] = [&written, &formulas].map(|spec| pliant::train::value(spec, path).unwrap());
        assert_eq!(a, b, "{path}");
    }
}

#[test]
fn a_model_of_formulas_says_where_a_law_is_wrong() {
    let mut laws = spec("formula").laws;
    let LawSpec::Formula(broken) = &mut laws[1] else { panic!("cohesion is a formula") };
    broken.normal_force = Some("-strenght * r".into());
    let built = ModelSpec::Particles(ParticlesSpec { laws, ..spec("formula") }).build();
    let error = format!("{:#}", built.err().unwrap());
    assert!(
        error.contains("dynamics.laws[1]") && error.contains("cohesion") && error.contains("`strength`"),
        "{error}"
    );
}
