//! The BVH in memory: nodes of eight children and blocks of eight triangles, both arrays of lanes.

use glam::Vec3;

use crate::occluder::Vector;
use crate::simd::Lanes;

/// Set in a child that is a block; the other bits are its index.
pub(super) const BLOCK: u32 = 1 << 31;

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
    pub(super) const EMPTY: Self =
        Self { low: [[0.0; 8]; 3], high: [[0.0; 8]; 3], children: [0; 8], occupied: 0 };

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

    /// Adds a child with a box that is already padded.
    pub(super) fn set_child(&mut self, slot: usize, bounds: (Vec3, Vec3), child: u32) {
        self.set_bounds(slot, bounds);
        self.children[slot] = child;
        self.occupied |= 1 << slot;
    }

    /// Moves references to later nodes and blocks, by so many of each.
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

/// A box enlarged by at least `padding` on all sides, and by a unit in the last place of its corners.
pub(super) fn padded(low: Vec3, high: Vec3, padding: f32) -> (Vec3, Vec3) {
    let (low, high) = ((low - padding).to_array(), (high + padding).to_array());
    (Vec3::from_array(low.map(f32::next_down)), Vec3::from_array(high.map(f32::next_up)))
}
