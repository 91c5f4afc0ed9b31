//! Part of a light's frame that emits.

use glam::{Vec2, Vec3};

/// Most corners of a polygon.
pub(super) const MOST_CORNERS: usize = 12;

/// Part of a light's frame that emits, in the coordinates of the sample pattern's unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// All of it.
    Whole,
    /// The ellipse that touches the sides.
    Ellipse,
    /// A convex polygon.
    Polygon(Sides),
}

/// Sides of a convex polygon: `a + b · u + c · v` is not negative on the inner side of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sides {
    pub(super) coefficients: [Vec3; MOST_CORNERS],
    pub(super) count: usize,
}

impl Sides {
    /// The coefficients `a`, `b` and `c` of every side.
    pub fn coefficients(&self) -> &[Vec3] {
        &self.coefficients[..self.count]
    }
}

impl Extent {
    /// True if a point of the unit square emits.
    #[inline]
    pub fn contains(&self, uv: Vec2) -> bool {
        match self {
            Self::Whole => true,
            Self::Ellipse => (uv * 2.0 - 1.0).length_squared() <= 1.0,
            Self::Polygon(sides) => {
                sides.coefficients().iter().all(|side| side.x + side.y * uv.x + side.z * uv.y >= 0.0)
            }
        }
    }
}
