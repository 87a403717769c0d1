//! What is wrong with a config is shown where it is wrong.
#[path = "fixtures/house.rs"]
mod house;

use house::{CompareSpec, House};
use pliant::config::{ConfigError, load, write_whole};

/// The error of a config, drawn in plain text.
fn refusal(house: &House, stem: &str, overrides: &[&str]) -> String {
    let error = house.load(stem, overrides).expect_err("this config is wrong");
    assert!(!error.graphical().is_empty());
    error.plain()
}

/// The text under the caret of a plainly drawn error.
fn culprit(drawn: &str) -> String {
    let lines: Vec<&str> = drawn.lines().collect();
    let caret = lines.iter().position(|line| line.contains(" | ") && line.contains('^')).expect("a line of carets");
    let (start, end) = (lines[caret].find('^').unwrap(), lines[caret].rfind('^').unwrap());
    lines[caret - 1][start..=end].to_owned()
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
        let drawn = refusal(&house, "compare/default", &[]);
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
        let drawn = refusal(&house, "compare/default", &[text]);
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
    let drawn = refusal(&house, "compare/default", &["title=3"]);
    for said in ["unknown key `sampels`", "greater than 0", "missing key `samples`", "`title` must be a string"] {
        assert!(drawn.contains(said), "{drawn}");
    }
}

#[test]
fn circles_are_named() {
    let circle = [("compare/a", "extends = \"b\"\n"), ("compare/b", "extends = \"a\"\n")];
    let part = [("model/learned", "extends = \"learned\"\n")];
    let own = [("model/learned", "kind = \"learned\"\nmodel = \"learned\"\n")];
    let drawn = refusal(&House::new(&circle), "compare/a", &[]);
    assert!(drawn.contains("compare/a.toml → ") && drawn.contains("compare/b.toml → "), "{drawn}");
    assert!(refusal(&House::new(&part), "compare/default", &[]).contains("circle"));
    assert!(refusal(&House::new(&own), "compare/default", &[]).contains("circle"));
}

#[test]
fn hostile_files_are_refused() {
    let house = House::new(&[]);
    let (x, absent) = (house.path("x"), house.path("y"));
    let refuse = |bytes: &[u8], said: &str| {
        write_whole(&x, bytes).unwrap();
        let drawn = refusal(&house, "x", &[]);
        assert!(drawn.contains(said), "{said}: {drawn}");
    };
    refuse(b"title = \"\xff\"", "not UTF-8");
    refuse(&vec![b'#'; 5 << 20], "larger than 4 MiB");
    refuse(format!("x = {}1{}", "[".repeat(70), "]".repeat(70)).as_bytes(), "nested more than 64 deep");
    refuse(format!("x = {}1{}", "[".repeat(100_000), "]".repeat(100_000)).as_bytes(), "recurs");
    refuse(format!("{} = 1", vec!["a"; 100_000].join(".")).as_bytes(), "recurs");
    refuse(format!("[{}]", vec!["a"; 79].join(".")).as_bytes(), "nested more than 64 deep");
    refuse(format!("planner = 3{}", " ".repeat(1 << 20)).as_bytes(), "must be a table");
    assert!(refusal(&house, "y", &[]).contains(&absent.display().to_string()));
    assert!(load::<CompareSpec>(house.0.path(), &[]).unwrap_err().plain().contains("it is a folder"));
    assert!(refusal(&house, "compare/default", &[&format!("seeds={}", "[".repeat(100_000))]).contains("64 deep"));
    assert!(refusal(&house, "compare/default", &[&format!("{}=1", vec!["a"; 100_000].join("."))]).contains("64 deep"));
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
