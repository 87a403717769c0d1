//! The house: which module may import which, where each external crate may appear, and how long a file may grow.
use std::path::{Path, PathBuf};

/// Modules may import only from modules before them.
const ORDER: &[&str] = &[
    "family",
    "watch",
    "config",
    "state",
    "shape",
    "tool",
    "world",
    "perception",
    "graph",
    "model",
    "data",
    "metric",
    "train",
    "planner",
    "problem",
    "chooser",
    "compare",
    "table",
    "view",
    "sweep",
];

/// Modules that must not know of each other although the order would allow it.
const FORBIDDEN: &[(&str, &[&str])] =
    &[("planner", &["model", "world", "tool", "graph", "data", "train"]), ("model", &["world"])];

/// Files that may do what [`FORBIDDEN`] forbids their module.
const LICENSED: &[(&str, &str)] = &[("src/model/oracle.rs", "world")];

/// Where an external crate may be named.
const CRATES: &[(&str, &[&str])] = &[
    ("rapier3d", &["src/world/"]),
    ("dfdx", &["src/model/net/", "src/train/"]),
    ("parry3d", &["src/state/", "src/shape/", "src/world/"]),
    ("gemm", &["src/model/net/"]),
    ("numkong", &["src/model/net/"]),
    ("wide", &["src/model/mpm/"]),
    ("egg", &["src/model/formula/"]),
    ("nalgebra", &["src/state/", "src/planner/"]),
    ("cmaes", &["src/train/"]),
    ("clarabel", &["src/model/correction/projection/", "src/train/search/"]),
    ("lsap", &["src/metric/"]),
    ("hdf5_pure", &["src/data/export/"]),
    ("kuva", &["src/table/"]),
    ("base64", &["src/view/"]),
    ("rerun", &["src/view/"]),
    ("clap", &["src/main", "experiments/"]),
    ("mimalloc", &["src/main.rs", "experiments/main.rs"]),
];

/// Longest file, in lines.
const LIMIT: usize = 300;

fn sources(root: &str) -> Vec<PathBuf> {
    let (mut folders, mut files) = (vec![PathBuf::from(root)], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a source folder") {
            let path = entry.expect("a folder entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).expect("a source file")
}

fn module_of(path: &Path) -> String {
    let inside = path.strip_prefix("src").expect("a file of src");
    let first = inside.iter().next().expect("a file name").to_string_lossy();
    first.trim_end_matches(".rs").to_owned()
}

/// Modules named after `crate::` anywhere in the file, comments aside: (line, module).
fn imports(text: &str) -> Vec<(usize, String)> {
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n");
    let name = |s: &str| s.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for (at, path) in code.match_indices("crate::") {
        let (line, rest) = (code[..at].matches('\n').count() + 1, &code[at + path.len()..]);
        match rest.strip_prefix('{') {
            Some(list) => found.extend(branches(list).into_iter().map(|branch| (line, name(branch)))),
            None => found.push((line, name(rest))),
        }
    }
    found.retain(|(_, module)| !module.is_empty());
    found
}

/// What commas separate in `list` up to its closing brace, whatever stands in braces inside.
fn branches(list: &str) -> Vec<&str> {
    let (mut depth, mut start, mut found) = (0, 0, Vec::new());
    for (at, c) in list.char_indices() {
        if depth == 0 && (c == ',' || c == '}') {
            found.push(&list[start..at]);
            start = at + 1;
        }
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            _ => {}
        }
    }
    found
}

#[test]
fn imports_are_seen_however_they_are_written() {
    let text = "use crate::{\n    a::{B, c},\n    d,\n}; // crate::e\nfn f() -> crate::g::H { crate::i() }";
    let expected = [(1, "a"), (1, "d"), (5, "g"), (5, "i")].map(|(line, name)| (line, name.to_owned()));
    assert_eq!(imports(text), expected);
}

#[test]
fn the_map_on_the_front_page_lists_the_modules_in_their_order() {
    let front = read(Path::new("src/lib.rs"));
    let listed: Vec<&str> = front.lines().filter_map(|line| line.strip_prefix("//! | [`")?.split('`').next()).collect();
    assert_eq!(listed, ORDER.iter().copied().filter(|module| *module != "family").collect::<Vec<_>>());
}

#[test]
fn imports_point_upward() {
    let rank = |name: &str| ORDER.iter().position(|m| *m == name);
    let mut seen = 0;
    for path in sources("src") {
        let own = module_of(&path);
        if ["lib", "main"].contains(&own.as_str()) {
            continue;
        }
        let mine = rank(&own).unwrap_or_else(|| panic!("{}: module `{own}` has no place in the order", path.display()));
        for (line, target) in imports(&read(&path)) {
            let place = format!("{}:{line}: `{own}` imports `{target}`", path.display());
            let theirs = rank(&target).unwrap_or_else(|| panic!("{place}, which has no place in the order"));
            assert!(theirs <= mine, "{place}, which stands below it");
            let forbidden = FORBIDDEN.iter().any(|(m, list)| *m == own && list.contains(&target.as_str()));
            let licensed = LICENSED.contains(&(path.to_str().expect("UTF-8 path"), target.as_str()));
            assert!(!forbidden || licensed, "{place}, which it must not know");
            seen += 1;
        }
    }
    assert!(seen > 50, "only {seen} imports were seen: the test reads the wrong folder");
}

#[test]
fn external_crates_stay_in_their_rooms() {
    for path in sources("src").into_iter().chain(sources("experiments")) {
        let (text, place) = (read(&path), path.to_string_lossy().into_owned());
        for (name, rooms) in CRATES {
            let used = text
                .lines()
                .map(|l| l.split("//").next().unwrap_or_default())
                .any(|l| l.contains(&format!("{name}::")) || l.trim_start().starts_with(&format!("use {name}")));
            assert!(!used || rooms.iter().any(|room| place.starts_with(room)), "{place} may not use `{name}`");
        }
    }
}

#[test]
fn files_hold_one_concept() {
    for path in sources("src").into_iter().chain(sources("experiments")).chain(sources("tests")) {
        let lines = read(&path).lines().count();
        assert!(
            lines <= LIMIT,
            "{} has {lines} lines, more than {LIMIT}: which concept should move out?",
            path.display()
        );
        let stem = path.file_stem().expect("a file name").to_string_lossy();
        assert!(
            !["utils", "common", "helpers", "manager", "base", "misc"].contains(&&*stem),
            "{}: name the concept",
            path.display()
        );
    }
}
