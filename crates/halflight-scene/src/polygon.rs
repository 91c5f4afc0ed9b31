//! Polygons to triangles.

use glam::{DVec2, DVec3, Vec3};

/// Appends the triangles of the polygon whose corners are `corners`, indices into `positions`.
///
/// Strictly convex polygons become a fan; others have their ears clipped, in the plane of their vector area.
/// A polygon that crosses itself still gives `corners.len() - 2` triangles, but no promise of what they cover.
pub(crate) fn triangulate(corners: &[u32], positions: &[Vec3], triangles: &mut Vec<[u32; 3]>) {
    let flat = match corners {
        [] | [_] | [_, _] => return,
        &[a, b, c] => return triangles.push([a, b, c]),
        _ => project(corners, positions),
    };
    let count = corners.len();
    if (0..count).all(|at| turn(flat[at], flat[(at + 1) % count], flat[(at + 2) % count]) > 0.0) {
        triangles.extend((1..count - 1).map(|at| [corners[0], corners[at], corners[at + 1]]));
        return;
    }
    let mut left: Vec<usize> = (0..count).collect();
    let mut start = 0;
    while left.len() > 3 {
        let count = left.len();
        let corner = |at: usize| flat[left[at % count]];
        // Going on where the last ear was keeps long polygons quadratic.
        let ear = (start..start + count).find(|&at| {
            let [a, b, c] = [corner(at + count - 1), corner(at), corner(at + 1)];
            turn(a, b, c) > 0.0
                && left.iter().all(|&other| {
                    let p = flat[other];
                    // Corners of the ear itself, also where the polygon touches itself there, are not inside.
                    p == a || p == b || p == c || !inside(p, a, b, c)
                })
        });
        // A polygon without an ear is degenerate or crosses itself: any corner is as good as another.
        let ear = ear.unwrap_or(start) % count;
        let [before, after] = [(ear + count - 1) % count, (ear + 1) % count];
        triangles.push([left[before], left[ear], left[after]].map(|at| corners[at]));
        left.remove(ear);
        start = ear;
    }
    triangles.push([left[0], left[1], left[2]].map(|at| corners[at]));
}

/// The polygon in the plane of its vector area, counter-clockwise.
fn project(corners: &[u32], positions: &[Vec3]) -> Vec<DVec2> {
    let points: Vec<DVec3> = corners.iter().map(|&at| positions[at as usize].as_dvec3()).collect();
    // Newell: relative to the first corner, so that far polygons keep their digits.
    let origin = points[0];
    let next = points.iter().cycle().skip(1);
    let normal: DVec3 = points.iter().zip(next).map(|(&a, &b)| (a - origin).cross(b - origin)).sum();
    let (axis_u, axis_v) = normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    points.iter().map(|&p| DVec2::new((p - origin).dot(axis_u), (p - origin).dot(axis_v))).collect()
}

/// Twice the signed area of a triangle: positive where it turns left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn inside(p: DVec2, a: DVec2, b: DVec2, c: DVec2) -> bool {
    turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area by the triangles, all of which must face +z.
    fn area(outline: &[[f32; 2]]) -> (usize, f32) {
        let positions: Vec<Vec3> = outline.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect();
        let corners: Vec<u32> = (0..outline.len() as u32).collect();
        let mut triangles = Vec::new();
        triangulate(&corners, &positions, &mut triangles);
        let mut area = 0.0;
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|at| positions[at as usize]);
            let twice = (b - a).cross(c - a).z;
            assert!(twice >= 0.0, "{triangle:?} faces away");
            area += twice / 2.0;
        }
        (triangles.len(), area)
    }

    #[test]
    fn convex_polygons_keep_their_area() {
        assert_eq!(area(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]), (2, 2.0));
        assert_eq!(area(&[[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [2.0, 2.0], [0.0, 2.0]]), (3, 5.0));
    }

    #[test]
    fn concave_polygons_are_not_fanned_across_their_notches() {
        // An arrow head, a U and a comb: fans from the first corner leave each of them.
        assert_eq!(area(&[[0.0, 0.0], [4.0, -3.0], [1.0, 0.0], [4.0, 3.0]]), (2, 3.0));
        let u =
            [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        assert_eq!(area(&u), (6, 7.0));
    }

    #[test]
    fn points_along_an_edge_lose_no_area() {
        assert_eq!(area(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]), (3, 4.0));
    }
}
