//! Positions of light samples: stratified patterns over a light's unit square.

use glam::Vec2;
use serde::{Deserialize, Serialize};

use crate::hash;

/// How the samples are placed inside their strata.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PatternKind {
    /// The centre of every stratum: a regular grid, the same for every key.
    Grid,
    /// A regular grid whose rows are shifted, each by its own random amount along and across itself.
    ShiftedRows,
    /// Every sample at a random place in its stratum.
    Jittered,
}

/// A stratified pattern of `columns * rows` samples.
///
/// Sample `k` lies in column `k % columns` (along the first coordinate of the unit square, see [`crate::light::AreaLight::point`])
/// and row `k / columns` (along the second), and is bit `k` of every mask. Random placements come from the key a receiver asks with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Pattern {
    /// Placement inside the strata.
    pub kind: PatternKind,
    /// Strata along the first coordinate.
    pub columns: u16,
    /// Strata along the second coordinate.
    pub rows: u16,
}

/// Why a pattern cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PatternError {
    /// The number of samples is outside what masks can hold.
    #[error("{0} light samples asked for; a pattern has 1 to {max}", max = Pattern::MAX_LEN)]
    Count(usize),
}

impl Pattern {
    /// The largest number of samples: 64 × 64, a mask of 64 words.
    pub const MAX_LEN: usize = 4096;

    /// The most nearly square pattern with exactly `count` samples.
    ///
    /// # Errors
    /// `count` is 0 or above [`Pattern::MAX_LEN`].
    pub fn with_count(kind: PatternKind, count: usize) -> Result<Self, PatternError> {
        if count == 0 || count > Self::MAX_LEN {
            return Err(PatternError::Count(count));
        }
        let rows =
            (1..=64).rev().find(|rows| count.is_multiple_of(*rows) && rows * rows <= count).unwrap_or(1);
        Ok(Self { kind, columns: (count / rows) as u16, rows: rows as u16 })
    }

    /// Number of samples.
    #[inline]
    pub fn len(&self) -> usize {
        usize::from(self.columns) * usize::from(self.rows)
    }

    /// Returns true if the pattern has no samples, which only one built by hand can be.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Words of 64 bits in a mask for this pattern.
    #[inline]
    pub fn words(&self) -> usize {
        self.len().div_ceil(64)
    }

    /// Place of sample `index` in the unit square, strictly inside its stratum.
    #[inline]
    pub fn position(&self, index: usize, key: u32) -> Vec2 {
        let (column, row) = (index % usize::from(self.columns), index / usize::from(self.columns));
        let (du, dv) = match self.kind {
            PatternKind::Grid => (0.5, 0.5),
            PatternKind::ShiftedRows => hash::unit_pair(hash::sample_bits(key, row as u32)),
            PatternKind::Jittered => hash::unit_pair(hash::sample_bits(key, index as u32)),
        };
        // Multiplying by reciprocals is what the vector code does: both must give the same bits.
        let (scale_u, scale_v) = (1.0 / f32::from(self.columns), 1.0 / f32::from(self.rows));
        Vec2::new((column as f32 + du) * scale_u, (row as f32 + dv) * scale_v)
    }

    /// Returns true if every key gives equal positions.
    pub fn ignores_key(&self) -> bool {
        self.kind == PatternKind::Grid
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_factor_into_near_squares() {
        let shape = |count| {
            let p = Pattern::with_count(PatternKind::Grid, count).unwrap();
            (p.columns, p.rows)
        };
        assert_eq!(shape(64), (8, 8));
        assert_eq!(shape(32), (8, 4));
        assert_eq!(shape(4096), (64, 64));
        assert_eq!(shape(7), (7, 1));
        assert_eq!(Pattern::with_count(PatternKind::Grid, 0), Err(PatternError::Count(0)));
        assert_eq!(Pattern::with_count(PatternKind::Grid, 4097), Err(PatternError::Count(4097)));
    }

    #[test]
    fn samples_stay_in_their_strata() {
        for kind in [PatternKind::Grid, PatternKind::ShiftedRows, PatternKind::Jittered] {
            let pattern = Pattern { kind, columns: 8, rows: 4 };
            for key in 0..100 {
                for index in 0..pattern.len() {
                    let p = pattern.position(index, key);
                    assert_eq!((p.x * 8.0) as usize, index % 8, "{kind:?}");
                    assert_eq!((p.y * 4.0) as usize, index / 8, "{kind:?}");
                }
            }
        }
    }

    #[test]
    fn rows_shift_as_a_whole() {
        let pattern = Pattern { kind: PatternKind::ShiftedRows, columns: 8, rows: 8 };
        let (a, b) = (pattern.position(16, 3), pattern.position(17, 3));
        assert!((b.x - a.x - 0.125).abs() < 1e-6 && a.y == b.y);
        assert_ne!(pattern.position(8, 3).y - 0.125, pattern.position(0, 3).y);
    }
}
