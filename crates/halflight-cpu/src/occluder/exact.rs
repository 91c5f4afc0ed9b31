//! Intersections of segments and rays with triangles, decided in exact arithmetic.

use std::cmp::Ordering;

use glam::{DVec3, Vec3, Vec3Swizzles as _};
use robust::{Coord3D, orient3d};

use super::expansion::Expansion;

/// True if the open segment between two points meets a closed triangle in a single point.
///
/// The signs are exact: a segment from the inside of a closed mesh to its outside meets the mesh, through
/// edges and corners as well. A triangle whose plane contains an end of the segment is not met.
pub(crate) fn meets(origin: Vec3, end: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let sides = [volume(a, b, c, origin), volume(a, b, c, end)];
    let across = sides[0] < 0.0 && sides[1] > 0.0 || sides[0] > 0.0 && sides[1] < 0.0;
    if !across {
        return false;
    }
    let edges = [volume(origin, end, a, b), volume(origin, end, b, c), volume(origin, end, c, a)];
    edges.iter().all(|&side| side >= 0.0) || edges.iter().all(|&side| side <= 0.0)
}

/// Number with the sign of N · (A − P), where N is the normal of the triangle by the order of its corners, A
/// any of them and P the point; 0 in the triangle's plane.
pub(crate) fn side_of_plane([a, b, c]: [Vec3; 3], point: Vec3) -> f64 {
    volume(a, b, c, point)
}

/// Number with the sign of a tetrahedron's volume.
fn volume(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    orient3d(a, b, c, d)
}

/// A ray: all points `origin + t · d` with t > 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Direction, of any length.
    pub(crate) d: Vec3,
}

impl Ray {
    /// True if the ray meets a closed triangle in a single point.
    ///
    /// A triangle whose plane contains the ray's origin, or the whole ray, is not met.
    pub(crate) fn meets(&self, [a, b, c]: [Vec3; 3]) -> bool {
        let sides = [self.side(a, b), self.side(b, c), self.side(c, a)];
        let (some_positive, some_negative) =
            (sides.iter().any(|&side| side > 0.0), sides.iter().any(|&side| side < 0.0));
        if some_positive == some_negative {
            return false;
        }
        // The sum of the sides is N · d, and N · (A − origin) over it is the parameter.
        let ahead = side_of_plane([a, b, c], self.origin);
        if some_positive { ahead > 0.0 } else { ahead < 0.0 }
    }

    /// Parameter at which the ray meets a triangle's plane, with a relative error of 2⁻³² at most. The ray
    /// must meet the triangle.
    pub(crate) fn parameter(&self, corners: [Vec3; 3]) -> f64 {
        let [a, b, c, o, d] = [corners[0], corners[1], corners[2], self.origin, self.d].map(Vec3::as_dvec3);
        let (u, v) = (b - a, c - a);
        let (plus, minus) = (u.yzx() * v.zxy(), u.zxy() * v.yzx());
        let (normal, size) = (plus - minus, plus.abs() + minus.abs());
        let (distance, along) = (normal.dot(a - o), normal.dot(d));
        // Both are wrong by at most 2⁻⁴⁹ times the sum of the absolute values of their terms.
        let sure = |value: f64, size: f64| value.abs() > size * 2f64.powi(-16);
        if sure(distance, size.dot((a - o).abs())) && sure(along, size.dot(d.abs())) {
            return distance / along;
        }
        let (distance, along) = self.fraction(corners);
        distance.value() / along.value()
    }

    /// Compares the parameters at which the ray meets two triangles. The ray must meet both.
    pub(crate) fn compare(&self, first: [Vec3; 3], second: [Vec3; 3]) -> Ordering {
        let (p, q) = (self.parameter(first), self.parameter(second));
        if (p - q).abs() > 2f64.powi(-30) * (p.abs() + q.abs()) {
            return p.total_cmp(&q);
        }
        if first == second {
            return Ordering::Equal;
        }
        let (mut a, mut b) = (self.fraction(first), self.fraction(second));
        // Denominators become positive.
        for (distance, along) in [&mut a, &mut b] {
            if along.sign() < 0.0 {
                (*distance, *along) = (distance.negated(), along.negated());
            }
        }
        let mut difference = a.0.times(&b.1);
        difference.add_all(&b.0.times(&a.1).negated());
        difference.sign().total_cmp(&0.0)
    }

    /// Parameter at which the ray meets a triangle's plane, as N · (A − origin) over N · d.
    fn fraction(&self, [a, b, c]: [Vec3; 3]) -> (Expansion, Expansion) {
        let (mut distance, mut along) = (Expansion::ZERO, Expansion::ZERO);
        // The origin's distance is the volume of four points: a sum of the determinants of each three of
        // them.
        let [a, b, c, o, d] = [a, b, c, self.origin, self.d].map(Vec3::as_dvec3);
        add_determinant(&mut distance, a, b, c);
        add_determinant(&mut distance, -o, b, c);
        add_determinant(&mut distance, a, -o, c);
        add_determinant(&mut distance, a, b, -o);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            add_determinant(&mut along, d, p, q);
        }
        (distance, along)
    }

    /// Number with the sign of d · (P − origin) × (Q − origin): the side on which the ray passes an edge.
    fn side(&self, p: Vec3, q: Vec3) -> f64 {
        let [p, q, o, d] = [p, q, self.origin, self.d].map(Vec3::as_dvec3);
        let (from, to) = (p - o, q - o);
        let (plus, minus) = (from.yzx() * to.zxy(), from.zxy() * to.yzx());
        let side = d.dot(plus - minus);
        // Seven roundings of each product; differences of coordinates are rounded as well.
        let error = d.abs().dot(plus.abs() + minus.abs()) * 2f64.powi(-49);
        if side.abs() > error {
            return side;
        }
        let mut exact = Expansion::ZERO;
        add_determinant(&mut exact, d, p, q);
        add_determinant(&mut exact, d, -o, q);
        add_determinant(&mut exact, d, p, -o);
        exact.sign()
    }
}

/// Adds a · (b × c), for vectors of single-precision numbers.
fn add_determinant(to: &mut Expansion, a: DVec3, b: DVec3, c: DVec3) {
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        to.add_product(b[next], c[last], a[axis]);
        to.add_product(-b[last], c[next], a[axis]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_count_and_touching_ends_do_not() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let through = |x: f32, y: f32| meets(Vec3::new(x, y, -1.0), Vec3::new(x, y, 1.0), triangle);
        assert!(through(0.2, 0.2) && through(0.0, 0.0) && through(0.5, 0.5) && through(0.3, 0.0));
        assert!(!through(-1e-30, 0.0) && !through(0.5, 0.5 + f32::EPSILON) && !through(2.0, -1.0));
        // From below, from above and with the corners the other way round.
        let (low, high) = (Vec3::new(0.2, 0.2, -1.0), Vec3::new(0.2, 0.2, 1.0));
        assert!(meets(high, low, triangle) && meets(low, high, [Vec3::X, Vec3::ZERO, Vec3::Y]));
        // Ends in the plane, the whole segment in the plane, both ends on one side.
        let inside = Vec3::new(0.2, 0.2, 0.0);
        assert!(!meets(low, inside, triangle) && !meets(inside, high, triangle));
        assert!(!meets(inside - Vec3::X, inside + Vec3::X, triangle));
        assert!(!meets(high, high * 2.0, triangle));
        // A triangle without area has no inside.
        assert!(!meets(low, high, [Vec3::ZERO, Vec3::X, Vec3::X]));
    }

    #[test]
    fn rays_meet_what_lies_ahead() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let up = |x: f32, y: f32| Ray { origin: Vec3::new(x, y, -1.0), d: Vec3::Z * 1e-3 };
        for (x, y) in [(0.2, 0.2), (0.0, 0.0), (0.5, 0.5), (0.3, 0.0)] {
            assert!(up(x, y).meets(triangle) && up(x, y).meets([Vec3::Y, Vec3::X, Vec3::ZERO]));
            assert!((up(x, y).parameter(triangle) - 1.0 / f64::from(1e-3f32)).abs() < 1e-9);
        }
        for (x, y) in [(-1e-30, 0.0), (0.5, 0.5 + f32::EPSILON), (2.0, -1.0)] {
            assert!(!up(x, y).meets(triangle));
        }
        // Behind the origin, along the plane, from within the plane, and a triangle without area.
        let middle = Vec3::new(0.2, 0.2, 0.0);
        assert!(!Ray { origin: middle + Vec3::Z, d: Vec3::Z }.meets(triangle));
        assert!(!Ray { origin: middle - Vec3::X, d: Vec3::X }.meets(triangle));
        assert!(!Ray { origin: middle, d: Vec3::Z }.meets(triangle));
        assert!(!up(0.2, 0.0).meets([Vec3::ZERO, Vec3::X, Vec3::X]));
    }

    #[test]
    fn rays_pass_an_edge_on_one_side_for_both_its_triangles() {
        // Points that single precision cannot put on the edge: each triangle is met or its neighbour is.
        let (p, q) = (Vec3::new(0.1, 0.7, 3.3), Vec3::new(0.9, -0.3, 2.9));
        let (left, right) = (Vec3::new(-3.0, -2.0, 3.1), Vec3::new(3.0, 2.0, 3.7));
        let origin = Vec3::new(0.3, 0.2, -7.7);
        for step in 1..1000 {
            let ray = Ray { origin, d: p.lerp(q, step as f32 / 1000.0) - origin };
            let met = [ray.meets([p, q, left]), ray.meets([q, p, right])];
            assert!(met[0] || met[1], "{step}");
            // Exactly through the edge at most for the few points that happen to lie on it.
            if met[0] && met[1] {
                assert_eq!(ray.compare([p, q, left], [q, p, right]), Ordering::Equal, "{step}");
            }
        }
    }

    #[test]
    fn parameters_are_compared_exactly() {
        let ray = Ray { origin: Vec3::new(0.0, 0.0, -1.0), d: Vec3::Z };
        let at = |z: f32| [Vec3::new(-1.0, -1.0, z), Vec3::new(1.0, -1.0, z), Vec3::new(0.0, 1.0, z)];
        assert_eq!(ray.compare(at(1e-38), at(0.0)), Ordering::Greater);
        assert_eq!(ray.compare(at(0.0), at(1e-38)), Ordering::Less);
        let wide = |corners: [Vec3; 3]| corners.map(|p| Vec3::new(p.x * 3.0, p.y * 5.0, p.z));
        assert_eq!(ray.compare(at(0.3), wide(at(0.3))), Ordering::Equal);
        let [a, b, c] = wide(at(0.3));
        assert_eq!(ray.compare(at(0.3), [c, b, a]), Ordering::Equal);
        assert_eq!(ray.compare(at(0.3), [b, a, c - Vec3::Z * 1e-7]), Ordering::Greater);
    }
}
