//! A rigid cube in a bath, as recorded by DPI-Net's position-based simulator (Li et al. 2019).
use super::super::arrays::Arrays;
use super::super::episode::states;
use super::{Episode, NO_TOOL, Part, Recording};
use crate::state::{Control, Wall};
use anyhow::ensure;
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// Files with `positions` (frames, N, 3) float32 \[m\], y up, the floor at y = 0, 60 frames a second; the first 64 particles are a
/// rigid cube, the rest is fluid. Names that begin with `train` are to learn from.
///
/// A point (x, y, z) becomes (x, −z, y): a quarter turn about x, so that no handedness changes. Particles are given by their
/// centres, which rest about a centimetre above the floor; some start up to 5 mm below it and are pushed out at once. In the same way
/// they keep a centimetre from four walls around 1.25 m times 0.4 m, of which the files say nothing.
pub(super) struct Boxbath;

/// Particles of the cube.
const CUBE: usize = 64;

/// Around everything that any frame of the recordings shows, and as far from it as the floor is.
const WALLS: [Wall; 4] = [
    Wall { normal: DVec3::X, offset: 0.0 },
    Wall { normal: DVec3::NEG_X, offset: -1.25 },
    Wall { normal: DVec3::Y, offset: -0.4 },
    Wall { normal: DVec3::NEG_Y, offset: 0.0 },
];

/// Time between frames \[s\].
const INTERVAL: f64 = 1.0 / 60.0;

impl Recording for Boxbath {
    fn name(&self) -> &'static str {
        "boxbath"
    }

    fn bodies(&self) -> &'static [&'static str] {
        &["fluid", "rigid cube"]
    }

    fn read(&self, path: &Path) -> anyhow::Result<Episode> {
        let (shape, positions) = Arrays::open(path)?.read::<f32>("positions", &[None, None, Some(3)])?;
        let (frames, count) = (shape[0], shape[1]);
        ensure!(
            frames >= 2 && count > CUBE,
            "`positions` in {} has {frames} frames of {count} particles, not two or more of more than the {CUBE} of the \
             cube; is it a boxbath recording?",
            path.display()
        );
        let upright = |p: &[f32]| DVec3::new(p[0].into(), -f64::from(p[2]), p[1].into());
        let points: Vec<DVec3> = positions.chunks_exact(3).map(upright).collect();
        let frames: Vec<Vec<DVec3>> = points.chunks_exact(count).map(<[DVec3]>::to_vec).collect();
        Ok(Episode {
            tool: NO_TOOL.to_owned(),
            theta: Vec::new(),
            interval: INTERVAL,
            start: Vec::new(),
            controls: vec![Control::default(); frames.len() - 1],
            states: states(frames, INTERVAL),
            body: (0..count).map(|i| u32::from(i < CUBE)).collect(),
            walls: WALLS.into(),
            constants: Arc::default(),
        })
    }

    fn part(&self, stem: &str) -> Part {
        if stem.starts_with("train") { Part::Train } else { Part::HeldOut }
    }
}
