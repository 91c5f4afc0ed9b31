//! Ray-traced visibility: a bounding-volume hierarchy (BVH) over the scene's triangles, traversed by packets
//! of rays.
//!
//! `build` makes nodes of eight children and blocks of eight triangles (`layout`). Ray–triangle intersection
//! is decided exactly (`occluder`); box tests (`slab`) are conservative. Packets (`any_hit`), single rays
//! (`single`) and a search through all triangles therefore agree hit for hit, for every instruction set.

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
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<Block>,
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
        let (nodes, blocks) = build::build(mesh, extent.padding());
        Ok(Self { nodes, blocks, extent, triangle_count: mesh.triangle_count(), build_time: start.elapsed() })
    }

    /// Time that building took.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.blocks.capacity() * size_of::<Block>()
    }

    /// Diagonal of the smallest box around the mesh, metres.
    pub fn diagonal(&self) -> f32 {
        self.extent.diagonal
    }

    /// Largest absolute coordinate of any corner.
    pub(crate) fn largest(&self) -> f32 {
        self.extent.largest
    }

    /// Triangles whose boxes may touch a box, in no particular order.
    pub(crate) fn triangles_in(&self, low: Vec3, high: Vec3) -> Vec<u32> {
        let (mut found, mut waiting) = (Vec::new(), Vec::new());
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
                    Child::Block(block) => found.extend(self.blocks[block as usize].triangles()),
                }
            }
        }
        found
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// True if the BVH matches this mesh: equally many triangles with the same corners.
    pub fn is_over(&self, mesh: &Mesh) -> bool {
        mesh.triangle_count() == self.triangle_count
            && self.blocks.par_iter().with_min_len(1024).all(|block| {
                (0..).zip(block.triangles()).all(|(lane, triangle)| {
                    (triangle as usize) < mesh.triangle_count()
                        && block.triangle_corners(lane) == mesh.corners(triangle as usize)
                })
            })
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
