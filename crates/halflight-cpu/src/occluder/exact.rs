//! The question that every ray is about, answered in exact arithmetic.

use glam::Vec3;
use robust::{Coord3D, orient3d};

/// Whether the open segment between two points meets a closed triangle in a single point.
///
/// The signs are exact, so a segment that passes from the inside of a closed mesh to its outside meets it, through edges
/// and corners as well. A triangle that has an end of the segment in its plane is not met.
pub(crate) fn meets(origin: Vec3, end: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let sides = [volume(a, b, c, origin), volume(a, b, c, end)];
    let across = sides[0] < 0.0 && sides[1] > 0.0 || sides[0] > 0.0 && sides[1] < 0.0;
    if !across {
        return false;
    }
    let edges = [volume(origin, end, a, b), volume(origin, end, b, c), volume(origin, end, c, a)];
    edges.iter().all(|&side| side >= 0.0) || edges.iter().all(|&side| side <= 0.0)
}

/// A number with the sign of the volume of a tetrahedron.
fn volume(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    orient3d(a, b, c, d)
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
}
