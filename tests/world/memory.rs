//! What a world remembers: clones, snapshots, seeds, and the oracle that lives on them.
use crate::bench::*;
use glam::DVec3;
use pliant::model::{Oracle, WorldModel};
use pliant::state::Snapshot;
use pliant::world::{BlockSpec, SceneSpec, StartSpec, World};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

#[test]
fn clones_and_snapshots_continue_byte_for_byte() {
    let mut world = World::new(&spec(), 5).unwrap();
    for (tool, motion) in [(press(), down_to(0.012, 0.01)), (fingers(), grip(0.02)), (roller(), roll(0.015))] {
        world.take(&tool, &motion.start);
        // The tool is deep in the dough when the copies are taken.
        motion.controls[..9].iter().for_each(|control| world.step(control));
        let snapshot = world.snapshot();
        let (mut restored, mut cloned) = (World::restore(&snapshot).unwrap(), world.clone());
        assert_eq!(restored.snapshot(), snapshot);
        for control in &motion.controls[9..] {
            for copy in [&mut world, &mut restored, &mut cloned] {
                copy.step(control);
            }
            assert!(world.particles() == restored.particles() && world.particles() == cloned.particles());
            assert_eq!(world.snapshot(), restored.snapshot());
            assert_eq!(world.snapshot(), cloned.snapshot());
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_whatever_the_thread_count() {
    let ranges = BlockSpec { x: [0.05, 0.07], y: [0.05, 0.07], z: [0.025, 0.035], turn: [0.0, 1.0] };
    let spec = SceneSpec { start: StartSpec::Block(ranges), particles: 60, ..spec() };
    let tools = shipped_tools();
    let run = |threads: usize| -> Vec<Snapshot> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let one = |seed: u64| {
            let mut world = World::new(&spec, seed).unwrap();
            let tool = &tools[seed as usize % tools.len()].1;
            let motion = random_motion(&world, tool.as_ref(), &mut ChaCha8Rng::seed_from_u64(seed));
            world.execute(tool.shape(), &motion);
            world.snapshot()
        };
        pool.install(|| (0..tools.len() as u64).into_par_iter().map(one).collect())
    };
    let serial = run(1);
    assert!(serial == run(2), "two threads give other bytes");
    assert!(serial[0] != serial[1], "seeds differ");
}

#[test]
fn the_oracle_predicts_execution_bit_for_bit() {
    let mut world = World::new(&spec(), 2).unwrap();
    for (tool, motion) in [(fingers(), grip(0.015)), (press(), down_to(0.012, 0.01)), (roller(), roll(0.015))] {
        let scene = world.scene(&tool, &motion.start);
        Oracle.accepts(&scene).unwrap();
        let alone = Oracle.rollout(&scene, &motion.controls);
        let many = Oracle.rollouts(&scene, &[motion.clone(), motion.clone()]);
        let truth = world.execute(&tool, &motion);
        assert!(scene.particles == truth[0] && alone == truth && many == [truth.clone(), truth]);
    }
    let mut scene = world.scene(&press(), &[at(0.0, 0.0, 0.1)]);
    scene.snapshot = None;
    assert!(Oracle.accepts(&scene).unwrap_err().to_string().contains("simulator"));
}

#[test]
fn hostile_snapshots_are_refused_in_a_sentence() {
    let Snapshot(bytes) = World::new(&spec(), 1).unwrap().snapshot();
    let refused = |bytes: &[u8]| match World::restore(&Snapshot(bytes.into())) {
        Ok(_) => panic!("accepted"),
        Err(error) => assert!(error.to_string().contains("snapshot"), "{error}"),
    };
    for length in (0..bytes.len()).step_by(bytes.len() / 40).chain([1, 14, 15, 16, 46, 47, 48, bytes.len() - 1]) {
        refused(&bytes[..length]);
    }
    for place in (0..bytes.len()).step_by(bytes.len() / 40) {
        let mut damaged = bytes.to_vec();
        damaged[place] ^= 0x40;
        refused(&damaged);
    }
}

#[test]
fn velocities_are_backward_differences() {
    let mut world = World::new(&spec(), 1).unwrap();
    let rollout = world.execute(&press(), &down_to(0.015, 0.01));
    assert_eq!(rollout.len(), 16);
    assert!(rollout[0].velocities.iter().all(|v| *v == DVec3::ZERO));
    for pair in rollout.windows(2) {
        for ((now, then), velocity) in pair[1].positions.iter().zip(&pair[0].positions).zip(&pair[1].velocities) {
            assert!((*now - *then - *velocity * 0.1).length() < 1e-12);
        }
    }
    assert!(rollout[8].velocities.iter().any(|v| v.length() > 0.01));
}
