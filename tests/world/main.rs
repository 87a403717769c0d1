//! The ground truth: dough rests, yields, keeps its volume and its place on the table; and a world's future is its state's.
mod bench;
mod building;
mod memory;
mod physics;
