//! Triangle list that receivers share.

use super::Hull;
use crate::occluder::{Block, Triangle};
use crate::simd::{Kernel, Simd};

/// Triangles, packed into blocks.
#[derive(Default)]
pub(crate) struct List {
    blocks: Vec<Block>,
    count: usize,
}

impl List {
    /// Removes all triangles and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Number of triangles.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks[..self.count.div_ceil(8)]
    }

    /// Block and lane of the next triangle.
    #[inline(always)]
    fn next(&mut self) -> (&mut Block, usize) {
        let (block, lane) = (self.count / 8, self.count % 8);
        if block == self.blocks.len() {
            self.blocks.push(Block::EMPTY);
        }
        self.count += 1;
        let block = &mut self.blocks[block];
        block.truncate(lane);
        (block, lane)
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, triangle: &Triangle) {
        let (block, lane) = self.next();
        block.set_lane(lane, triangle);
    }

    /// Adds the triangles of a block whose bits are set in a mask.
    #[inline(always)]
    pub(crate) fn push_lanes(&mut self, from: &Block, mut lanes: u32) {
        while lanes != 0 {
            let (block, lane) = self.next();
            block.copy_lane(lane, from, lanes.trailing_zeros() as usize);
            lanes &= lanes - 1;
        }
    }

    /// Becomes the part of another list that lies in a hull.
    pub(crate) fn keep<S: Simd>(&mut self, from: &Self, hull: &Hull) {
        S::call(Keep { list: self, from, hull, indices: None });
    }

    /// Becomes the part of another list that lies in a hull; `indices` becomes the kept triangles' indices in
    /// that list.
    pub(crate) fn keep_indexed<S: Simd>(&mut self, from: &Self, hull: &Hull, indices: &mut Vec<u32>) {
        S::call(Keep { list: self, from, hull, indices: Some(indices) });
    }
}

struct Keep<'a> {
    list: &'a mut List,
    from: &'a List,
    hull: &'a Hull,
    indices: Option<&'a mut Vec<u32>>,
}

impl Kernel for Keep<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        self.list.clear();
        if let Some(indices) = &mut self.indices {
            indices.clear();
        }
        for (number, block) in (0..).step_by(8).zip(self.from.blocks()) {
            let met = self.hull.meets::<S::Eight>(block);
            self.list.push_lanes(block, met);
            if let Some(indices) = &mut self.indices {
                let mut met = met;
                while met != 0 {
                    indices.push(number + met.trailing_zeros());
                    met &= met - 1;
                }
            }
        }
    }
}
