//! Pixel set with concurrent insertion.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

/// Pixels of an image, one bit each, one word per 8 × 8 pixels. Iteration therefore follows the image in
/// tiles, whose pixels see almost the same geometry.
#[derive(Debug, Default)]
pub(crate) struct PixelSet {
    width: u32,
    height: u32,
    columns: usize,
    words: Vec<AtomicU64>,
}

impl PixelSet {
    /// Empties the set and sets the size of the image.
    pub(crate) fn reset(&mut self, width: u32, height: u32) {
        (self.width, self.height) = (width, height);
        self.columns = width.div_ceil(8) as usize;
        let words = self.columns * height.div_ceil(8) as usize;
        self.words.resize_with(words, AtomicU64::default);
        self.words.iter_mut().for_each(|word| *word.get_mut() = 0);
    }

    /// Adds a pixel.
    #[inline]
    pub(crate) fn insert(&self, x: u32, y: u32) {
        let word = &self.words[(y / 8) as usize * self.columns + (x / 8) as usize];
        let bit = 1 << ((y % 8) * 8 + x % 8);
        // Only the set itself is shared, and it is read after the threads have joined.
        if word.load(Ordering::Relaxed) & bit == 0 {
            word.fetch_or(bit, Ordering::Relaxed);
        }
    }

    /// Adds all pixels that satisfy a predicate.
    pub(crate) fn insert_where(&mut self, holds: impl Fn(usize) -> bool + Sync) {
        let (width, height, columns) = (self.width as usize, self.height as usize, self.columns);
        self.words.par_iter_mut().enumerate().with_min_len(64).for_each(|(tile, word)| {
            let (left, top) = (tile % columns * 8, tile / columns * 8);
            let wide = (width - left).min(8);
            let mut bits = 0;
            for (row, y) in (top..height.min(top + 8)).enumerate() {
                let first = y * width + left;
                for lane in 0..wide {
                    bits |= u64::from(holds(first + lane)) << (row * 8 + lane);
                }
            }
            *word.get_mut() |= bits;
        });
    }

    /// Moves all pixels out as indices into the image, tile by tile and row by row in each.
    pub(crate) fn drain(&mut self, pixels: &mut Vec<u32>) {
        pixels.clear();
        for (tile, word) in self.words.iter_mut().enumerate() {
            let mut bits = std::mem::take(word.get_mut());
            if bits == 0 {
                continue;
            }
            let (x, y) = ((tile % self.columns * 8) as u32, (tile / self.columns * 8) as u32);
            while bits != 0 {
                let at = bits.trailing_zeros();
                pixels.push((y + at / 8) * self.width + x + at % 8);
                bits &= bits - 1;
            }
        }
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.words.capacity() * 8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_out_once_and_tile_by_tile() {
        let mut set = PixelSet::default();
        let mut pixels = vec![1];
        set.reset(19, 10);
        for (x, y) in [(18, 9), (0, 0), (8, 0), (7, 1), (0, 8), (8, 0), (7, 1)] {
            set.insert(x, y);
        }
        set.drain(&mut pixels);
        assert_eq!(pixels, [0, 19 + 7, 8, 8 * 19, 9 * 19 + 18]);
        set.drain(&mut pixels);
        assert!(pixels.is_empty());
        set.insert(0, 0);
        set.insert_where(|pixel| pixel % 19 == 18 || pixel == 9 * 19);
        set.drain(&mut pixels);
        let last: Vec<u32> = (0..10).map(|y| y * 19 + 18).collect();
        assert_eq!(pixels, [&[0], &last[..8], &[9 * 19], &last[8..]].concat());
    }
}
