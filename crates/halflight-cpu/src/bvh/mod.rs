//! Ray-traced visibility: a bounding-volume hierarchy (BVH) over the scene's triangles, traversed by packets
//! of rays.
//!
//! `build` makes nodes of eight children and blocks of eight triangles (`layout`). Ray–triangle intersection
//! is decided exactly (`occluder`); box tests (`slab`) are conservative. Packets (`any_hit`), single rays
//! (`single`) and a search through all triangles therefore agree hit for hit, for every instruction set.
//!
//! Triangles with an alpha mask lie in a second BVH (`Bvh::masked`): traversal of the first one, and the
//! visibility backends that collect triangles in it, need not know of them.

mod any_hit;
mod build;
mod closest_hit;
mod layout;
mod packet;
mod refit;
mod single;
mod slab;
mod stack;
#[cfg(test)]
pub(crate) mod tests;

use std::time::{Duration, Instant};

use glam::Vec3;
use halflight_core::scene::{Mesh, MeshError};
use rayon::prelude::*;

pub(crate) use closest_hit::Hits;
pub(crate) use layout::{Child, Node};
pub(crate) use packet::{Packet, RAYS};
pub(crate) use slab::Shaft;
pub(crate) use stack::{STACK, Stacks, push_near_last};

use crate::occluder::Block;

/// Reason for which no BVH can be built over a mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BvhError {
    /// Invalid mesh: its arrays are inconsistent.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The BVH is over another mesh, or over the same one before it moved.
    #[error(
        "the BVH is not over the scene's mesh: build one with Bvh::build, or refit it after the mesh has moved"
    )]
    Foreign,
    /// Different number of triangles: the BVH cannot be refitted to the mesh.
    #[error("the mesh has {found} triangles, but the BVH is over {expected}: build a new one")]
    TriangleCount {
        /// Number of triangles of the mesh.
        found: usize,
        /// Number of triangles of the BVH.
        expected: usize,
    },
}

/// Bounding-volume hierarchy over the triangles of one mesh.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Nodes and blocks of the triangles without an alpha mask.
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<Block>,
    /// BVH over the triangles with an alpha mask, if there are any; it has the extent and the triangle count of
    /// the whole mesh.
    masked: Option<Box<Bvh>>,
    extent: Extent,
    triangle_count: usize,
    build_time: Duration,
}

impl Bvh {
    /// Builds the BVH. Over a mesh without triangles, every ray misses.
    ///
    /// # Errors
    /// The mesh does not validate.
    pub fn build(mesh: &Mesh) -> Result<Self, BvhError> {
        let start = Instant::now();
        let extent = Extent::of(mesh)?;
        let over = |masked: bool| {
            let (nodes, blocks) = build::build(mesh, extent.padding(), masked);
            let (triangle_count, build_time) = (mesh.triangle_count(), start.elapsed());
            Self { nodes, blocks, masked: None, extent, triangle_count, build_time }
        };
        let masked = (!mesh.alpha_masks.is_empty()).then(|| Box::new(over(true)));
        let masked = masked.filter(|masked| !masked.nodes.is_empty());
        Ok(Self { masked, ..over(false) })
    }

    /// BVH over the triangles with an alpha mask, which are in no node of this one; none where there are none.
    pub(crate) fn masked(&self) -> Option<&Self> {
        self.masked.as_deref()
    }

    /// Time that building took.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let masked = self.masked().map_or(0, |masked| size_of::<Self>() + masked.bytes());
        self.nodes.capacity() * size_of::<Node>() + self.blocks.capacity() * size_of::<Block>() + masked
    }

    /// Diagonal of the smallest box around the mesh, metres.
    pub fn diagonal(&self) -> f32 {
        self.extent.diagonal
    }

    /// Largest absolute coordinate of any corner.
    pub(crate) fn largest(&self) -> f32 {
        self.extent.largest
    }

    /// Triangles whose boxes may touch a box, in no particular order, alpha-masked ones included.
    pub(crate) fn triangles_in(&self, low: Vec3, high: Vec3) -> Vec<u32> {
        let mut found = self.masked().map_or_else(Vec::new, |masked| masked.triangles_in(low, high));
        self.any_block_in(low, high, |block| {
            found.extend(block.triangles());
            false
        });
        found
    }

    /// True if the box of a triangle may touch a box; alpha-masked ones included.
    pub(crate) fn has_triangle_in(&self, low: Vec3, high: Vec3) -> bool {
        self.any_block_in(low, high, |_| true)
            || self.masked().is_some_and(|masked| masked.has_triangle_in(low, high))
    }

    /// True if `test` is for one of the blocks whose boxes touch a box.
    fn any_block_in(&self, low: Vec3, high: Vec3, mut test: impl FnMut(&Block) -> bool) -> bool {
        let mut waiting = Vec::new();
        waiting.extend(self.nodes.first().map(|_| 0));
        while let Some(index) = waiting.pop() {
            let node = &self.nodes[index as usize];
            for slot in node.slots() {
                let (from, to) = node.slot_bounds(slot);
                if !(from.cmple(high).all() && to.cmpge(low).all()) {
                    continue;
                }
                match Child::decode(node.child(slot)) {
                    Child::Node(child) => waiting.push(child),
                    Child::Block(block) if test(&self.blocks[block as usize]) => return true,
                    Child::Block(_) => {}
                }
            }
        }
        false
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// True if the BVH matches this mesh: equally many triangles with the same corners, and alpha masks for the
    /// same ones of them.
    pub fn is_over(&self, mesh: &Mesh) -> bool {
        let over = |bvh: &Self| {
            bvh.blocks.par_iter().with_min_len(1024).all(|block| {
                (0..).zip(block.triangles()).all(|(lane, triangle)| {
                    (triangle as usize) < mesh.triangle_count()
                        && block.triangle_corners(lane) == mesh.corners(triangle as usize)
                })
            })
        };
        mesh.triangle_count() == self.triangle_count
            && over(self)
            && self.masked().is_none_or(over)
            && self.is_parted_as(mesh)
    }

    /// True if the triangles of a mesh with as many have alpha masks where those of the BVH have.
    fn is_parted_as(&self, mesh: &Mesh) -> bool {
        let all = |bvh: &Self, masked: bool| {
            let mut triangles = bvh.blocks.iter().flat_map(Block::triangles);
            triangles.all(|triangle| mesh.alpha_mask(triangle as usize).is_some() == masked)
        };
        match self.masked() {
            Some(masked) => all(masked, true) && all(self, false),
            None => mesh.alpha_masks.is_empty() || all(self, false),
        }
    }
}

/// Size of a mesh.
#[derive(Clone, Copy, Debug)]
struct Extent {
    diagonal: f32,
    /// Largest absolute coordinate of any corner.
    largest: f32,
}

impl Extent {
    /// Extent of a mesh; an error if the mesh does not validate.
    fn of(mesh: &Mesh) -> Result<Self, BvhError> {
        mesh.validate()?;
        let (low, high) = mesh.bounds().unwrap_or_default();
        Ok(Self { diagonal: (high - low).length(), largest: low.abs().max(high.abs()).max_element() })
    }

    /// Padding of all boxes before they are rounded outwards. A tiny value suffices: it is for rays that run
    /// in a box's side.
    fn padding(self) -> f32 {
        self.largest * 2f32.powi(-40)
    }
}
