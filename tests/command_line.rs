//! The programs as a newcomer meets them: good input gives files and tables, bad input a sentence and exit code 2.
use std::path::Path;
use std::process::{Command, Output};
use std::time::Instant;

fn run(program: &str, folder: &Path, words: &[&str]) -> Output {
    Command::new(program).current_dir(folder).args(words).output().expect("the program starts")
}

fn pliant(folder: &Path, words: &[&str]) -> Output {
    run(env!("CARGO_BIN_EXE_pliant"), folder, words)
}

fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn complaint(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(!text.contains("panicked"), "{text}");
    text
}

/// An empty folder that sees the project's configs.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::os::unix::fs::symlink(concat!(env!("CARGO_MANIFEST_DIR"), "/configs"), folder.path().join("configs")).unwrap();
    folder
}

const QUICKSTART: &str = "configs/compare/quickstart.toml";

#[test]
fn a_tiny_comparison_leaves_everything_and_its_repetition_is_quick_and_equal() {
    let folder = folder();
    let words = [
        "compare",
        QUICKSTART,
        "dataset=smoke",
        "goal=[disc]",
        "seeds=[7]",
        "budget.rollouts=6",
        "model.analytic.train.identify.evaluations=12",
        "model.learned.train.network.steps=3",
        "model.hybrid.train.identify.evaluations=12",
        "model.hybrid.train.residual.steps=3",
        "out=results",
    ];
    let began = Instant::now();
    let first = pliant(folder.path(), &words);
    let first_took = began.elapsed();
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    for name in ["oracle", "still", "analytic", "learned", "hybrid", "sampling floor"] {
        assert!(out(&first).contains(name), "{}", out(&first));
    }
    for file in ["rows.jsonl", "predictions.jsonl", "table.md", "table.tex", "report.html", "config.toml"] {
        assert!(folder.path().join("results").join(file).exists(), "{file}");
    }
    let began = Instant::now();
    let again = pliant(folder.path(), &[&words[..], &["--json"]].concat());
    assert!(began.elapsed() < first_took / 2, "nothing was reused");
    let rows: Vec<serde_json::Value> = out(&again).lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(rows.len(), 10);
    let written = std::fs::read_to_string(folder.path().join("results/rows.jsonl")).unwrap();
    assert_eq!(out(&again), written);
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64();
    for row in rows.iter().filter(|r| r["model"] == "oracle" && r["planner"] == "cem") {
        let (promised, achieved) = (number(row, "predicted").unwrap(), number(row, "achieved").unwrap());
        assert!((promised - achieved).abs() < 1e-6, "the simulator promised {promised} and achieved {achieved}");
    }
    let descending = rows.iter().find(|r| r["model"] == "oracle" && r["planner"] == "descent").unwrap();
    assert!(descending["predicted"].is_null(), "the simulator has no gradient to descend");

    // Seconds tell an attempt that was made again from one that was kept.
    std::fs::remove_file(folder.path().join("results/attempts/disc/7/cem/still.json")).unwrap();
    let mended = out(&pliant(folder.path(), &[&words[..], &["--json"]].concat()));
    let others = |text: &str| -> Vec<String> {
        let lost = |line: &&str| line.contains("\"model\":\"still\",\"planner\":\"cem\"");
        text.lines().filter(|line| !lost(line)).map(str::to_owned).collect()
    };
    assert_eq!((mended.lines().count(), others(&mended).len()), (10, 9));
    assert_eq!(others(&mended), others(&written), "attempts that were there were made again");
}

#[test]
fn an_open_loop_is_planned_from_what_models_imagine() {
    let folder = folder();
    let words = ["compare", QUICKSTART, "dataset=smoke", "model=[oracle, still]", "planner=[cem]", "goal=[pressed]"];
    let open = ["seeds=[7]", "budget.rollouts=2", "actions=2", "+control=open", "--json"];
    let output = pliant(folder.path(), &[&words[..], &open].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows: Vec<serde_json::Value> = out(&output).lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let (oracle, still) = (&rows[0], &rows[1]);
    assert!(oracle["achieved"].is_number(), "the simulator goes on from where it has arrived: {oracle}");
    assert!(still["achieved"].is_number() && still["tools"].as_array().unwrap().len() == 2, "{still}");
}

#[test]
fn a_share_is_planned_by_and_metrics_that_a_config_adds_have_columns_of_their_own() {
    let folder = folder();
    let words = ["compare", QUICKSTART, "dataset=smoke", "model=[oracle, still]", "goal=[disc]", "seeds=[7]"];
    let share = ["budget.rollouts=3", "cost={kind=missed, of={kind=iou}}", "+metric=[aligned, iou_coarse]"];
    let refused = complaint(&pliant(folder.path(), &[&words[..], &share].concat()));
    assert!(refused.contains("planner.descent") && refused.contains("`cost`"), "{refused}");
    let output = pliant(folder.path(), &[&words[..], &share, &["planner=[cem]", "--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for line in out(&output).lines() {
        let row: serde_json::Value = serde_json::from_str(line).unwrap();
        let number = |key: &str, name: &str| row[key][name].as_f64().unwrap_or_else(|| panic!("{key}.{name}: {row}"));
        let achieved = row["achieved"].as_f64().unwrap();
        assert!((achieved - 0.1 * (1.0 - number("metrics", "iou"))).abs() < 1e-12, "{row}");
        assert!(number("metrics", "aligned") <= number("metrics", "chamfer"), "{row}");
        assert!((number("metrics", "iou_coarse") - number("metrics", "iou")).abs() < 0.2, "{row}");
        assert!(number("floors", "aligned") > 0.0 && number("floors", "iou_coarse") < 1.0, "{row}");
    }
    let table = out(&pliant(folder.path(), &[&words[..], &share, &["planner=[cem]"]].concat()));
    assert!(table.contains("aligned [mm]") && table.contains("iou_coarse"), "{table}");
    let taken = [&words[..], &["planner=[cem]", "+metric={emd: {kind: coverage}}"]].concat();
    assert!(complaint(&pliant(folder.path(), &taken)).contains("metric.emd"));
}

#[test]
fn a_model_that_teaches_no_policy_leaves_no_folder_of_one_and_a_policy_that_is_there_is_not_written_again() {
    let folder = folder();
    let words = ["compare", QUICKSTART, "dataset=smoke", "planner=[policy]", "goal=[disc]", "seeds=[7]"];
    let small = ["budget.rollouts=2", "+policy={samples: 6, network: {steps: 2, width: 4}}"];
    let run = |more: &[&str]| {
        let output = pliant(folder.path(), &[&words[..], &small, more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run(&["model=[oracle, still]"]);
    let policies = folder.path().join("runs/policy");
    assert!(!policies.exists() || std::fs::read_dir(&policies).unwrap().next().is_none(), "a folder of nothing");
    let fit = "model.analytic.train.identify.evaluations=12";
    run(&["model=[analytic]", fit]);
    let recipe = std::fs::read_dir(&policies).unwrap().next().unwrap().unwrap().path().join("recipe.json");
    let written = || std::fs::metadata(&recipe).unwrap().modified().unwrap();
    let before = written();
    run(&["model=[analytic]", fit, "seeds=[8]"]);
    assert_eq!(written(), before);
}

#[test]
fn one_goal_is_worked_at_action_by_action() {
    let folder = folder();
    let words = ["plan", QUICKSTART, "dataset=smoke", "model=[still]", "planner=[cem]", "goal=[disc]"];
    let output = pliant(folder.path(), &[&words[..], &["budget.rollouts=2", "actions=2", "+out=plan"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines: Vec<String> = out(&output).lines().map(str::to_owned).collect();
    assert!(lines[0].starts_with("1  gripper_rod  r ") && lines[1].starts_with("2  "), "{lines:?}");
    assert!(lines[..2].iter().all(|line| line.contains("achieved") && line.contains(" mm, ") && line.contains('°')));
    for file in ["plan.jsonl", "report.html", "config.toml", "episodes/episode_00001.npz"] {
        assert!(folder.path().join("plan").join(file).exists(), "{file}");
    }
    let view = pliant(folder.path(), &["view", "plan/episodes/episode_00001.npz"]);
    assert!(view.status.success(), "{}", String::from_utf8_lossy(&view.stderr));
}

#[test]
fn a_model_is_trained_on_any_folder_of_episodes_and_drawn_over_one_of_them() {
    let folder = folder();
    let here = folder.path();
    assert!(pliant(here, &["simulate", "configs/dataset/smoke.toml", "--to", "mine"]).status.success());
    let words = ["configs/model/learned.toml", "mine", "train.network.steps=3"];
    let trained = pliant(here, &[&["train"], &words[..]].concat());
    assert!(trained.status.success(), "{}", String::from_utf8_lossy(&trained.stderr));
    assert!(out(&trained).contains("learned") && out(&trained).contains("network: runs/fit/"), "{}", out(&trained));
    let view = ["view", "mine/episode_00001.npz", "--model", words[0], words[2]];
    let view = pliant(here, &view);
    assert!(view.status.success(), "{}", String::from_utf8_lossy(&view.stderr));
    let page = std::fs::read_to_string(here.join("mine/episode_00001.html")).unwrap();
    assert!(page.contains("\"model\":\"learned\""), "the prediction is not on the page");
    let none = complaint(&pliant(here, &["train", words[0], "nowhere"]));
    assert!(none.contains("nowhere holds no dataset"), "{none}");
}

#[test]
fn a_network_is_read_as_formulas_and_the_file_that_holds_them_is_a_model() {
    let folder = folder();
    let here = folder.path();
    assert!(pliant(here, &["simulate", "configs/dataset/smoke.toml", "--to", "mine"]).status.success());
    let small = ["train.pair.steps=3", "train.pair.batch=2"];
    let distilled = pliant(here, &[&["distil", "configs/model/pair.toml", "mine"], &small[..]].concat());
    assert!(distilled.status.success(), "{}", String::from_utf8_lossy(&distilled.stderr));
    let said = out(&distilled);
    assert!(said.contains("normal_force") && said.contains("yes"), "{said}");
    let stage = said.lines().find_map(|line| line.strip_prefix("distil: ")).expect("the folder of the stage");
    let written = format!("{stage}/model.toml");
    let again = pliant(here, &["train", &written, "mine"]);
    assert!(again.status.success(), "{}", String::from_utf8_lossy(&again.stderr));
    let errors = |text: &str, name: &str| {
        // The header begins with `model` too.
        let line = text.lines().filter_map(|line| line.strip_prefix(name)).next_back().expect("a line of errors");
        line.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(errors(&out(&again), "model "), errors(&said, "pair "), "it is another model");
    let network = said.lines().find_map(|line| line.strip_prefix("pair: ")).expect("the folder of the network");
    let twice = pliant(here, &["distil", network, "mine"]);
    assert!(out(&twice).contains("normal_force"), "{}", String::from_utf8_lossy(&twice.stderr));
    let none = complaint(&pliant(here, &["distil", "configs/model/still.toml", "mine"]));
    assert!(none.contains("kind \"particles\""), "{none}");
}

#[test]
fn bad_input_is_a_sentence_and_exit_code_two() {
    let folder = folder();
    let here = folder.path();
    assert!(complaint(&pliant(here, &["compare", "configs/compare/nowhere.toml"])).contains("nowhere.toml"));
    let typo = complaint(&pliant(here, &["compare", QUICKSTART, "planner.cem.sampels=3"]));
    assert!(typo.contains("did you mean `samples`"), "{typo}");
    let part = complaint(&pliant(here, &["compare", QUICKSTART, "model=[lerned]"]));
    assert!(part.contains("learned"), "{part}");
    assert!(complaint(&pliant(here, &["compare", QUICKSTART, "seeds=[]"])).contains("seeds"));
    assert!(complaint(&pliant(here, &["compare", QUICKSTART, "budget.rollouts=many"])).contains("rollouts"));
    assert!(complaint(&pliant(here, &["simulate", "configs/dataset/smoke.toml", "episodes=0"])).contains("episodes"));
    std::fs::write(here.join("notes.txt"), "mine").unwrap();
    let inside = complaint(&pliant(here, &["simulate", "configs/dataset/smoke.toml", "--to", "notes.txt"]));
    assert!(inside.contains("notes.txt"), "{inside}");
    assert_eq!(std::fs::read_to_string(here.join("notes.txt")).unwrap(), "mine");
    let outside = ["compare", QUICKSTART, "model=[still]", "dataset=smoke", "goal=[pressed]"];
    let outside =
        complaint(&pliant(here, &[&outside[..], &["goal.pressed.action=[[0,1],[0,1],[0,2],[0,1]]"]].concat()));
    assert!(outside.contains("action") && outside.contains("pressed"), "{outside}");
    let cloud = ["compare", QUICKSTART, "model=[still]", "dataset=smoke", "planner=[cem]", "goal=[pressed]"];
    let start = "+start={file = \"no.ply\", perception = \"cloud\"}";
    let missing = complaint(&pliant(here, &[&cloud[..], &[start]].concat()));
    assert!(missing.contains("no.ply"), "{missing}");
}

#[test]
fn a_formula_is_differentiated_and_simplified_and_its_mistakes_are_pointed_at() {
    let folder = folder();
    let formula = |words: &[&str]| pliant(folder.path(), &[&["formula"], words].concat());
    let shown = out(&formula(&["k/2.5 * max(0, d - r)^2.5", "--wrt", "r", "--range", "r=0..0.02"]));
    for said in ["derivative", "simplified", "operations", "agrees with the formula at 1024 points"] {
        assert!(shown.contains(said), "{shown}");
    }
    assert!(out(&formula(&["x / x", "--wrt", "x", "--range", "x=1..2"])).contains("simplified  1\n            0\n"));
    assert!(out(&formula(&["x / x", "--wrt", "x", "--range", "x=0..2"])).contains("simplified  x/x\n"));
    assert!(complaint(&formula(&["k * (r", "--wrt", "r"])).contains("  k * (r\n      ^\n"));
    assert!(complaint(&formula(&["stiffness * r", "--wrt", "stifness"])).contains("did you mean `stiffness`?"));
    assert!(complaint(&formula(&["r", "--wrt", "r", "--range", "r=2..1"])).contains("r=0..0.02"));
}

#[test]
fn configs_can_be_printed_with_their_origins_and_described() {
    let folder = folder();
    let shown = out(&pliant(folder.path(), &["compare", QUICKSTART, "planner.cem.samples=33", "--cfg"]));
    assert!(shown.contains("samples = 33") && shown.contains("command line"), "{shown}");
    assert!(shown.contains("configs/material/dough.toml:"), "{shown}");
    let schema: serde_json::Value = serde_json::from_str(&out(&pliant(folder.path(), &["schema"]))).unwrap();
    assert!(schema["properties"]["seeds"].is_object());
}

#[test]
fn every_experiment_runs_at_smoke_size_and_every_table_is_what_its_rows_give() {
    let folder = folder();
    let experiments = |words: &[&str]| {
        let output = run(env!("CARGO_BIN_EXE_experiments"), folder.path(), words);
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        out(&output)
    };
    let listed = experiments(&["list"]);
    let names: Vec<&str> = listed.lines().filter(|l| !l.starts_with(' ')).filter_map(|l| l.split(':').next()).collect();
    assert!(names.contains(&"quickstart") && names.len() >= 4, "{listed}");
    for name in names {
        experiments(&[name, "--smoke"]);
        assert!(folder.path().join(format!("runs/smoke/tables/{name}.tex")).exists());
    }
    let committed = Path::new(env!("CARGO_MANIFEST_DIR"));
    let check = run(env!("CARGO_BIN_EXE_experiments"), committed, &["check"]);
    assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stderr));
}
