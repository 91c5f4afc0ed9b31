//! Voxel grid with one bit per voxel, and coarser copies for empty-space skipping.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

/// Bits of square levels. Level 0 has one texel per column of voxels; every other level has half the texels
/// per side of the one before, each the union of four. Slices are words of 64 bits, the nearest in the lowest
/// bit.
#[derive(Debug)]
pub(super) struct Grid {
    words: Vec<AtomicU64>,
    levels: Vec<Level>,
    /// Words per texel.
    depth: usize,
    bits: usize,
}

#[derive(Clone, Copy, Debug)]
struct Level {
    side: usize,
    /// Index of the level's first word.
    first: usize,
}

impl Grid {
    /// Creates an empty grid.
    pub(super) fn new(side: usize, bits: usize) -> Self {
        let depth = bits.div_ceil(64);
        let mut levels = vec![Level { side, first: 0 }];
        let mut total = side * side * depth;
        let mut half = side;
        while half > 1 {
            half = half.div_ceil(2);
            levels.push(Level { side: half, first: total });
            total += half * half * depth;
        }
        let mut words = Vec::new();
        words.resize_with(total, AtomicU64::default);
        Self { words, levels, depth, bits }
    }

    /// Texels per side.
    pub(super) fn side(&self) -> usize {
        self.levels[0].side
    }

    /// Number of slices.
    pub(super) fn bits(&self) -> usize {
        self.bits
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.words.capacity() * 8 + self.levels.capacity() * size_of::<Level>()
    }

    /// Clears every voxel.
    pub(super) fn clear(&mut self) {
        self.words.par_iter_mut().with_min_len(1 << 14).for_each(|word| *word.get_mut() = 0);
    }

    /// Sets the voxels of one column between two slices, both included.
    #[inline]
    pub(super) fn set(&self, column: usize, row: usize, low: usize, high: usize) {
        let base = (row * self.side() + column) * self.depth;
        for word in low / 64..=high / 64 {
            let bits = span(low, high, word);
            let word = &self.words[base + word];
            // Most bits are set already; reading is much cheaper than a locked write.
            if word.load(Ordering::Relaxed) & bits != bits {
                word.fetch_or(bits, Ordering::Relaxed);
            }
        }
    }

    /// True if any voxel of a texel of level 0 is set between two slices, both included.
    #[inline(always)]
    pub(super) fn meets(&self, texel: usize, low: usize, high: usize) -> bool {
        let base = texel * self.depth;
        let (first, last) = (low / 64, high / 64);
        if first == last {
            let bits = (2u64 << (high - low)).wrapping_sub(1);
            return self.words[base + first].load(Ordering::Relaxed) >> (low % 64) & bits != 0;
        }
        (first..=last)
            .any(|word| self.words[base + word].load(Ordering::Relaxed) & span(low, high, word) != 0)
    }

    /// First set slice of a texel in the order from `from` to `to`, both included.
    pub(super) fn first_set(&self, texel: usize, from: usize, to: usize) -> Option<usize> {
        let set = |slice: &usize| self.meets(texel, *slice, *slice);
        if from <= to { (from..=to).find(set) } else { (to..=from).rev().find(set) }
    }

    /// Rebuilds the coarser levels.
    pub(super) fn build_levels(&self) {
        for pair in self.levels.windows(2) {
            let [fine, coarse] = [pair[0], pair[1]];
            (0..coarse.side).into_par_iter().with_min_len(8).for_each(|row| {
                for column in 0..coarse.side {
                    for word in 0..self.depth {
                        let mut union = 0;
                        for y in 2 * row..(2 * row + 2).min(fine.side) {
                            for x in 2 * column..(2 * column + 2).min(fine.side) {
                                let at = fine.first + (y * fine.side + x) * self.depth + word;
                                union |= self.words[at].load(Ordering::Relaxed);
                            }
                        }
                        let at = coarse.first + (row * coarse.side + column) * self.depth + word;
                        self.words[at].store(union, Ordering::Relaxed);
                    }
                }
            });
        }
    }

    /// True if no voxel of a box, its last texels and slices included, is set. Conservative: may return false
    /// for an empty box that has set voxels nearby.
    #[inline(always)]
    pub(super) fn is_empty(&self, low: [usize; 3], high: [usize; 3]) -> bool {
        let widest = (high[0] - low[0]).max(high[1] - low[1]);
        // At most five texels per side: fewer would be larger and seldom empty.
        let level = (usize::BITS - (widest / 4).leading_zeros()) as usize;
        let Level { side, first } = self.levels[level.min(self.levels.len() - 1)];
        for word in low[2] / 64..high[2] / 64 + 1 {
            let bits = span(low[2], high[2], word);
            for row in low[1] >> level..(high[1] >> level) + 1 {
                let at = row * side;
                for texel in at + (low[0] >> level)..at + (high[0] >> level) + 1 {
                    let at = first + texel * self.depth + word;
                    if self.words[at].load(Ordering::Relaxed) & bits != 0 {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Bits of the finest level.
    pub(super) fn to_words(&self) -> Vec<u64> {
        let count = self.side() * self.side() * self.depth;
        self.words[..count].iter().map(|word| word.load(Ordering::Relaxed)).collect()
    }
}

/// Bits of word `word` between slices `low` and `high`, both included; one of them lies in the word or the
/// word lies between them.
#[inline(always)]
fn span(low: usize, high: usize, word: usize) -> u64 {
    let from = u64::MAX << low.saturating_sub(word * 64);
    let to = u64::MAX >> (63 - (high - word * 64).min(63));
    from & to
}
