//! Fitting models to data: one loop for everything learned, identification for everything written.
//!
//! The one loop is `training_loop.rs`: whatever has weights is a `Learner` there, world models (`trainer.rs`) and networks of two clouds
//! (`point_net/`) alike.
//!
//! Both minimise the same number on the same windows of the training episodes, the error [`Matched`], so that their
//! results can be compared; [`evaluate`] then scores any model on episodes that neither has seen.
mod adam;
mod checkpoint;
pub mod classifier;
mod constants;
pub mod distil;
mod evaluate;
mod events;
mod fit;
mod fitting;
mod identification;
mod identify;
mod identify_spec;
mod journal;
mod layers;
mod matched;
pub mod point_net;
pub mod policy;
mod schedule;
pub mod search;
mod sparsity;
mod split;
mod spread;
mod train_spec;
mod trainer;
mod training_loop;
mod unmatched;
mod unroll;
mod validation;
mod window;
mod windows;

pub use adam::Adam;
pub use constants::{replace, value};
pub use evaluate::{Evaluation, evaluate};
pub use fit::{Fit, FitSpec};
pub use identification::{Constant, Errors, Identification};
pub use identify::Identifier;
pub use identify_spec::{ConeSpec, IdentifySpec};
pub use matched::{Matched, displacement_scale};
pub use schedule::rate_at;
pub use split::{Split, Tools};
pub use train_spec::{Keep, TrainSpec};
pub use trainer::{Trained, Trainer};
pub use unmatched::Unmatched;
pub use unroll::Unroll;
pub use window::Window;
pub use windows::Windows;
