//! The same planner, budget and random numbers for every model; only the model differs.
mod alone;
mod artifact;
mod attempt;
mod bench;
mod commit;
mod contender;
mod control;
mod distil;
pub mod disturbance;
mod goal;
mod journey;
mod policies;
mod prediction;
mod row;
mod run;
mod spec;

pub use alone::train;
pub use artifact::{Artifacts, dataset_folder};
pub use attempt::Attempt;
pub use bench::{Comparison, compare, fit, fit_named};
pub use commit::commit;
pub use contender::{Contender, ContenderSpec};
pub use control::{AimSpec, ControlSpec};
pub use distil::distil;
pub use goal::{ActionSpec, DrawnSpec, Goal, GoalMaker, GoalSpec, RecipeSpec, Source, WordSpec};
pub use journey::{Journey, Step, plan};
pub use prediction::Prediction;
pub use row::{Row, read_rows, to_jsonl};
pub use spec::{CompareSpec, DataSpec, RUNS, StartSpec};

use bench::Bench;
