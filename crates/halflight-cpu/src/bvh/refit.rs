//! Moving a BVH along with its triangles.

use glam::Vec3;
use halflight_core::scene::Mesh;
use rayon::prelude::*;

use super::layout::{Child, Node, padded};
use super::{Bvh, BvhError, Extent};

/// A refitted BVH that costs more than this many times what it did is not worth having.
///
/// Measured on atrium, toys and tree, bent, twisted, waved, and broken into runs of triangles carried off in different
/// directions: a cost grown less than twice was at most 1.5 times that of a new BVH, and rays took at most 1.5
/// times as long; a cost grown 3 to 22 times by tearing made rays 1.4 to 7 times slower. Twisting alone makes new
/// BVHs as costly as old ones: there a new one gains nothing, and takes some fifteen times as long as a refit.
const WORN: f64 = 2.0;

impl Bvh {
    /// A BVH over the same triangles in other places: this one refitted, or a new one where triangles have moved
    /// so far against each other that the old would slow rays down. Which of them it is depends on the two meshes alone.
    ///
    /// # Errors
    /// As [`Bvh::refit`].
    pub fn follow(&self, mesh: &Mesh) -> Result<Self, BvhError> {
        let mut moved = self.clone();
        moved.refit(mesh)?;
        if moved.cost() > WORN * self.cost() { Self::build(mesh) } else { Ok(moved) }
    }

    /// Fits the BVH to the same triangles in other places: the tree stays, boxes and triangles are made anew.
    /// Answers are those of a fresh build, bit for bit. `build_time` stays that of the build.
    ///
    /// How fast it answers depends on how far triangles have moved against each other: see [`Bvh::cost`].
    ///
    /// # Errors
    /// As [`Bvh::build`], and where the number of triangles is another. The BVH is then as it was.
    pub fn refit(&mut self, mesh: &Mesh) -> Result<(), BvhError> {
        if mesh.triangle_count() != self.triangle_count {
            let (found, expected) = (mesh.triangle_count(), self.triangle_count);
            return Err(BvhError::TriangleCount { found, expected });
        }
        self.extent = Extent::of(mesh)?;
        let padding = self.extent.padding();
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
        Ok(())
    }

    /// How many children's boxes a ray through the whole is expected to meet: the sum of their surfaces over the root's.
    ///
    /// Of a refitted BVH it tells when to build a new one.
    pub fn cost(&self) -> f64 {
        let boxes = |node: &Node| node.slots().map(|slot| node.slot_bounds(slot)).collect::<Vec<_>>();
        let area = |(low, high): (Vec3, Vec3)| {
            let size = (high - low).as_dvec3();
            size.x * size.y + size.y * size.z + size.z * size.x
        };
        let Some(root) = self.nodes.first() else { return 0.0 };
        let whole = boxes(root).into_iter().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let sum: f64 = self.nodes.iter().flat_map(boxes).map(area).sum();
        whole.map(area).filter(|&whole| whole > 0.0).map_or(0.0, |whole| sum / whole)
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
