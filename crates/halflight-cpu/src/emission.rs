//! Lights that the camera sees.

use glam::{DVec3, Vec2, Vec3};
use halflight_core::camera::View;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::{AreaLight, Extent, LightFrame, Sphere};
use halflight_core::light_texture::PlacedTexture;
use halflight_core::scene::Scene;
use rayon::prelude::*;

/// Light that the camera sees, by the rays from its eye.
enum Seen<'a> {
    Flat(FlatLight<'a>),
    Sphere(SphereLight),
}

impl<'a> Seen<'a> {
    /// The light as seen from `eye`; none from a side that does not emit.
    fn new(scene: &'a Scene, light: &'a AreaLight, eye: Vec3) -> Option<Self> {
        if !light.visible || !light.emits_towards(eye) {
            return None;
        }
        Some(match light.as_sphere() {
            Some(sphere) => Self::Sphere(SphereLight::new(sphere, light.radiance, eye)),
            None => Self::Flat(FlatLight::new(scene, light, eye)),
        })
    }

    /// Parameter and radiance where a ray along `d` from the eye meets the light.
    fn along(&self, d: Vec3) -> Option<(f32, Vec3)> {
        match self {
            Self::Flat(light) => light.along(d),
            Self::Sphere(light) => light.along(d),
        }
    }
}

/// Sphere that the camera sees.
struct SphereLight {
    radiance: Vec3,
    /// Centre, from the eye.
    centre: DVec3,
    /// Square of the eye's distance from the centre without that of the radius: negative inside.
    outside: f64,
}

impl SphereLight {
    fn new(sphere: &Sphere, radiance: Vec3, eye: Vec3) -> Self {
        let centre = sphere.centre.as_dvec3() - eye.as_dvec3();
        Self { radiance, centre, outside: centre.length_squared() - f64::from(sphere.radius).powi(2) }
    }

    /// Nearest point of the surface; from inside the only one, which emits inwards as well.
    fn along(&self, d: Vec3) -> Option<(f32, Vec3)> {
        let d = d.as_dvec3();
        let (square, along) = (d.length_squared(), self.centre.dot(d));
        let root = (along * along - square * self.outside).sqrt();
        // NaN, beside the sphere, is none.
        let t = if self.outside > 0.0 { self.outside / (along + root) } else { (along + root) / square };
        (t > 0.0 && root >= 0.0).then_some((t as f32, self.radiance))
    }
}

/// Flat light that the camera sees.
struct FlatLight<'a> {
    light: &'a AreaLight,
    texture: Option<PlacedTexture<'a>>,
    extent: Extent,
    /// Normal of the frame, and its product with the frame's corner as seen from the eye.
    normal: Vec3,
    height: f32,
    corner: Vec3,
    /// Vectors whose products with a point, seen from the corner, are its coordinates in the frame.
    duals: [Vec3; 2],
}

impl<'a> FlatLight<'a> {
    fn new(scene: &'a Scene, light: &'a AreaLight, eye: Vec3) -> Self {
        let LightFrame { origin, u, v } = light.frame();
        let normal = u.cross(v);
        let squared = normal.length_squared();
        let duals = [v.cross(normal) / squared, normal.cross(u) / squared];
        let corner = origin - eye;
        let (texture, extent) = (scene.light_texture(light), light.extent());
        Self { light, texture, extent, normal, height: normal.dot(corner), corner, duals }
    }

    /// Parameter and radiance where a ray along `d` from the eye meets the light.
    fn along(&self, d: Vec3) -> Option<(f32, Vec3)> {
        let t = self.height / self.normal.dot(d);
        let at = d * t - self.corner;
        let uv = Vec2::new(at.dot(self.duals[0]), at.dot(self.duals[1]));
        // NaN, along the light's plane, is outside.
        let inside = t > 0.0 && uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all();
        if !(inside && self.extent.contains(uv)) {
            return None;
        }
        let factors = self.texture.as_ref().map_or(Vec3::ONE, |texture| texture.at(uv));
        Some((t, self.light.radiance * factors))
    }
}

/// Height below a surface, relative to the largest coordinate, from which on a light is behind it. A lamp in the plane of its own face, or
/// of a ceiling, is before it by less ([`flush`](crate::flush)), and both are rounded.
const BEHIND: f32 = 16.0 / 16_777_216.0;

/// Tangent plane of a surface that the camera sees, relative to the eye.
struct Facet {
    point: Vec3,
    normal: Vec3,
    slack: f32,
}

impl Facet {
    fn new(point: Vec3, normal: Vec3, eye: Vec3) -> Self {
        let largest = point.abs().max(eye.abs()).max((point + eye).abs()).max_element();
        Self { point, normal, slack: BEHIND * largest }
    }

    /// True if the surface hides a point.
    fn hides(&self, at: Vec3) -> bool {
        self.normal.dot(at - self.point) < -self.slack
    }
}

/// Lights of a scene that the camera sees.
pub(crate) struct SeenLights<'a> {
    view: View,
    lights: Vec<Seen<'a>>,
}

impl<'a> SeenLights<'a> {
    /// The visible lights of a scene in an image of this size; none if no light is visible.
    pub(crate) fn new(scene: &'a Scene, width: u32, height: u32) -> Option<Self> {
        if !scene.lights.iter().any(|light| light.visible) {
            return None;
        }
        let view = View::new(&scene.camera, width, height);
        let lights = scene.lights.iter().filter_map(|light| Seen::new(scene, light, view.eye)).collect();
        Some(Self { view, lights })
    }

    /// Radiance of the nearest light that an entry of a G-buffer does not hide, seen at an offset from the centre of a pixel; none where there is no light.
    /// The surface lies in its tangent plane around the point that the ray at `own` offset meets.
    pub(crate) fn before(
        &self,
        seen: &GBuffer,
        entry: usize,
        pixel: [usize; 2],
        own: Vec2,
        offset: Vec2,
    ) -> Option<Vec3> {
        let through = |offset: Vec2| {
            let [x, y] = pixel.map(|at| at as f64 + 0.5);
            self.view.through(x + f64::from(offset.x), y + f64::from(offset.y))
        };
        let d = through(offset);
        let depth = seen.depth[entry];
        let facet = depth.is_finite().then(|| {
            let point = if own == offset { d * depth } else { through(own) * depth };
            Facet::new(point, seen.normal[entry], self.view.eye)
        });
        let hidden = |t: f32| facet.as_ref().is_some_and(|facet| facet.hides(d * t));
        let found = self.lights.iter().filter_map(|light| light.along(d)).filter(|&(t, _)| !hidden(t));
        found.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, radiance)| radiance)
    }

    /// Replaces the radiance of pixels by that of lights before their surfaces, as a mean over `offsets` from the pixels' centres, and writes the part
    /// that lights emit. The surface lies in its tangent plane everywhere. Offsets whose bit `traced` has, a word a pixel, take no part; empty, it
    /// has none.
    pub(crate) fn add(
        &self,
        gbuffer: &GBuffer,
        offsets: &[Vec2],
        traced: &[u16],
        radiance: &mut [Vec3],
        emission: &mut Vec<Vec3>,
    ) {
        let width = gbuffer.width.max(1) as usize;
        emission.resize(radiance.len(), Vec3::ZERO);
        if self.lights.is_empty() {
            return;
        }
        let rows = radiance.par_chunks_mut(width).zip(emission.par_chunks_mut(width)).enumerate();
        rows.for_each(|(y, (radiance, emission))| {
            for (x, (radiance, emission)) in radiance.iter_mut().zip(emission).enumerate() {
                let pixel = y * width + x;
                let traced = traced.get(pixel).copied().unwrap_or(0);
                let (mut seen, mut others, mut all) = (Vec3::ZERO, 0, 0);
                for (_, &offset) in offsets.iter().enumerate().filter(|(bit, _)| traced >> bit & 1 == 0) {
                    all += 1;
                    match self.before(gbuffer, pixel, [x, y], Vec2::ZERO, offset) {
                        Some(emitted) => seen += emitted,
                        None => others += 1,
                    }
                }
                if others < all {
                    let part = 1.0 / all as f32;
                    *emission = seen * part;
                    *radiance = *radiance * (others as f32 * part) + *emission;
                }
            }
        });
    }
}
