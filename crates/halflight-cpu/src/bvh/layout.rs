//! Memory layout of the BVH: nodes of eight children and blocks of eight triangles, both in
//! structure-of-arrays form.

use glam::Vec3;

use crate::simd::Lanes;
use crate::vector::Vector;

/// Flag of a child that is a block; the other bits are the child's index.
pub(super) const BLOCK: u32 = 1 << 31;

/// Node: the boxes of up to eight children and references to them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    low: [[f32; 8]; 3],
    high: [[f32; 8]; 3],
    children: [u32; 8],
    /// Mask of the slots that hold a child.
    occupied: u32,
}

/// Reference to a child of a node.
#[derive(Clone, Copy)]
pub(crate) enum Child {
    Node(u32),
    Block(u32),
}

impl Node {
    pub(super) const EMPTY: Self =
        Self { low: [[0.0; 8]; 3], high: [[0.0; 8]; 3], children: [0; 8], occupied: 0 };

    /// Boxes of the children, already padded.
    #[inline(always)]
    pub(crate) fn bounds<L: Lanes>(&self) -> (Vector<L>, Vector<L>) {
        (Vector::load(&self.low, 0), Vector::load(&self.high, 0))
    }

    /// Box of one child, broadcast to all lanes.
    #[inline(always)]
    pub(super) fn child_bounds<L: Lanes>(&self, child: usize) -> (Vector<L>, Vector<L>) {
        (Vector::broadcast(&self.low, child), Vector::broadcast(&self.high, child))
    }

    #[inline(always)]
    pub(crate) fn occupied(&self) -> u32 {
        self.occupied
    }

    /// Slots that hold a child.
    pub(super) fn slots(&self) -> impl Iterator<Item = usize> + use<> {
        let occupied = self.occupied;
        (0..8).filter(move |slot| occupied >> slot & 1 == 1)
    }

    /// Box of a child.
    pub(super) fn slot_bounds(&self, slot: usize) -> (Vec3, Vec3) {
        let corner = |side: &[[f32; 8]; 3]| Vec3::from_array(side.map(|axis| axis[slot]));
        (corner(&self.low), corner(&self.high))
    }

    /// Sets a child's box, which is already padded.
    pub(super) fn set_bounds(&mut self, slot: usize, (low, high): (Vec3, Vec3)) {
        for axis in 0..3 {
            self.low[axis][slot] = low[axis];
            self.high[axis][slot] = high[axis];
        }
    }

    /// Adds a child whose box is already padded.
    pub(super) fn set_child(&mut self, slot: usize, bounds: (Vec3, Vec3), child: u32) {
        self.set_bounds(slot, bounds);
        self.children[slot] = child;
        self.occupied |= 1 << slot;
    }

    /// Offsets all references by a number of nodes and of blocks.
    pub(super) fn moved(mut self, nodes: u32, blocks: u32) -> Self {
        for slot in self.slots() {
            let child = &mut self.children[slot];
            *child += if *child & BLOCK == 0 { nodes } else { blocks };
        }
        self
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

/// Box enlarged by at least `padding` on all sides, and by a unit in the last place of its corners.
pub(super) fn padded(low: Vec3, high: Vec3, padding: f32) -> (Vec3, Vec3) {
    let (low, high) = ((low - padding).to_array(), (high + padding).to_array());
    (Vec3::from_array(low.map(f32::next_down)), Vec3::from_array(high.map(f32::next_up)))
}
