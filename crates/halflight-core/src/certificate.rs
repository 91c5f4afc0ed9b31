//! Certificates: bounds on the visible fraction in a whole region, without masks of its receivers.

use glam::Vec3;

/// A box that holds receivers: the origins of their shadow rays, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Lowest coordinates.
    pub low: Vec3,
    /// Highest coordinates.
    pub high: Vec3,
}

impl Region {
    /// A region without receivers.
    pub const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// The smallest region that holds this one and a point.
    #[must_use]
    pub fn with(self, point: Vec3) -> Self {
        Self { low: self.low.min(point), high: self.high.max(point) }
    }
}

/// Bound that holds for all receivers of a region and one light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Certificate {
    /// All of them see all of the light.
    Lit,
    /// None of them sees any of the light.
    Umbra,
    /// The visible fractions, 0 … 1, of any two of them differ by no more than this.
    Bounded(f32),
    /// Nothing.
    #[default]
    Open,
}
