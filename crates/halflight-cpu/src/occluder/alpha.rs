//! Alpha test of a hit.

use glam::{DVec3, Vec3};
use halflight_core::scene::Mesh;

/// True if the point where the line from `origin` along `d` meets a triangle is solid. The line must meet the triangle.
///
/// The point's weights are those of the three tetrahedra that the line and the edges span. All hits are tested here, by the same operations
/// in double precision, so that whoever finds one takes the same texel.
pub(crate) fn is_solid(mesh: &Mesh, triangle: u32, origin: Vec3, d: DVec3) -> bool {
    let Some(mask) = mesh.alpha_mask(triangle as usize) else { return true };
    let vertices = mesh.triangles[triangle as usize].map(|vertex| vertex as usize);
    let [a, b, c] = vertices.map(|vertex| mesh.positions[vertex].as_dvec3() - origin.as_dvec3());
    let weights = [(b, c), (c, a), (a, b)].map(|(p, q)| d.dot(p.cross(q)));
    let sum = weights[0] + weights[1] + weights[2];
    // Slivers whose weights cancel take their middle.
    let weight = |corner: usize| if sum == 0.0 { 1.0 / 3.0 } else { (weights[corner] / sum).clamp(0.0, 1.0) };
    let uv = |corner: usize| mesh.uvs[vertices[corner]].as_dvec2();
    mask.is_solid(uv(0) * weight(0) + uv(1) * weight(1) + uv(2) * weight(2))
}
