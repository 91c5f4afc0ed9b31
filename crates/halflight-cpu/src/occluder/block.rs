//! Eight triangles as arrays of lanes.

use glam::{DVec3, Vec3};
use halflight_core::scene::Mesh;

use super::vector::Vector;
use crate::simd::Lanes;

/// Up to eight triangles.
#[derive(Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    corners: [[[f32; 8]; 3]; 3],
    /// Products of two edges, rounded once.
    normals: [[f32; 8]; 3],
    /// Largest component of any edge.
    longest: [f32; 8],
    /// The triangles' indices in the mesh.
    triangles: [u32; 8],
    /// One bit a lane with a triangle that has an area.
    occupied: u32,
}

/// One triangle, as it is put into a [`Block`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Triangle {
    corners: [[f32; 3]; 3],
    /// Product of two edges, rounded once.
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
        let normal = (b - a).cross(c - a);
        Self {
            corners: corners.map(|corner| corner.to_array()),
            normal: normal.as_vec3().to_array(),
            longest: (b - a).abs().max((c - b).abs()).max((a - c).abs()).max_element() as f32,
            index,
            has_area: normal != DVec3::ZERO,
        }
    }
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

    /// Puts a triangle into a lane.
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

    /// The corners of one triangle.
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

    /// Makes all lanes but the first `count` empty.
    #[inline(always)]
    pub(crate) fn truncate(&mut self, count: usize) {
        self.occupied &= (1 << count) - 1;
    }
}
