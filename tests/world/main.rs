//! The ground truth: things fall, slide and bounce as they must; dough rests, yields, keeps its volume and its place on the
//! table; and a world's future is its state's.
mod bench;
mod bodies;
mod building;
mod cut;
mod fluid;
mod memory;
mod physics;
