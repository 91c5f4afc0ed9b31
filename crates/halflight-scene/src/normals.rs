//! Computation of missing vertex normals.

mod incidence;

use std::collections::{HashMap, HashSet};

use glam::Vec3;
use halflight_core::scene::Mesh;
use rayon::prelude::*;

use incidence::Incidence;

/// Most faces at a point that are compared pair by pair. At other points they are grouped by direction, so
/// that the time stays linear.
const MAX_PAIRED: usize = 128;

/// Number of direction cells along each side of a cube.
const CELLS: f32 = 16.0;

/// Number of points that one task takes.
const POINTS: usize = 1 << 12;

/// Computes a normal for every vertex whose normal is zero: the mean of the faces around its position,
/// weighted by their angle there (Thürmer and Wüthrich 1998: independent of the triangulation), without faces
/// beyond a crease: an edge at which faces meet at more than `crease_deg` degrees. A vertex on a crease is split. Returns the number of vertices with a computed normal.
///
/// Around points of more than 128 faces, faces of nearly one direction (within 6°) are grouped: they get one
/// normal, and lie on one side of a crease.
///
/// Triangles must have an area.
pub(crate) fn compute_missing_normals(mesh: &mut Mesh, crease_deg: f32) -> usize {
    let crease_cos = crease_deg.to_radians().cos();
    let missing: Vec<bool> = mesh.normals.iter().map(|&normal| normal == Vec3::ZERO).collect();
    if !missing.contains(&true) {
        return 0;
    }
    let around = Incidence::new(mesh);
    let points: Vec<_> = (0..around.points()).step_by(POINTS).collect();
    let shared = &*mesh;
    let computed: Vec<Computed> = points
        .into_par_iter()
        .map(|first| {
            let mut computed = Computed::default();
            for point in first..(first + POINTS).min(around.points()) {
                computed.add_point(shared, &missing, around.of(point), crease_cos);
            }
            computed
        })
        .collect();
    let mut count = 0;
    for Computed { normals, moved, .. } in computed {
        count += normals.len();
        let mut vertices = Vec::with_capacity(normals.len());
        for Normal { vertex, normal, first } in normals {
            if first {
                mesh.normals[vertex as usize] = normal;
                vertices.push(vertex);
            } else {
                vertices.push(mesh.positions.len() as u32);
                mesh.positions.push(mesh.positions[vertex as usize]);
                mesh.uvs.push(mesh.uvs[vertex as usize]);
                mesh.normals.push(normal);
            }
        }
        let corners = mesh.triangles.as_flattened_mut();
        for (corner, normal) in moved {
            corners[corner as usize] = vertices[normal];
        }
    }
    count
}

/// Normal of a vertex.
struct Normal {
    vertex: u32,
    normal: Vec3,
    /// True for the vertex's first normal, which needs no new vertex.
    first: bool,
}

/// Normals around a range of points.
#[derive(Default)]
struct Computed {
    normals: Vec<Normal>,
    /// Corners that get a new vertex, and the index of its normal.
    moved: Vec<(u32, usize)>,
    faces: Vec<Face>,
}

/// Face at a point.
#[derive(Clone, Copy)]
struct Face {
    normal: Vec3,
    /// Normal times the angle at the point.
    weighted: Vec3,
}

impl Computed {
    /// Adds a point with triangle corners around it.
    fn add_point(&mut self, mesh: &Mesh, missing: &[bool], corners: &[u32], crease_cos: f32) {
        let vertices = mesh.triangles.as_flattened();
        let needs = |corner: &u32| missing[vertices[*corner as usize] as usize];
        if !corners.iter().any(needs) {
            return;
        }
        self.faces.clear();
        self.faces.extend(corners.iter().map(|&corner| face(mesh, corner)));
        let grouped = (corners.len() > MAX_PAIRED).then(|| group(&self.faces, crease_cos));
        let first = self.normals.len();
        let mut by_group = HashMap::new();
        let mut begun = HashSet::new();
        for (at, &corner) in corners.iter().enumerate().filter(|(_, corner)| needs(corner)) {
            let vertex = vertices[corner as usize];
            let known = match &grouped {
                None => {
                    let normal = mean(self.faces[at].normal, &self.faces, crease_cos);
                    let known = self.normals[first..]
                        .iter()
                        .position(|known| known.vertex == vertex && known.normal == normal);
                    known.map_or_else(
                        || {
                            self.add_normal(
                                vertex,
                                normal,
                                !self.normals[first..].iter().any(|n| n.vertex == vertex),
                            )
                        },
                        |known| first + known,
                    )
                }
                Some((groups, normals)) => *by_group
                    .entry((vertex, groups[at]))
                    .or_insert_with(|| self.add_normal(vertex, normals[groups[at]], begun.insert(vertex))),
            };
            if !self.normals[known].first {
                self.moved.push((corner, known));
            }
        }
    }

    /// Adds a normal; returns its index.
    fn add_normal(&mut self, vertex: u32, normal: Vec3, first: bool) -> usize {
        self.normals.push(Normal { vertex, normal, first });
        self.normals.len() - 1
    }
}

/// Face at a corner, which is three times the triangle plus 0, 1 or 2.
fn face(mesh: &Mesh, corner: u32) -> Face {
    let [a, b, c] = mesh.corners(corner as usize / 3);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    // Angle between the edges at the corner. The arc cosine would lose small angles.
    let (u, v) = match corner % 3 {
        0 => (b - a, c - a),
        1 => (c - b, a - b),
        _ => (a - c, b - c),
    };
    Face { normal, weighted: normal * u.cross(v).length().atan2(u.dot(v)) }
}

/// Mean of the faces that are not beyond a crease from one with `normal`; falls back to `normal` where the
/// sum vanishes.
fn mean(normal: Vec3, faces: &[Face], crease_cos: f32) -> Vec3 {
    let near = faces.iter().filter(|other| other.normal.dot(normal) > crease_cos);
    near.map(|other| other.weighted).sum::<Vec3>().try_normalize().unwrap_or(normal)
}

/// Groups faces by direction. Returns the group of every face, and the normal of every group.
fn group(faces: &[Face], crease_cos: f32) -> (Vec<usize>, Vec<Vec3>) {
    let mut known = HashMap::new();
    let mut groups: Vec<Face> = Vec::new();
    let of_face: Vec<usize> = faces
        .iter()
        .map(|face| {
            let group = *known.entry(cell(face.normal)).or_insert(groups.len());
            match groups.get_mut(group) {
                Some(sum) => {
                    sum.normal += face.normal;
                    sum.weighted += face.weighted;
                }
                None => groups.push(*face),
            }
            group
        })
        .collect();
    for group in &mut groups {
        group.normal = group.normal.normalize_or_zero();
    }
    let normals = groups.iter().map(|group| mean(group.normal, &groups, crease_cos)).collect();
    (of_face, normals)
}

/// Cell of a direction on the surface of a cube: side, and position on it.
fn cell(direction: Vec3) -> (usize, bool, [u8; 2]) {
    let axis = direction.abs().max_position();
    let across = match axis {
        0 => [direction.y, direction.z],
        1 => [direction.z, direction.x],
        _ => [direction.x, direction.y],
    };
    let length = direction[axis].abs().max(f32::MIN_POSITIVE);
    let place = across.map(|along| ((along / length + 1.0) * (CELLS / 2.0)) as u8);
    (axis, direction[axis] < 0.0, place)
}
