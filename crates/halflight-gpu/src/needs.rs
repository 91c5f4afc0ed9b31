//! Memory that the stages of a configuration take for an image.

use halflight_core::pattern::Pattern;
use halflight_core::pyramid::MAX_LEVEL;

use crate::bindings::Slot;

/// Levels from pixels to the coarsest cells.
pub(crate) const LEVELS: usize = MAX_LEVEL as usize + 1;

/// Bytes of queries, samples and states of cells.
pub(crate) const RECORD: u64 = 16;

/// Bytes that each slot takes. Every stage declares the slots that it writes; of two declarations the larger one counts, and a
/// slot that no stage declares takes no memory to speak of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Needs {
    /// Width of the image, pixels.
    pub(crate) width: u32,
    /// Height of the image, pixels.
    pub(crate) height: u32,
    /// Number of uniforms.
    pub(crate) uniforms: u32,
    bytes: Vec<u64>,
}

impl Needs {
    /// Returns the needs of an image for which nothing is declared yet.
    pub(crate) fn new(width: u32, height: u32, uniforms: u32) -> Self {
        Self { width, height, uniforms, bytes: vec![0; Slot::ALL.len()] }
    }

    /// Declares that a slot takes this many bytes.
    pub(crate) fn declare(&mut self, slot: Slot, bytes: u64) {
        let known = &mut self.bytes[slot as usize];
        *known = bytes.max(*known);
    }

    /// Bytes of a slot.
    pub(crate) fn bytes(&self, slot: Slot) -> u64 {
        self.bytes[slot as usize]
    }

    /// Number of records in a slot of records.
    pub(crate) fn records(&self, slot: Slot) -> u64 {
        self.bytes(slot) / RECORD
    }

    /// Number of pixels.
    pub(crate) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Number of cells of a level.
    pub(crate) fn cells(&self, level: u32) -> u64 {
        u64::from(cells(self.width, self.height, level))
    }

    /// Number of cells of all levels up to `coarsest`.
    pub(crate) fn all_cells(&self, coarsest: u32) -> u64 {
        (0..=coarsest).map(|level| self.cells(level)).sum()
    }
}

/// Returns the number of cells of a level.
pub(crate) fn cells(width: u32, height: u32, level: u32) -> u32 {
    width.div_ceil(1 << level) * height.div_ceil(1 << level)
}

/// Returns the first cell of each level in buffers that hold all levels.
pub(crate) fn level_places(width: u32, height: u32) -> [u32; LEVELS] {
    let mut next = 0;
    std::array::from_fn(|level| {
        let place = next;
        next += cells(width, height, level as u32);
        place
    })
}

/// Returns the words of 32 bits in a mask.
pub(crate) fn words(pattern: Pattern) -> u32 {
    (pattern.len() as u32).div_ceil(32)
}
