//! Triangulation of polygons.

mod constrained;
mod ears;

use glam::{DVec2, DVec3, Vec2Swizzles, Vec3};

/// Most corners of a polygon that is triangulated by ear clipping, which takes quadratic time.
const MAX_EARS: usize = 32;

/// Appends the triangles of the polygon whose corners are `corners`, indices into `positions`.
///
/// Corners that repeat the one before add nothing. Strictly convex polygons become a fan. Others have their
/// ears clipped, where they are small, or become a constrained Delaunay triangulation in n log n: its
/// triangles inside the outline, so that polygons that touch themselves, such as those with holes on bridges,
/// keep their area. A polygon that crosses itself gets triangles as well; what they cover is not specified.
pub(crate) fn triangulate(corners: &[u32], positions: &[Vec3], triangles: &mut Vec<[u32; 3]>) {
    let position = |at: u32| positions[at as usize];
    if let &[a, b, c] = corners {
        return triangles.push([a, b, c]);
    }
    let Some(&last) = corners.last() else { return };
    let repeats = |before: u32, at: u32| before == at || position(before) == position(at);
    let mut before = last;
    let distinct: Vec<u32>;
    let repeated = corners.iter().any(|&at| repeats(std::mem::replace(&mut before, at), at));
    let corners = if repeated {
        let mut before = last;
        distinct =
            corners.iter().copied().filter(|&at| !repeats(std::mem::replace(&mut before, at), at)).collect();
        &distinct
    } else {
        corners
    };
    match corners {
        [] | [_] | [_, _] => return,
        &[a, b, c] => return triangles.push([a, b, c]),
        _ => {}
    }
    let flat = project(corners, positions);
    let count = corners.len();
    let convex = (0..count).all(|at| turn(flat[at], flat[(at + 1) % count], flat[(at + 2) % count]) > 0.0);
    let ears = if convex || count > MAX_EARS { None } else { Some(ears::clip(&flat)) };
    let found = match ears {
        None if convex => fan(count),
        Some((found, true)) => found,
        Some((found, false)) => constrained::triangulate(&flat).unwrap_or(found),
        None => constrained::triangulate(&flat).unwrap_or_else(|| fan(count)),
    };
    triangles.extend(found.into_iter().map(|triangle| triangle.map(|at| corners[at])));
}

fn fan(count: usize) -> Vec<[usize; 3]> {
    (1..count - 1).map(|at| [0, at, at + 1]).collect()
}

/// Projection of the polygon along the axis nearest to its vector area, counter-clockwise. Its coordinates
/// are those of the corners, so that collinear points stay collinear.
fn project(corners: &[u32], positions: &[Vec3]) -> Vec<DVec2> {
    let point = |at: u32| positions[at as usize].as_dvec3();
    // Newell's method, relative to the first corner, so that distant polygons keep their digits.
    let origin = point(corners[0]);
    let next = corners.iter().cycle().skip(1);
    let area: DVec3 =
        corners.iter().zip(next).map(|(&a, &b)| (point(a) - origin).cross(point(b) - origin)).sum();
    let flat = |p: DVec3| match area.abs().max_position() {
        0 => DVec2::new(p.y, p.z),
        1 => DVec2::new(p.z, p.x),
        _ => DVec2::new(p.x, p.y),
    };
    let mirrored = area[area.abs().max_position()] < 0.0;
    corners.iter().map(|&at| flat(point(at))).map(|p| if mirrored { p.yx() } else { p }).collect()
}

/// Twice the signed area of a triangle: positive for a left turn.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests;
