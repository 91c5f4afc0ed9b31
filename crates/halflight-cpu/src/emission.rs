//! Lights that the camera sees.

use glam::{Vec2, Vec3};
use halflight_core::camera::View;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::{AreaLight, Extent, LightFrame};
use halflight_core::light_texture::PlacedTexture;
use halflight_core::scene::Scene;
use rayon::prelude::*;

/// Light that the camera sees, by the rays from its eye.
struct Seen<'a> {
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

impl<'a> Seen<'a> {
    /// The light as seen from `eye`; none from a side that does not emit.
    fn new(scene: &'a Scene, light: &'a AreaLight, eye: Vec3) -> Option<Self> {
        if !light.visible || !light.emits_towards(eye) {
            return None;
        }
        let LightFrame { origin, u, v } = light.frame();
        let normal = u.cross(v);
        let squared = normal.length_squared();
        let duals = [v.cross(normal) / squared, normal.cross(u) / squared];
        let corner = origin - eye;
        let (texture, extent) = (scene.light_texture(light), light.extent());
        Some(Self { light, texture, extent, normal, height: normal.dot(corner), corner, duals })
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

/// Replaces the radiance of pixels by that of visible lights before their surfaces, sub-sample by sub-sample at `offsets` from the pixels' centres, and
/// writes the part that lights emit. A surface counts with its distance at the pixel's centre: lights before an edge are not antialiased against what
/// hides them.
pub(crate) fn add(
    scene: &Scene,
    gbuffer: &GBuffer,
    offsets: &[Vec2],
    radiance: &mut [Vec3],
    emission: &mut Vec<Vec3>,
) {
    let (width, view) =
        (gbuffer.width.max(1) as usize, View::new(&scene.camera, gbuffer.width, gbuffer.height));
    let lights: Vec<Seen> =
        scene.lights.iter().filter_map(|light| Seen::new(scene, light, view.eye)).collect();
    emission.resize(radiance.len(), Vec3::ZERO);
    if lights.is_empty() {
        return;
    }
    let part = 1.0 / offsets.len().max(1) as f32;
    let rows = radiance.par_chunks_mut(width).zip(emission.par_chunks_mut(width)).enumerate();
    rows.for_each(|(y, (radiance, emission))| {
        for (x, (radiance, emission)) in radiance.iter_mut().zip(emission).enumerate() {
            let depth = gbuffer.depth[y * width + x];
            let (mut seen, mut others) = (Vec3::ZERO, 0);
            for offset in offsets {
                let (x, y) = (x as f64 + 0.5 + f64::from(offset.x), y as f64 + 0.5 + f64::from(offset.y));
                let d = view.through(x, y);
                let found = lights.iter().filter_map(|light| light.along(d)).filter(|(t, _)| *t < depth);
                match found.min_by(|(a, _), (b, _)| a.total_cmp(b)) {
                    Some((_, emitted)) => seen += emitted,
                    None => others += 1,
                }
            }
            if others < offsets.len() {
                *emission = seen * part;
                *radiance = *radiance * (others as f32 * part) + *emission;
            }
        }
    });
}
