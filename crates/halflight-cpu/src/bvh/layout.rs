//! The hierarchy in memory: nodes of eight children and blocks of eight triangles, both arrays of lanes.

use std::time::Duration;

use halflight_core::scene::Mesh;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::vector::Vector;
use crate::simd::Lanes;

/// Set in a child that is a block; the other bits are its index.
const BLOCK: u32 = 1 << 31;

/// Eight boxes and what is in them.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    low: [[f32; 8]; 3],
    high: [[f32; 8]; 3],
    children: [u32; 8],
    /// One bit a child that exists.
    occupied: u32,
}

/// What a child is.
#[derive(Clone, Copy)]
pub(super) enum Child {
    Node(u32),
    Block(u32),
}

/// Up to eight triangles; the lanes left over hold copies of one corner, which nothing hits.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    corners: [[[f32; 8]; 3]; 3],
    /// The triangles' indices in the mesh.
    triangles: [u32; 8],
}

impl Node {
    const EMPTY: Self = Self { low: [[0.0; 8]; 3], high: [[0.0; 8]; 3], children: [0; 8], occupied: 0 };

    /// The children's boxes, already padded.
    #[inline(always)]
    pub(super) fn bounds<L: Lanes>(&self) -> (Vector<L>, Vector<L>) {
        (Vector::load(&self.low, 0), Vector::load(&self.high, 0))
    }

    /// One child's box in all lanes.
    #[inline(always)]
    pub(super) fn child_bounds<L: Lanes>(&self, child: usize) -> (Vector<L>, Vector<L>) {
        (Vector::broadcast(&self.low, child), Vector::broadcast(&self.high, child))
    }

    #[inline(always)]
    pub(super) fn occupied(&self) -> u32 {
        self.occupied
    }

    #[inline(always)]
    pub(super) fn child(&self, child: usize) -> u32 {
        self.children[child]
    }
}

impl Child {
    #[inline(always)]
    pub(super) fn decode(child: u32) -> Self {
        if child & BLOCK == 0 { Self::Node(child) } else { Self::Block(child & !BLOCK) }
    }
}

impl Block {
    fn new(mesh: &Mesh, triangles: &[u32]) -> Self {
        let filler = mesh.corners(triangles[0] as usize)[0];
        let mut block = Self { corners: [[[0.0; 8]; 3]; 3], triangles: [u32::MAX; 8] };
        for lane in 0..8 {
            let corners =
                triangles.get(lane).map_or([filler; 3], |&triangle| mesh.corners(triangle as usize));
            for (to, corner) in block.corners.iter_mut().zip(corners) {
                for axis in 0..3 {
                    to[axis][lane] = corner[axis];
                }
            }
        }
        block.triangles[..triangles.len()].copy_from_slice(triangles);
        block
    }

    #[inline(always)]
    pub(super) fn corners<L: Lanes>(&self) -> [Vector<L>; 3] {
        [
            Vector::load(&self.corners[0], 0),
            Vector::load(&self.corners[1], 0),
            Vector::load(&self.corners[2], 0),
        ]
    }

    /// One triangle's corners in all lanes.
    #[inline(always)]
    pub(super) fn triangle_corners<L: Lanes>(&self, lane: usize) -> [Vector<L>; 3] {
        [
            Vector::broadcast(&self.corners[0], lane),
            Vector::broadcast(&self.corners[1], lane),
            Vector::broadcast(&self.corners[2], lane),
        ]
    }

    #[inline(always)]
    pub(super) fn triangle(&self, lane: usize) -> u32 {
        self.triangles[lane]
    }
}

/// The padded boxes of triangles.
#[inline(always)]
pub(super) fn boxes<L: Lanes>(corners: &[Vector<L>; 3], padding: f32) -> (Vector<L>, Vector<L>) {
    let padding = L::splat(padding);
    let padding = Vector { x: padding, y: padding, z: padding };
    let [a, b, c] = *corners;
    (a.min(b).min(c).sub(padding), a.max(b).max(c).add(padding))
}

/// Nodes, blocks and the number of levels. Node 0 is the root.
pub(super) fn build(mesh: &Mesh, padding: f32) -> (Vec<Node>, Vec<Block>, usize) {
    if mesh.triangles.is_empty() {
        return (Vec::new(), Vec::new(), 0);
    }
    let boxes: Vec<Aabb> = (0..mesh.triangle_count())
        .map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            Aabb::new(a.min(b).min(c).into(), a.max(b).max(c).into())
        })
        .collect();
    let parameters = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
    let binary = build_bvh2(&boxes, parameters, &mut Duration::default());
    Flattener::new(mesh, &binary, padding).run()
}

/// Turns a binary hierarchy into a wide one.
struct Flattener<'a> {
    mesh: &'a Mesh,
    binary: &'a Bvh2,
    /// Triangles under each binary node.
    counts: Vec<u32>,
    padding: f32,
    nodes: Vec<Node>,
    blocks: Vec<Block>,
}

impl<'a> Flattener<'a> {
    fn new(mesh: &'a Mesh, binary: &'a Bvh2, padding: f32) -> Self {
        let mut counts = vec![0; binary.nodes.len()];
        // Parents before children on this list, so that the way back meets children first.
        let mut order = vec![0u32];
        let mut next = 0;
        while let Some(&index) = order.get(next) {
            let node = &binary.nodes[index as usize];
            if !node.is_leaf() {
                order.extend([node.first_index, node.first_index + 1]);
            }
            next += 1;
        }
        for &index in order.iter().rev() {
            let node = &binary.nodes[index as usize];
            counts[index as usize] = if node.is_leaf() {
                node.prim_count
            } else {
                counts[node.first_index as usize] + counts[node.first_index as usize + 1]
            };
        }
        Self { mesh, binary, counts, padding, nodes: Vec::new(), blocks: Vec::new() }
    }

    fn run(mut self) -> (Vec<Node>, Vec<Block>, usize) {
        self.nodes.push(Node::EMPTY);
        let mut depth = 1;
        let mut open = vec![(0u32, 0usize, 1usize)];
        while let Some((binary, wide, level)) = open.pop() {
            depth = depth.max(level);
            let (children, count) = self.children(binary);
            for (slot, &child) in children[..count].iter().enumerate() {
                let reference = if self.fits_block(child) {
                    self.push_block(child);
                    (self.blocks.len() - 1) as u32 | BLOCK
                } else {
                    self.nodes.push(Node::EMPTY);
                    open.push((child, self.nodes.len() - 1, level + 1));
                    (self.nodes.len() - 1) as u32
                };
                self.fill(wide, slot, child, reference);
            }
        }
        self.nodes.shrink_to_fit();
        self.blocks.shrink_to_fit();
        (self.nodes, self.blocks, depth)
    }

    fn fits_block(&self, binary: u32) -> bool {
        self.counts[binary as usize] <= 8
    }

    /// Opens the largest of the boxes under a binary node until there are eight.
    fn children(&self, root: u32) -> ([u32; 8], usize) {
        let mut children = [root; 8];
        let mut count = 1;
        while count < 8 {
            let largest = (0..count)
                .filter(|&slot| !self.fits_block(children[slot]))
                .map(|slot| (slot, self.binary.nodes[children[slot] as usize].aabb().half_area()))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((slot, _)) = largest else { break };
            let first = self.binary.nodes[children[slot] as usize].first_index;
            (children[slot], children[count]) = (first, first + 1);
            count += 1;
        }
        (children, count)
    }

    fn fill(&mut self, wide: usize, slot: usize, child: u32, reference: u32) {
        let bounds = self.binary.nodes[child as usize].aabb();
        let node = &mut self.nodes[wide];
        for axis in 0..3 {
            node.low[axis][slot] = bounds.min[axis] - self.padding;
            node.high[axis][slot] = bounds.max[axis] + self.padding;
        }
        node.children[slot] = reference;
        node.occupied |= 1 << slot;
    }

    fn push_block(&mut self, binary: u32) {
        let mut triangles = [0u32; 8];
        let mut count = 0;
        // A subtree of eight leaves leaves at most seven siblings behind.
        let mut open = [binary; 8];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let node = &self.binary.nodes[open[waiting] as usize];
            if node.is_leaf() {
                for slot in node.first_index..node.first_index + node.prim_count {
                    triangles[count] = self.binary.primitive_indices[slot as usize];
                    count += 1;
                }
            } else {
                (open[waiting], open[waiting + 1]) = (node.first_index + 1, node.first_index);
                waiting += 2;
            }
        }
        self.blocks.push(Block::new(self.mesh, &triangles[..count]));
    }
}
