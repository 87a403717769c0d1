//! Readers of point clouds and meshes: every format they promise, and every way a file can be broken.
use glam::DVec3;
use npyz::WriterBuilder;
use pliant::shape::{parse_points, read_mesh, read_points};
use pliant::state::Closure;
use std::path::PathBuf;

fn cloud() -> Vec<DVec3> {
    (0..5).map(|i| DVec3::new(i as f64, 0.5 * i as f64 - 1.0, 0.25)).collect()
}

fn points(name: &str, bytes: &[u8]) -> anyhow::Result<Vec<DVec3>> {
    parse_points(name.as_ref(), bytes)
}

/// Writes `bytes` to a fresh file and hands its path to `read`.
fn with_file<T>(name: &str, bytes: &[u8], read: impl FnOnce(PathBuf) -> T) -> T {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(path)
}

fn ply_header(format: &str, count: u64) -> Vec<u8> {
    let properties =
        "property uchar red\nproperty double z\nproperty float x\nproperty list uchar int odd\nproperty float y";
    format!("ply\nformat {format} 1.0\ncomment made here\nelement vertex {count}\n{properties}\nend_header\n")
        .into_bytes()
}

/// Properties in an odd order, a colour and a list among them.
fn ply(format: &str) -> Vec<u8> {
    let mut bytes = ply_header(format, 5);
    for p in cloud() {
        match format {
            "ascii" => bytes.extend(format!("255 {} {} 2 7 8 {}\n", p.z, p.x, p.y).into_bytes()),
            "binary_little_endian" => {
                bytes.push(255);
                bytes.extend(p.z.to_le_bytes());
                bytes.extend((p.x as f32).to_le_bytes());
                bytes.extend([1, 7, 0, 0, 0]);
                bytes.extend((p.y as f32).to_le_bytes());
            }
            _ => {
                bytes.push(255);
                bytes.extend(p.z.to_be_bytes());
                bytes.extend((p.x as f32).to_be_bytes());
                bytes.extend([1, 0, 0, 0, 7]);
                bytes.extend((p.y as f32).to_be_bytes());
            }
        }
    }
    bytes
}

fn npy(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

/// The cloud's numbers, row by row or column by column.
fn numbers(fortran: bool) -> Vec<f64> {
    let rows = cloud();
    let by_row = rows.iter().flat_map(|p| p.to_array()).collect();
    let by_column = (0..3).flat_map(|axis| rows.iter().map(move |p| p[axis])).collect();
    if fortran { by_column } else { by_row }
}

fn npz(arrays: &[&str]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut archive = npyz::npz::NpzWriter::new(&mut bytes);
    for name in arrays {
        let array = archive.array::<f64>(name, Default::default()).unwrap().default_dtype();
        let mut array = array.shape(&[5, 3]).begin_nd().unwrap();
        let shift = if *name == "positions" || arrays.len() == 1 { 0.0 } else { 100.0 };
        array.extend(numbers(false).into_iter().map(|x| x + shift)).unwrap();
        array.finish().unwrap();
    }
    drop(archive);
    bytes.into_inner()
}

fn tetrahedron() -> [[[f32; 3]; 3]; 4] {
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    [[o, y, x], [o, x, z], [o, y, z], [x, y, z]]
}

fn stl(header: &str) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend(4u32.to_le_bytes());
    for triangle in tetrahedron() {
        bytes.extend([0; 12]);
        triangle.as_flattened().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii_stl() -> Vec<u8> {
    let vertex = |[x, y, z]: [f32; 3]| format!("vertex {x} {y} {z}\n");
    let facet =
        |t: [[f32; 3]; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", t.map(vertex).concat());
    format!("solid part\n{}endsolid part\n", tetrahedron().map(facet).concat()).into_bytes()
}

/// Every well-formed file of these tests.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let mut files = vec![
        ("a.ply", ply("ascii")),
        ("b.PLY", ply("binary_little_endian")),
        ("c.ply", ply("binary_big_endian")),
        ("d.npz", npz(&["anything"])),
        ("e.npz", npz(&["others", "positions"])),
    ];
    for fortran in [false, true] {
        let encode = |bytes: fn(f64) -> Vec<u8>| numbers(fortran).into_iter().flat_map(bytes).collect::<Vec<_>>();
        files.push(("f.npy", npy("<f8", fortran, "(5, 3)", &encode(|x| x.to_le_bytes().to_vec()))));
        files.push(("g.npy", npy(">f8", fortran, "(5, 3)", &encode(|x| x.to_be_bytes().to_vec()))));
        files.push(("h.npy", npy("<f4", fortran, "(5, 3)", &encode(|x| (x as f32).to_le_bytes().to_vec()))));
        files.push(("i.npy", npy(">f4", fortran, "(5, 3)", &encode(|x| (x as f32).to_be_bytes().to_vec()))));
    }
    files
}

#[test]
fn every_format_gives_the_same_points() {
    for (name, bytes) in files() {
        assert_eq!(with_file(name, &bytes, |path| read_points(&path)).unwrap(), cloud(), "{name}");
    }
    for bytes in [stl("binary"), stl("solid but binary"), ascii_stl()] {
        assert_eq!(points("a.stl", &bytes).unwrap().len(), 4);
        let mesh = with_file("a.stl", &bytes, |path| read_mesh(&path)).unwrap();
        assert_eq!((mesh.vertices.len(), mesh.closure), (4, Closure::Watertight));
        assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-12);
    }
}

#[test]
fn a_file_cut_anywhere_is_refused_with_its_name() {
    let mut all = files();
    all.extend([("j.stl", stl("binary")), ("k.stl", stl("solid but binary")), ("l.stl", ascii_stl())]);
    for (name, bytes) in all {
        for length in 0..bytes.len() {
            match points(name, &bytes[..length]) {
                Err(error) => assert!(format!("{error:#}").contains(name), "{error:#}"),
                // Nothing is lost with a last line break, the last digits of a number, or a comment.
                Ok(read) => assert!(
                    length + 12 > bytes.len() && !name.contains("np"),
                    "{name} cut to {length} of {} still gives {read:?}",
                    bytes.len()
                ),
            }
        }
    }
}

#[test]
fn any_changed_byte_gives_points_or_a_sentence() {
    let mut all = files();
    all.extend([("j.stl", stl("binary")), ("l.stl", ascii_stl())]);
    for (name, bytes) in all {
        for place in 0..bytes.len() {
            for value in [0, b'(', b'9', 0xff] {
                let mut changed = bytes.clone();
                changed[place] = value;
                if let Ok(read) = points(name, &changed) {
                    assert!(read.iter().all(|p| p.is_finite()) && !read.is_empty());
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_points_is_refused_by_what_is_wrong() {
    let le = |x: f64| x.to_le_bytes();
    let data = |count: usize| (0..count).flat_map(|i| le(i as f64)).collect::<Vec<_>>();
    let nan: Vec<u8> = [0.0, f64::NAN, 0.0].into_iter().flat_map(le).collect();
    let huge_ply = |format, count| {
        let mut bytes = ply_header(format, count);
        bytes.extend([0; 100]);
        bytes
    };
    let mut deep = npy("<f8", false, &format!("{}1", "(".repeat(20_000)), &[]);
    deep.truncate(30_000);
    let mut long_header = b"\x93NUMPY\x02\x00".to_vec();
    long_header.extend(u32::MAX.to_le_bytes());
    let mut many_triangles = stl("binary");
    many_triangles[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let no_properties = "ply\nformat ascii 1.0\nelement vertex 1000000000000\nend_header\n";
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("a.npy", npy("<f8", false, "(4, 2)", &data(8)), "(N, 3)"),
        ("a.npy", npy("<f8", false, "(6,)", &data(6)), "(N, 3)"),
        ("a.npy", npy("<i8", false, "(2, 3)", &data(6)), "f4 or f8"),
        ("a.npy", npy("<f8", false, "(0, 3)", &[]), "no points"),
        ("a.npy", npy("<f8", false, "(1, 3)", &nan), "point 0"),
        ("a.npy", npy("<f8", false, "(1000000000000, 3)", &data(6)), "claims"),
        ("a.npy", npy("<f8", false, "(6148914691236517205, 3)", &data(6)), "claims"),
        ("a.npy", npy("<f8", false, "(0, 6148914691236517205, 6148914691236517205, 9)", &data(6)), "claims"),
        ("a.npy", deep, "nested"),
        ("a.npy", long_header, "truncated"),
        ("a.npy", b"not numpy at all".to_vec(), "NumPy"),
        ("a.npz", npz(&["one", "two"]), "positions"),
        ("a.npz", npz(&[]), "positions"),
        ("a.npz", b"PK\x03\x04 but no archive".to_vec(), "archive"),
        ("a.ply", huge_ply("ascii", 1_000_000_000_000), "claims 1000000000000"),
        ("a.ply", huge_ply("binary_little_endian", 1_000_000_000_000), "claims 1000000000000"),
        ("a.ply", huge_ply("binary_big_endian", u64::MAX), "claims"),
        ("a.ply", no_properties.into(), "claims"),
        ("a.ply", ply_header("ascii", 0), "no points"),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header\n".to_vec(), "vertex"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n".to_vec(), "lack"),
        ("a.stl", many_triangles, "claims"),
        ("a.stl", b"solid empty\nendsolid empty\n".to_vec(), "no points"),
        ("a.obj", vec![], ".ply"),
        ("noextension", vec![], ".ply"),
    ];
    for (name, bytes, expected) in cases {
        let error = format!("{:#}", points(name, &bytes).expect_err(expected));
        assert!(error.contains(name) && error.contains(expected), "{error} should speak of {expected}");
    }
    let missing = format!("{:#}", read_points("/no/such/cloud.ply".as_ref()).unwrap_err());
    assert!(missing.contains("/no/such/cloud.ply") && missing.contains("check the path"), "{missing}");
    let empty = with_file("a.stl", b"solid a\nendsolid a\n", |path| read_mesh(&path)).unwrap_err();
    assert!(format!("{empty:#}").contains("at least one triangle"));
}

#[test]
fn the_tool_heads_of_a_real_robot_are_solids_in_metres() {
    let here = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/robocook");
    let tools = std::env::var_os("PLIANT_DATA").map_or_else(here, PathBuf::from).join("tools");
    if !tools.is_dir() {
        println!("skipped: {} is not there", tools.display());
        return;
    }
    let round = |diameter: f64, length: f64| std::f64::consts::PI / 4.0 * diameter * diameter * length;
    let heads = [
        ("press_square", 0.04 * 0.04 * 0.02),
        ("punch_square", 0.018 * 0.018 * 0.02),
        ("press_circle", round(0.04, 0.02)),
        ("punch_circle", round(0.02, 0.02)),
        ("roller_large", round(0.04, 0.07)),
        ("roller_small", round(0.024, 0.07)),
        ("gripper_l_wall", 0.0118 * 0.06 * 0.0506),
    ];
    for (name, volume) in heads {
        let mesh = read_mesh(&tools.join(format!("{name}.stl"))).unwrap();
        println!("{name}: {:?}, {} triangles, {:.3e} m³", mesh.closure, mesh.triangles.len(), mesh.volume());
        assert!((mesh.volume() / volume - 1.0).abs() < 0.01, "{name} holds {} m³", mesh.volume());
    }
}
