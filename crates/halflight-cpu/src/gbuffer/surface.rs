//! Surfaces that primary rays hit, and what of them goes into a G-buffer.

use glam::{DVec3, Vec2, Vec3, Vec3Swizzles as _};
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE, receiver_origin};
use halflight_core::scene::{Mesh, Texture};
use halflight_core::smooth::SmoothTriangle;
use halflight_core::specular::{Specular, SurfaceSpecular};
use rayon::prelude::*;

use crate::occluder::exact::Ray;
use crate::occluder::{barycentric, corner_weights};

/// Consecutive entries of all layers of a G-buffer.
pub(super) struct Layers<'a> {
    pub(super) depth: &'a mut [f32],
    position: &'a mut [Vec3],
    normal: &'a mut [Vec3],
    /// Empty where no surface of the scene is smooth.
    shading: &'a mut [Vec3],
    albedo: &'a mut [Vec3],
    /// Empty where no surface of the scene is glossy.
    specular: &'a mut [SurfaceSpecular],
    primitive: &'a mut [u32],
}

impl<'a> Layers<'a> {
    /// Parts a G-buffer that has been reset into runs of `length` entries, after it has got the layers that the mesh's surfaces need.
    pub(super) fn parts(
        out: &'a mut GBuffer,
        mesh: &Mesh,
        length: usize,
    ) -> impl IndexedParallelIterator<Item = Self> {
        // Scenes without smooth surfaces have no layer for them.
        let (pixels, smooth) = (out.pixels(), !mesh.normals.is_empty());
        out.shading.resize(if smooth { pixels } else { 0 }, Vec3::ZERO);
        let mut shading = out.shading.chunks_mut(length);
        let parts = pixels.div_ceil(length);
        let shading: Vec<&mut [Vec3]> = (0..parts).map(|_| shading.next().unwrap_or_default()).collect();
        out.specular.resize(if mesh.is_glossy() { pixels } else { 0 }, SurfaceSpecular::MATTE);
        let mut specular = out.specular.chunks_mut(length);
        let specular: Vec<&mut [SurfaceSpecular]> =
            (0..parts).map(|_| specular.next().unwrap_or_default()).collect();
        out.depth
            .par_chunks_mut(length)
            .zip(out.position.par_chunks_mut(length))
            .zip(out.normal.par_chunks_mut(length))
            .zip(out.albedo.par_chunks_mut(length))
            .zip(out.primitive.par_chunks_mut(length))
            .zip(shading)
            .zip(specular)
            .map(|((((((depth, position), normal), albedo), primitive), shading), specular)| Self {
                depth,
                position,
                normal,
                shading,
                albedo,
                specular,
                primitive,
            })
    }

    /// Writes the entry of a ray along `d` that has hit a triangle, or nothing.
    #[inline(always)]
    pub(super) fn write(&mut self, pixel: usize, mesh: &Mesh, eye: Vec3, d: Vec3, seen: &Surface) {
        if seen.triangle == NO_PRIMITIVE {
            self.depth[pixel] = f32::INFINITY;
            self.position[pixel] = Vec3::ZERO;
            self.normal[pixel] = Vec3::ZERO;
            if let Some(shading) = self.shading.get_mut(pixel) {
                *shading = Vec3::ZERO;
            }
            self.albedo[pixel] = Vec3::ZERO;
            if let Some(specular) = self.specular.get_mut(pixel) {
                *specular = SurfaceSpecular::MATTE;
            }
            self.primitive[pixel] = NO_PRIMITIVE;
            return;
        }
        let t = seen.parameter(eye, d);
        let from_behind = seen.normal.dot(d) > 0.0;
        let normal = if from_behind { -seen.normal } else { seen.normal };
        let (mut point, mut shading) = (eye.as_dvec3() + d.as_dvec3() * t, normal);
        let weights = || barycentric(&seen.weights, d);
        if let Some(smooth) = seen.smooth {
            let (second, third) = weights();
            let smooth = if from_behind { smooth.reversed() } else { smooth };
            (point, shading) = smooth.surface(seen.corners, [1.0 - second - third, second, third], point);
        }
        self.depth[pixel] = t as f32;
        self.position[pixel] = receiver_origin(point, normal, seen.extent);
        self.normal[pixel] = normal;
        if let Some(place) = self.shading.get_mut(pixel) {
            *place = shading;
        }
        let base = match seen.texture {
            None => seen.albedo,
            Some(texture) => {
                let (second, third) = weights();
                seen.albedo * texel(mesh, texture, seen.triangle, second, third)
            }
        };
        let (albedo, surface) = match seen.specular {
            None => (base, SurfaceSpecular::MATTE),
            Some(specular) => (specular.diffuse(base), specular.surface(base)),
        };
        self.albedo[pixel] = albedo;
        if let Some(place) = self.specular.get_mut(pixel) {
            *place = surface;
        }
        self.primitive[pixel] = seen.triangle;
    }
}

/// Properties that all rays which hit one triangle share.
#[derive(Clone, Copy)]
pub(super) struct Surface {
    pub(super) triangle: u32,
    corners: [Vec3; 3],
    /// Product of two edges.
    cross: DVec3,
    /// Distance of the triangle's plane from the eye, times the product's length.
    distance: f64,
    /// Bound on the error of products of directions and the product of edges, times 2³². Infinite where the distance is
    /// not known that well.
    error: DVec3,
    /// Largest extent of the triangle along any axis.
    extent: f32,
    normal: Vec3,
    /// Shading normals on the side of `normal`, for smooth surfaces.
    smooth: Option<SmoothTriangle>,
    albedo: Vec3,
    texture: Option<u32>,
    specular: Option<Specular>,
    /// Weights of the corners, where `smooth` or `texture` take them.
    weights: [Vec3; 3],
}

impl Surface {
    pub(super) const NONE: Self = Self {
        triangle: NO_PRIMITIVE,
        corners: [Vec3::ZERO; 3],
        cross: DVec3::ZERO,
        distance: 0.0,
        error: DVec3::ZERO,
        extent: 0.0,
        normal: Vec3::ZERO,
        smooth: None,
        albedo: Vec3::ZERO,
        texture: None,
        specular: None,
        weights: [Vec3::ZERO; 3],
    };

    pub(super) fn new(mesh: &Mesh, eye: Vec3, triangle: u32, corners: [Vec3; 3]) -> Self {
        if triangle == NO_PRIMITIVE {
            return Self::NONE;
        }
        let material = &mesh.materials[mesh.material_ids[triangle as usize] as usize];
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (u, v, away) = (b - a, c - a, a - eye.as_dvec3());
        let (plus, minus) = (u.yzx() * v.zxy(), u.zxy() * v.yzx());
        let (cross, error) = (plus - minus, (plus.abs() + minus.abs()) * 2f64.powi(-16));
        let distance = cross.dot(away);
        let normal = geometric_normal(corners);
        let smooth = SmoothTriangle::new(mesh, triangle as usize, normal);
        let weighted = smooth.is_some() || material.texture.is_some();
        let known = distance.abs() > error.dot(away.abs());
        Self {
            triangle,
            corners,
            cross,
            distance,
            error: if known { error } else { DVec3::INFINITY },
            extent: u.abs().max(v.abs()).max((c - b).abs()).max_element() as f32,
            normal,
            smooth,
            albedo: material.albedo,
            texture: material.texture,
            specular: material.specular,
            weights: if weighted { corner_weights(corners, eye) } else { Self::NONE.weights },
        }
    }

    /// The parameter at which the ray along `d` meets the triangle, wrong by a 2⁻³²nd of itself at most.
    #[inline(always)]
    fn parameter(&self, eye: Vec3, d: Vec3) -> f64 {
        let along = self.cross.dot(d.as_dvec3());
        if along.abs() > self.error.dot(d.as_dvec3().abs()) {
            return self.distance / along;
        }
        Ray { origin: eye, d }.parameter(self.corners)
    }
}

/// Of edges in single precision, as other devices have them, in double, so that no triangle is too small for it.
fn geometric_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3()
}

/// Albedo of diffuse reflection at a place on a triangle, by the weights of its second and third corner.
pub(crate) fn diffuse_albedo(mesh: &Mesh, triangle: u32, second: f32, third: f32) -> Vec3 {
    let material = &mesh.materials[mesh.material_ids[triangle as usize] as usize];
    let texture = material.texture.map_or(Vec3::ONE, |texture| texel(mesh, texture, triangle, second, third));
    let base = material.albedo * texture;
    material.specular.map_or(base, |specular| specular.diffuse(base))
}

fn texel(mesh: &Mesh, texture: u32, triangle: u32, second: f32, third: f32) -> Vec3 {
    let [a, b, c] = mesh.triangles[triangle as usize].map(|vertex| mesh.uvs[vertex as usize]);
    bilinear(&mesh.textures[texture as usize], a + ((b - a) * second + (c - a) * third))
}

/// The texture at `uv`, repeated beyond the unit square; texel centres lie at half numbers.
fn bilinear(texture: &Texture, uv: Vec2) -> Vec3 {
    let (width, height) = (texture.width as usize, texture.height as usize);
    // The part after the point can round up to 1, and is NaN for an infinite coordinate.
    let place = |unit: f32, size: usize| {
        let at = (unit - unit.floor()) * size as f32 - 0.5;
        let low = at.floor();
        (((low as i64).rem_euclid(size.max(1) as i64)) as usize, if at.is_finite() { at - low } else { 0.0 })
    };
    let ((x, fx), (y, fy)) = (place(uv.x, width), place(1.0 - uv.y, height));
    let texel = |x: usize, y: usize| texture.linear((y % height) * width + x % width);
    if texture.texels.is_empty() || width == 0 || height == 0 {
        return Vec3::ONE;
    }
    let top = texel(x, y).lerp(texel(x + 1, y), fx);
    let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), fx);
    top.lerp(bottom, fy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_repeat_and_have_their_origin_below() {
        let texels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
        let texture = Texture { width: 2, height: 2, texels };
        // Texel centres: the first texel is the upper left one.
        for (u, v, expected) in [(0.25, 0.75, Vec3::X), (0.75, 0.75, Vec3::Y), (0.25, 0.25, Vec3::Z)] {
            for shift in [-3.0, 0.0, 1.0, 8.0] {
                assert_eq!(bilinear(&texture, Vec2::new(u + shift, v - shift)), expected, "{u} {v} {shift}");
            }
        }
        // Between all four, inside and across the border.
        let mean = (Vec3::X + Vec3::Y + Vec3::Z + Vec3::ONE) / 4.0;
        assert_eq!(bilinear(&texture, Vec2::new(0.5, 0.5)), mean);
        assert_eq!(bilinear(&texture, Vec2::new(0.0, 1.0)), mean);
        assert!(bilinear(&texture, Vec2::new(f32::INFINITY, 0.2)).is_finite());
    }
}
