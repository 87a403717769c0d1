//! Shapes: what they contain, how much that is, and how a surface is filled.
use glam::{DVec2, DVec3};
use pliant::shape::{FillSpec, Filled, Shape, ShapeSpec, letter};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

fn shape(text: &str) -> anyhow::Result<Box<dyn Shape>> {
    toml_edit::de::from_str::<ShapeSpec>(text)?.build()
}

const SHAPES: &[(&str, Option<f64>)] = &[
    ("kind = 'cuboid'\nwidth = 0.06\nlength = 0.04\nthickness = 0.02", Some(0.06 * 0.04 * 0.02)),
    ("kind = 'disc'\ndiameter = 0.06\nthickness = 0.02", Some(PI * 0.03 * 0.03 * 0.02)),
    ("kind = 'ring'\nouter = 0.06\ninner = 0.02\nthickness = 0.02", Some(PI * (9e-4 - 1e-4) * 0.02)),
    ("kind = 'ellipsoid'\nwidth = 0.06\nlength = 0.04\nheight = 0.02", Some(PI / 6.0 * 0.06 * 0.04 * 0.02)),
    ("kind = 'letter'\ncharacter = 'B'\nheight = 0.06\nthickness = 0.02", None),
    ("kind = 'letter'\ncharacter = 'i'\nheight = 0.06\nwidth = 0.06\nvolume = 5e-5", Some(5e-5)),
    ("kind = 'cuboid'\nwidth = 0.06\nlength = 0.04\nvolume = 5e-5", Some(5e-5)),
    ("kind = 'ring'\nouter = 0.06\ninner = 0.02\nvolume = 5e-5", Some(5e-5)),
    ("kind = 'ellipsoid'\nwidth = 0.06\nlength = 0.04\nvolume = 5e-5", Some(5e-5)),
];

#[test]
fn volumes_are_what_they_contain_and_bounds_hold_it() {
    for (text, known) in SHAPES {
        let (shape, mut rng) = (shape(text).unwrap(), ChaCha8Rng::seed_from_u64(1));
        let (low, high) = shape.bounds();
        assert_eq!(low.z, 0.0, "{text} stands on the table");
        assert!((low + high).truncate().length() < 1e-12, "{text} is centred");
        if let Some(known) = known {
            assert!((shape.volume() / known - 1.0).abs() < 1e-9, "{text}: {} m³", shape.volume());
        }
        let (wide_low, wide_high) = (low - 0.1 * (high - low), high + 0.1 * (high - low));
        let (mut hits, tries) = (0, 50_000);
        let (mut seen_low, mut seen_high) = (high, low);
        for _ in 0..tries {
            let at = wide_low + (wide_high - wide_low) * DVec3::new(rng.random(), rng.random(), rng.random());
            if shape.contains(at) {
                hits += 1;
                assert!(at.cmpge(low).all() && at.cmple(high).all(), "{text} contains {at} beyond its bounds");
                (seen_low, seen_high) = (seen_low.min(at), seen_high.max(at));
            }
        }
        let measured = hits as f64 / tries as f64 * (wide_high - wide_low).element_product();
        assert!((measured / shape.volume() - 1.0).abs() < 0.03, "{text}: {measured} counted, {} said", shape.volume());
        assert!((seen_low - low).max(high - seen_high).max_element() < 0.004, "{text} does not reach its bounds");
    }
}

#[test]
fn points_have_the_shape_of_the_volume() {
    for (text, _) in SHAPES {
        let shape = shape(text).unwrap();
        let points = shape.points(300, &mut ChaCha8Rng::seed_from_u64(2));
        assert_eq!(points.len(), 300);
        assert!(points.iter().all(|p| shape.contains(*p)));
        // Even: nobody is nearer than a third of the mean spacing, and every part of the volume has somebody near.
        let spacing = (shape.volume() / 300.0).cbrt();
        for (i, p) in points.iter().enumerate() {
            assert!(points[..i].iter().all(|q| q.distance(*p) > spacing / 3.0), "{text}: two points nearly coincide");
        }
        for at in shape.points(1000, &mut ChaCha8Rng::seed_from_u64(3)) {
            let nearest = points.iter().map(|p| p.distance(at)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1.5 * spacing, "{text}: nobody within {nearest} of {at}");
        }
    }
}

#[test]
fn letters_look_like_letters() {
    use pliant::shape::Outline;
    let at = |c: char, x: f64, y: f64| {
        let glyph = letter(c, 0.06).unwrap();
        glyph.covers(DVec2::new(x, y) * glyph.half())
    };
    // (x, y) in −1..1 from the lower left of the ink's box to its upper right.
    assert!(at('L', -0.9, 0.9) && at('L', 0.9, -0.9) && !at('L', 0.5, 0.5), "an L has a foot to the right");
    assert!(at('T', 0.0, -0.5) && at('T', 0.9, 0.95) && !at('T', 0.8, -0.8), "a T has its bar on top");
    assert!(!at('O', 0.0, 0.0) && at('O', 0.0, 0.97) && at('O', -0.97, 0.0), "an O is hollow");
    assert!(!at('C', 0.9, 0.0) && at('C', -0.9, 0.0), "a C is open to the right");
    assert!(letter('\u{10FFFF}', 0.06).is_err() && letter(' ', 0.06).is_err());
}

#[test]
fn impossible_shapes_are_refused_by_key() {
    let cases = [
        ("kind = 'disc'\ndiameter = 0.06", "thickness"),
        ("kind = 'disc'\ndiameter = 0.06\nthickness = 0.01\nvolume = 1e-5", "both"),
        ("kind = 'disc'\ndiameter = -0.06\nthickness = 0.01", "diameter"),
        ("kind = 'disc'\ndiameter = nan\nthickness = 0.01", "diameter"),
        ("kind = 'ring'\nouter = 0.02\ninner = 0.03\nthickness = 0.01", "inner"),
        ("kind = 'ellipsoid'\nwidth = 0.06\nlength = 0.04\nvolume = 0.0", "volume"),
        ("kind = 'disc'\ndiametre = 0.06\nthickness = 0.01", "diametre"),
        ("kind = 'cone'\nheight = 0.06", "cone"),
        (
            "kind = 'cloud'\npath = '/no/such.ply'\nfill = { cell = 0.002, closing = 0.004, opening = 0.0 }",
            "/no/such.ply",
        ),
    ];
    for (text, expected) in cases {
        let Err(error) = shape(text) else { panic!("{text} was accepted") };
        assert!(format!("{error:#}").contains(expected), "{error:#} should speak of {expected}");
    }
}

const FILL: FillSpec = FillSpec { cell: 0.002, closing: 0.004, opening: 0.004 };

/// Points on the outside of a ring of height `height`, none on the table side.
fn ring_surface(inner: f64, outer: f64, height: f64) -> Vec<DVec3> {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut points = Vec::new();
    while points.len() < 3000 {
        let at = DVec2::new(rng.random_range(-outer..outer), rng.random_range(-outer..outer));
        if (inner..outer).contains(&at.length()) {
            points.push(at.extend(height));
            // The wall below, seen at a random height.
            points.push((at.normalize() * outer).extend(rng.random_range(0.0..height)));
        }
    }
    points
}

#[test]
fn the_volume_under_a_surface_is_filled_and_its_hole_is_not() {
    let filled = Filled::under(&ring_surface(0.015, 0.04, 0.02), &FILL).unwrap();
    let exact = PI * (0.04_f64.powi(2) - 0.015_f64.powi(2)) * 0.02;
    assert!((filled.volume() / exact - 1.0).abs() < 0.07, "{} against {exact}", filled.volume());
    assert!(filled.contains(DVec3::new(0.0, 0.03, 0.001)) && filled.contains(DVec3::new(0.0, 0.03, 0.019)));
    assert!(!filled.contains(DVec3::new(0.0, 0.03, 0.021)) && !filled.contains(DVec3::new(0.0, 0.03, -0.001)));
    assert!(!filled.contains(DVec3::new(0.0, 0.0, 0.001)), "the hole is wider than what closing closes");
    let moved = filled.clone().moved(DVec2::new(0.1, -0.2));
    assert!(moved.contains(DVec3::new(0.1, -0.17, 0.001)) && moved.volume() == filled.volume());
}

#[test]
fn gaps_are_closed_and_whiskers_dropped() {
    let plate: Vec<DVec3> = (0..40 * 40)
        .map(|i| DVec3::new((i % 40) as f64 + 0.5, (i / 40) as f64 + 0.5, 10.0) * 1e-3)
        .filter(|p| p.truncate().distance(DVec2::splat(0.02)) > 0.003)
        .collect();
    let whisker = (0..30).map(|i| DVec3::new(0.0405 + i as f64 * 1e-3, 0.02, 0.01));
    let filled = Filled::under(&plate.iter().copied().chain(whisker).collect::<Vec<_>>(), &FILL).unwrap();
    assert!((filled.height(DVec2::splat(0.02)) - 0.01).abs() < 1e-9, "the gap takes its neighbours' height");
    assert_eq!(filled.height(DVec2::new(0.06, 0.02)), 0.0, "the whisker goes");
    assert!((filled.volume() / 1.6e-5 - 1.0).abs() < 0.05, "{}", filled.volume());
    let wide = FillSpec { opening: 0.03, ..FILL };
    assert!(Filled::under(&plate, &wide).unwrap_err().to_string().contains("opening"));
    assert!(Filled::under(&[], &FILL).is_err());
    assert!(Filled::under(&[DVec3::Z, DVec3::new(1e9, 0.0, 1.0)], &FILL).unwrap_err().to_string().contains("wide"));
}
