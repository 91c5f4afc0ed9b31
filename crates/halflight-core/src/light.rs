//! Area lights: their shapes, and points on them.

use glam::{Vec2, Vec3};

use crate::limits::MAX_COORDINATE;

/// Surface that emits along its normal: a uniform radiance, or one times a picture.
///
/// A light is not geometry: it casts no shadow and the camera does not see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Extent and position.
    pub shape: Shape,
    /// Emitted radiance per channel, W/m²/sr.
    pub radiance: Vec3,
    /// True if the back emits as well.
    pub two_sided: bool,
    /// Picture that the radiance is multiplied with; none for a uniform light.
    pub texture: Option<TexturePlace>,
}

/// Picture of a light, by its place in [`Scene::light_textures`](crate::scene::Scene::light_textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexturePlace {
    /// Index of the picture.
    pub index: u32,
    /// True if its first coordinate runs along the second one of the light's unit square, and its second along the first.
    pub transposed: bool,
}

/// Shape of a light.
///
/// A `match` has no catch-all arm: the compiler then names every place that a new shape concerns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Parallelogram.
    Parallelogram(Parallelogram),
}

/// Parallelogram that emits along `cross(edge_u, edge_v)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallelogram {
    /// One corner, world space, metres.
    pub corner: Vec3,
    /// Edge from `corner`, metres.
    pub edge_u: Vec3,
    /// Other edge from `corner`, metres; not parallel to `edge_u`.
    pub edge_v: Vec3,
}

/// Parallelogram that contains a light, in the light's plane: all samples have coordinates 0 … 1 along `u` and `v`.
///
/// `cross(u, v)` points to the emitting side. Coordinates in the frame are those of the sample pattern only where
/// [`AreaLight::strata_are_rectangles`]; other shapes map the pattern's unit square to a part of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFrame {
    /// Corner with the coordinates 0, 0, world space, metres.
    pub origin: Vec3,
    /// Edge from `origin`, metres.
    pub u: Vec3,
    /// Other edge from `origin`, metres.
    pub v: Vec3,
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
    /// The scene has no picture with the light's index.
    #[error("light {index} has picture {texture}, but the scene has only {count}")]
    Texture {
        /// Index of the light in the scene.
        index: usize,
        /// Index of the picture.
        texture: u32,
        /// Number of pictures of the scene.
        count: usize,
    },
    /// Radiance below zero.
    #[error("light {index} has a negative radiance")]
    Negative {
        /// Index of the light in the scene.
        index: usize,
    },
}

impl AreaLight {
    /// Creates a parallelogram that emits along `cross(edge_u, edge_v)`; see [`Parallelogram`].
    pub const fn parallelogram(corner: Vec3, edge_u: Vec3, edge_v: Vec3, radiance: Vec3) -> Self {
        let shape = Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v });
        Self { shape, radiance, two_sided: false, texture: None }
    }

    /// Lets the back emit as well.
    #[must_use]
    pub const fn two_sided(self) -> Self {
        Self { two_sided: true, ..self }
    }

    /// Multiplies the radiance with the picture at `index` in [`Scene::light_textures`](crate::scene::Scene::light_textures).
    #[must_use]
    pub const fn textured(self, index: u32) -> Self {
        Self { texture: Some(TexturePlace { index, transposed: false }), ..self }
    }

    /// Parallelogram that contains the light.
    #[inline]
    pub fn frame(&self) -> LightFrame {
        match self.shape {
            Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }) => {
                LightFrame { origin: corner, u: edge_u, v: edge_v }
            }
        }
    }

    /// True if a point's coordinates in the frame are its coordinates in the sample pattern: strata of the pattern are
    /// then equal parallelograms in the frame, and rows of samples are straight.
    #[inline]
    pub fn strata_are_rectangles(&self) -> bool {
        match self.shape {
            Shape::Parallelogram(_) => true,
        }
    }

    /// World-space point at `uv` in the unit square of the sample pattern. Equal areas of the square are equal areas of
    /// the light.
    #[inline]
    pub fn point(&self, uv: Vec2) -> Vec3 {
        match self.shape {
            Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }) => {
                corner + edge_u * uv.x + edge_v * uv.y
            }
        }
    }

    /// Normal of the emitting side with the length of the light's area, m².
    #[inline]
    pub fn vector_area(&self) -> Vec3 {
        match self.shape {
            Shape::Parallelogram(Parallelogram { edge_u, edge_v, .. }) => edge_u.cross(edge_v),
        }
    }

    /// Area in m².
    pub fn area(&self) -> f32 {
        self.vector_area().length()
    }

    /// Unit normal of the emitting side.
    pub fn normal(&self) -> Vec3 {
        self.vector_area().normalize_or_zero()
    }

    /// Centre of the frame, world space.
    pub fn centre(&self) -> Vec3 {
        let LightFrame { origin, u, v } = self.frame();
        origin + (u + v) * 0.5
    }

    /// Corners of the frame in order around it: the light lies in their convex hull.
    pub fn corners(&self) -> [Vec3; 4] {
        let LightFrame { origin, u, v } = self.frame();
        [origin, origin + u, origin + u + v, origin + v]
    }

    /// Low and high corner of the frame's bounding box, world space.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let [a, b, c, d] = self.corners();
        (a.min(b).min(c).min(d), a.max(b).max(c).max(d))
    }

    /// Height of a point above the light's plane times the light's area: positive on the emitting side.
    #[inline]
    pub fn side(&self, point: Vec3) -> f32 {
        self.vector_area().dot(point - self.frame().origin)
    }

    /// True if light leaves towards `point`: always for a two-sided light, only in front of a one-sided one.
    #[inline]
    pub fn emits_towards(&self, point: Vec3) -> bool {
        let side = self.side(point);
        if self.two_sided { side != 0.0 } else { side > 0.0 }
    }

    /// Light after an affine map that takes points to `point(p)` and directions to `direction(d)`.
    #[must_use]
    #[inline]
    pub fn transformed(&self, point: impl Fn(Vec3) -> Vec3, direction: impl Fn(Vec3) -> Vec3) -> Self {
        let shape = match self.shape {
            Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }) => {
                Shape::Parallelogram(Parallelogram {
                    corner: point(corner),
                    edge_u: direction(edge_u),
                    edge_v: direction(edge_v),
                })
            }
        };
        Self { shape, ..*self }
    }

    /// Light moved by `offset`, metres.
    #[must_use]
    #[inline]
    pub fn moved(&self, offset: Vec3) -> Self {
        self.transformed(|point| point + offset, |direction| direction)
    }

    /// Light of `factor` times the lengths, about its centre.
    #[must_use]
    pub fn scaled(&self, factor: f32) -> Self {
        match self.shape {
            Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }) => {
                let corner = corner + (edge_u + edge_v) * (0.5 * (1.0 - factor));
                let (edge_u, edge_v) = (edge_u * factor, edge_v * factor);
                Self { shape: Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }), ..*self }
            }
        }
    }

    /// Light that emits from its other side. Every point keeps its radiance, so that a picture is mirrored.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let transpose = |place: TexturePlace| TexturePlace { transposed: !place.transposed, ..place };
        let shape = match self.shape {
            Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }) => {
                Shape::Parallelogram(Parallelogram { corner, edge_u: edge_v, edge_v: edge_u })
            }
        };
        Self { shape, texture: self.texture.map(transpose), ..*self }
    }

    /// Checks that the light is finite and in range, has an area and does not emit negative radiance.
    ///
    /// # Errors
    /// The first fault found; `index` is only used to name the light.
    pub fn validate(&self, index: usize) -> Result<(), LightError> {
        let LightFrame { origin, u, v } = self.frame();
        let finite = [origin, u, v, self.radiance].iter().all(|v| v.is_finite());
        if !finite {
            return Err(LightError::NotFinite { index });
        }
        if self.corners().iter().any(|corner| corner.abs().max_element() >= MAX_COORDINATE) {
            return Err(LightError::TooFar { index });
        }
        if self.radiance.min_element() < 0.0 {
            return Err(LightError::Negative { index });
        }
        let (u, v) = (u.as_dvec3(), v.as_dvec3());
        // Relative, so that lights of any scale pass: the sine of the angle between the edges.
        let sine = u.cross(v).length() / (u.length() * v.length());
        // NaN (an edge of zero length) must fail as well.
        if sine > 1e-6 { Ok(()) } else { Err(LightError::NoArea { index }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIGHT: AreaLight = AreaLight::parallelogram(
        Vec3::new(1.0, 2.0, 3.0),
        Vec3::new(2.0, 0.0, 0.0),
        Vec3::new(1.0, 0.0, 2.0),
        Vec3::ONE,
    );

    #[test]
    fn samples_lie_in_the_frame_and_its_bounds() {
        let (low, high) = LIGHT.bounds();
        assert_eq!((low, high), (Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 2.0, 5.0)));
        for uv in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE, Vec2::new(0.25, 0.75)] {
            let point = LIGHT.point(uv);
            assert!(point.cmpge(low).all() && point.cmple(high).all());
            let LightFrame { origin, u, v } = LIGHT.frame();
            assert!(LIGHT.strata_are_rectangles());
            assert_eq!(point, origin + u * uv.x + v * uv.y);
        }
        assert_eq!(LIGHT.corners().map(|corner| LIGHT.side(corner)), [0.0; 4]);
    }

    #[test]
    fn the_reverse_has_the_points_and_emits_to_the_other_side() {
        let (below, above) = (Vec3::ZERO, Vec3::Y * 4.0);
        assert!(LIGHT.emits_towards(below) && !LIGHT.emits_towards(above));
        assert!(LIGHT.two_sided().emits_towards(above));
        let back = LIGHT.reversed();
        assert!(!back.emits_towards(below) && back.emits_towards(above));
        assert_eq!((back.bounds(), back.area(), back.centre()), (LIGHT.bounds(), 4.0, LIGHT.centre()));
    }

    #[test]
    fn maps_move_every_point() {
        let uv = Vec2::new(0.25, 0.5);
        assert_eq!(LIGHT.moved(Vec3::Y).point(uv), LIGHT.point(uv) + Vec3::Y);
        let doubled = LIGHT.transformed(|p| p * 2.0, |d| d * 2.0);
        assert_eq!(doubled.point(uv), LIGHT.point(uv) * 2.0);
        let scaled = LIGHT.scaled(0.5);
        assert_eq!((scaled.centre(), scaled.area()), (LIGHT.centre(), 1.0));
    }
}
