//! The hierarchy in memory: nodes of eight children and blocks of eight triangles, both arrays of lanes.

use std::time::Duration;

use glam::Vec3;
use halflight_core::scene::Mesh;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::crowds::Crowds;
use crate::occluder::{Block, Vector};
use crate::simd::Lanes;

/// Set in a child that is a block; the other bits are its index.
const BLOCK: u32 = 1 << 31;

/// The level from which on the binary hierarchy is no longer followed.
const DEEP: usize = 48;

/// Eight boxes and what is in them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    low: [[f32; 8]; 3],
    high: [[f32; 8]; 3],
    children: [u32; 8],
    /// One bit a child that exists.
    occupied: u32,
}

/// What a child is.
#[derive(Clone, Copy)]
pub(crate) enum Child {
    Node(u32),
    Block(u32),
}

impl Node {
    const EMPTY: Self = Self { low: [[0.0; 8]; 3], high: [[0.0; 8]; 3], children: [0; 8], occupied: 0 };

    /// The children's boxes, already padded.
    #[inline(always)]
    pub(crate) fn bounds<L: Lanes>(&self) -> (Vector<L>, Vector<L>) {
        (Vector::load(&self.low, 0), Vector::load(&self.high, 0))
    }

    /// One child's box in all lanes.
    #[inline(always)]
    pub(super) fn child_bounds<L: Lanes>(&self, child: usize) -> (Vector<L>, Vector<L>) {
        (Vector::broadcast(&self.low, child), Vector::broadcast(&self.high, child))
    }

    #[inline(always)]
    pub(crate) fn occupied(&self) -> u32 {
        self.occupied
    }

    /// The slots of children that exist.
    pub(super) fn slots(&self) -> impl Iterator<Item = usize> + use<> {
        let occupied = self.occupied;
        (0..8).filter(move |slot| occupied >> slot & 1 == 1)
    }

    /// A child's box.
    pub(super) fn slot_bounds(&self, slot: usize) -> (Vec3, Vec3) {
        let corner = |side: &[[f32; 8]; 3]| Vec3::from_array(side.map(|axis| axis[slot]));
        (corner(&self.low), corner(&self.high))
    }

    /// Sets a child's box, already padded.
    pub(super) fn set_bounds(&mut self, slot: usize, (low, high): (Vec3, Vec3)) {
        for axis in 0..3 {
            self.low[axis][slot] = low[axis];
            self.high[axis][slot] = high[axis];
        }
    }

    fn fill(&mut self, slot: usize, bounds: &Aabb, padding: f32, child: u32) {
        let [low, high] = [bounds.min, bounds.max].map(|corner| Vec3::new(corner[0], corner[1], corner[2]));
        self.set_bounds(slot, padded(low, high, padding));
        self.children[slot] = child;
        self.occupied |= 1 << slot;
    }

    #[inline(always)]
    pub(crate) fn child(&self, child: usize) -> u32 {
        self.children[child]
    }
}

impl Child {
    #[inline(always)]
    pub(crate) fn decode(child: u32) -> Self {
        if child & BLOCK == 0 { Self::Node(child) } else { Self::Block(child & !BLOCK) }
    }
}

/// A box enlarged by at least `padding` on all sides, and by a unit in the last place of its corners.
pub(super) fn padded(low: Vec3, high: Vec3, padding: f32) -> (Vec3, Vec3) {
    let (low, high) = ((low - padding).to_array(), (high + padding).to_array());
    (Vec3::from_array(low.map(f32::next_down)), Vec3::from_array(high.map(f32::next_up)))
}

/// Nodes and blocks. Node 0 is the root.
pub(super) fn build(mesh: &Mesh, padding: f32) -> (Vec<Node>, Vec<Block>) {
    if mesh.triangles.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let crowds = Crowds::of(mesh);
    let boxes: Vec<Aabb> = (0..mesh.triangle_count())
        .map(|triangle| {
            let (low, high) = crowds.bounds(triangle);
            Aabb::new(low.into(), high.into())
        })
        .collect();
    drop(crowds);
    let parameters = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
    let binary = build_bvh2(&boxes, parameters, &mut Duration::default());
    Flattener::new(mesh, &binary, padding).run()
}

/// Some triangles that follow each other in the binary hierarchy's order.
#[derive(Clone, Copy)]
struct Subtree {
    first: u32,
    count: u32,
    bounds: Aabb,
    /// The binary node over them; none below the level where the binary hierarchy is given up.
    binary: Option<u32>,
}

/// Turns a binary hierarchy into a wide one.
struct Flattener<'a> {
    mesh: &'a Mesh,
    binary: &'a Bvh2,
    /// Triangles in the order in which a walk through the binary hierarchy meets them.
    order: Vec<u32>,
    /// Where in that order each binary node's triangles start, and how many they are.
    ranges: Vec<(u32, u32)>,
    padding: f32,
    nodes: Vec<Node>,
    blocks: Vec<Block>,
}

impl<'a> Flattener<'a> {
    fn new(mesh: &'a Mesh, binary: &'a Bvh2, padding: f32) -> Self {
        let mut order = Vec::with_capacity(mesh.triangle_count());
        let mut ranges = vec![(0, 0); binary.nodes.len()];
        // Parents before children on this list, so that the way back meets children first.
        let mut walk = Vec::with_capacity(binary.nodes.len());
        let mut open = vec![0u32];
        while let Some(index) = open.pop() {
            walk.push(index);
            let node = &binary.nodes[index as usize];
            ranges[index as usize].0 = order.len() as u32;
            if node.is_leaf() {
                let slots = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                order.extend_from_slice(&binary.primitive_indices[slots]);
                ranges[index as usize].1 = node.prim_count;
            } else {
                open.extend([node.first_index + 1, node.first_index]);
            }
        }
        for &index in walk.iter().rev() {
            let node = &binary.nodes[index as usize];
            if !node.is_leaf() {
                let first = node.first_index as usize;
                ranges[index as usize].1 = ranges[first].1 + ranges[first + 1].1;
            }
        }
        Self { mesh, binary, order, ranges, padding, nodes: Vec::new(), blocks: Vec::new() }
    }

    fn run(mut self) -> (Vec<Node>, Vec<Block>) {
        self.nodes.push(Node::EMPTY);
        let mut open = vec![(self.subtree(0), 0usize, 1usize)];
        while let Some((subtree, wide, level)) = open.pop() {
            let (children, count) = self.children(subtree, level);
            for (slot, &child) in children[..count].iter().enumerate() {
                let reference = if child.count <= 8 {
                    let triangles = child.first as usize..(child.first + child.count) as usize;
                    self.blocks.push(Block::new(self.mesh, &self.order[triangles]));
                    (self.blocks.len() - 1) as u32 | BLOCK
                } else {
                    self.nodes.push(Node::EMPTY);
                    open.push((child, self.nodes.len() - 1, level + 1));
                    (self.nodes.len() - 1) as u32
                };
                self.nodes[wide].fill(slot, &child.bounds, self.padding, reference);
            }
        }
        self.nodes.shrink_to_fit();
        self.blocks.shrink_to_fit();
        (self.nodes, self.blocks)
    }

    fn subtree(&self, binary: u32) -> Subtree {
        let (first, count) = self.ranges[binary as usize];
        Subtree { first, count, bounds: *self.binary.nodes[binary as usize].aabb(), binary: Some(binary) }
    }

    /// Opens the largest of the boxes under a node until there are eight.
    fn children(&self, root: Subtree, level: usize) -> ([Subtree; 8], usize) {
        let mut children = [root; 8];
        let mut count = 1;
        while count < 8 {
            let largest = (0..count)
                .filter(|&slot| children[slot].count > 8)
                .max_by(|&a, &b| children[a].bounds.half_area().total_cmp(&children[b].bounds.half_area()));
            let Some(slot) = largest else { break };
            (children[slot], children[count]) = self.halves(children[slot], level);
            count += 1;
        }
        (children, count)
    }

    /// The two parts of a subtree of more than eight triangles. Copies of one triangle make the binary hierarchy as
    /// deep as they are many: far down, triangles are parted by number.
    fn halves(&self, subtree: Subtree, level: usize) -> (Subtree, Subtree) {
        if let (Some(binary), true) = (subtree.binary, level < DEEP) {
            let first = self.binary.nodes[binary as usize].first_index;
            return (self.subtree(first), self.subtree(first + 1));
        }
        let middle = subtree.count / 2;
        let part = |first: u32, count: u32| {
            let mut bounds = Aabb::INVALID;
            for &triangle in &self.order[first as usize..(first + count) as usize] {
                for corner in self.mesh.corners(triangle as usize) {
                    bounds.extend(corner.into());
                }
            }
            Subtree { first, count, bounds, binary: None }
        };
        (part(subtree.first, middle), part(subtree.first + middle, subtree.count - middle))
    }
}
