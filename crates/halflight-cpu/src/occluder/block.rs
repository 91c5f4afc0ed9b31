//! Blocks of eight triangles in structure-of-arrays form.

use glam::{DVec3, Vec3, Vec3Swizzles as _};
use halflight_core::scene::Mesh;

use super::expansion::Expansion;
use crate::simd::Lanes;
use crate::vector::Vector;

/// Up to eight triangles.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    corners: [[[f32; 8]; 3]; 3],
    /// Cross products of two edges, rounded once.
    normals: [[f32; 8]; 3],
    /// Largest component of any edge.
    longest: [f32; 8],
    /// The triangles' indices in the mesh.
    triangles: [u32; 8],
    /// Mask of the lanes that hold a triangle with a non-zero area.
    occupied: u32,
}

/// One triangle, prepared for a lane of a [`Block`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Triangle {
    corners: [[f32; 3]; 3],
    /// Cross product of two edges, rounded once.
    normal: [f32; 3],
    /// Largest component of any edge.
    longest: f32,
    /// Index in the mesh.
    index: u32,
    has_area: bool,
}

impl Triangle {
    pub(crate) fn new(mesh: &Mesh, index: u32) -> Self {
        let corners = mesh.corners(index as usize);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let normal = normal([a, b, c]);
        Self {
            corners: corners.map(|corner| corner.to_array()),
            normal: normal.as_vec3().to_array(),
            longest: (b - a).abs().max((c - b).abs()).max((a - c).abs()).max_element() as f32,
            index,
            has_area: normal != DVec3::ZERO,
        }
    }
}

/// Cross product of two edges, with a relative error below 2⁻²⁶ in each component despite cancellation. Zero
/// only for triangles without area.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (u, v) = (b - a, c - a);
    let (plus, minus) = (u.yzx() * v.zxy(), u.zxy() * v.yzx());
    let normal = plus - minus;
    // The cross product has four roundings of the two products.
    if normal.abs().cmpge((plus.abs() + minus.abs()) * 2f64.powi(-24)).all() {
        return normal;
    }
    // Slivers: double precision holds products of coordinates exactly.
    let terms = [a.yzx() * b.zxy(), b.yzx() * c.zxy(), c.yzx() * a.zxy()];
    let others = [a.zxy() * b.yzx(), b.zxy() * c.yzx(), c.zxy() * a.yzx()];
    let component = |axis: usize| {
        let [p, q, r] = terms.map(|term| term[axis]);
        let [x, y, z] = others.map(|term| -term[axis]);
        let mut sum = Expansion::ZERO;
        [p, q, r, x, y, z].into_iter().for_each(|term| sum.add(term));
        sum.value()
    };
    DVec3::new(component(0), component(1), component(2))
}

impl Block {
    pub(crate) const EMPTY: Self = Self {
        corners: [[[0.0; 8]; 3]; 3],
        normals: [[0.0; 8]; 3],
        longest: [0.0; 8],
        triangles: [u32::MAX; 8],
        occupied: 0,
    };

    pub(crate) fn new(mesh: &Mesh, triangles: &[u32]) -> Self {
        let mut block = Self::EMPTY;
        for (lane, &triangle) in triangles.iter().enumerate() {
            block.set_lane(lane, &Triangle::new(mesh, triangle));
        }
        block
    }

    /// Indices of the triangles in the mesh.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = u32> {
        self.triangles.iter().copied().take_while(|&triangle| triangle != u32::MAX)
    }

    /// Rebuilds the block from the same triangles of a mesh.
    pub(crate) fn update(&mut self, mesh: &Mesh) {
        let triangles = self.triangles;
        for (lane, triangle) in triangles.into_iter().take_while(|&triangle| triangle != u32::MAX).enumerate()
        {
            self.set_lane(lane, &Triangle::new(mesh, triangle));
        }
    }

    /// Sets a lane to a triangle.
    #[inline(always)]
    pub(crate) fn set_lane(&mut self, lane: usize, triangle: &Triangle) {
        for (to, from) in self.corners.iter_mut().zip(&triangle.corners) {
            for (to, from) in to.iter_mut().zip(from) {
                to[lane] = *from;
            }
        }
        for (to, from) in self.normals.iter_mut().zip(&triangle.normal) {
            to[lane] = *from;
        }
        self.longest[lane] = triangle.longest;
        self.triangles[lane] = triangle.index;
        self.occupied = self.occupied & !(1 << lane) | u32::from(triangle.has_area) << lane;
    }

    #[inline(always)]
    pub(crate) fn corners<L: Lanes>(&self) -> [Vector<L>; 3] {
        [
            Vector::load(&self.corners[0], 0),
            Vector::load(&self.corners[1], 0),
            Vector::load(&self.corners[2], 0),
        ]
    }

    #[inline(always)]
    pub(crate) fn normals<L: Lanes>(&self) -> Vector<L> {
        Vector::load(&self.normals, 0)
    }

    #[inline(always)]
    pub(crate) fn longest<L: Lanes>(&self) -> L {
        L::load(&self.longest)
    }

    /// Corners of one triangle.
    pub(crate) fn triangle_corners(&self, lane: usize) -> [Vec3; 3] {
        self.corners.map(|[x, y, z]| Vec3::new(x[lane], y[lane], z[lane]))
    }

    #[inline(always)]
    pub(crate) fn occupied(&self) -> u32 {
        self.occupied
    }

    #[inline(always)]
    pub(crate) fn triangle(&self, lane: usize) -> u32 {
        self.triangles[lane]
    }

    /// Copies one triangle of another block into a lane.
    #[inline(always)]
    pub(crate) fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
        for (to, from) in self.corners.iter_mut().flatten().zip(from.corners.iter().flatten()) {
            to[lane] = from[from_lane];
        }
        for (to, from) in self.normals.iter_mut().zip(&from.normals) {
            to[lane] = from[from_lane];
        }
        self.longest[lane] = from.longest[from_lane];
        self.triangles[lane] = from.triangles[from_lane];
        self.occupied |= 1 << lane;
    }

    /// Empties all lanes but the first `count`.
    #[inline(always)]
    pub(crate) fn truncate(&mut self, count: usize) {
        self.occupied &= (1 << count) - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_slivers_are_right() {
        // p, 2p and s: the normal is p × s. Its z is the 2⁻²³ that p's sides differ by, times s.
        let p = DVec3::new(1.0 + 2f64.powi(-23), 1.0, 0.0);
        for power in [-10, -30, -40, -80] {
            let s = DVec3::new(1.0, 1.0, 0.0) * 2f64.powi(power);
            let expected = DVec3::Z * 2f64.powi(power - 23);
            assert_eq!(normal([p, p * 2.0, s]), expected);
            assert_eq!(normal([s, p, p * 2.0]), expected);
            assert_eq!(normal([p, s, p * 2.0]), -expected);
        }
        // The plain cross product does not suffice.
        let s = DVec3::new(1.0, 1.0, 0.0) * 2f64.powi(-40);
        assert_ne!(p.cross(s - p), normal([p, p * 2.0, s]));
        assert_eq!(normal([p, p * 2.0, p * 3.0]), DVec3::ZERO);
        assert_eq!(normal([DVec3::ZERO, DVec3::X, DVec3::Y]), DVec3::Z);
    }
}
