//! An episode as a `.npz` file that `numpy.load` reads.
use super::Episode;
use super::arrays::{Arrays, Draft};
use super::episode::states;
use crate::config::write_whole;
use crate::state::{Control, Particles, Pose, Wall};
use anyhow::{Context, ensure};
use glam::{DQuat, DVec3, Vec3};
use std::path::Path;
use std::sync::Arc;

/// Number of columns of a pose: x, y, z, then the quaternion x, y, z, w.
const POSE: usize = 7;
/// Number of columns of a wall: the normal, then the offset.
const WALL: usize = 4;

impl Episode {
    /// Reads the episode file at `path`, made with the tool called `tool`.
    ///
    /// Arrays: `positions` (H + 1, N, 3) float32 \[m\]; `tool_poses` (H + 1, parts, 7) float64, x y z \[m\] and the unit
    /// quaternion x y z w; `theta` (d) float64; `interval` () float64 \[s\]; `body` (N) int32, left out where all are 0; `walls`
    /// (W, 4) float64, a unit normal into the room and its product with the points of the wall \[m\], left out where there are none.
    ///
    /// # Errors
    /// When the file is missing or truncated, an array is missing or of another shape or type, a number is not finite, a
    /// quaternion or a wall's normal has not length 1, the interval is not positive, or a body number is negative.
    pub fn read(path: &Path, tool: &str) -> anyhow::Result<Self> {
        let mut arrays = Arrays::open(path)?;
        let (shape, positions) = arrays.read::<f32>("positions", &[None, None, Some(3)])?;
        let (frames, count) = (shape[0], shape[1]);
        ensure!(
            frames >= 2 && count >= 1,
            "`positions` in {} has {frames} frames of {count} particles; two frames of one are the least",
            path.display()
        );
        let (shape, poses) = arrays.read::<f64>("tool_poses", &[Some(frames), None, Some(POSE)])?;
        let (_, theta) = arrays.read("theta", &[None])?;
        let (_, interval) = arrays.read::<f64>("interval", &[])?;
        let interval = interval[0];
        ensure!(interval > 0.0, "`interval` in {} is {interval}; it must be positive [s]", path.display());
        let pose = |row: &[f64]| Pose { translation: DVec3::from_slice(row), rotation: DQuat::from_slice(&row[3..]) };
        let poses: Vec<Pose> = poses.chunks_exact(POSE).map(pose).collect();
        ensure!(
            poses.iter().all(|p| (p.rotation.length() - 1.0).abs() < 1e-6),
            "`tool_poses` in {} has a quaternion whose length is not 1; its columns are x y z qx qy qz qw",
            path.display()
        );
        let parts = shape[1];
        let mut controls = (0..frames).map(|t| Control { poses: poses[t * parts..(t + 1) * parts].to_vec() });
        let start = controls.next().map(|c| c.poses).unwrap_or_default();
        let controls = controls.collect();
        let (body, walls) = (bodies(&mut arrays, count, path)?, walls(&mut arrays, path)?);
        let points: Vec<DVec3> = positions.chunks_exact(3).map(|p| Vec3::from_slice(p).as_dvec3()).collect();
        let frames = points.chunks_exact(count).map(<[DVec3]>::to_vec).collect();
        let states = states(frames, interval);
        let (tool, constants) = (tool.to_owned(), Arc::default());
        Ok(Self { tool, theta, interval, start, controls, states, body, walls, constants })
    }

    /// Writes the episode to `path`, whole; positions are rounded to float32, velocities are not kept.
    ///
    /// # Errors
    /// When a number is not finite, the counts disagree, or the file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let (frames, count, parts) =
            (self.horizon() + 1, self.states.first().map_or(0, Particles::len), self.start.len());
        let even = self.states.len() == frames
            && self.states.iter().all(|x| x.len() == count)
            && self.body.len() == count
            && self.controls.iter().all(|c| c.poses.len() == parts);
        ensure!(even, "the episode for {} has uneven numbers of states, particles or tool parts", path.display());
        ensure!(
            self.states.iter().all(Particles::is_finite),
            "the episode for {} contains a number that is not finite",
            path.display()
        );
        let points = self.states.iter().flat_map(|x| &x.positions);
        let positions: Vec<f32> = points.flat_map(|p| p.as_vec3().to_array()).collect();
        let poses = (0..frames).flat_map(|t| self.poses(t));
        let poses: Vec<f64> =
            poses.flat_map(|p| p.translation.to_array().into_iter().chain(p.rotation.to_array())).collect();
        let mut draft = Draft::new();
        let added = draft
            .add("positions", &[frames, count, 3], positions)
            .and_then(|()| draft.add("tool_poses", &[frames, parts, POSE], poses))
            .and_then(|()| draft.add("theta", &[self.theta.len()], self.theta.clone()))
            .and_then(|()| draft.add("interval", &[], vec![self.interval]))
            .and_then(|()| match self.body.iter().any(|body| *body > 0) {
                true => draft.add("body", &[count], numbers(&self.body)?),
                false => Ok(()),
            })
            .and_then(|()| match self.walls.is_empty() {
                true => Ok(()),
                false => {
                    draft.add("walls", &[self.walls.len(), WALL], self.walls.iter().flat_map(Wall::to_array).collect())
                }
            });
        added.with_context(|| format!("{} cannot be prepared", path.display()))?;
        write_whole(path, &draft.bytes()?)
    }
}

/// The array `body`; zeros where there is none.
fn bodies(arrays: &mut Arrays, count: usize, path: &Path) -> anyhow::Result<Arc<[u32]>> {
    if !arrays.has("body") {
        return Ok(vec![0; count].into());
    }
    let (_, numbers) = arrays.read::<i32>("body", &[Some(count)])?;
    let body: Result<Arc<[u32]>, _> = numbers.into_iter().map(u32::try_from).collect();
    body.with_context(|| format!("`body` in {} has a negative number; bodies count from 0", path.display()))
}

/// The array `walls`; none where there is no such array.
fn walls(arrays: &mut Arrays, path: &Path) -> anyhow::Result<Arc<[Wall]>> {
    if !arrays.has("walls") {
        return Ok(Arc::default());
    }
    let (_, numbers) = arrays.read::<f64>("walls", &[None, Some(WALL)])?;
    let wall = |row: &[f64]| Wall { normal: DVec3::from_slice(row), offset: row[3] };
    let walls: Arc<[Wall]> = numbers.chunks_exact(WALL).map(wall).collect();
    ensure!(
        walls.iter().all(|wall| (wall.normal.length() - 1.0).abs() < 1e-6),
        "`walls` in {} has a normal whose length is not 1; its columns are nx ny nz offset",
        path.display()
    );
    Ok(walls)
}

fn numbers(body: &[u32]) -> anyhow::Result<Vec<i32>> {
    body.iter().map(|b| Ok(i32::try_from(*b)?)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::made_up;
    use super::*;

    fn sentence(path: &Path) -> String {
        format!("{:#}", Episode::read(path, "press").unwrap_err())
    }

    #[test]
    fn an_episode_comes_back_as_it_was_and_its_bytes_depend_on_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.npz"), folder.path().join("b.npz"));
        let episode = made_up(3);
        episode.write(&a).unwrap();
        assert_eq!(Episode::read(&a, &episode.tool).unwrap(), episode);
        episode.write(&b).unwrap();
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
        assert_eq!(std::fs::read(&a).unwrap()[10..14], [0, 0, 0x21, 0], "the archive carries the time of writing");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "a draft was left behind");
    }

    #[test]
    fn bodies_walls_and_the_lack_of_a_tool_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("episode.npz");
        let mut episode = made_up(3);
        episode.body = [0, 2, 1, 1, 0].into();
        episode.walls = [Wall { normal: DVec3::X, offset: -0.1 }, Wall { normal: DVec3::NEG_Y, offset: 0.3 }].into();
        (episode.start, episode.theta) = (Vec::new(), Vec::new());
        episode.controls.iter_mut().for_each(|c| c.poses.clear());
        episode.write(&path).unwrap();
        assert_eq!(Episode::read(&path, "press").unwrap(), episode);
        episode.body = [0; 4].into();
        assert!(format!("{:#}", episode.write(&path).unwrap_err()).contains("uneven"));

        let refused = |body: i32, walls: [f64; 4]| {
            let mut draft = Draft::new();
            draft.add("positions", &[2, 1, 3], vec![0.0f32; 6]).unwrap();
            draft.add("tool_poses", &[2, 0, 7], Vec::<f64>::new()).unwrap();
            draft.add("theta", &[0], Vec::<f64>::new()).unwrap();
            draft.add("interval", &[], vec![0.1]).unwrap();
            draft.add("body", &[1], vec![body]).unwrap();
            draft.add("walls", &[1, 4], walls.to_vec()).unwrap();
            std::fs::write(&path, draft.bytes().unwrap()).unwrap();
            sentence(&path)
        };
        let told = refused(-1, [1.0, 0.0, 0.0, 0.2]);
        assert!(told.contains("`body`"), "{told}");
        let told = refused(0, [1.0, 1.0, 0.0, 0.2]);
        assert!(told.contains("`walls`") && told.contains("length is not 1"), "{told}");
    }

    #[test]
    fn damaged_files_are_refused_with_their_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("episode.npz");
        assert!(sentence(&path).contains("episode.npz is missing"), "{}", sentence(&path));
        made_up(3).write(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for keep in [0, 1, 50, whole.len() / 2, whole.len() - 10, whole.len() - 1] {
            std::fs::write(&path, &whole[..keep]).unwrap();
            assert!(sentence(&path).contains("episode.npz"), "{keep}: {}", sentence(&path));
        }
        // No flipped byte may panic; one within the numbers must be noticed by its checksum.
        let mut noticed = 0;
        for i in (0..whole.len()).step_by(7) {
            let mut bytes = whole.clone();
            bytes[i] ^= 0x55;
            std::fs::write(&path, &bytes).unwrap();
            noticed += usize::from(Episode::read(&path, "press").is_err());
        }
        assert!(noticed * 7 > whole.len() * 8 / 10, "{noticed} of {} flips noticed", whole.len() / 7);
    }

    #[test]
    fn wrong_shapes_types_and_numbers_are_refused_with_the_array() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("episode.npz");
        let write = |positions: &[usize], poses: &[usize], turn: f64, first: f32, interval: f64| {
            let mut draft = Draft::new();
            let mut numbers = vec![0.0f32; positions.iter().product()];
            numbers[0] = first;
            draft.add("positions", positions, numbers).unwrap();
            let numbers = (0..poses.iter().product()).map(|i| if i % 7 == 6 { turn } else { 0.0 }).collect::<Vec<_>>();
            draft.add("tool_poses", poses, numbers).unwrap();
            draft.add("theta", &[2], vec![1.0, 2.0]).unwrap();
            if interval == 7.0 {
                draft.add("interval", &[], vec![7.0f32]).unwrap();
            } else if interval != 8.0 {
                draft.add("interval", &[], vec![interval]).unwrap();
            }
            std::fs::write(&path, draft.bytes().unwrap()).unwrap();
        };
        write(&[3, 2, 3], &[3, 1, 7], 1.0, 0.0, 0.1);
        Episode::read(&path, "press").unwrap();
        type Case<'a> = (&'a [usize], &'a [usize], f64, f32, f64, &'a [&'a str]);
        let cases: [Case<'_>; 9] = [
            (&[3, 2, 2], &[3, 1, 7], 1.0, 0.0, 0.1, &["`positions`", "[3, 2, 2]", "(any, any, 3)"]),
            (&[3, 6], &[3, 1, 7], 1.0, 0.0, 0.1, &["`positions`", "[3, 6]"]),
            (&[1, 2, 3], &[1, 1, 7], 1.0, 0.0, 0.1, &["`positions`", "1 frames"]),
            (&[3, 2, 3], &[2, 1, 7], 1.0, 0.0, 0.1, &["`tool_poses`", "[2, 1, 7]", "(3, any, 7)"]),
            (&[3, 2, 3], &[3, 1, 7], 0.5, 0.0, 0.1, &["`tool_poses`", "quaternion"]),
            (&[3, 2, 3], &[3, 1, 7], 1.0, f32::NAN, 0.1, &["`positions`", "not finite", "element 0"]),
            (&[3, 2, 3], &[3, 1, 7], 1.0, 0.0, -0.1, &["`interval`", "positive"]),
            (&[3, 2, 3], &[3, 1, 7], 1.0, 0.0, 7.0, &["`interval`", "<f4"]),
            (&[3, 2, 3], &[3, 1, 7], 1.0, 0.0, 8.0, &["`interval`", "cannot be read"]),
        ];
        for (positions, poses, turn, first, interval, words) in cases {
            write(positions, poses, turn, first, interval);
            assert!(words.iter().all(|w| sentence(&path).contains(w)), "{}", sentence(&path));
        }
    }
}
