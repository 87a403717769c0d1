//! The cutting surface of a thin solid.
use super::{Placed, Solid};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// A solid is a blade when its thinnest side is at most this share of the next.
const THIN: f64 = 0.5;

/// How many skins ahead of its edge what a blade cuts makes way for it: parted surfaces that lie on each other push one another
/// apart at random.
const AHEAD: f64 = 4.0;

/// A surface that cuts, in its solid's frame: a rectangle, or the wall of a convex prism along z.
///
/// A point's side of it is the sign of `max_k (n_k · p − d_k)`; it is cut as far as the surface reaches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Blade {
    /// The planes (n, d) that its rectangles lie in; of a prism the outward ones.
    planes: Vec<(DVec3, f64)>,
    /// The two directions in which the surface extends; of a prism the first is zero, as a ring has no end.
    axes: [DVec3; 2],
    /// Its range along these \[m\].
    reach: [[f64; 2]; 2],
    /// Half of the thickness of the solid around it \[m\].
    half: f64,
}

impl Blade {
    /// Where a point is: its signed distance from the surface, and its place along the surface's two directions \[m\].
    pub fn place(&self, point: DVec3) -> DVec3 {
        self.placed(point).0
    }

    /// [`Blade::place`], and the normal of the plane that decides it.
    fn placed(&self, point: DVec3) -> (DVec3, DVec3) {
        let far = self.planes.iter().map(|(normal, distance)| (normal.dot(point) - distance, *normal));
        let (out, normal) = far.max_by(|a, b| a.0.total_cmp(&b.0)).expect("a blade has a plane");
        (DVec3::new(out, self.axes[0].dot(point), self.axes[1].dot(point)), normal)
    }

    /// Where a point comes to lie that makes way to one side (the sign of `side`) of the solid, `skin` \[m\] beyond it; none where
    /// it is no nearer than that, or farther beyond the surface's ends than the crack opens ahead.
    pub fn clear(&self, point: DVec3, side: f64, skin: f64) -> Option<DVec3> {
        let (place, normal) = self.placed(point);
        let inside = [place.y, place.z]
            .iter()
            .zip(self.reach)
            .all(|(x, [low, high])| (low - AHEAD * skin..=high + AHEAD * skin).contains(x));
        let lack = self.half + skin - side.signum() * place.x;
        (inside && lack > 0.0).then(|| point + side.signum() * lack * normal)
    }

    /// The surface's corners, one after the other, as [`Blade::place`] has them \[m\].
    pub fn corners(&self) -> [DVec3; 4] {
        let [[a, b], [c, d]] = self.reach;
        [[a, c], [b, c], [b, d], [a, d]].map(|[u, w]| DVec3::new(0.0, u, w))
    }
}

impl Solid {
    /// The middle surfaces of a thin box or of a thin mesh's bounding box; of an assembly of such the ring that they close, or
    /// each for itself. None where one of them is thick.
    pub fn blades(&self) -> Option<Vec<Blade>> {
        match self {
            Self::Assembly(pieces) => {
                let sheets = pieces.iter().map(Sheet::of).collect::<Option<Vec<_>>>()?;
                Some(ring(&sheets).map_or_else(|| sheets.iter().map(Sheet::blade).collect(), |ring| vec![ring]))
            }
            single => Some(vec![Sheet::middle(single.half_extents())?.blade()]),
        }
    }
}

/// A rectangle: its centre, its half sides and half the thickness of what it is the middle of \[m\].
struct Sheet {
    centre: DVec3,
    sides: [DVec3; 2],
    thickness: f64,
}

impl Sheet {
    /// The middle of a box, across its thinnest side.
    fn middle(half: DVec3) -> Option<Self> {
        let mut axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * half);
        axes.sort_by(|a, b| a.length().total_cmp(&b.length()));
        let [thin, a, b] = axes;
        (thin.length() <= THIN * a.length()).then_some(Self {
            centre: DVec3::ZERO,
            sides: [a, b],
            thickness: thin.length(),
        })
    }

    fn of(piece: &Placed) -> Option<Self> {
        let sheet = Self::middle(piece.solid.half_extents())?;
        let sides = sheet.sides.map(|side| piece.pose.rotation * side);
        Some(Self { centre: piece.pose.translation, sides, ..sheet })
    }

    fn normal(&self) -> DVec3 {
        self.sides[0].cross(self.sides[1]).normalize()
    }

    fn blade(&self) -> Blade {
        let axes = self.sides.map(DVec3::normalize);
        let range = |k: usize| {
            let middle = axes[k].dot(self.centre);
            [middle - self.sides[k].length(), middle + self.sides[k].length()]
        };
        Blade {
            planes: vec![(self.normal(), self.normal().dot(self.centre))],
            axes,
            reach: [range(0), range(1)],
            half: self.thickness,
        }
    }
}

/// The prism whose walls the sheets are: upright, convex around z, and each as wide as its neighbours leave it.
fn ring(sheets: &[Sheet]) -> Option<Blade> {
    let outward = |sheet: &Sheet| sheet.normal() * sheet.normal().dot(sheet.centre).signum();
    let mut walls: Vec<(f64, &Sheet)> =
        sheets.iter().map(|sheet| (outward(sheet).truncate().to_angle(), sheet)).collect();
    walls.sort_by(|a, b| a.0.total_cmp(&b.0));
    let upright = |sheet: &&Sheet| sheet.sides.iter().any(|side| side.truncate().length() < 1e-9);
    let width = |sheet: &Sheet| sheet.sides.iter().map(|side| side.truncate().length()).fold(0.0, f64::max);
    let next = walls.iter().cycle().skip(1);
    let closed = walls.iter().zip(next).all(|((from, a), (to, b))| {
        let turn = (to - from).rem_euclid(std::f64::consts::TAU);
        // Two walls at an angle meet where each has gone (R tan of half the angle) from its middle.
        let corner = |sheet: &Sheet| outward(sheet).dot(sheet.centre) * (turn / 2.0).tan();
        turn < std::f64::consts::PI && corner(a) <= 1.001 * width(a) && corner(b) <= 1.001 * width(b)
    });
    (walls.len() > 2 && walls.iter().all(|(_, sheet)| upright(sheet)) && closed).then(|| {
        let heights = sheets.iter().map(|sheet| {
            let half = sheet.sides.iter().map(|side| side.z.abs()).fold(0.0, f64::max);
            DVec2::new(sheet.centre.z - half, sheet.centre.z + half)
        });
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r.x), h.max(r.y)));
        let planes = sheets.iter().map(|sheet| (outward(sheet), outward(sheet).dot(sheet.centre))).collect();
        let half = sheets.iter().map(|sheet| sheet.thickness).fold(0.0, f64::max);
        Blade { planes, axes: [DVec3::ZERO, DVec3::Z], reach: [[-1.0, 1.0], [low, high]], half }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Pose;
    use glam::DQuat;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_blade_lies_in_the_middle_of_what_is_thin() {
        let cuboid = |x, y, z| Solid::Cuboid { half: DVec3::new(x, y, z) };
        let blades = cuboid(0.05, 0.0015, 0.03).blades().unwrap();
        let [blade] = &blades[..] else { panic!("{blades:?}") };
        let point = DVec3::new(0.01, 0.002, -0.03);
        let place = blade.place(point);
        assert_eq!(place.x.abs(), 0.002);
        assert!(place.truncate().length() < point.length() && (place.length() - point.length()).abs() < 1e-15);
        let [a, b, c, d] = blade.corners();
        assert!((b - a + d - a - (c - a)).length() < 1e-15, "no rectangle");
        assert!(((b - a).cross(d - a).length() - 0.1 * 0.06).abs() < 1e-15);
        let side = place.x.signum();
        assert!(blade.clear(point, side, 0.001).unwrap().abs_diff_eq(point.with_y(0.0025), 1e-15));
        assert!(blade.clear(point, -side, 0.001).unwrap().abs_diff_eq(point.with_y(-0.0025), 1e-15));
        assert_eq!(blade.clear(point.with_z(-0.0341), side, 0.001), None);
        assert_eq!(blade.clear(point.with_y(0.0026), side, 0.001), None);
        assert!(cuboid(0.05, 0.04, 0.03).blades().is_none(), "a block is no blade");
    }

    #[test]
    fn a_tube_is_one_blade_around_its_inside() {
        // Sixteen boxes, each as wide as the outer polygon's sides.
        let width = 0.0215 * (std::f64::consts::PI / 16.0).tan();
        let wall = |k: u32| {
            let rotation = DQuat::from_rotation_z(std::f64::consts::TAU * f64::from(k) / 16.0);
            let solid = Solid::Cuboid { half: DVec3::new(0.0015, width, 0.03) };
            Placed { solid, pose: Pose { translation: rotation * (0.02 * DVec3::X), rotation } }
        };
        let walls: Vec<Placed> = (0..16).map(wall).collect();
        let blades = Solid::Assembly(walls.clone().into()).blades().unwrap();
        let [ring] = &blades[..] else { panic!("{} blades", blades.len()) };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..1000 {
            let point = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-0.04..0.04)));
            let (out, radius) = (ring.place(point).x, point.truncate().length());
            assert!(radius > 0.0196 || out < 0.0, "{point} is inside, but at {out}");
            assert!(radius < 0.0204 || out > 0.0, "{point} is outside, but at {out}");
        }
        let open = Solid::Assembly(walls[1..].into());
        assert_eq!(open.blades().unwrap().len(), 15, "an open ring cuts as its walls do");
    }
}
