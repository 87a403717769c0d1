//! The verbs of Pliant.
fn main() {}
