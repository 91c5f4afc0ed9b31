//! Questions to a visibility backend and their answers: masks with one bit a light sample, 1 = visible.

use glam::Vec3;

use crate::pattern::{Pattern, PatternKind};

/// One receiver that asks which light samples it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// The receiver, already offset off its surface, world space.
    pub origin: Vec3,
    /// Unit shading normal, towards the viewer; samples below its horizon are not asked for.
    pub normal: Vec3,
    /// Key of the light-sample pattern; equal keys give equal sample positions.
    pub key: u32,
    /// Index of the receiver's pixel, row by row.
    pub pixel: u32,
    /// How many samples were asked for, before those below a horizon were taken out.
    pub asked: u32,
}

/// Purpose of a batch's rays, by which they are counted apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// To decide on refinement (the masks may be kept and used for irradiance as well).
    #[default]
    Refine,
    /// For irradiance alone: level-0 fragments and additional samples.
    Final,
}

/// A batch of queries about one light with one pattern, with room for the answers.
///
/// `wanted` holds, per query, the samples that are asked for; `visible` receives the answers, of which only wanted bits
/// mean anything. Masks are [`Pattern::words`] words long, so they range from a few bits to 4,096.
#[derive(Clone, Debug)]
pub struct MaskBatch {
    light: u32,
    pattern: Pattern,
    purpose: Purpose,
    queries: Vec<Query>,
    wanted: Vec<u64>,
    visible: Vec<u64>,
}

/// The parts of a batch that a backend reads and the one that it writes.
#[derive(Debug)]
pub struct BatchParts<'a> {
    /// The receivers.
    pub queries: &'a [Query],
    /// Wanted samples, [`MaskBatch::words`] words a query.
    pub wanted: &'a [u64],
    /// Answers, laid out like `wanted`.
    pub visible: &'a mut [u64],
}

impl Default for MaskBatch {
    fn default() -> Self {
        Self {
            light: 0,
            pattern: Pattern { kind: PatternKind::Grid, columns: 1, rows: 1 },
            purpose: Purpose::Refine,
            queries: Vec::new(),
            wanted: Vec::new(),
            visible: Vec::new(),
        }
    }
}

impl MaskBatch {
    /// Empties the batch for new questions and keeps its memory.
    pub fn reset(&mut self, light: u32, pattern: Pattern, purpose: Purpose) {
        self.light = light;
        self.pattern = pattern;
        self.purpose = purpose;
        self.queries.clear();
        self.wanted.clear();
        self.visible.clear();
    }

    /// Asks for all samples of the pattern, or for those in `subset` (missing words are taken as 0).
    pub fn push(&mut self, origin: Vec3, normal: Vec3, pixel: u32, key: u32, subset: Option<&[u64]>) {
        let words = self.words();
        let at = self.wanted.len();
        for word in 0..words {
            let all = full_word(self.pattern.len(), word);
            self.wanted.push(subset.map_or(all, |s| s.get(word).copied().unwrap_or(0) & all));
        }
        self.visible.resize(at + words, 0);
        let asked = self.wanted[at..].iter().map(|w| w.count_ones()).sum();
        self.queries.push(Query { origin, normal, key, pixel, asked });
    }

    /// Makes room for `count` queries that ask for everything, to be filled in place (by several threads, say).
    pub fn fill(&mut self, count: usize) -> &mut [Query] {
        let words = self.words();
        let asked = self.pattern.len() as u32;
        let blank = Query { origin: Vec3::ZERO, normal: Vec3::ZERO, key: 0, pixel: 0, asked };
        self.queries.resize(count, blank);
        self.wanted.clear();
        if words == 1 {
            self.wanted.resize(count, full_word(self.pattern.len(), 0));
        } else {
            self.wanted.reserve(count * words);
            for _ in 0..count {
                self.wanted.extend((0..words).map(|word| full_word(self.pattern.len(), word)));
            }
        }
        self.visible.resize(count * words, 0);
        &mut self.queries
    }

    /// Index of the light in the scene.
    pub fn light(&self) -> u32 {
        self.light
    }

    /// The pattern all queries share; they differ in key.
    pub fn pattern(&self) -> Pattern {
        self.pattern
    }

    /// Purpose by which the rays are counted.
    pub fn purpose(&self) -> Purpose {
        self.purpose
    }

    /// Words of 64 bits in each mask.
    #[inline]
    pub fn words(&self) -> usize {
        self.pattern.words()
    }

    /// Number of queries.
    pub fn len(&self) -> usize {
        self.queries.len()
    }

    /// Returns true if there are no queries.
    pub fn is_empty(&self) -> bool {
        self.queries.is_empty()
    }

    /// All queries.
    pub fn queries(&self) -> &[Query] {
        &self.queries
    }

    /// Samples that query `index` asks for (after horizon culling: those that were traced).
    #[inline]
    pub fn wanted(&self, index: usize) -> &[u64] {
        let words = self.words();
        &self.wanted[index * words..(index + 1) * words]
    }

    /// The answer to query `index`; bits that are not wanted mean nothing.
    #[inline]
    pub fn visible(&self, index: usize) -> &[u64] {
        let words = self.words();
        &self.visible[index * words..(index + 1) * words]
    }

    /// True if query `index` has visible samples among the wanted ones, and if it has hidden ones.
    #[inline]
    pub fn lit_and_unlit(&self, index: usize) -> (bool, bool) {
        let (mut lit, mut unlit) = (0, 0);
        for (&wanted, &visible) in self.wanted(index).iter().zip(self.visible(index)) {
            lit |= wanted & visible;
            unlit |= wanted & !visible;
        }
        (lit != 0, unlit != 0)
    }

    /// Data that a backend needs to answer.
    pub fn parts(&mut self) -> BatchParts<'_> {
        BatchParts { queries: &self.queries, wanted: &self.wanted, visible: &mut self.visible }
    }

    /// Queries, wanted samples and answers, all writable: for culling samples below a horizon before a backend sees the
    /// batch, and for refiners that reuse bits they know already.
    pub fn slots_mut(&mut self) -> (&mut [Query], &mut [u64], &mut [u64]) {
        (&mut self.queries, &mut self.wanted, &mut self.visible)
    }

    /// Bytes held, used or not.
    pub fn bytes(&self) -> usize {
        self.queries.capacity() * size_of::<Query>() + (self.wanted.capacity() + self.visible.capacity()) * 8
    }
}

/// The bits of word `word` in a mask that has all of `len` samples.
#[inline]
pub fn full_word(len: usize, word: usize) -> u64 {
    match len.saturating_sub(word * 64) {
        0 => 0,
        bits @ 1..=63 => (1 << bits) - 1,
        _ => u64::MAX,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_hold_16_to_4096_bits() {
        for (count, words) in [(16, 1), (64, 1), (65, 2), (256, 4), (4096, 64)] {
            let pattern = Pattern::with_count(PatternKind::Jittered, count).unwrap();
            let mut batch = MaskBatch::default();
            batch.reset(3, pattern, Purpose::Final);
            batch.push(Vec3::ZERO, Vec3::Y, 7, 9, None);
            batch.push(Vec3::ZERO, Vec3::Y, 8, 9, Some(&[0b1010]));
            assert_eq!((batch.words(), batch.light(), batch.len()), (words, 3, 2));
            assert_eq!(batch.wanted(0).iter().map(|w| w.count_ones()).sum::<u32>() as usize, count);
            assert_eq!(batch.queries()[1].asked, 2);
            assert_eq!(batch.wanted(1)[0], 0b1010);
            let mut filled = MaskBatch::default();
            filled.reset(3, pattern, Purpose::Final);
            assert_eq!(filled.fill(5).len(), 5);
            assert_eq!(filled.wanted(4), batch.wanted(0));
        }
    }

    #[test]
    fn full_words_stop_at_the_last_sample() {
        assert_eq!(full_word(64, 0), u64::MAX);
        assert_eq!(full_word(65, 1), 1);
        assert_eq!(full_word(16, 0), 0xffff);
        assert_eq!(full_word(16, 1), 0);
    }
}
