//! Emitters: triangles that are connected across edges that are not sharp.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use halflight_core::scene::Mesh;

use crate::file::CREASE_DEG;

/// Most triangles at an edge that are compared with each other; edges of surfaces have two.
const AT_EDGE: usize = 8;

/// Triangles whose corners are numbered by position.
pub(super) struct Welded {
    pub(super) points: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Unit normals of the triangles.
    normals: Vec<DVec3>,
    /// Indices of the triangles in the mesh, in ascending order.
    numbers: Vec<usize>,
}

impl Welded {
    /// Triangles `numbers` of a mesh, without those that have no area.
    pub(super) fn of(mesh: &Mesh, numbers: &[usize]) -> Self {
        let mut welded =
            Self { points: Vec::new(), triangles: Vec::new(), normals: Vec::new(), numbers: Vec::new() };
        let mut known = HashMap::new();
        for &number in numbers {
            let corners = mesh.corners(number);
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
            let triangle = corners.map(|corner| {
                // The sum turns -0 into 0.
                *known.entry((corner + 0.0).to_array().map(f32::to_bits)).or_insert_with(|| {
                    welded.points.push(corner);
                    welded.points.len() as u32 - 1
                })
            });
            welded.triangles.push(triangle);
            welded.normals.push(normal);
            welded.numbers.push(number);
        }
        welded
    }

    /// Corners of a triangle.
    pub(super) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|point| self.points[point as usize].as_dvec3())
    }

    /// Index in the mesh of the first triangle of a patch.
    pub(super) fn first(&self, patch: &[usize]) -> usize {
        patch.first().map_or(usize::MAX, |&triangle| self.numbers[triangle])
    }

    /// First corner of the first triangle of a patch.
    pub(super) fn corner(&self, patch: &[usize]) -> Vec3 {
        patch.first().map_or(Vec3::ZERO, |&triangle| self.points[self.triangles[triangle][0] as usize])
    }
}

/// Returns the triangles of each emitter, in ascending order, emitters by their first triangle. Triangles are connected where they share
/// both ends of an edge at which their normals differ by less than the crease angle: sides of a box are emitters of their own, pieces of
/// a curved surface are one.
pub(super) fn patches(welded: &Welded) -> Vec<Vec<usize>> {
    let crease_cos = f64::from(CREASE_DEG).to_radians().cos();
    let mut sets = Sets { parents: (0..welded.triangles.len()).collect() };
    let mut edges: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    for (number, &[a, b, c]) in welded.triangles.iter().enumerate() {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let others = edges.entry([from.min(to), from.max(to)]).or_default();
            for &other in others.iter() {
                if welded.normals[number].dot(welded.normals[other]) > crease_cos {
                    sets.join(number, other);
                }
            }
            if others.len() < AT_EDGE {
                others.push(number);
            }
        }
    }
    let mut patches: Vec<Vec<usize>> = Vec::new();
    let mut known = HashMap::new();
    for number in 0..welded.triangles.len() {
        let patch = *known.entry(sets.root(number)).or_insert(patches.len());
        match patches.get_mut(patch) {
            Some(patch) => patch.push(number),
            None => patches.push(vec![number]),
        }
    }
    patches
}

/// Disjoint sets of triangles.
struct Sets {
    parents: Vec<usize>,
}

impl Sets {
    fn root(&mut self, mut at: usize) -> usize {
        while self.parents[at] != at {
            self.parents[at] = self.parents[self.parents[at]];
            at = self.parents[at];
        }
        at
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b)] = a.min(b);
    }
}
