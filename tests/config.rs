//! Configs are composed as documented.
#[path = "fixtures/house.rs"]
mod house;

use house::{CompareSpec, DescentSpec, House, Loop, ModelSpec, PlannerSpec};
use pliant::config::{fingerprint, load, schema, write_whole};
use std::path::Path;
use tempfile::TempDir;

fn spec_of(house: &House, overrides: &[&str]) -> CompareSpec {
    house.load("compare/default", overrides).unwrap_or_else(|error| panic!("{}", error.plain())).spec
}

fn samples(planner: &PlannerSpec) -> usize {
    match planner {
        PlannerSpec::Cem(spec) => spec.samples,
        PlannerSpec::Descent(_) => panic!("not a CEM"),
    }
}

fn steps(spec: &CompareSpec, model: &str) -> usize {
    match &spec.model[model] {
        ModelSpec::Learned(spec) => spec.train.steps,
        _ => panic!("not learned"),
    }
}

#[test]
fn names_become_parts_and_lists_become_tables_in_order() {
    let house = House::new(&[]);
    let spec = spec_of(&house, &[]);
    assert_eq!(samples(&spec.planner), 40);
    assert_eq!(spec.model.keys().collect::<Vec<_>>(), ["learned", "still"]);
    assert_eq!(spec_of(&house, &["model=[still,learned]"]).model.keys().collect::<Vec<_>>(), ["still", "learned"]);
    assert_eq!(spec_of(&house, &["model=still"]).model.keys().collect::<Vec<_>>(), ["still"]);
    assert_eq!(samples(&spec_of(&house, &["planner=careful"]).planner), 400);
}

#[test]
fn a_file_is_laid_over_what_it_extends() {
    let quick = "extends = \"default\"\nseeds = [7]\n[model.learned.train]\nsteps = 5\n[planner]\nsamples = 9\n";
    let own =
        "extends = \"quick\"\n[model.mine]\nextends = \"learned\"\ntrain.steps = 3\n[planner]\nextends = \"careful\"\n";
    let both = "extends = [\"quick\", \"../planner_of/one\"]\n";
    let one = "[planner]\ndecay = 0.25\n";
    let house =
        House::new(&[("compare/quick", quick), ("compare/own", own), ("compare/both", both), ("planner_of/one", one)]);
    let spec = house.load("compare/quick", &[]).unwrap().spec;
    assert_eq!((samples(&spec.planner), steps(&spec, "learned"), &spec.seeds[..]), (9, 5, &[7][..]));
    let spec = house.load("compare/own", &[]).unwrap().spec;
    assert_eq!(spec.model.keys().collect::<Vec<_>>(), ["learned", "still", "mine"]);
    assert_eq!((samples(&spec.planner), steps(&spec, "learned"), steps(&spec, "mine")), (400, 5, 3));
    let PlannerSpec::Cem(cem) = house.load("compare/both", &[]).unwrap().spec.planner else { panic!() };
    assert_eq!((cem.samples, cem.decay), (9, 0.25));
}

#[test]
fn overrides_change_add_and_delete_whatever_their_order() {
    let house = House::new(&[]);
    let changed =
        spec_of(&house, &["planner.samples=256", "planner=careful", "model.learned.train.steps=7", "~model.still"]);
    assert_eq!((samples(&changed.planner), steps(&changed, "learned")), (256, 7));
    assert_eq!(changed.model.len(), 1);
    assert_eq!(spec_of(&house, &["~model.still", "model=[learned,still]"]).model.len(), 1);
    let added =
        spec_of(&house, &["+model.mine={extends=learned, train={steps: 2}}", "title=two words", "feedback=open"]);
    assert_eq!((steps(&added, "mine"), added.title.as_str(), added.feedback), (2, "two words", Loop::Open));
    assert_eq!(spec_of(&house, &["title=\"a = \\\"b\\\"\"", "seeds=[]"]).title, "a = \"b\"");
    assert_eq!(spec_of(&house, &["seeds.1=5"]).seeds, [0, 5]);
    let PlannerSpec::Cem(cem) = spec_of(&house, &["planner.decay=1e-3", "+planner.seed=3"]).planner else { panic!() };
    assert_eq!((cem.decay, cem.seed), (1e-3, Some(3)));
    let PlannerSpec::Cem(cem) = spec_of(&house, &["planner.decay=2"]).planner else { panic!() };
    assert_eq!(cem.decay, 2.0);
    assert_eq!(
        spec_of(&house, &["fallback={kind=descent,rate=1}"]).fallback.map(|it| *it),
        Some(PlannerSpec::Descent(DescentSpec { rate: 1.0 }))
    );
}

#[test]
fn a_key_named_like_a_folder_keeps_strings_where_strings_are_wanted() {
    let grid = "extends = \"default\"\n[grid]\nplanner = [\"cem\", \"descent\"]\n\"planner.samples\" = [1, 2]\n";
    let house = House::new(&[("compare/grid", grid)]);
    let loaded =
        house.load("compare/grid", &["grid.\"planner.samples\"=[8]", "model.learned.train.planner=descent"]).unwrap();
    let ModelSpec::Learned(learned) = &loaded.spec.model["learned"] else { panic!() };
    assert_eq!(learned.train.planner, "descent");
    assert_eq!(loaded.spec.grid["planner"], ["cem", "descent"]);
    assert_eq!(loaded.spec.grid["planner.samples"], [8]);
    assert!(loaded.resolved.to_toml().contains("\"planner.samples\" = [8]"), "{}", loaded.resolved.to_toml());
}

#[test]
fn the_resolved_config_loads_to_the_same_config_and_tells_where_values_are_from() {
    let laws = "kind = \"laws\"\norigin = [0, 1e-9, 3.5]\n[[laws]]\nkind = \"descent\"\nrate = 1e300\n[[laws]]\nkind = \"cem\"\nsamples = 3\n";
    let house = House::new(&[("model/laws", laws)]);
    let loaded = house
        .load(
            "compare/default",
            &["planner.samples=256", "model=[laws,learned,still]", "title=\"a\\n\\\"b\\\"\\t\\u0001'\""],
        )
        .unwrap();
    let saved = house.0.path().join("run/config.toml");
    write_whole(&saved, loaded.resolved.to_toml().as_bytes()).unwrap();
    let again = load::<CompareSpec>(&saved, &[]).unwrap_or_else(|error| panic!("{}", error.plain()));
    assert_eq!(again.spec, loaded.spec);
    assert_eq!(again.spec.model.keys().collect::<Vec<_>>(), ["laws", "learned", "still"]);
    assert_eq!(fingerprint(&again.spec), fingerprint(&loaded.spec));
    let shown = loaded.resolved.annotated();
    let line = |start: &str| shown.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{shown}"));
    assert_eq!(line("samples = 256"), "samples = 256  # from command line");
    assert!(line("steps").ends_with("configs/model/learned.toml:4"), "{shown}");
    assert!(line("seeds").ends_with("configs/compare/default.toml:3"), "{shown}");
    assert_eq!(line("decay"), "decay = 0.5  # default");
    write_whole(&saved, shown.as_bytes()).unwrap();
    assert_eq!(load::<CompareSpec>(&saved, &[]).unwrap().spec, loaded.spec);
}

#[test]
fn the_schema_names_every_kind() {
    let schema = schema::<CompareSpec>();
    assert!(["\"cem\"", "\"descent\"", "\"learned\"", "samples"].iter().all(|word| schema.contains(word)));
}

#[test]
fn whole_files_replace_and_leave_nothing_beside_them() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a/b/c.json");
    write_whole(&path, b"one").unwrap();
    write_whole(&path, b"two").unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"two");
    assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    let in_file = write_whole(&path.join("d"), b"x").unwrap_err().to_string();
    assert!(in_file.contains("c.json") && in_file.contains("a file is where a folder should be"), "{in_file}");
    let on_folder = write_whole(&folder.path().join("a"), b"x").unwrap_err().to_string();
    assert!(on_folder.contains("a folder of that name"), "{on_folder}");
    assert!(write_whole(Path::new("/"), b"x").is_err());
    #[cfg(unix)]
    assert_eq!(std::os::unix::fs::PermissionsExt::mode(&path.metadata().unwrap().permissions()) & 0o777, 0o644);
}
