//! A planning problem.
