//! Refitting of a BVH to moved triangles.

use glam::Vec3;
use halflight_core::scene::Mesh;
use rayon::prelude::*;

use super::layout::{Child, Node, padded};
use super::{Bvh, BvhError, Extent};

/// Growth of the cost beyond which a refitted BVH is replaced by a new one.
///
/// Measured on atrium, toys and tree, bent, twisted, waved, and broken into runs of triangles carried off in
/// different directions. With a growth below 2, the cost was at most 1.5 times that of a new BVH, and rays
/// took at most 1.5 times as long. A growth of 3 to 22, by tearing, made rays 1.4 to 7 times slower. Twisting
/// alone makes new BVHs as costly as old ones: there a rebuild gains nothing, and takes some fifteen times as
/// long as a refit.
const WORN: f64 = 2.0;

impl Bvh {
    /// BVH over the same triangles in other positions: this one refitted, or a new one where triangles have
    /// moved so far relative to each other that the old tree would slow rays down. The choice depends on the
    /// two meshes alone. It is a new one, too, where other triangles have alpha masks.
    ///
    /// # Errors
    /// See [`Bvh::refit`].
    pub fn follow(&self, mesh: &Mesh) -> Result<Self, BvhError> {
        let mut moved = self.clone();
        match moved.refit(mesh) {
            Err(BvhError::Foreign) => return Self::build(mesh),
            refitted => refitted?,
        }
        if moved.cost() > WORN * self.cost() { Self::build(mesh) } else { Ok(moved) }
    }

    /// Refits the BVH to the same triangles in other positions: the tree stays, boxes and triangles are
    /// updated. Masks are those of a new BVH, bit for bit. `build_time` stays that of the build.
    ///
    /// Traversal time depends on how far triangles have moved relative to each other: see [`Bvh::cost`].
    ///
    /// # Errors
    /// See [`Bvh::build`]; also an error if the number of triangles differs, or other ones have alpha masks. The BVH
    /// is then unchanged.
    pub fn refit(&mut self, mesh: &Mesh) -> Result<(), BvhError> {
        if mesh.triangle_count() != self.triangle_count {
            let (found, expected) = (mesh.triangle_count(), self.triangle_count);
            return Err(BvhError::TriangleCount { found, expected });
        }
        let extent = Extent::of(mesh)?;
        if !self.is_parted_as(mesh) {
            return Err(BvhError::Foreign);
        }
        if let Some(masked) = &mut self.masked {
            masked.update(mesh, extent);
        }
        self.update(mesh, extent);
        Ok(())
    }

    /// Updates boxes and triangles of the nodes' own blocks.
    fn update(&mut self, mesh: &Mesh, extent: Extent) {
        self.extent = extent;
        let padding = extent.padding();
        let boxes: Vec<Bounds> = self
            .blocks
            .par_iter_mut()
            .map(|block| {
                block.update(mesh);
                Bounds::around(mesh, block.triangles()).padded(padding)
            })
            .collect();
        let mut around = vec![Bounds::NONE; self.nodes.len()];
        // Children come after their parents.
        for (index, node) in self.nodes.iter_mut().enumerate().rev() {
            for slot in node.slots() {
                let bounds = match Child::decode(node.child(slot)) {
                    Child::Node(child) => around[child as usize],
                    Child::Block(block) => boxes[block as usize],
                };
                node.set_bounds(slot, (bounds.low, bounds.high));
                around[index] = around[index].joined(bounds);
            }
        }
    }

    /// Expected number of children's boxes that a ray through the root meets: the sum of their surface areas
    /// over the root's. Alpha-masked triangles have a root of their own, whose number is added.
    ///
    /// The growth of this number after refits tells when to build a new BVH.
    pub fn cost(&self) -> f64 {
        let boxes = |node: &Node| node.slots().map(|slot| node.slot_bounds(slot)).collect::<Vec<_>>();
        let area = |(low, high): (Vec3, Vec3)| {
            let size = (high - low).as_dvec3();
            size.x * size.y + size.y * size.z + size.z * size.x
        };
        let masked = self.masked().map_or(0.0, Self::cost);
        let Some(root) = self.nodes.first() else { return masked };
        let whole = boxes(root).into_iter().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let sum: f64 = self.nodes.iter().flat_map(boxes).map(area).sum();
        masked + whole.map(area).filter(|&whole| whole > 0.0).map_or(0.0, |whole| sum / whole)
    }
}

#[derive(Clone, Copy)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn around(mesh: &Mesh, triangles: impl Iterator<Item = u32>) -> Self {
        let corners = triangles.flat_map(|triangle| mesh.corners(triangle as usize));
        corners.fold(Self::NONE, |bounds, corner| bounds.joined(Self { low: corner, high: corner }))
    }

    fn joined(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn padded(self, padding: f32) -> Self {
        let (low, high) = padded(self.low, self.high, padding);
        Self { low, high }
    }
}
