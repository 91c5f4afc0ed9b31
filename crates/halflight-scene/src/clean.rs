//! Cleaning of a loaded mesh: triangles without an area go, missing normals are computed.

use std::collections::HashMap;

use glam::Vec3;
use halflight_core::scene::Mesh;

/// Faces that meet at a smaller angle share a computed vertex normal; across a larger one the edge stays sharp.
/// 65° keeps a six-sided column round (60° between its faces) and the edges of a box sharp.
const CREASE_COS: f32 = 0.422_618_26;

/// Removes the triangles of `mesh` that have no area or name a vertex twice, then the vertices that no triangle
/// uses. Returns how many triangles went.
pub(crate) fn drop_zero_area(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let keep: Vec<bool> = (0..before).map(|triangle| has_area(mesh.corners(triangle))).collect();
    let mut flags = keep.iter();
    mesh.triangles.retain(|_| flags.next().is_some_and(|&keep| keep));
    let mut flags = keep.iter();
    mesh.material_ids.retain(|_| flags.next().is_some_and(|&keep| keep));
    drop_unused_vertices(mesh);
    before - mesh.triangles.len()
}

/// Whether a triangle spans an area that single precision can still work with.
fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let [u, v] = [(b - a), (c - a)];
    let [exact_u, exact_v] = [b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3()];
    // In double precision the cross product of collinear single-precision points is zero up to the last bits
    // (1e-16); three points that are only nearly collinear are at least 1e-7 off.
    let sine = exact_u.cross(exact_v).length() / (exact_u.length() * exact_v.length());
    // NaN, for edges of zero length, must fail as well.
    sine > 1e-10 && u.cross(v).normalize_or_zero() != Vec3::ZERO
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

/// Gives every vertex whose normal is zero one of its own: the mean of the faces around its position, weighted by
/// their angle there (Thürmer and Wüthrich 1998: the same however polygons were triangulated), faces beyond a crease
/// left out. A vertex on a crease is split. Returns how many vertices got a normal.
///
/// Triangles must have an area.
pub(crate) fn compute_missing_normals(mesh: &mut Mesh) -> usize {
    let missing: Vec<bool> = mesh.normals.iter().map(|&normal| normal == Vec3::ZERO).collect();
    if !missing.contains(&true) {
        return 0;
    }
    let point_of = weld(&mesh.positions);
    let around = Incidence::new(mesh, &point_of);
    let faces: Vec<Vec3> = (0..mesh.triangles.len())
        .map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            (b - a).cross(c - a).normalize_or_zero()
        })
        .collect();
    let angles: Vec<f32> = (0..mesh.triangles.len()).flat_map(|at| corner_angles(mesh.corners(at))).collect();
    let mut splits: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    let mut computed = 0;
    for (triangle, &face) in faces.iter().enumerate() {
        for corner in 0..3 {
            let vertex = mesh.triangles[triangle][corner];
            if !missing[vertex as usize] {
                continue;
            }
            let sum: Vec3 = around
                .of(point_of[vertex as usize])
                .iter()
                .map(|&other| (faces[other as usize / 3], angles[other as usize]))
                .filter(|(other, _)| other.dot(face) > CREASE_COS)
                .map(|(other, angle)| other * angle)
                .sum();
            // The triangle itself stands in where rounding leaves no sum.
            let normal = sum.try_normalize().unwrap_or(face);
            let current = &mut mesh.normals[vertex as usize];
            if *current == Vec3::ZERO {
                *current = normal;
                computed += 1;
            } else if *current != normal {
                let split =
                    *splits.entry((vertex, normal.to_array().map(f32::to_bits))).or_insert_with(|| {
                        computed += 1;
                        mesh.positions.push(mesh.positions[vertex as usize]);
                        mesh.uvs.push(mesh.uvs[vertex as usize]);
                        mesh.normals.push(normal);
                        (mesh.positions.len() - 1) as u32
                    });
                mesh.triangles[triangle][corner] = split;
            }
        }
    }
    computed
}

/// The angles at the corners of a triangle, in radians.
fn corner_angles([a, b, c]: [Vec3; 3]) -> [f32; 3] {
    // Not by the arc cosine, which loses the small angles.
    let angle = |u: Vec3, v: Vec3| u.cross(v).length().atan2(u.dot(v));
    [angle(b - a, c - a), angle(c - b, a - b), angle(a - c, b - c)]
}

/// For every vertex the first vertex (in order) at exactly its position: seams of texture coordinates or materials
/// are not creases.
fn weld(positions: &[Vec3]) -> Vec<u32> {
    // Adding zero turns -0 into 0, which is the same place.
    let key = |vertex: u32| (positions[vertex as usize] + 0.0).to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
    let mut point_of = vec![0; positions.len()];
    for group in order.chunk_by(|&a, &b| key(a) == key(b)) {
        for &vertex in group {
            point_of[vertex as usize] = group[0];
        }
    }
    point_of
}

/// The triangle corners at every point, in one array.
struct Incidence {
    /// Where the corners of each point begin; one entry more than points.
    starts: Vec<u32>,
    /// Three times the triangle, plus 0, 1 or 2.
    corners: Vec<u32>,
}

impl Incidence {
    fn new(mesh: &Mesh, point_of: &[u32]) -> Self {
        let point = |vertex: u32| point_of[vertex as usize] as usize;
        let vertices = mesh.triangles.as_flattened();
        let mut starts = vec![0; mesh.positions.len() + 1];
        for &vertex in vertices {
            starts[point(vertex) + 1] += 1;
        }
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; vertices.len()];
        for (corner, &vertex) in vertices.iter().enumerate() {
            let slot = &mut next[point(vertex)];
            corners[*slot as usize] = corner as u32;
            *slot += 1;
        }
        Self { starts, corners }
    }

    fn of(&self, point: u32) -> &[u32] {
        let at = point as usize;
        &self.corners[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
}
