//! Rays whose visibility may depend on rounding: those that pass an edge or the border of a texel of an alpha mask, or end at a
//! triangle, within the error of single precision.

use halflight::alpha::AlphaMask;
use halflight::glam::{DVec2, DVec3, Vec3};
use halflight::scene::Mesh;

/// Least distance between a segment and any edge of the mesh or texel's border of its alpha masks, and between its ends and any
/// triangle's plane above or below that triangle, in double precision, metres. Triangles that have both ends on one side are
/// skipped: the shaders never count a triangle whose plane contains an end within rounding.
pub(crate) fn clearance(mesh: &Mesh, origin: Vec3, end: Vec3) -> f64 {
    clearance_among(mesh, |_| true, origin, end)
}

/// Clearance of the triangles that have an alpha mask.
pub(crate) fn masked_clearance(mesh: &Mesh, origin: Vec3, end: Vec3) -> f64 {
    clearance_among(mesh, |triangle| mesh.alpha_mask(triangle).is_some(), origin, end)
}

fn clearance_among(mesh: &Mesh, counts: impl Fn(usize) -> bool, origin: Vec3, end: Vec3) -> f64 {
    let (origin, end) = (origin.as_dvec3(), end.as_dvec3());
    let of = |triangle: usize| {
        let corners @ [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        if normal.dot(origin - a) * normal.dot(end - a) > 0.0 {
            return f64::INFINITY;
        }
        let edges = [(a, b), (b, c), (c, a)].map(|(p, q)| between(origin, end, p, q));
        let ends = [origin, end].map(|point| above(point, corners));
        let texels = texel_clearance(mesh, triangle, origin, end);
        edges.into_iter().chain(ends).chain([texels]).fold(f64::INFINITY, f64::min)
    };
    (0..mesh.triangle_count()).filter(|&triangle| counts(triangle)).map(of).fold(f64::INFINITY, f64::min)
}

/// Least distance between a line and the borders of the texel that it meets a triangle with an alpha mask in, metres; infinite where it
/// does not.
pub(crate) fn texel_clearance(mesh: &Mesh, triangle: usize, origin: DVec3, end: DVec3) -> f64 {
    let Some(mask) = mesh.alpha_mask(triangle) else { return f64::INFINITY };
    let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
    let (u, v, d) = (b - a, c - a, end - origin);
    let normal = u.cross(v);
    let hit = origin + d * (normal.dot(a - origin) / normal.dot(d));
    // Vectors whose products with a place, seen from the first corner, are the weights of the other two.
    let duals = [v.cross(normal), normal.cross(u)].map(|dual| dual / normal.length_squared());
    let weights = duals.map(|dual| dual.dot(hit - a));
    // A ray that passes outside within rounding is near an edge. NaN, in the triangle's plane, is no hit.
    if !(weights[0] >= 0.0 && weights[1] >= 0.0 && weights[0] + weights[1] <= 1.0) {
        return f64::INFINITY;
    }
    let size = DVec2::new(mask.width().into(), mask.height().into());
    let [first, second, third] =
        mesh.triangles[triangle].map(|vertex| mesh.uvs[vertex as usize].as_dvec2() * size);
    let border = |axis: usize| {
        let slope = duals[0] * (second - first)[axis] + duals[1] * (third - first)[axis];
        let at = first[axis] + slope.dot(hit - a);
        // Step in the plane to the nearest border, whose line is parallel to the other axis's.
        let step = slope * ((at.round() - at) / slope.length_squared());
        let across = normal.cross(slope).cross(d);
        (step.dot(across) / across.length()).abs()
    };
    border(0).min(border(1))
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

#[test]
fn clearances_of_texels_are_distances() {
    let mut mesh = halflight_tests::quads(&[(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y)]);
    mesh.uvs = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| (u, v).into()).to_vec();
    // Texels of 0.5 m x 0.25 m.
    mesh.alpha_masks = vec![AlphaMask::new(4, 4, [255; 16].into_iter(), 0.5).unwrap()];
    mesh.materials[0].alpha_mask = Some(0);
    let from = |x: f64, y: f64, lean: f64| {
        texel_clearance(&mesh, 0, DVec3::new(x - lean, y, -1.0), DVec3::new(x + lean, y, 1.0))
    };
    assert!((from(1.1, 0.33, 0.0) - 0.08).abs() < 1e-9 && (from(1.43, 0.38, 0.0) - 0.07).abs() < 1e-9);
    // Outside the first triangle.
    assert!(from(0.6, 0.33, 0.0) == f64::INFINITY && from(2.1, 0.33, 0.0) == f64::INFINITY);
    // A ray that leans by 45° passes the border at x = 0.5 nearer than it meets the plane from it.
    assert!((from(0.56, 0.12, 1.0) - 0.06 * 0.5f64.sqrt()).abs() < 1e-9);
    assert!(clearance(&mesh, Vec3::new(0.7, 0.26, -1.0), Vec3::new(0.7, 0.26, 1.0)) < 0.011);
    mesh.materials[0].alpha_mask = None;
    assert!(clearance(&mesh, Vec3::new(0.7, 0.26, -1.0), Vec3::new(0.7, 0.26, 1.0)) > 0.05);
}
