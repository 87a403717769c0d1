//! The network agrees with the naive one, and with differences of it.
use super::input::{EDGE_FEATURES, NODE_FEATURES};
use super::naive::{Leaves, Plain, run};
use super::{Aggregation, Architecture, Edges, Input, Links, Network, Precision, Sharing};
use dfdx::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn network(sharing: Sharing, width: usize) -> Network {
    network_with(Aggregation::Sum, sharing, width)
}

fn network_with(aggregation: Aggregation, sharing: Sharing, width: usize) -> Network {
    shaken(architecture(aggregation, sharing, width))
}

fn architecture(aggregation: Aggregation, sharing: Sharing, width: usize) -> Architecture {
    let edges = ["particle", "tool", "floor"].map(str::to_owned).to_vec();
    let (constants, shared_edges, layer_norm) = (Vec::new(), false, false);
    let (rounds, history, bodies) = (2, 1, 1);
    Architecture { width, rounds, sharing, aggregation, history, bodies, constants, edges, shared_edges, layer_norm }
}

fn shaken(architecture: Architecture) -> Network {
    let mut network = Network::new(architecture, 3);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let shaken: Vec<f32> = network.weights().iter().map(|w| w + rng.random_range(-0.1..0.1)).collect();
    network.set_weights(&shaken);
    network
}

fn input(edge_counts: [usize; 3], [particles, receivers, count]: [usize; 3]) -> Input {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut fill = |n: usize| -> Vec<f32> { (0..n).map(|_| rng.random_range(-1.0..1.0)).collect() };
    let nodes = fill(count * NODE_FEATURES);
    let edges = edge_counts.map(|e| {
        let receivers = (0..e).map(|k| (k * receivers / e) as u32).collect();
        let senders = (0..e).map(|k| ((k * 7 + 3) % count) as u32).collect();
        let window = fill(e).iter().map(|x| x.abs()).collect();
        Edges { links: Arc::new(Links { receivers, senders }), features: fill(e * EDGE_FEATURES), window }
    });
    Input { particles, receivers, nodes, edges: edges.to_vec() }
}

fn cotangent(count: usize) -> Vec<f32> {
    (0..count).map(|i| (i as f32 * 0.9).sin()).collect()
}

/// `max |a − b| / max |b|`.
fn gap<T: Copy + Into<f64>>(a: &[f32], b: &[T]) -> f64 {
    assert_eq!(a.len(), b.len());
    let b: Vec<f64> = b.iter().map(|x| (*x).into()).collect();
    let size = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    a.iter().zip(&b).fold(0.0f64, |m, (x, y)| m.max((f64::from(*x) - y).abs())) / size.max(1e-20)
}

#[test]
fn agrees_with_the_naive_network_in_value_and_every_derivative() {
    let cases =
        [(Sharing::Shared, 24, [300, 70, 9], [40, 40, 61]), (Sharing::PerRound, 17, [150, 0, 40], [40, 47, 61])];
    let kinds = [
        (Aggregation::Sum, false, false),
        (Aggregation::Mean, false, false),
        (Aggregation::Max, false, false),
        (Aggregation::Sum, true, false),
        (Aggregation::Sum, false, true),
        (Aggregation::Mean, true, true),
    ];
    for ((sharing, width, counts, rows), kind) in cases.into_iter().flat_map(|c| kinds.map(|k| (c, k))) {
        let (aggregation, shared_edges, layer_norm) = kind;
        let (input, plain) = (input(counts, rows), architecture(aggregation, sharing, width));
        let network = shaken(Architecture { shared_edges, layer_norm, ..plain });
        let device = Cpu::default();
        let leaves = Leaves::of(&network, &input, &device);
        let output = run(network.architecture(), &leaves, &input, &device);
        let fast = network.forward(input.clone());
        assert!(gap(&fast, &output.as_vec()) < 1e-5, "{}", gap(&fast, &output.as_vec()));

        let at = cotangent(fast.len());
        let at_output: Plain = device.tensor_from_vec(at.iter().map(|g| f64::from(*g)).collect(), (input.particles, 3));
        let grads = (output * at_output).sum::<Rank0, _>().backward();
        let mut weights = vec![0.0; network.weights().len()];
        let (_, back) = network.pull(input.clone(), &at, &mut weights);
        let mut rest = &weights[..];
        for (name, shape, _) in network.named() {
            let (own, after) = rest.split_at(shape.0 * shape.1);
            rest = after;
            if counts[1] == 0 && name.contains("edge.tool") {
                assert!(own.iter().all(|g| *g == 0.0), "{name}");
            } else {
                let g = gap(own, &grads.get(&leaves.weights[name]).as_vec());
                assert!(g < 2e-5, "{name}: {g}");
            }
        }
        assert!(gap(&back.nodes, &grads.get(&leaves.nodes).as_vec()) < 2e-5);
        for (own, (features, window)) in back.edges.iter().zip(&leaves.edges) {
            if !own.window.is_empty() {
                assert!(gap(&own.features, &grads.get(features).as_vec()) < 2e-5);
                assert!(gap(&own.window, &grads.get(window).as_vec()) < 2e-5);
            }
        }
        let (_, alone) = network.pull(input, &at, &mut []);
        assert_eq!((alone.nodes, alone.edges[0].features.len()), (back.nodes, back.edges[0].features.len()));
    }
}

#[test]
fn derivatives_agree_with_central_differences() {
    let (network, input) = (network(Sharing::Shared, 16), input([60, 20, 8], [12, 12, 20]));
    let at = cotangent(3 * input.particles);
    let mut weights = vec![0.0; network.weights().len()];
    let (_, back) = network.pull(input.clone(), &at, &mut weights);
    let device = Cpu::default();
    let here = Leaves::of(&network, &input, &device);
    let cost = |leaves: &Leaves| -> f64 {
        let output = run(network.architecture(), leaves, &input, &device).as_vec();
        output.iter().zip(&at).map(|(y, g)| y * f64::from(*g)).sum()
    };
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let h = 1e-5;
    for _ in 0..10 {
        let mut direction = |n: usize| -> Vec<f32> { (0..n).map(|_| rng.random_range(-1.0..1.0)).collect() };
        let (mut to, mut d) = (network.clone(), input.clone());
        to.set_weights(&direction(weights.len()));
        d.nodes = direction(input.nodes.len());
        for edges in &mut d.edges {
            (edges.features, edges.window) = (direction(edges.features.len()), direction(edges.window.len()));
        }
        let along = Leaves::of(&to, &d, &device);
        let difference = (cost(&here.along(&along, h)) - cost(&here.along(&along, -h))) / (2.0 * h);
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(x, y)| f64::from(*x) * f64::from(*y)).sum::<f64>();
        let edges = back.edges.iter().zip(&d.edges);
        let edges = edges.map(|(g, d)| dot(&g.features, &d.features) + dot(&g.window, &d.window));
        let exact = dot(&weights, &to.weights()) + dot(&back.nodes, &d.nodes) + edges.sum::<f64>();
        assert!(exact.abs() > 1e-2, "a trivial direction: {exact}");
        assert!((exact - difference).abs() < 2e-5 * exact.abs().max(1.0), "{exact} against {difference}");
    }
}

#[test]
fn nothing_to_move_and_nobody_to_hear() {
    let network = network(Sharing::Shared, 16);
    let empty = Input { particles: 0, receivers: 0, nodes: vec![0.0; NODE_FEATURES], edges: vec![Edges::default(); 3] };
    assert!(network.forward(empty.clone()).is_empty());
    assert_eq!(network.pull(empty, &[], &mut vec![0.0; network.weights().len()]).1.nodes, vec![0.0; NODE_FEATURES]);
    let alone = input([0, 0, 0], [3, 4, 5]);
    assert!(network.forward(alone).iter().all(|x| x.is_finite()));
}

#[test]
fn an_untrained_network_is_exactly_zero_and_trainable() {
    let trained = network(Sharing::Shared, 16);
    let fresh = Network::new(trained.architecture().clone(), 9);
    let input = input([60, 20, 8], [12, 12, 20]);
    assert!(fresh.forward(input.clone()).iter().all(|x| *x == 0.0));
    let mut weights = vec![0.0; fresh.weights().len()];
    fresh.pull(input, &cotangent(36), &mut weights);
    assert!(weights.iter().any(|g| g.abs() > 1e-3));
    assert_eq!(fresh.weights(), Network::new(trained.architecture().clone(), 9).weights());
    assert_ne!(fresh.weights(), Network::new(trained.architecture().clone(), 10).weights());
}

#[test]
fn rounded_products_are_near_and_so_are_their_derivatives() {
    let input = input([300, 70, 9], [40, 40, 61]);
    let exact = network(Sharing::Shared, 24);
    let mut rounded = network(Sharing::Shared, 24).in_precision(Precision::Bfloat16);
    let at = cotangent(3 * input.particles);
    let near = |a: &[f32], b: &[f32]| {
        let gap = gap(a, b);
        // Six products on the way, each factor wrong by at most 2⁻⁹.
        assert!(gap > 0.0 && gap < 12.0 / 512.0, "{gap}");
    };
    near(&rounded.forward(input.clone()), &exact.forward(input.clone()));
    let ((_, to), (_, from)) = (rounded.pull(input.clone(), &at, &mut []), exact.pull(input.clone(), &at, &mut []));
    near(&to.nodes, &from.nodes);
    to.edges.iter().zip(&from.edges).for_each(|(to, from)| near(&to.features, &from.features));

    let [mut of_rounded, mut of_exact] = [0; 2].map(|_| vec![0.0; exact.weights().len()]);
    rounded.pull(input.clone(), &at, &mut of_rounded);
    exact.pull(input.clone(), &at, &mut of_exact);
    assert_eq!(of_rounded, of_exact, "training rounds nothing");

    let halves: Vec<f32> = exact.weights().iter().map(|w| 0.5 * w).collect();
    let before = rounded.forward(input.clone());
    rounded.set_weights(&halves);
    assert!(gap(&rounded.forward(input), &before) > 0.1, "new weights are rounded anew");
}
