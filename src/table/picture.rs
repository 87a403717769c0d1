//! Particles as a small SVG picture, seen obliquely from above.
use glam::{DVec2, DVec3};
use std::fmt::Write;

/// A titled cloud of particles to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Caption.
    pub title: String,
    /// Positions \[m\].
    pub points: Vec<DVec3>,
}

const SIZE: f64 = 220.0;

/// Screen coordinates (right, up) and depth toward the viewer: turned 30° about z, looked at from 35° above the table.
pub(super) fn project(p: DVec3) -> (DVec2, f64) {
    let (turn, tilt) = (30_f64.to_radians(), 35_f64.to_radians());
    let right = p.x * turn.cos() - p.y * turn.sin();
    let away = p.x * turn.sin() + p.y * turn.cos();
    let up = p.z * tilt.cos() + away * tilt.sin();
    (DVec2::new(right, up), p.z * tilt.sin() - away * tilt.cos())
}

/// An SVG around `middle` in which `half_width` metres reach to the edge, so that pictures drawn alike can be compared.
///
/// Far particles are drawn first, high ones lighter; the lines are 2 cm apart on the table.
pub fn picture(picture: &Picture, middle: DVec3, half_width: f64) -> String {
    let scale = SIZE / (2.0 * half_width);
    let screen = |p: DVec3| {
        let (flat, depth) = project(p);
        (SIZE / 2.0 + scale * flat.x, SIZE * 0.62 - scale * flat.y, depth)
    };
    let mut svg = format!("<svg viewBox=\"0 0 {SIZE} {SIZE}\" width=\"{SIZE}\" height=\"{SIZE}\">");
    let lines = (half_width / 0.01).floor() as i32;
    for k in (-lines..=lines).step_by(2) {
        let (a, b) = (0.01 * f64::from(k), 0.01 * f64::from(lines));
        for (from, to) in [((a, -b), (a, b)), ((-b, a), (b, a))] {
            let (x1, y1, _) = screen(DVec3::new(from.0, from.1, 0.0));
            let (x2, y2, _) = screen(DVec3::new(to.0, to.1, 0.0));
            let _ = write!(svg, "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"#e4e4e4\"/>");
        }
    }
    let mut points: Vec<(f64, f64, f64, f64)> = picture
        .points
        .iter()
        .filter(|p| p.is_finite())
        .map(|p| (screen(*p - middle), p.z))
        .map(|((x, y, d), z)| (x, y, d, z))
        .collect();
    points.sort_by(|a, b| a.2.total_cmp(&b.2));
    for (x, y, _, z) in points {
        let light = 38.0 + 40.0 * (z / 0.04).clamp(0.0, 1.0);
        let _ = write!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"hsl(32 70% {light:.0}%)\" stroke=\"#0003\" stroke-width=\".5\"/>",
            scale * 0.0035
        );
    }
    svg + "</svg>"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_particles_cover_far_ones_and_high_ones_stand_higher() {
        let (near, far) = (project(DVec3::new(0.0, -0.1, 0.0)), project(DVec3::new(0.0, 0.1, 0.0)));
        assert!(near.1 > far.1 && near.0.y < far.0.y);
        assert!(project(DVec3::Z).0.y > project(DVec3::ZERO).0.y);
    }

    #[test]
    fn every_finite_particle_is_drawn_once() {
        let points = vec![DVec3::ZERO, DVec3::new(0.01, 0.0, 0.02), DVec3::NAN];
        let svg = picture(&Picture { title: String::new(), points }, DVec3::ZERO, 0.06);
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(!svg.contains("NaN"));
    }
}
