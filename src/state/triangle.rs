//! The point of one triangle closest to a given point, and which feature it lies on.
use glam::DVec3;

/// A part of a triangle a, b, c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    /// Corner i.
    Corner(usize),
    /// The side from corner i to corner i + 1 (mod 3).
    Side(usize),
    /// The interior.
    Face,
}

/// The closest point of the triangle and its feature, by the signs of barycentric areas (Ericson 2005, section 5.1.5).
pub(super) fn closest_point([a, b, c]: [DVec3; 3], p: DVec3) -> (DVec3, Feature) {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Feature::Corner(0));
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Feature::Corner(1));
    }
    let at_c = d1 * d4 - d3 * d2;
    if at_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Feature::Side(0));
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Feature::Corner(2));
    }
    let at_b = d5 * d2 - d1 * d6;
    if at_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Feature::Side(2));
    }
    let at_a = d3 * d6 - d5 * d4;
    if at_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        return (b + (c - b) * ((d4 - d3) / (d4 - d3 + d5 - d6)), Feature::Side(1));
    }
    let sum = at_a + at_b + at_c;
    (a + ab * (at_b / sum) + ac * (at_c / sum), Feature::Face)
}
