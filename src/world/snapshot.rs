//! A world as bytes.
use super::World;
use super::engine::Engine;
use crate::state::{Pose, Snapshot, Wall};
use anyhow::{Context, ensure};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// First bytes of every snapshot: what it is, and the version of its layout.
const HEADER: &[u8] = b"pliant world 4\n";
/// Length of the digest that follows the header.
const DIGEST: usize = 32;

#[derive(Serialize)]
struct Saved<'a> {
    engine: &'a Engine,
    chosen: &'a [u32],
    before: &'a [DVec3],
    poses: &'a [Pose],
    interval: f64,
    steps: u64,
    walls: &'a [Wall],
}

#[derive(Deserialize)]
struct Loaded {
    engine: Engine,
    chosen: Vec<u32>,
    before: Vec<DVec3>,
    poses: Vec<Pose>,
    interval: f64,
    steps: u64,
    walls: Vec<Wall>,
}

impl World {
    /// This world as bytes: header, SHA-256 of the rest, and the rest in postcard's encoding.
    pub fn snapshot(&self) -> Snapshot {
        let saved = Saved {
            engine: &self.engine,
            chosen: &self.chosen,
            before: &self.before,
            poses: &self.poses,
            interval: self.interval,
            steps: self.steps as u64,
            walls: &self.walls,
        };
        let body = postcard::to_stdvec(&saved).expect("plain data always has an encoding");
        let digest = Sha256::digest(&body);
        Snapshot([HEADER, digest.as_slice(), &body].concat().into())
    }

    /// The world that a snapshot was taken of, which continues bit for bit as that one does.
    ///
    /// # Errors
    /// When the bytes are not a snapshot, are damaged, or come from another version.
    pub fn restore(snapshot: &Snapshot) -> anyhow::Result<Self> {
        let rest = snapshot.0.strip_prefix(HEADER).context("these bytes are not a snapshot of this version's world")?;
        ensure!(rest.len() > DIGEST, "the snapshot of the world is cut short: take it again");
        let (digest, body) = rest.split_at(DIGEST);
        ensure!(Sha256::digest(body).as_slice() == digest, "the snapshot of the world is damaged: take it again");
        let loaded: Loaded = postcard::from_bytes(body)
            .context("the snapshot of the world was written by another version: take it again")?;
        let Loaded { mut engine, chosen, before, poses, interval, steps, walls } = loaded;
        engine.refresh();
        Ok(Self { engine, chosen, before, poses, interval, steps: steps as usize, walls })
    }
}
