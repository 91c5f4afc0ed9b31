//! Parts of rays.

/// Part of all rays of a fan, as an interval of their parameter 0 … 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Run {
    pub(super) from: f32,
    pub(super) to: f32,
    /// True if the run is known to lie in the grid.
    pub(super) inside: bool,
}

impl Run {
    /// Whole rays, not known to lie in the grid.
    pub(super) const WHOLE: Self = Self { from: 0.0, to: 1.0, inside: false };
    pub(super) const NONE: Self = Self { from: 0.0, to: 0.0, inside: false };
}
