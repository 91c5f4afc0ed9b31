//! The G-buffer: what each pixel's centre sees, found by packets of primary rays.

use glam::{DVec3, Vec2, Vec3, Vec3Swizzles as _};
use halflight_core::camera::View;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE, receiver_origin};
use halflight_core::scene::{Mesh, Scene, Texture};
use halflight_core::smooth::SmoothTriangle;
use rayon::prelude::*;

use crate::bvh::{Bvh, Hits, Packet, STACK};
use crate::occluder::exact::Ray;
use crate::occluder::{barycentric, corner_weights};
use crate::simd::{Isa, Kernel, Simd};

/// Pixels along the side of a tile, and of the squares that it consists of. A tile is a packet; where the tile before it has
/// shown more than [`FINE`] triangles, each square is.
const TILE: usize = 8;
const SQUARE: usize = 4;

/// Triangles in a tile beyond which rays that travel apart meet fewer of them.
const FINE: usize = 16;

/// Triangles that are remembered.
const SURFACES: usize = 64;

/// Fills `out` with the nearest surface at every pixel centre. `bvh` must be built over `scene`'s mesh.
///
/// Hits, and the order of two hits, are decided in exact arithmetic for the ray from the eye
/// along the pixel's direction in single precision. Shared edges are watertight. Of surfaces that a ray meets in the same
/// point (coplanar ones, or ones that touch there) the triangle with the lowest index is seen. Triangles seen edge-on are
/// not. Ray parameters are distances along the view direction, so they are the depths; they and the positions are rounded
/// once, from double precision.
pub fn trace(bvh: &Bvh, scene: &Scene, width: u32, height: u32, out: &mut GBuffer) {
    trace_with(Isa::best(), bvh, scene, width, height, out);
}

fn trace_with(isa: Isa, bvh: &Bvh, scene: &Scene, width: u32, height: u32, out: &mut GBuffer) {
    out.reset(width, height);
    if width == 0 || height == 0 {
        return;
    }
    let view = View::new(&scene.camera, width, height);
    let band = TILE * width as usize;
    // Scenes without smooth surfaces have no layer for them.
    let (pixels, smooth) = (out.pixels(), !scene.mesh.normals.is_empty());
    out.shading.resize(if smooth { pixels } else { 0 }, Vec3::ZERO);
    let shading_rows = (0..height as usize).step_by(TILE);
    let mut shading = out.shading.chunks_mut(band);
    let shading: Vec<&mut [Vec3]> = shading_rows.map(|_| shading.next().unwrap_or_default()).collect();
    out.depth
        .par_chunks_mut(band)
        .zip(out.position.par_chunks_mut(band))
        .zip(out.normal.par_chunks_mut(band))
        .zip(out.albedo.par_chunks_mut(band))
        .zip(out.primitive.par_chunks_mut(band))
        .zip(shading)
        .enumerate()
        // Bands differ in cost.
        .with_max_len(1)
        .for_each(|(index, (((((depth, position), normal), albedo), primitive), shading))| {
            let rows = Rows { top: index * TILE, depth, position, normal, shading, albedo, primitive };
            isa.run(Band { bvh, mesh: &scene.mesh, view: &view, width: width as usize, rows });
        });
}

/// Up to [`TILE`] rows of the image.
struct Rows<'a> {
    top: usize,
    depth: &'a mut [f32],
    position: &'a mut [Vec3],
    normal: &'a mut [Vec3],
    /// Empty where no surface of the scene is smooth.
    shading: &'a mut [Vec3],
    albedo: &'a mut [Vec3],
    primitive: &'a mut [u32],
}

impl Rows<'_> {
    #[inline(always)]
    fn write(&mut self, pixel: usize, mesh: &Mesh, eye: Vec3, d: Vec3, seen: &Surface) {
        if seen.triangle == NO_PRIMITIVE {
            self.depth[pixel] = f32::INFINITY;
            self.position[pixel] = Vec3::ZERO;
            self.normal[pixel] = Vec3::ZERO;
            if let Some(shading) = self.shading.get_mut(pixel) {
                *shading = Vec3::ZERO;
            }
            self.albedo[pixel] = Vec3::ZERO;
            self.primitive[pixel] = NO_PRIMITIVE;
            return;
        }
        let t = seen.parameter(eye, d);
        let from_behind = seen.normal.dot(d) > 0.0;
        let normal = if from_behind { -seen.normal } else { seen.normal };
        let (mut point, mut shading) = (eye.as_dvec3() + d.as_dvec3() * t, normal);
        let weights = || barycentric(&corner_weights(seen.corners, eye), d);
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
        self.albedo[pixel] = match seen.texture {
            None => seen.albedo,
            Some(texture) => {
                let (second, third) = weights();
                seen.albedo * texel(mesh, texture, seen.triangle, second, third)
            }
        };
        self.primitive[pixel] = seen.triangle;
    }
}

/// Properties that all pixels which see one triangle share.
#[derive(Clone, Copy)]
struct Surface {
    triangle: u32,
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
}

impl Surface {
    const NONE: Self = Self {
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
    };

    fn new(mesh: &Mesh, eye: Vec3, triangle: u32, corners: [Vec3; 3]) -> Self {
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
        let known = distance.abs() > error.dot(away.abs());
        Self {
            triangle,
            corners,
            cross,
            distance,
            error: if known { error } else { DVec3::INFINITY },
            extent: u.abs().max(v.abs()).max((c - b).abs()).max_element() as f32,
            normal,
            smooth: SmoothTriangle::new(mesh, triangle as usize, normal),
            albedo: material.albedo,
            texture: material.texture,
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

/// All tiles of some rows.
struct Band<'a> {
    bvh: &'a Bvh,
    mesh: &'a Mesh,
    width: usize,
    view: &'a View,
    rows: Rows<'a>,
}

impl Kernel for Band<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        let width = self.width;
        let mut packet = Packet::new();
        let mut hits = Hits::new();
        let mut stack = [(0u32, 0.0f32); STACK];
        // Tiles see few triangles, by turns.
        let mut surfaces = [Surface::NONE; SURFACES];
        let mut fine = false;
        for left in (0..width).step_by(TILE) {
            let (tile, squares) = self.tile(left);
            let mut triangles = 0;
            let parts: &[usize] = if fine { &squares } else { &[0, squares[4]] };
            for part in parts.windows(2) {
                let pixels = &tile[part[0]..part[1]];
                if pixels.is_empty() {
                    continue;
                }
                packet.clear(self.view.eye);
                for &pixel in pixels {
                    packet.push(self.view.direction(pixel % width, self.rows.top + pixel / width));
                }
                packet.finish::<S>();
                self.bvh.closest_hit::<S>(&packet, &mut stack, &mut hits);
                for (ray, &pixel) in pixels.iter().enumerate() {
                    let triangle = hits.triangle[ray];
                    let seen = &mut surfaces[triangle as usize % SURFACES];
                    if triangle != seen.triangle {
                        let corners = self.bvh.hit_corners(&hits, ray);
                        *seen = Surface::new(self.mesh, self.view.eye, triangle, corners);
                        triangles += 1;
                    }
                    self.rows.write(pixel, self.mesh, self.view.eye, packet.direction(ray), seen);
                }
            }
            fine = triangles > FINE;
        }
    }
}

impl Band<'_> {
    /// The pixels of a tile, square by square, and where among them each square begins and the last one ends.
    fn tile(&self, left: usize) -> ([usize; TILE * TILE], [usize; 5]) {
        let width = self.width;
        let (columns, rows) = (TILE.min(width - left), self.rows.depth.len() / width);
        let (mut tile, mut squares, mut count) = ([0; TILE * TILE], [0; 5], 0);
        for square in 0..4 {
            let (x, y) = (square % 2 * SQUARE, square / 2 * SQUARE);
            for y in y..rows.min(y + SQUARE) {
                for x in x..columns.min(x + SQUARE) {
                    tile[count] = y * width + left + x;
                    count += 1;
                }
            }
            squares[square + 1] = count;
        }
        (tile, squares)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use halflight_core::scene::{Camera, Material};

    use super::*;
    use crate::bvh::tests::meshes::{hall, lamp, scene, soup};

    fn hall_scene() -> Scene {
        let camera = Camera {
            eye: Vec3::new(3.0, 1.7, 15.0),
            target: Vec3::new(4.5, 1.5, 4.0),
            up: Vec3::Y,
            fov_y_deg: 60.0,
            ..Camera::default()
        };
        Scene { camera, ..scene(&hall(), lamp(Vec3::new(4.0, 3.8, 8.0), 1.5)) }
    }

    fn traced(scene: &Scene, width: u32, height: u32, isa: Isa) -> GBuffer {
        let mut out = GBuffer::default();
        trace_with(isa, &Bvh::build(&scene.mesh).unwrap(), scene, width, height, &mut out);
        out
    }

    /// Distance along `d` to a triangle grown by `slack` of its size, in double precision.
    fn distance([a, b, c]: [Vec3; 3], origin: Vec3, d: Vec3, slack: f64) -> Option<f64> {
        let [a, b, c, origin, d] = [a, b, c, origin, d].map(Vec3::as_dvec3);
        let (u, v) = (b - a, c - a);
        let determinant = u.dot(d.cross(v));
        let from = origin - a;
        let (s, t) = (from.dot(d.cross(v)) / determinant, d.dot(from.cross(u)) / determinant);
        let along = v.dot(from.cross(u)) / determinant;
        (s >= -slack && t >= -slack && s + t <= 1.0 + slack && along > 0.0).then_some(along)
    }

    #[test]
    fn finds_what_brute_force_finds_on_every_instruction_set() {
        let scene = hall_scene();
        let (width, height) = (41, 29);
        let view = View::new(&scene.camera, width, height);
        let expected = traced(&scene, width, height, Isa::BASELINE);
        for pixel in 0..expected.pixels() {
            let d = view.direction(pixel % width as usize, pixel / width as usize);
            let all = |slack: f64| {
                let mesh = &scene.mesh;
                let hit = move |t| distance(mesh.corners(t), scene.camera.eye, d, slack);
                (0..mesh.triangle_count()).filter_map(hit)
            };
            let depth = f64::from(expected.depth[pixel]);
            // The hall is closed, 16 long, and single precision has 24 bits: a hundred of its units.
            let tolerance = 16.0 * 100.0 / f64::from(1 << 24);
            assert!(depth < all(0.0).fold(f64::INFINITY, f64::min) + tolerance, "pixel {pixel}");
            // Outlines are wider by the error bound, at most 2⁻¹⁸ of 16 · 3: under a hundredth of the narrowest facet,
            // 0.05. There the position is the nearest one on the triangle.
            let close = |slack| all(slack).any(|t| (t - depth).abs() < tolerance);
            assert!(close(1e-2), "pixel {pixel}");
            let off = scene.camera.eye + d * expected.depth[pixel] - expected.position[pixel];
            assert!(f64::from(off.length()) < tolerance || !close(0.0), "pixel {pixel}");
            let normal = expected.normal[pixel];
            assert!((normal.length() - 1.0).abs() < 1e-6 && normal.dot(d) < 0.0, "pixel {pixel}");
        }
        for isa in Isa::available() {
            let found = traced(&scene, width, height, isa);
            assert_eq!(found.primitive, expected.primitive, "{isa:?}");
            assert_eq!(found.depth, expected.depth, "{isa:?}");
            assert_eq!(found.position, expected.position, "{isa:?}");
        }
    }

    #[test]
    fn pixel_centres_do_not_depend_on_what_surrounds_them() {
        // The middle pixel of odd sizes looks straight ahead, whatever tiles it lies in.
        let scene = hall_scene();
        let isa = Isa::best();
        let straight = traced(&scene, 1, 1, isa);
        assert!(straight.is_receiver(0));
        for (width, height) in [(1, 1), (1, 17), (9, 1), (127, 129)] {
            let out = traced(&scene, width, height, isa);
            let middle = out.index(width / 2, height / 2);
            assert_eq!(out.primitive[middle], straight.primitive[0], "{width}x{height}");
            assert!((out.depth[middle] - straight.depth[0]).abs() < 1e-4, "{width}x{height}");
            assert_eq!(out.pixels(), (width * height) as usize);
            assert!(out.position.iter().chain(&out.normal).chain(&out.albedo).all(|v| v.is_finite()));
        }
    }

    #[test]
    fn pixels_that_see_nothing_are_cleared() {
        let mut out = traced(&hall_scene(), 20, 20, Isa::best());
        assert!(out.primitive.iter().all(|&triangle| triangle != NO_PRIMITIVE));
        let empty = Scene { camera: hall_scene().camera, ..scene(&[], lamp(Vec3::Y, 1.0)) };
        trace(&Bvh::build(&empty.mesh).unwrap(), &empty, 20, 20, &mut out);
        assert!(out.primitive.iter().all(|&triangle| triangle == NO_PRIMITIVE));
        assert!(out.depth.iter().all(|&depth| depth == f32::INFINITY));
        assert!(out.position.iter().chain(&out.normal).chain(&out.albedo).all(|&v| v == Vec3::ZERO));
    }

    #[test]
    fn cameras_without_a_direction_are_no_trouble() {
        let mut scene = scene(&soup(100, 0.3), lamp(Vec3::Y, 1.0));
        for (target, up) in [(Vec3::ZERO, Vec3::Z), (Vec3::Z, Vec3::Y)] {
            scene.camera = Camera { eye: Vec3::Z, target, up, fov_y_deg: 90.0, ..Camera::default() };
            let out = traced(&scene, 16, 16, Isa::best());
            assert!(out.depth.iter().all(|depth| !depth.is_nan()));
            assert!(out.normal.iter().all(|normal| normal.is_finite()));
        }
    }

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

    #[test]
    fn albedo_is_the_material_times_the_texture() {
        let mut scene = hall_scene();
        Arc::make_mut(&mut scene.mesh).materials =
            vec![Material { albedo: Vec3::new(0.5, 1.0, 0.25), texture: Some(0) }];
        Arc::make_mut(&mut scene.mesh).textures =
            vec![Texture { width: 1, height: 1, texels: vec![[128, 0, 255, 0]] }];
        let out = traced(&scene, 4, 4, Isa::best());
        // sRGB 128 by hand (IEC 61966-2-1), to seven digits.
        let expected = Vec3::new(0.5 * 0.215_860_5, 0.0, 0.25);
        assert!(out.albedo.iter().all(|&albedo| albedo.abs_diff_eq(expected, 1e-7)));
    }
}
