//! Planners on functions whose minimum is known.
mod curvature;
mod differences;
mod field;
mod patience;
mod proposals;
mod search;
mod seconds;
