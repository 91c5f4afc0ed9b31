//! Area lights: their shapes, and points on them.

mod extent;
mod polygon;
mod sphere;

use std::borrow::Cow;
use std::f32::consts::FRAC_PI_4;

use glam::{Vec2, Vec3};

use crate::limits::{MAX_COORDINATE, MAX_RADIANCE};
pub use extent::Extent;
pub use polygon::{Polygon, PolygonError};
pub use sphere::Sphere;

/// Surface that emits along its normal: a uniform radiance, or one times a texture.
///
/// A light is not geometry: it casts no shadow, and the camera sees it only where that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Extent and position.
    pub shape: Shape,
    /// Emitted radiance per channel, W/m²/sr.
    pub radiance: Vec3,
    /// True if the back emits as well.
    pub two_sided: bool,
    /// True if the camera sees the light, from the sides that emit.
    pub visible: bool,
    /// Texture that the radiance is multiplied with; none for a uniform light.
    pub texture: Option<TexturePlace>,
}

/// Texture of a light, by its place in [`Scene::light_textures`](crate::scene::Scene::light_textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexturePlace {
    /// Index of the texture.
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
    /// Disk or ellipse.
    Ellipse(Ellipse),
    /// Convex polygon.
    Polygon(Polygon),
    /// Sphere.
    Sphere(Sphere),
}

/// Ellipse `centre + cos t · axis_u + sin t · axis_v`, a disk where the axes are perpendicular and equally long. It emits along
/// `cross(axis_u, axis_v)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Centre, world space, metres.
    pub centre: Vec3,
    /// Vector from the centre to the edge, metres.
    pub axis_u: Vec3,
    /// Other vector from the centre to the edge, metres; not parallel to `axis_u`.
    pub axis_v: Vec3,
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

/// Parallelogram that contains a flat light, in its plane: all samples have coordinates 0 … 1 along `u` and `v`.
///
/// `cross(u, v)` points to the emitting side. Coordinates in the frame are those of the sample pattern. Samples outside the light's
/// [extent](AreaLight::extent) are never asked for.
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
    /// The radius of a sphere is zero or negative.
    #[error("light {index} has a radius of 0 or less, expected metres above 0")]
    Radius {
        /// Index of the light in the scene.
        index: usize,
    },
    /// The scene has no texture with the light's index.
    #[error("light {index} has texture {texture}, but the scene has only {count}")]
    Texture {
        /// Index of the light in the scene.
        index: usize,
        /// Index of the texture.
        texture: u32,
        /// Number of textures of the scene.
        count: usize,
    },
    /// Only parallelograms have textures.
    #[error("light {index} has a texture and is no parallelogram: only parallelograms have textures")]
    TexturedShape {
        /// Index of the light in the scene.
        index: usize,
    },
    /// Single precision cannot work with radiances so large.
    #[error(
        "light {index} has a radiance of {MAX_RADIANCE:e} W/m²/sr or more: choose a smaller unit for all lights"
    )]
    TooBright {
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

impl Ellipse {
    /// Parallelogram whose sides it touches.
    #[inline]
    fn frame(&self) -> LightFrame {
        let Self { centre, axis_u, axis_v } = *self;
        LightFrame { origin: centre - axis_u - axis_v, u: axis_u * 2.0, v: axis_v * 2.0 }
    }
}

impl AreaLight {
    /// Creates a parallelogram that emits along `cross(edge_u, edge_v)`; see [`Parallelogram`].
    pub const fn parallelogram(corner: Vec3, edge_u: Vec3, edge_v: Vec3, radiance: Vec3) -> Self {
        let shape = Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v });
        Self { shape, radiance, two_sided: false, visible: false, texture: None }
    }

    /// Lets the back emit as well.
    #[must_use]
    pub const fn two_sided(self) -> Self {
        Self { two_sided: true, ..self }
    }

    /// Lets the camera see the light.
    #[must_use]
    pub const fn visible(self) -> Self {
        Self { visible: true, ..self }
    }

    /// Multiplies the radiance with the texture at `index` in [`Scene::light_textures`](crate::scene::Scene::light_textures).
    #[must_use]
    pub const fn textured(self, index: u32) -> Self {
        Self { texture: Some(TexturePlace { index, transposed: false }), ..self }
    }

    /// Creates an ellipse; see [`Ellipse`].
    pub const fn ellipse(centre: Vec3, axis_u: Vec3, axis_v: Vec3, radiance: Vec3) -> Self {
        let shape = Shape::Ellipse(Ellipse { centre, axis_u, axis_v });
        Self { shape, radiance, two_sided: false, visible: false, texture: None }
    }

    /// Creates a disk that emits along `normal`, which need not have length 1.
    pub fn disk(centre: Vec3, normal: Vec3, radius: f32, radiance: Vec3) -> Self {
        let (u, v) = normal.normalize_or(Vec3::Y).any_orthonormal_pair();
        // The pair may be left-handed.
        let v = if u.cross(v).dot(normal) < 0.0 { -v } else { v };
        Self::ellipse(centre, u * radius, v * radius, radiance)
    }

    /// Creates a convex polygon; see [`Polygon::new`].
    ///
    /// # Errors
    /// The corners are no convex polygon.
    pub fn polygon(corners: &[Vec3], radiance: Vec3) -> Result<Self, PolygonError> {
        let shape = Shape::Polygon(Polygon::new(corners)?);
        Ok(Self { shape, radiance, two_sided: false, visible: false, texture: None })
    }

    /// Creates a sphere; see [`Sphere`].
    pub const fn sphere(centre: Vec3, radius: f32, radiance: Vec3) -> Self {
        let shape = Shape::Sphere(Sphere { centre, radius });
        Self { shape, radiance, two_sided: false, visible: false, texture: None }
    }

    /// The sphere that the light is, if it is one. What receivers see of it depends on where they are ([`AreaLight::seen_from`]).
    #[inline]
    pub const fn as_sphere(&self) -> Option<&Sphere> {
        match &self.shape {
            Shape::Sphere(sphere) => Some(sphere),
            Shape::Parallelogram(_) | Shape::Ellipse(_) | Shape::Polygon(_) => None,
        }
    }

    /// Flat light that a receiver at `origin` sees: the light itself or, of a sphere, the disk that covers it
    /// ([`Sphere::disk_seen_from`]). Its frame is that of the receiver's light samples.
    #[inline]
    pub fn seen_from(&self, origin: Vec3) -> Cow<'_, Self> {
        match self.as_sphere() {
            None => Cow::Borrowed(self),
            Some(sphere) => Cow::Owned(Self {
                shape: Shape::Ellipse(sphere.disk_seen_from(origin)),
                // The disk faces the receiver, whatever rounding says.
                two_sided: true,
                ..*self
            }),
        }
    }

    /// True if the light is a sphere around the receiver at `origin` or touches it within rounding ([`Sphere::surrounds`]).
    #[inline]
    pub fn surrounds(&self, origin: Vec3) -> bool {
        self.as_sphere().is_some_and(|sphere| sphere.surrounds(origin))
    }

    /// Parallelogram that contains the light; of a sphere, that of [`Sphere::great_disk`], in which receivers have no light samples: theirs
    /// lie in the frame of [`AreaLight::seen_from`].
    #[inline]
    pub fn frame(&self) -> LightFrame {
        match self.shape {
            Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }) => {
                LightFrame { origin: corner, u: edge_u, v: edge_v }
            }
            Shape::Ellipse(ellipse) => ellipse.frame(),
            Shape::Polygon(polygon) => polygon.frame(),
            Shape::Sphere(sphere) => sphere.great_disk().frame(),
        }
    }

    /// World-space point at `uv` in the unit square of the sample pattern, which are its coordinates in the frame. Equal areas of the square are
    /// equal areas of the frame; points that the light does not [contain](Self::extent) emit nothing.
    #[inline]
    pub fn point(&self, uv: Vec2) -> Vec3 {
        match self.shape {
            Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }) => {
                corner + edge_u * uv.x + edge_v * uv.y
            }
            Shape::Ellipse(_) | Shape::Polygon(_) | Shape::Sphere(_) => {
                let LightFrame { origin, u, v } = self.frame();
                origin + u * uv.x + v * uv.y
            }
        }
    }

    /// Part of the frame that emits.
    #[inline]
    pub fn extent(&self) -> Extent {
        match &self.shape {
            Shape::Parallelogram(_) => Extent::Whole,
            Shape::Ellipse(_) | Shape::Sphere(_) => Extent::Ellipse,
            Shape::Polygon(polygon) => Extent::Polygon(polygon.sides()),
        }
    }

    /// Normal of the emitting side with the length of the frame's area, m².
    #[inline]
    pub fn vector_area(&self) -> Vec3 {
        match self.shape {
            Shape::Parallelogram(Parallelogram { edge_u, edge_v, .. }) => edge_u.cross(edge_v),
            Shape::Ellipse(_) | Shape::Polygon(_) | Shape::Sphere(_) => {
                let LightFrame { u, v, .. } = self.frame();
                u.cross(v)
            }
        }
    }

    /// Area of the frame in m².
    pub fn frame_area(&self) -> f32 {
        self.vector_area().length()
    }

    /// Part of the frame's area that emits, 0 … 1.
    pub fn filled(&self) -> f32 {
        match &self.shape {
            Shape::Parallelogram(_) => 1.0,
            Shape::Ellipse(_) | Shape::Sphere(_) => FRAC_PI_4,
            Shape::Polygon(polygon) => polygon.area() / self.frame_area(),
        }
    }

    /// Area of one side in m², or of the surface of a sphere.
    pub fn area(&self) -> f32 {
        match &self.shape {
            Shape::Sphere(sphere) => sphere.area(),
            Shape::Parallelogram(_) | Shape::Ellipse(_) | Shape::Polygon(_) => {
                self.frame_area() * self.filled()
            }
        }
    }

    /// Unit normal of the emitting side; of a sphere, which has none, that of its [frame](AreaLight::frame).
    pub fn normal(&self) -> Vec3 {
        self.vector_area().normalize_or_zero()
    }

    /// Centre of the frame, world space.
    pub fn centre(&self) -> Vec3 {
        let LightFrame { origin, u, v } = self.frame();
        origin + (u + v) * 0.5
    }

    /// Corners of the frame in order around it, or of a tetrahedron around a sphere: the light lies in their convex hull.
    #[inline]
    pub fn corners(&self) -> [Vec3; 4] {
        if let Shape::Sphere(sphere) = &self.shape {
            return sphere.corners();
        }
        let LightFrame { origin, u, v } = self.frame();
        [origin, origin + u, origin + u + v, origin + v]
    }

    /// Low and high corner of the bounding box of the frame, or of a sphere, world space.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        if let Shape::Sphere(Sphere { centre, radius }) = self.shape {
            return (centre - radius, centre + radius);
        }
        let [a, b, c, d] = self.corners();
        (a.min(b).min(c).min(d), a.max(b).max(c).max(d))
    }

    /// Height of a point above the light's plane times the light's area: positive on the emitting side. 1 for a sphere, which emits to
    /// everywhere.
    #[inline]
    pub fn side(&self, point: Vec3) -> f32 {
        if self.as_sphere().is_some() {
            return 1.0;
        }
        self.vector_area().dot(point - self.frame().origin)
    }

    /// True if light leaves towards `point`: always for a two-sided light and a sphere, only in front of a one-sided one.
    #[inline]
    pub fn emits_towards(&self, point: Vec3) -> bool {
        let side = self.side(point);
        if self.two_sided { side != 0.0 } else { side > 0.0 }
    }

    /// Light after an affine map that takes points to `point(p)` and directions to `direction(d)`. A sphere stays a sphere: its volume is
    /// scaled as all volumes are.
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
            Shape::Ellipse(Ellipse { centre, axis_u, axis_v }) => Shape::Ellipse(Ellipse {
                centre: point(centre),
                axis_u: direction(axis_u),
                axis_v: direction(axis_v),
            }),
            Shape::Polygon(polygon) => Shape::Polygon(polygon.transformed(point, direction)),
            Shape::Sphere(Sphere { centre, radius }) => {
                let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(direction);
                let scale = x.cross(y).dot(z).abs().cbrt();
                Shape::Sphere(Sphere { centre: point(centre), radius: radius * scale })
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
            Shape::Ellipse(_) | Shape::Polygon(_) | Shape::Sphere(_) => {
                let centre = self.centre();
                self.transformed(|point| centre + (point - centre) * factor, |direction| direction * factor)
            }
        }
    }

    /// Light that emits from its other side; a sphere has one only. Every point keeps its radiance, so that a texture is mirrored.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let transpose = |place: TexturePlace| TexturePlace { transposed: !place.transposed, ..place };
        let shape = match self.shape {
            Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v }) => {
                Shape::Parallelogram(Parallelogram { corner, edge_u: edge_v, edge_v: edge_u })
            }
            Shape::Ellipse(Ellipse { centre, axis_u, axis_v }) => {
                Shape::Ellipse(Ellipse { centre, axis_u: axis_v, axis_v: axis_u })
            }
            Shape::Polygon(polygon) => Shape::Polygon(polygon.reversed()),
            Shape::Sphere(sphere) => Shape::Sphere(sphere),
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
        let (low, high) = self.bounds();
        if low.abs().max(high.abs()).max_element() >= MAX_COORDINATE {
            return Err(LightError::TooFar { index });
        }
        if self.as_sphere().is_some_and(|sphere| sphere.radius <= 0.0) {
            return Err(LightError::Radius { index });
        }
        if self.radiance.min_element() < 0.0 {
            return Err(LightError::Negative { index });
        }
        if self.radiance.max_element() >= MAX_RADIANCE {
            return Err(LightError::TooBright { index });
        }
        if self.texture.is_some() && self.extent() != Extent::Whole {
            return Err(LightError::TexturedShape { index });
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

    #[test]
    fn spheres_are_spheres_after_every_map() {
        let light = AreaLight::sphere(Vec3::new(1.0, 2.0, 3.0), 0.5, Vec3::ONE);
        let sphere = |light: AreaLight| *light.as_sphere().unwrap();
        assert_eq!(light.validate(0), Ok(()));
        assert_eq!(light.bounds(), (Vec3::new(0.5, 1.5, 2.5), Vec3::new(1.5, 2.5, 3.5)));
        assert!((light.area() - std::f32::consts::PI).abs() < 1e-6);
        assert_eq!(light.reversed(), light);
        assert!(light.emits_towards(Vec3::ZERO) && light.emits_towards(light.centre()));
        assert_eq!(sphere(light.moved(Vec3::X)), Sphere { centre: Vec3::new(2.0, 2.0, 3.0), radius: 0.5 });
        assert!((sphere(light.scaled(3.0)).radius - 1.5).abs() < 1e-6);
        let stretched =
            sphere(light.transformed(|p| p * Vec3::new(1.0, 8.0, 1.0), |d| d * Vec3::new(1.0, 8.0, 1.0)));
        assert!((stretched.radius - 1.0).abs() < 1e-6 && stretched.centre.y == 16.0);
        assert_eq!(light.textured(0).validate(2), Err(LightError::TexturedShape { index: 2 }));
        let of = |radius| AreaLight::sphere(Vec3::ZERO, radius, Vec3::ONE).validate(1);
        assert_eq!([of(0.0), of(-1.0)], [Err(LightError::Radius { index: 1 }); 2]);
        assert_eq!([of(f32::NAN), of(f32::INFINITY)], [Err(LightError::NotFinite { index: 1 }); 2]);
        assert_eq!(of(1e8), Err(LightError::TooFar { index: 1 }));
        assert!(light.surrounds(light.centre()) && !LIGHT.surrounds(LIGHT.centre()));
        assert_eq!(LIGHT.seen_from(Vec3::ZERO).into_owned(), LIGHT);
    }

    #[test]
    fn shapes_lie_in_their_frames_and_have_their_areas() {
        let disk = AreaLight::disk(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, -2.0, 0.5), 0.5, Vec3::ONE);
        let corners =
            [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(3.0, 0.0, -2.0), Vec3::new(0.5, 0.0, -3.0)];
        let polygon = AreaLight::polygon(&corners, Vec3::ONE).unwrap();
        assert!(disk.normal().abs_diff_eq(Vec3::new(0.0, -2.0, 0.5).normalize(), 1e-6));
        assert!(polygon.normal().abs_diff_eq(Vec3::Y, 1e-6));
        let sphere = AreaLight::sphere(Vec3::new(1.0, 2.0, 3.0), 0.5, Vec3::ONE);
        let seen = sphere.seen_from(Vec3::new(-1.0, 0.5, 2.0)).into_owned();
        for light in [disk, polygon, seen] {
            let (extent, side) = (light.extent(), 400);
            let inside = |index: i32| {
                let uv = Vec2::new((index % side) as f32 + 0.5, (index / side) as f32 + 0.5) / side as f32;
                extent.contains(uv)
            };
            let share = (0..side * side).filter(|&index| inside(index)).count() as f32 / (side * side) as f32;
            assert!((share * light.frame_area() / light.area() - 1.0).abs() < 3e-3, "{light:?}");
            assert_eq!(light.validate(0), Ok(()));
            assert_eq!(light.textured(0).validate(3), Err(LightError::TexturedShape { index: 3 }));
            let bright = AreaLight { radiance: Vec3::new(0.0, 1e30, 0.0), ..light };
            assert_eq!(bright.validate(1), Err(LightError::TooBright { index: 1 }));
            let back = light.reversed();
            assert!(back.normal().abs_diff_eq(-light.normal(), 1e-6));
            assert!((back.area() / light.area() - 1.0).abs() < 1e-6);
            assert!((light.scaled(2.0).area() / light.area() - 4.0).abs() < 1e-5);
            let moved = light.moved(Vec3::X);
            assert!((moved.centre() - light.centre()).abs_diff_eq(Vec3::X, 1e-6));
            let uv = Vec2::new(0.25, 0.75);
            assert!((moved.point(uv) - light.point(uv)).abs_diff_eq(Vec3::X, 1e-6));
        }
    }
}
