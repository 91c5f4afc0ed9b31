//! Boxes that a builder can part where very many triangles meet in a point.

use glam::Vec3;
use halflight_core::hash::{fold, sample_bits};
use halflight_core::scene::Mesh;

/// Triangles at one point from which on they are a crowd.
const CROWD: u32 = 512;

/// Number of triangles that meet at each point of a mesh.
///
/// obvhs joins boxes that are each other's nearest among their neighbours along a curve. Where boxes are equal, as those of
/// copies of a triangle, or grow steadily along the curve, as around a vertex of many triangles, few are, and building takes
/// quadratic time. Boxes of a crowd are enlarged by parts of their own, so that they differ.
pub(crate) struct Crowds<'a> {
    mesh: &'a Mesh,
    /// The place in `counts` of every vertex, by its position.
    places: Vec<u32>,
    counts: Vec<u32>,
}

impl<'a> Crowds<'a> {
    /// Counts the triangles of `mesh`.
    pub(crate) fn of(mesh: &'a Mesh) -> Self {
        // Two points at one place only make a crowd of fewer triangles.
        let mut counts = vec![0; mesh.positions.len().next_power_of_two().max(1 << 10)];
        let mask = counts.len() as u32 - 1;
        // Adding zero turns -0 into 0, which is the same point.
        let place =
            |position: &Vec3| (*position + 0.0).to_array().map(f32::to_bits).into_iter().fold(0, fold) & mask;
        let places: Vec<u32> = mesh.positions.iter().map(place).collect();
        for &vertex in mesh.triangles.as_flattened() {
            counts[places[vertex as usize] as usize] += 1;
        }
        Self { mesh, places, counts }
    }

    /// The lowest and highest coordinates of a triangle; in a crowd, of a box that is larger on each side by up to a hundredth.
    pub(crate) fn bounds(&self, triangle: usize) -> (Vec3, Vec3) {
        let [a, b, c] = self.mesh.corners(triangle);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let count = |vertex: u32| self.counts[self.places[vertex as usize] as usize];
        if self.mesh.triangles[triangle].iter().all(|&vertex| count(vertex) < CROWD) {
            return (low, high);
        }
        let part = |side: u32| (sample_bits(side, triangle as u32) >> 8) as f32 * (1e-2 / (1 << 24) as f32);
        let parts = |first: u32| Vec3::new(part(first), part(first + 1), part(first + 2));
        let size = high - low;
        (low - size * parts(0), high + size * parts(3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_of_a_crowd_differ_and_hold_their_triangles() {
        let count = 600;
        let rim = (0..count).map(|at| at as f32 * 0.01).map(|angle| Vec3::new(angle.cos(), 0.0, angle.sin()));
        let mut mesh = Mesh { positions: [Vec3::ZERO].into_iter().chain(rim).collect(), ..Mesh::default() };
        // A fan, copies of one triangle elsewhere, and one triangle by itself.
        mesh.triangles.extend((1..count).map(|at| [0, at, at + 1]));
        let copies = mesh.positions.len() as u32;
        mesh.positions.extend([Vec3::X * 9.0, Vec3::X * 9.0 + Vec3::Y, Vec3::X * 9.0 + Vec3::Z]);
        mesh.triangles.extend(vec![[copies, copies + 1, copies + 2]; count as usize]);
        let alone = mesh.positions.len() as u32;
        mesh.positions.extend([Vec3::Y * 5.0, Vec3::Y * 6.0, Vec3::Y * 5.0 + Vec3::X]);
        mesh.triangles.push([alone, alone + 1, alone + 2]);
        let crowds = Crowds::of(&mesh);
        let mut seen = std::collections::BTreeSet::new();
        for triangle in 0..mesh.triangle_count() {
            let (low, high) = crowds.bounds(triangle);
            seen.insert([low, high].map(|corner| corner.to_array().map(f32::to_bits)));
            let [a, b, c] = mesh.corners(triangle);
            let (least, most) = (a.min(b).min(c), a.max(b).max(c));
            assert!(low.cmple(least).all() && high.cmpge(most).all(), "{triangle}");
            let close = 0.0101 * (most - least);
            assert!((least - low).cmple(close).all() && (high - most).cmple(close).all(), "{triangle}");
            assert!(triangle + 1 < mesh.triangle_count() || (low, high) == (least, most));
        }
        assert_eq!(seen.len(), mesh.triangle_count());
    }
}
