//! Parallelogram area lights and points on them.

use glam::{Vec2, Vec3};

use crate::scene::MAX_COORDINATE;

/// A parallelogram that emits a uniform radiance along `cross(edge_u, edge_v)`.
///
/// It is not geometry: it casts no shadow and the camera does not see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// One corner, world space, metres.
    pub corner: Vec3,
    /// Edge from `corner`, metres.
    pub edge_u: Vec3,
    /// Other edge from `corner`, metres; not parallel to `edge_u`.
    pub edge_v: Vec3,
    /// Emitted radiance per channel, W/m²/sr.
    pub radiance: Vec3,
    /// Whether the back emits as well.
    pub two_sided: bool,
}

/// Why a light cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LightError {
    /// A coordinate or the radiance is NaN or infinite.
    #[error("light {index} has a value that is not finite")]
    NotFinite {
        /// Index of the light in the scene.
        index: usize,
    },
    /// Single precision cannot work with distances so large.
    #[error(
        "light {index} lies {MAX_COORDINATE:e} m or more from the origin along an axis: scale the scene down or bring it nearer"
    )]
    TooFar {
        /// Index of the light in the scene.
        index: usize,
    },
    /// The edges span no area.
    #[error("light {index} has no area: its edges are zero or parallel")]
    NoArea {
        /// Index of the light in the scene.
        index: usize,
    },
    /// Radiance below zero.
    #[error("light {index} has a negative radiance")]
    Negative {
        /// Index of the light in the scene.
        index: usize,
    },
}

impl AreaLight {
    /// Area in m².
    pub fn area(&self) -> f32 {
        self.edge_u.cross(self.edge_v).length()
    }

    /// Unit normal of the emitting side.
    pub fn normal(&self) -> Vec3 {
        self.edge_u.cross(self.edge_v).normalize_or_zero()
    }

    /// World-space point at `uv` in the unit square.
    #[inline]
    pub fn point(&self, uv: Vec2) -> Vec3 {
        self.corner + self.edge_u * uv.x + self.edge_v * uv.y
    }

    /// The four corners in order around the light.
    pub fn corners(&self) -> [Vec3; 4] {
        let c = self.corner;
        [c, c + self.edge_u, c + self.edge_u + self.edge_v, c + self.edge_v]
    }

    /// Whether any light leaves towards `point`: always for a two-sided light, only in front of a one-sided one.
    #[inline]
    pub fn emits_towards(&self, point: Vec3) -> bool {
        let side = self.edge_u.cross(self.edge_v).dot(point - self.corner);
        if self.two_sided { side != 0.0 } else { side > 0.0 }
    }

    /// Checks that the light is finite and in range, has an area and does not emit negative radiance.
    ///
    /// # Errors
    /// The first fault found; `index` is only used to name the light.
    pub fn validate(&self, index: usize) -> Result<(), LightError> {
        let finite = [self.corner, self.edge_u, self.edge_v, self.radiance].iter().all(|v| v.is_finite());
        if !finite {
            return Err(LightError::NotFinite { index });
        }
        if self.corners().iter().any(|corner| corner.abs().max_element() >= MAX_COORDINATE) {
            return Err(LightError::TooFar { index });
        }
        if self.radiance.min_element() < 0.0 {
            return Err(LightError::Negative { index });
        }
        let (u, v) = (self.edge_u.as_dvec3(), self.edge_v.as_dvec3());
        // Relative, so that lights of any scale pass: the sine of the angle between the edges.
        let sine = u.cross(v).length() / (u.length() * v.length());
        // NaN (an edge of zero length) must fail as well.
        if sine > 1e-6 { Ok(()) } else { Err(LightError::NoArea { index }) }
    }
}
