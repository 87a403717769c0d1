//! Configs are composed as documented, and what is wrong with one is shown where it is wrong.
use indexmap::IndexMap;
use pliant::config::{ConfigError, Loaded, fingerprint, load, schema, write_whole};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CemSpec {
    /// Plans drawn a round [1].
    #[schemars(range(min = 2, max = 10000))]
    samples: usize,
    #[serde(default = "half")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    decay: f64,
    #[serde(default)]
    seed: Option<u64>,
}

fn half() -> f64 {
    0.5
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct DescentSpec {
    rate: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum PlannerSpec {
    Cem(CemSpec),
    Descent(DescentSpec),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TrainSpec {
    #[schemars(range(min = 1))]
    steps: usize,
    #[serde(default)]
    widths: Vec<usize>,
    /// A name kept as a name although `planner` is a folder.
    #[serde(default)]
    planner: String,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LearnedSpec {
    train: TrainSpec,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StillSpec {}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LawsSpec {
    laws: Vec<PlannerSpec>,
    origin: [f64; 3],
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum ModelSpec {
    Learned(LearnedSpec),
    Still(StillSpec),
    Laws(LawsSpec),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Loop {
    Open,
    Closed,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CompareSpec {
    planner: PlannerSpec,
    model: IndexMap<String, ModelSpec>,
    #[serde(default = "closed")]
    feedback: Loop,
    #[serde(default)]
    seeds: Vec<u64>,
    #[serde(default)]
    title: String,
    /// Names kept as names although `planner` is a folder.
    #[serde(default)]
    grid: IndexMap<String, Vec<serde_json::Value>>,
    #[serde(default)]
    fallback: Option<Box<PlannerSpec>>,
}

fn closed() -> Loop {
    Loop::Closed
}

const CEM: &str = "kind = \"cem\"\nsamples = 40\n";
const LEARNED: &str = "kind = \"learned\"\n\n[train]\nsteps = 1000\nwidths = [64, 64]\n";

struct House(TempDir);

impl House {
    fn new(files: &[(&str, &str)]) -> Self {
        let house = Self(TempDir::new().unwrap());
        let usual = [
            ("planner/cem", CEM),
            ("planner/careful", "extends = \"cem\"\nsamples = 400\n"),
            ("planner/descent", "kind = \"descent\"\nrate = 0.1\n"),
            ("model/learned", LEARNED),
            ("model/still", "kind = \"still\"\n"),
            ("compare/default", "planner = \"cem\"\nmodel = [\"learned\", \"still\"]\nseeds = [0, 1]\n"),
        ];
        for (stem, text) in usual.iter().chain(files) {
            write_whole(&house.path(stem), text.as_bytes()).unwrap();
        }
        house
    }

    fn path(&self, stem: &str) -> PathBuf {
        self.0.path().join("configs").join(format!("{stem}.toml"))
    }

    fn load(&self, stem: &str, overrides: &[&str]) -> Result<Loaded<CompareSpec>, ConfigError> {
        load(&self.path(stem), &overrides.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>())
    }

    fn spec(&self, overrides: &[&str]) -> CompareSpec {
        self.load("compare/default", overrides).unwrap_or_else(|error| panic!("{}", error.plain())).spec
    }

    /// The error of a config, drawn in plain text.
    fn refusal(&self, stem: &str, overrides: &[&str]) -> String {
        let error = self.load(stem, overrides).expect_err("this config is wrong");
        assert!(!error.graphical().is_empty());
        error.plain()
    }
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

/// The text under the caret of a plainly drawn error.
fn culprit(drawn: &str) -> String {
    let lines: Vec<&str> = drawn.lines().collect();
    let caret = lines.iter().position(|line| line.contains(" | ") && line.contains('^')).expect("a line of carets");
    let (start, end) = (lines[caret].find('^').unwrap(), lines[caret].rfind('^').unwrap());
    lines[caret - 1][start..=end].to_owned()
}

#[test]
fn names_become_parts_and_lists_become_tables_in_order() {
    let house = House::new(&[]);
    let spec = house.spec(&[]);
    assert_eq!(samples(&spec.planner), 40);
    assert_eq!(spec.model.keys().collect::<Vec<_>>(), ["learned", "still"]);
    assert_eq!(house.spec(&["model=[still,learned]"]).model.keys().collect::<Vec<_>>(), ["still", "learned"]);
    assert_eq!(house.spec(&["model=still"]).model.keys().collect::<Vec<_>>(), ["still"]);
    assert_eq!(samples(&house.spec(&["planner=careful"]).planner), 400);
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
        house.spec(&["planner.samples=256", "planner=careful", "model.learned.train.steps=7", "~model.still"]);
    assert_eq!((samples(&changed.planner), steps(&changed, "learned")), (256, 7));
    assert_eq!(changed.model.len(), 1);
    assert_eq!(house.spec(&["~model.still", "model=[learned,still]"]).model.len(), 1);
    let added = house.spec(&["+model.mine={extends=learned, train={steps: 2}}", "title=two words", "feedback=open"]);
    assert_eq!((steps(&added, "mine"), added.title.as_str(), added.feedback), (2, "two words", Loop::Open));
    assert_eq!(house.spec(&["title=\"a = \\\"b\\\"\"", "seeds=[]"]).title, "a = \"b\"");
    assert_eq!(house.spec(&["seeds.1=5"]).seeds, [0, 5]);
    let PlannerSpec::Cem(cem) = house.spec(&["planner.decay=1e-3", "+planner.seed=3"]).planner else { panic!() };
    assert_eq!((cem.decay, cem.seed), (1e-3, Some(3)));
    let PlannerSpec::Cem(cem) = house.spec(&["planner.decay=2"]).planner else { panic!() };
    assert_eq!(cem.decay, 2.0);
    assert_eq!(
        house.spec(&["fallback={kind=descent,rate=1}"]).fallback.map(|it| *it),
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
fn mistakes_in_files_are_shown_where_they_are() {
    let cases: &[(&str, &str, &str, &str)] = &[
        ("planner/cem", "kind = \"cem\"\nsampels = 40\n", "sampels", "did you mean `samples`?"),
        ("planner/cem", "kind = \"cem\"\nsamples = 1\n", "1", "at least 2"),
        ("planner/cem", "kind = \"cem\"\nsamples = 40\ndecay = 0\n", "0", "greater than 0"),
        ("planner/cem", "kind = \"cem\"\nsamples = 40.0\n", "40.0", "write 40"),
        ("planner/cem", "kind = \"cem\"\nsamples = \"many\"\n", "\"many\"", "must be an integer, not a string"),
        ("planner/cem", "kind = \"cem\"\nsamples = -3\n", "-3", "at least"),
        ("planner/cem", "kind = \"cme\"\nsamples = 40\n", "\"cme\"", "did you mean `cem`?"),
        ("planner/cem", "kind = \"cem\"\n", "k", "missing key `samples` in `planner`"),
        ("planner/cem", "samples = 40\n", "s", "missing key `kind` in `planner`"),
        ("planner/cem", "kind = \"cem\"\nsamples = = 40\n", "=", "not TOML"),
        ("planner/cem", "kind = \"cem\"\nsamples = 40\ndecay = nan\n", "nan", "finite"),
        (
            "model/learned",
            "kind = \"learned\"\n[train]\nsteps = 1\nwidths = [1, true]\n",
            "true",
            "model.learned.train.widths.1",
        ),
        ("model/learned", "kind = \"learned\"\n[train]\nwidths = [1]\n", "[train]", "missing key `steps`"),
        ("model/still", "kind = \"laws\"\norigin = [1, 2]\nlaws = []\n", "[1, 2]", "must have 3 elements, not 2"),
        (
            "model/still",
            "kind = \"laws\"\norigin = [1, 2, 3]\nlaws = [{ kind = \"descend\" }]\n",
            "\"descend\"",
            "`descent`",
        ),
        ("compare/default", "extends = \"defualt\"\n", "\"defualt\"", "did you mean `default`?"),
        ("compare/default", "planner = \"cmm\"\nmodel = []\n", "\"cmm\"", "did you mean `cem`?"),
        (
            "compare/default",
            "planner = \"cem\"\nmodel = [\"still\", \"lerned\"]\n",
            "\"lerned\"",
            "did you mean `learned`?",
        ),
        ("compare/default", "planner = \"cem\"\nmodel = 3\n", "3", "`model` must be a table, not an integer"),
        ("compare/default", "planner = \"cem\"\nmodel = []\nfeedback = \"opn\"\n", "\"opn\"", "did you mean `open`?"),
        ("compare/default", "planner = \"cem\"\nmodel = []\nplaner = 3\n", "planer", "did you mean `planner`?"),
        ("compare/default", "extends = 3\n", "3", "`extends` takes"),
    ];
    for (stem, text, under, said) in cases {
        let house = House::new(&[(stem, text)]);
        let drawn = house.refusal("compare/default", &[]);
        assert!(drawn.contains(said), "{text}\n{drawn}");
        assert!(drawn.contains(&format!("configs/{stem}.toml:")), "{text}\n{drawn}");
        assert_eq!(&culprit(&drawn), under, "{drawn}");
    }
}

#[test]
fn mistakes_in_overrides_are_shown_in_the_override() {
    let house = House::new(&[]);
    let cases: &[(&str, &str, &str)] = &[
        ("planner.sampels=3", "sampels", "did you mean `samples`?"),
        ("planner.samples=1", "1", "at least 2"),
        ("planner.samples=1e3", "1e3", "write 1000"),
        ("planner=cmm", "cmm", "did you mean `cem`?"),
        ("model=[learned, stil]", "stil", "did you mean `still`?"),
        ("model.lerned.train.steps=3", "lerned", "did you mean `learned`?"),
        ("model.learned.train.steps.x=3", "x", "`model.learned.train.steps` is an integer, so it has no key `x`"),
        ("~model.stil", "stil", "did you mean `still`?"),
        ("~planner=cem", "=", "without a value"),
        ("+planner.samples=3", "samples", "there already"),
        ("planner.samples", "planner.samples", "an override is"),
        ("=3", "=", "a key is missing"),
        ("planner..samples=3", ".", "a key is missing"),
        ("seeds=[1,2", "[1,2", "closing `]`"),
        ("seeds.9=1", "9", "a list of 2"),
        ("title=\"a", "\"a", "closing quote"),
        ("planner.decay=inf", "inf", "finite"),
        ("~planner.samples", "k", "missing key `samples`"),
        ("fallback.rate=3", "fallback", "missing key `kind`"),
    ];
    for (text, under, said) in cases {
        let drawn = house.refusal("compare/default", &[text]);
        assert!(drawn.contains(said), "{text}\n{drawn}");
        let from_file = *under == "k";
        assert_eq!(drawn.contains(&format!("command line `{text}`")), !from_file, "{drawn}");
        if *text != "planner.samples" && *text != "=3" {
            assert!(culprit(&drawn).starts_with(under), "{drawn}");
        }
    }
}

#[test]
fn every_mistake_is_told_at_once() {
    let house = House::new(&[("planner/cem", "kind = \"cem\"\nsampels = 40\ndecay = -1\n")]);
    let drawn = house.refusal("compare/default", &["title=3"]);
    for said in ["unknown key `sampels`", "greater than 0", "missing key `samples`", "`title` must be a string"] {
        assert!(drawn.contains(said), "{drawn}");
    }
}

#[test]
fn circles_are_named() {
    let circle = [("compare/a", "extends = \"b\"\n"), ("compare/b", "extends = \"a\"\n")];
    let part = [("model/learned", "extends = \"learned\"\n")];
    let own = [("model/learned", "kind = \"learned\"\nmodel = \"learned\"\n")];
    let drawn = House::new(&circle).refusal("compare/a", &[]);
    assert!(drawn.contains("compare/a.toml → ") && drawn.contains("compare/b.toml → "), "{drawn}");
    assert!(House::new(&part).refusal("compare/default", &[]).contains("circle"));
    assert!(House::new(&own).refusal("compare/default", &[]).contains("circle"));
}

#[test]
fn hostile_files_are_refused() {
    let house = House::new(&[]);
    let (x, absent) = (house.path("x"), house.path("y"));
    let refuse = |bytes: &[u8], said: &str| {
        write_whole(&x, bytes).unwrap();
        let drawn = house.refusal("x", &[]);
        assert!(drawn.contains(said), "{said}: {drawn}");
    };
    refuse(b"title = \"\xff\"", "not UTF-8");
    refuse(&vec![b'#'; 5 << 20], "larger than 4 MiB");
    refuse(format!("x = {}1{}", "[".repeat(70), "]".repeat(70)).as_bytes(), "nested more than 64 deep");
    refuse(format!("x = {}1{}", "[".repeat(100_000), "]".repeat(100_000)).as_bytes(), "recurs");
    refuse(format!("{} = 1", vec!["a"; 100_000].join(".")).as_bytes(), "recurs");
    refuse(format!("[{}]", vec!["a"; 79].join(".")).as_bytes(), "nested more than 64 deep");
    refuse(format!("planner = 3{}", " ".repeat(1 << 20)).as_bytes(), "must be a table");
    assert!(house.refusal("y", &[]).contains(&absent.display().to_string()));
    assert!(load::<CompareSpec>(house.0.path(), &[]).unwrap_err().plain().contains("it is a folder"));
    assert!(house.refusal("compare/default", &[&format!("seeds={}", "[".repeat(100_000))]).contains("64 deep"));
    assert!(house.refusal("compare/default", &[&format!("{}=1", vec!["a"; 100_000].join("."))]).contains("64 deep"));
}

#[test]
fn an_error_found_later_points_at_its_line() {
    let house = House::new(&[]);
    let loaded = house.load("compare/default", &[]).unwrap();
    let error = ConfigError::at(&loaded.resolved, "model.learned.train.steps", "train.steps must be even");
    assert!(error.to_string().ends_with("configs/model/learned.toml:4:9: train.steps must be even"), "{error}");
    assert_eq!(culprit(&error.plain()), "1000");
    let default = ConfigError::at(&loaded.resolved, "planner.decay", "decay must be an integer").plain();
    assert!(default.contains("configs/planner/cem.toml:1") && default.contains("default"), "{default}");
}

#[test]
fn the_graphical_error_shows_the_line() {
    let house = House::new(&[("planner/cem", "kind = \"cem\"\nsampels = 40\n")]);
    let error = house.load("compare/default", &[]).unwrap_err();
    let drawn = error.graphical();
    assert!(drawn.contains("sampels = 40") && drawn.contains("did you mean"), "{drawn}");
    let report = format!("{:?}", miette::Report::new(error));
    assert!(report.contains("sampels"), "{report}");
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
