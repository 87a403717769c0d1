//! What must hold of every tool in `configs/tool`, whatever the action and the workpiece.
use glam::{DQuat, DVec3};
use pliant::state::{ControlGrad, Pose, PoseGrad};
use pliant::tool::{Motion, Tool, ToolSpec, Workpiece};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STEPS: usize = 15;
const INTERVAL: f64 = 0.1;

fn tools() -> Vec<(String, Box<dyn Tool>)> {
    let mut files: Vec<_> = std::fs::read_dir("configs/tool").unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let read = |path: &std::path::PathBuf| {
        let spec: ToolSpec = toml_edit::de::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        (path.file_stem().unwrap().to_string_lossy().into_owned(), spec.build().unwrap())
    };
    files.iter().map(read).collect()
}

/// A cube, a slab, a ridge, a crumb and a large flat piece, away from the origin.
fn pieces() -> Vec<Workpiece> {
    [[0.03, 0.03, 0.03], [0.045, 0.03, 0.02], [0.02, 0.06, 0.05], [0.004, 0.003, 0.003], [0.06, 0.06, 0.015]]
        .into_iter()
        .zip([[0.0, 0.0, 0.0], [0.02, -0.03, 0.0], [-0.05, 0.01, 0.0], [0.1, 0.1, 0.0], [0.0, 0.02, 0.0]])
        .map(|(extent, centre)| Workpiece { centre: DVec3::from_array(centre), extent: DVec3::from_array(extent) })
        .collect()
}

/// `press_square.toml` with RoboCook's own head, whose file has the face up and lies away from the origin.
fn real_press() -> ToolSpec {
    let text = std::fs::read_to_string("configs/tool/press_square.toml").unwrap();
    let (keys, _) = text.split_once("[head.solid]").unwrap();
    let solid = "[head.solid]\nkind = 'mesh'\npath = 'tools/press_square.stl'\nturn = [3.141592653589793, 0.0, 0.0]\n";
    toml_edit::de::from_str(&(keys.to_owned() + solid)).unwrap()
}

#[test]
fn a_head_from_a_mesh_is_centred_with_its_face_down() {
    let missing = format!("{:#}", real_press().under("nowhere".as_ref()).build().err().expect("no such file"));
    assert!(missing.contains("nowhere/tools/press_square.stl"), "{missing}");

    // A pyramid, its tip up in the file, away from the origin.
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("tools")).unwrap();
    let corners = [[0.01, 0.01], [0.05, 0.01], [0.05, 0.05], [0.01, 0.05]].map(|[x, y]| [x, y, 0.06]);
    let tip = [0.03, 0.03, 0.08];
    let mut facets = vec![[corners[0], corners[2], corners[1]], [corners[0], corners[3], corners[2]]];
    facets.extend((0..4).map(|i| [corners[i], corners[(i + 1) % 4], tip]));
    let vertex = |[x, y, z]: [f64; 3]| format!("vertex {x} {y} {z}\n");
    let facet =
        |f: &[[f64; 3]; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", f.map(vertex).concat());
    let stl = format!("solid a\n{}endsolid a\n", facets.iter().map(facet).collect::<String>());
    std::fs::write(folder.path().join("tools/press_square.stl"), stl).unwrap();
    let press = real_press().under(folder.path()).build().unwrap();
    let solid = &press.shape().parts[0].solid;
    assert!(solid.half_extents().distance(DVec3::new(0.02, 0.02, 0.01)) < 1e-7, "{solid:?}");
    assert!(solid.project(DVec3::new(0.0, 0.0, -0.0099)).distance.abs() < 1e-4, "the tip is not below");
    assert!(solid.project(DVec3::new(0.018, 0.018, -0.009)).distance > 5e-3, "the base is not above");
}

#[test]
fn the_real_press_head_is_the_block_that_its_data_sheet_says() {
    let here = std::env::current_dir().unwrap();
    let Some(root) = here.ancestors().map(|a| a.join("shared/data/robocook")).find(|r| r.is_dir()) else {
        return eprintln!("skipped: shared/data/robocook is not beside the project");
    };
    let block = tools().into_iter().find(|(name, _)| name == "press_square").unwrap().1;
    let press = real_press().under(&root).build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..200 {
        let point = DVec3::from_array(rng.random::<[f64; 3]>()) * 0.08 - 0.04;
        let distance = |tool: &dyn Tool| tool.shape().parts[0].solid.project(point).distance;
        assert!((distance(block.as_ref()) - distance(press.as_ref())).abs() < 1e-6, "at {point}");
    }
}

fn random_theta(tool: &dyn Tool, piece: &Workpiece, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let space = tool.space(piece);
    let mut theta = space.at(&(0..space.dimension()).map(|_| rng.random()).collect::<Vec<f64>>());
    space.clamp(&mut theta);
    theta
}

/// The workpiece's bounding box as a grid of points that includes its faces and corners.
fn filled(piece: &Workpiece) -> Vec<DVec3> {
    let fractions = || (0..5).map(|i| f64::from(i) / 2.0 - 1.0);
    let point = |x, y, z: f64| piece.centre + piece.extent * DVec3::new(x, y, (z + 1.0) / 2.0);
    fractions().flat_map(|x| fractions().flat_map(move |y| fractions().map(move |z| point(x, y, z)))).collect()
}

fn distance(tool: &dyn Tool, poses: &[Pose], points: &[DVec3]) -> f64 {
    let parts = tool.shape().parts.iter().zip(poses);
    parts
        .flat_map(|(part, pose)| points.iter().map(|p| part.solid.project(pose.inverse_apply(*p)).distance))
        .fold(f64::INFINITY, f64::min)
}

fn lowest(tool: &dyn Tool, poses: &[Pose]) -> f64 {
    let parts = tool.shape().parts.iter().zip(poses);
    parts.flat_map(|(part, pose)| part.surface.iter().map(|s| pose.apply(s.position).z)).fold(f64::INFINITY, f64::min)
}

fn poses(motion: &Motion) -> Vec<&[Pose]> {
    std::iter::once(&motion.start[..]).chain(motion.controls.iter().map(|c| &c.poses[..])).collect()
}

#[test]
fn motions_start_and_end_clear_stay_above_the_table_and_below_the_speed_limit() {
    let pieces = pieces();
    for (name, tool) in tools() {
        let (tool, mut rng, mut fastest) = (tool.as_ref(), ChaCha8Rng::seed_from_u64(1), 0.0f64);
        for round in 0..1000 {
            let piece = &pieces[round % pieces.len()];
            let theta = random_theta(tool, piece, &mut rng);
            tool.space(piece).check(&theta).unwrap();
            let motion = tool.motion(&theta, piece, STEPS);
            assert_eq!(motion.controls.len(), STEPS);
            let path = poses(&motion);
            let material = filled(piece);
            for (when, at) in [("starts", path[0]), ("ends", path[STEPS])] {
                let gap = distance(tool, at, &material);
                assert!(gap > 1e-3, "{name} {when} {gap} m from the piece {piece:?} at {theta:?}");
            }
            for (t, at) in path.iter().enumerate() {
                assert_eq!(at.len(), tool.shape().parts.len());
                assert!(lowest(tool, at) > 5e-4, "{name} is at height {} after {t} steps", lowest(tool, at));
                for pose in *at {
                    assert!((pose.rotation.length() - 1.0).abs() < 1e-12);
                    assert!(pose.translation.distance(piece.centre) < 0.3, "{name} leaves the workspace");
                }
            }
            for pair in path.windows(2) {
                let speed = |(a, b): (&Pose, &Pose)| a.twist_to(b, INTERVAL).linear.length();
                fastest = pair[0].iter().zip(pair[1]).map(speed).fold(fastest, f64::max);
            }
        }
        println!("{name}: at most {fastest:.3} m/s");
        assert!(fastest < 0.2, "{name} moves at {fastest} m/s");
    }
}

#[test]
fn a_motion_reaches_into_the_material() {
    // How far a point is inside the box, from above or from the side.
    let depth = |piece: &Workpiece, point: DVec3| {
        let within = piece.extent - DVec3::new(0.0, 0.0, piece.extent.z) - (point - piece.centre).with_z(0.0).abs();
        within.x.min(within.y).min(piece.extent.z - point.z)
    };
    for (name, tool) in tools() {
        for piece in &pieces()[..3] {
            let space = tool.space(piece);
            // The deepest action at the middle of the piece.
            let mut theta = space.at(&vec![0.5; space.dimension()]);
            for (i, coordinate) in space.names.iter().enumerate() {
                match coordinate.as_str() {
                    "z" | "width" => theta[i] = space.low[i],
                    "depth" => theta[i] = space.high[i],
                    _ => {}
                }
            }
            let motion = tool.motion(&theta, piece, STEPS);
            let places = poses(&motion).into_iter().flat_map(|at| {
                let parts = tool.shape().parts.iter().zip(at);
                parts.flat_map(|(part, pose)| part.surface.iter().map(|s| pose.apply(s.position)))
            });
            let deepest = places.map(|point| depth(piece, point)).fold(f64::NEG_INFINITY, f64::max);
            assert!(deepest > 0.004, "{name} reaches only {deepest} m into {piece:?}");
        }
    }
}

#[test]
fn a_rolling_head_does_not_slip() {
    for (name, tool) in tools().into_iter().filter(|(name, _)| name.starts_with("roller")) {
        let piece = &pieces()[0];
        let space = tool.space(piece);
        let motion = tool.motion(&space.at(&vec![0.7; space.dimension()]), piece, STEPS);
        for pair in poses(&motion).windows(2) {
            for (from, to) in pair[0].iter().zip(pair[1]) {
                let twist = from.twist_to(to, INTERVAL);
                if twist.angular.length() > 0.0 {
                    let radius = tool.shape().parts[0].solid.half_extents().x;
                    let lowest = twist.linear + twist.angular.cross(-radius * DVec3::Z);
                    assert!(lowest.length() < 1e-9, "{name} slips at {lowest} m/s");
                }
            }
        }
    }
}

#[test]
fn the_derivative_of_a_motion_agrees_with_a_sixth_order_difference() {
    for (name, tool) in tools() {
        let (tool, mut rng) = (tool.as_ref(), ChaCha8Rng::seed_from_u64(2));
        for round in 0..50 {
            let piece = &pieces()[round % pieces().len()];
            let theta = random_theta(tool, piece, &mut rng);
            // J is linear in every pose entry: a weight on three body points of each pose, for each step.
            let weights: Vec<Vec<DVec3>> = (0..=STEPS)
                .map(|_| (0..3 * tool.shape().parts.len()).map(|_| DVec3::from_array(rng.random())).collect())
                .collect();
            let points = [DVec3::X, DVec3::Y, DVec3::Z];
            let cost = |theta: &[f64]| -> f64 {
                let motion = tool.motion(theta, piece, STEPS);
                let steps = poses(&motion).into_iter().zip(&weights);
                let body = |(at, w): (&[Pose], &Vec<DVec3>)| -> f64 {
                    (0..w.len()).map(|k| w[k].dot(at[k / 3].apply(points[k % 3]))).sum()
                };
                steps.map(body).sum()
            };
            let pull = |at: &[Pose], w: &[DVec3]| -> Vec<PoseGrad> {
                let point = |pose: &Pose, k: usize| (pose.rotation * points[k % 3]).cross(w[k]);
                (at.iter().enumerate())
                    .map(|(part, pose)| PoseGrad {
                        translation: (3 * part..3 * part + 3).map(|k| w[k]).sum(),
                        rotation: (3 * part..3 * part + 3).map(|k| point(pose, k)).sum(),
                    })
                    .collect()
            };
            let motion = tool.motion(&theta, piece, STEPS);
            let start = pull(&motion.start, &weights[0]);
            let controls: Vec<ControlGrad> = (motion.controls.iter().zip(&weights[1..]))
                .map(|(c, w)| ControlGrad { poses: pull(&c.poses, w) })
                .collect();
            let gradient = tool.motion_vjp(&theta, piece, &start, &controls);
            let space = tool.space(piece);
            for i in 0..theta.len() {
                let h = 2e-4 * (space.high[i] - space.low[i]);
                if h < 1e-9 {
                    continue;
                }
                let at = |s: f64| {
                    let mut theta = theta.clone();
                    theta[i] += s * h;
                    cost(&theta)
                };
                let odd = |s: f64| at(s) - at(-s);
                let difference = (45.0 * odd(1.0) - 9.0 * odd(2.0) + odd(3.0)) / (60.0 * h);
                let error = (gradient[i] - difference).abs();
                assert!(error < 1e-5 * (1.0 + difference.abs()), "{name} θ{i}: {} vs {difference}", gradient[i]);
                let name = &space.names[i];
                assert!(difference.abs() > 1e-6, "`{name}` seems to change nothing at {theta:?}");
            }
        }
    }
}

#[test]
fn the_gripper_opens_as_far_as_the_piece_needs() {
    let (_, gripper) = tools().into_iter().find(|(name, _)| name == "gripper_rod").unwrap();
    let gap = |extent: f64, rotation: f64| {
        let piece = Workpiece { centre: DVec3::ZERO, extent: DVec3::new(extent, 0.02, 0.03) };
        let start = gripper.motion(&[0.0, rotation, 0.01], &piece, STEPS).start;
        start[0].translation.distance(start[1].translation)
    };
    assert!((gap(0.02, 0.0) - 2.0 * (0.04 + 0.0059)).abs() < 1e-12);
    assert!(gap(0.07, 0.0) > 2.0 * (0.075 + 0.0059));
    assert!((gap(0.07, 1.57) - gap(0.02, 1.57)).abs() < 1e-3);
    let piece = pieces()[0];
    let closed = gripper.motion(&[0.0, 0.4, 0.013], &piece, STEPS).controls[9].poses.clone();
    let facing = closed[0].rotation * DVec3::X;
    assert!((closed[1].translation - closed[0].translation).dot(facing) - 2.0 * 0.0059 - 0.013 < 1e-12);
    assert!((closed[1].rotation * DVec3::X + facing).length() < 1e-12);
    assert!(closed[0].rotation.dot(DQuat::from_rotation_z(0.4)).abs() > 1.0 - 1e-12);
}
