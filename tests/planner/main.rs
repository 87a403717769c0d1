//! Planners on functions whose minimum is known.
mod curvature;
mod field;
mod proposals;
mod search;
mod seconds;
