//! Rays whose visibility may depend on rounding: those that pass an edge, or end at a triangle, within the
//! error of single precision.

use halflight::glam::{DVec3, Vec3};
use halflight::scene::Mesh;

/// Least distance between a segment and any edge of the mesh, and between its ends and any triangle's plane
/// above or below that triangle, in double precision, metres. Triangles that have both ends on one side are
/// skipped: the shaders never count a triangle whose plane contains an end within rounding.
pub(crate) fn clearance(mesh: &Mesh, origin: Vec3, end: Vec3) -> f64 {
    let (origin, end) = (origin.as_dvec3(), end.as_dvec3());
    let of = |triangle: usize| {
        let corners @ [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        if normal.dot(origin - a) * normal.dot(end - a) > 0.0 {
            return f64::INFINITY;
        }
        let edges = [(a, b), (b, c), (c, a)].map(|(p, q)| between(origin, end, p, q));
        let ends = [origin, end].map(|point| above(point, corners));
        edges.into_iter().chain(ends).fold(f64::INFINITY, f64::min)
    };
    (0..mesh.triangle_count()).map(of).fold(f64::INFINITY, f64::min)
}

/// Distance between two segments.
fn between(a: DVec3, b: DVec3, p: DVec3, q: DVec3) -> f64 {
    let (u, v, w) = (b - a, q - p, a - p);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let (uw, vw) = (u.dot(w), v.dot(w));
    let determinant = uu * vv - uv * uv;
    let s = if determinant > 0.0 { ((uv * vw - vv * uw) / determinant).clamp(0.0, 1.0) } else { 0.0 };
    // Nearest point on one segment to the other's, and back again.
    let t = ((uv * s + vw) / vv).clamp(0.0, 1.0);
    let s = ((uv * t - uw) / uu).clamp(0.0, 1.0);
    (w + u * s - v * t).length()
}

/// Distance of a point from the plane of a triangle that it lies above or below; infinite elsewhere.
fn above(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| normal.dot((q - p).cross(point - p)) >= 0.0);
    if inside { (normal.normalize().dot(point - a)).abs() } else { f64::INFINITY }
}

#[test]
fn clearances_are_distances() {
    let mesh = halflight_tests::quads(&[(Vec3::ZERO, Vec3::X, Vec3::Y)]);
    let from = |x: f32, y: f32| clearance(&mesh, Vec3::new(x, y, -1.0), Vec3::new(x, y, 1.0));
    assert!((from(0.75, 1.25) - 0.25).abs() < 1e-9);
    // The diagonal is an edge.
    assert!((from(0.75, 0.25) - 0.125f64.sqrt().min(0.25)).abs() < 1e-9 && from(0.5, 0.5) < 1e-9);
    let ends = |z: f32| clearance(&mesh, Vec3::new(0.7, 0.2, z), Vec3::new(0.7, 0.2, 2.0));
    assert!((ends(-0.1) - 0.1).abs() < 1e-7 && ends(0.1) == f64::INFINITY);
}
