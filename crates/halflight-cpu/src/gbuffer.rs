//! The G-buffer: what each pixel's centre sees, found by packets of primary rays.

mod rays;
mod sub_samples;
mod surface;

use glam::Vec3;
use halflight_core::camera::View;
use halflight_core::gbuffer::GBuffer;
use halflight_core::scene::{Mesh, Scene};
use rayon::prelude::*;

use crate::bvh::{Bvh, RAYS};
use crate::simd::{Isa, Kernel, Simd};
use rays::Rays;
use surface::Layers;

pub(crate) use sub_samples::{SubSample, trace_sub_samples};
pub(crate) use surface::diffuse_albedo;

/// Pixels along the side of a tile, and of the squares that it consists of. A tile is a packet; where the tile before it has
/// shown more than [`FINE`] triangles, each square is.
const TILE: usize = 8;
const SQUARE: usize = 4;

/// Triangles in a tile beyond which rays that travel apart meet fewer of them.
const FINE: usize = 16;

/// Fills `out` with the nearest surface at every pixel centre. `bvh` must be built over `scene`'s mesh.
///
/// Hits, and the order of two hits, are decided in exact arithmetic for the ray from the eye
/// along the pixel's direction in single precision. Shared edges are watertight. Of surfaces that a ray meets in the same
/// point (coplanar ones, or ones that touch there) the triangle with the lowest index is seen. Triangles seen edge-on are
/// not, nor are holes of alpha-masked ones. Ray parameters are distances along the view direction, so they are the depths; they and the positions are rounded
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
    // Bands differ in cost.
    let bands = Layers::parts(out, &scene.mesh, TILE * width as usize).enumerate().with_max_len(1);
    bands.for_each(|(index, layers)| {
        let top = index * TILE;
        isa.run(Band { bvh, mesh: &scene.mesh, view: &view, width: width as usize, top, layers });
    });
}

/// Rays that one thread traces at a time.
const TASK: usize = 1024;

/// Fills `out` with the nearest surfaces along rays, one entry a ray: the image has one row of as many pixels as the shorter slice has rays. Ray `i` leaves
/// `origins[i]` along `directions[i]`, of any length above 0; one without length sees nothing. Depths are ray parameters, normals point to the
/// rays' origins. Hits are decided as [`trace`] decides them.
pub fn trace_rays(bvh: &Bvh, scene: &Scene, origins: &[Vec3], directions: &[Vec3], out: &mut GBuffer) {
    let count = origins.len().min(directions.len());
    out.reset(count as u32, 1);
    let isa = Isa::best();
    let tasks = Layers::parts(out, &scene.mesh, TASK).enumerate().with_max_len(1);
    tasks.for_each(|(task, layers)| {
        let (first, mesh) = (task * TASK, &scene.mesh);
        let direction = |ray: usize, _| directions[first + ray];
        let origins = &origins[first..count.min(first + TASK)];
        isa.run(Sheaves { bvh, mesh, origins, rays: 1, limit: f32::INFINITY, direction, layers });
    });
}

/// Fills `out` with the nearest surfaces along sheaves of `rays` rays, up to the ray parameter `limit` or hardly beyond it. Ray `i` of sheaf `k` leaves
/// `origins[k]` along `direction(k, i)`, which has a length, and is entry `k * rays + i`.
pub(crate) fn trace_sheaves(
    bvh: &Bvh,
    scene: &Scene,
    origins: &[Vec3],
    rays: usize,
    limit: f32,
    direction: impl Fn(usize, usize) -> Vec3 + Sync,
    out: &mut GBuffer,
) {
    out.reset((origins.len() * rays) as u32, 1);
    let (isa, sheaves) = (Isa::best(), TASK / rays.max(1));
    let tasks = Layers::parts(out, &scene.mesh, sheaves * rays).enumerate().with_max_len(1);
    tasks.for_each(|(task, layers)| {
        let (first, mesh) = (task * sheaves, &scene.mesh);
        let direction = |sheaf: usize, ray: usize| direction(first + sheaf, ray);
        let origins = &origins[first..origins.len().min(first + sheaves)];
        isa.run(Sheaves { bvh, mesh, origins, rays, limit, direction, layers });
    });
}

/// Sheaves of rays, each from an origin of its own.
struct Sheaves<'a, D: Fn(usize, usize) -> Vec3> {
    bvh: &'a Bvh,
    mesh: &'a Mesh,
    origins: &'a [Vec3],
    rays: usize,
    limit: f32,
    direction: D,
    layers: Layers<'a>,
}

impl<D: Fn(usize, usize) -> Vec3> Kernel for Sheaves<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        let Self { bvh, mesh, origins, rays: count, limit, .. } = self;
        let mut rays = Rays::<RAYS>::new(bvh, mesh, Vec3::ZERO);
        for (sheaf, &origin) in origins.iter().enumerate() {
            rays.leave(origin, limit);
            for first in (0..count).step_by(RAYS) {
                let direction = |ray: usize| (self.direction)(sheaf, first + ray);
                if count == 1 && direction(0) == Vec3::ZERO {
                    self.layers.write(sheaf, mesh, origin, Vec3::ZERO, &surface::Surface::NONE);
                    continue;
                }
                let place = |ray: usize| sheaf * count + first + ray;
                rays.trace::<S>(RAYS.min(count - first), direction, place, &mut self.layers);
            }
        }
    }
}

/// All tiles of up to [`TILE`] rows.
struct Band<'a> {
    bvh: &'a Bvh,
    mesh: &'a Mesh,
    width: usize,
    view: &'a View,
    top: usize,
    layers: Layers<'a>,
}

impl Kernel for Band<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        let Self { width, view, top, .. } = self;
        let mut rays = Rays::<{ TILE * TILE }>::new(self.bvh, self.mesh, view.eye);
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
                let direction = |ray: usize| view.direction(pixels[ray] % width, top + pixels[ray] / width);
                triangles += rays.trace::<S>(pixels.len(), direction, |ray| pixels[ray], &mut self.layers);
            }
            fine = triangles > FINE;
        }
    }
}

impl Band<'_> {
    /// The pixels of a tile, square by square, and where among them each square begins and the last one ends.
    fn tile(&self, left: usize) -> ([usize; TILE * TILE], [usize; 5]) {
        let width = self.width;
        let (columns, rows) = (TILE.min(width - left), self.layers.depth.len() / width);
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

    use glam::Vec3;
    use halflight_core::gbuffer::NO_PRIMITIVE;
    use halflight_core::scene::{Camera, Material, Texture};

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
    fn albedo_is_the_material_times_the_texture() {
        let mut scene = hall_scene();
        Arc::make_mut(&mut scene.mesh).materials =
            vec![Material { albedo: Vec3::new(0.5, 1.0, 0.25), texture: Some(0), ..Material::default() }];
        Arc::make_mut(&mut scene.mesh).textures =
            vec![Texture { width: 1, height: 1, texels: vec![[128, 0, 255, 0]] }];
        let out = traced(&scene, 4, 4, Isa::best());
        // sRGB 128 by hand (IEC 61966-2-1), to seven digits.
        let expected = Vec3::new(0.5 * 0.215_860_5, 0.0, 0.25);
        assert!(out.albedo.iter().all(|&albedo| albedo.abs_diff_eq(expected, 1e-7)));
    }
}
