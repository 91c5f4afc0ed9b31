//! Cleaning of a loaded mesh: removes triangles without an area and unused vertices.

use glam::Vec3;
use halflight_core::scene::Mesh;
use rayon::prelude::*;

/// Removes the triangles of `mesh` that have no area or use a vertex twice, then the vertices that no
/// triangle uses. Returns the number of removed triangles.
pub(crate) fn drop_zero_area(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let keep: Vec<bool> =
        (0..before).into_par_iter().map(|triangle| has_area(mesh.corners(triangle))).collect();
    if keep.contains(&false) {
        let mut flags = keep.iter();
        mesh.triangles.retain(|_| flags.next().is_some_and(|&keep| keep));
        let mut flags = keep.iter();
        mesh.material_ids.retain(|_| flags.next().is_some_and(|&keep| keep));
    }
    drop_unused_vertices(mesh);
    before - mesh.triangles.len()
}

/// True if the area of a triangle is large enough for single precision.
fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let [u, v] = [(b - a), (c - a)];
    let [exact_u, exact_v] = [b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3()];
    // Limit on the square of the sine. In double precision the cross product of collinear single-precision
    // points is zero up to the last bits (1e-16); three points that are only nearly collinear have at least
    // 1e-7.
    let limit = 1e-20 * exact_u.length_squared() * exact_v.length_squared();
    let square = u.cross(v).length_squared();
    exact_u.cross(exact_v).length_squared() > limit && square > 0.0 && square.is_finite()
}

fn drop_unused_vertices(mesh: &mut Mesh) {
    const UNUSED: u32 = u32::MAX;
    let mut target = vec![UNUSED; mesh.positions.len()];
    for &vertex in mesh.triangles.as_flattened() {
        target[vertex as usize] = 0;
    }
    if !target.contains(&UNUSED) {
        return;
    }
    let mut count = 0;
    for (vertex, target) in target.iter_mut().enumerate() {
        if *target != UNUSED {
            *target = count;
            let to = count as usize;
            mesh.positions[to] = mesh.positions[vertex];
            mesh.normals[to] = mesh.normals[vertex];
            mesh.uvs[to] = mesh.uvs[vertex];
            count += 1;
        }
    }
    mesh.positions.truncate(count as usize);
    mesh.normals.truncate(count as usize);
    mesh.uvs.truncate(count as usize);
    for vertex in mesh.triangles.as_flattened_mut() {
        *vertex = target[*vertex as usize];
    }
}
