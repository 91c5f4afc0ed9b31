//! Search for the entries whose rectangles cover a receiver's, eight or sixteen at a time.

use std::ops::Range;

use super::cells::Entries;
use super::project::Rectangle;
use crate::simd::{Kernel, Lanes, Simd};

/// Kernel that calls a function for every entry of a list whose rectangle covers another, until the function
/// returns false.
pub(super) struct Cover<'a, F> {
    pub(super) entries: &'a Entries,
    pub(super) list: Range<usize>,
    pub(super) rectangle: Rectangle,
    pub(super) task: F,
}

impl<F: FnMut(usize) -> bool> Kernel for Cover<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> bool {
        let Rectangle { low, high } = self.rectangle;
        let (entries, width) = (self.entries, S::Wide::WIDTH);
        for at in self.list.clone().step_by(width) {
            let count = (self.list.end - at).min(width);
            let mut kept = (1u32 << count) - 1;
            if count == width {
                kept &= S::Wide::load(&entries.low[0][at..]).le(S::Wide::splat(low[0]));
                kept &= S::Wide::load(&entries.low[1][at..]).le(S::Wide::splat(low[1]));
                kept &= S::Wide::splat(high[0]).le(S::Wide::load(&entries.high[0][at..]));
                kept &= S::Wide::splat(high[1]).le(S::Wide::load(&entries.high[1][at..]));
            } else {
                for slot in 0..count {
                    let mut covers = true;
                    for axis in 0..2 {
                        covers &= entries.low[axis][at + slot] <= low[axis];
                        covers &= high[axis] <= entries.high[axis][at + slot];
                    }
                    kept &= !(u32::from(!covers) << slot);
                }
            }
            while kept != 0 {
                let slot = at + kept.trailing_zeros() as usize;
                kept &= kept - 1;
                if !(self.task)(slot) {
                    return false;
                }
            }
        }
        true
    }
}
