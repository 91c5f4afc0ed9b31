//! Lights that are flush with geometry: lamps in the plane of a ceiling, and models that still contain the
//! lamp's own polygon.
//!
//! Positions of light and surface are rounded independently. The surface therefore lies a few units in the
//! last place in front of the light or behind it, and would hide all, some or none of it by chance. One rule
//! holds for every visibility backend on the CPU and on the GPU alike:
//!
//! - A light is flush with a triangle if all of the triangle that lies over the light, seen along the light's
//!   normal, is within [`FLUSH`] times the largest coordinate of both from the light's plane: 16 to 32 units
//!   in the last place.
//! - Such a triangle does not hide the light: the light is moved along its normal to just before it, by at
//!   most that distance. A two-sided light becomes two one-sided ones, each moved to its own side.
//! - A triangle that is farther away hides the light as any other.

use std::fmt;

use glam::{DVec2, DVec3, Vec3};
use halflight_core::light::{AreaLight, LightFrame};
use halflight_core::scene::{Mesh, Scene};

use crate::bvh::Bvh;

/// Distance from a light within which triangles count as flush, relative to the largest coordinate.
pub const FLUSH: f64 = 32.0 / 16_777_216.0;

/// Bound on the rounding error of a light's own points, relative to its largest coordinate.
const ROUNDING: f64 = 8.0 / 16_777_216.0;

/// Light that is flush with triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct FlushLight {
    /// Index of the light in the scene.
    pub light: u32,
    /// Indices of the triangles in the mesh, in ascending order.
    pub triangles: Vec<u32>,
    /// Distance by which the light was moved, metres; the larger one for a two-sided light.
    pub moved: f32,
}

impl fmt::Display for FlushLight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { light, triangles, moved } = self;
        let some = triangles.iter().take(4).map(u32::to_string).collect::<Vec<_>>().join(", ");
        let more = if triangles.len() > 4 { ", …" } else { "" };
        let (noun, them) =
            if triangles.len() == 1 { ("triangle", "it does") } else { ("triangles", "they do") };
        write!(
            f,
            "light {light} lies in the plane of {noun} {some}{more} up to rounding; {them} not hide it (it was moved by {moved:e} m)"
        )
    }
}

/// Returns a scene's lights, moved off the triangles that they are flush with, and which these are. Without a BVH, all
/// triangles are tested. Textured lights of one colour become uniform lights.
pub fn separate_lights(scene: &Scene, bvh: Option<&Bvh>) -> (Vec<AreaLight>, Vec<FlushLight>) {
    let mesh = &scene.mesh;
    let size = |p: &Vec3| p.abs().max_element();
    let largest = bvh.map_or_else(|| mesh.positions.iter().map(size).fold(0.0, f32::max), Bvh::largest);
    separate_from(scene, largest, |low, high| {
        let touches = |&index: &u32| {
            let [a, b, c] = mesh.corners(index as usize);
            a.min(b).min(c).cmple(high).all() && a.max(b).max(c).cmpge(low).all()
        };
        match bvh {
            Some(bvh) => bvh.triangles_in(low, high),
            None => (0..mesh.triangle_count() as u32).filter(touches).collect(),
        }
    })
}

/// Light without its texture if that has one colour.
fn without_uniform_texture(scene: &Scene, light: AreaLight) -> AreaLight {
    let texture = light.texture.and_then(|place| scene.light_textures.get(place.index as usize));
    match texture.and_then(|texture| texture.uniform()) {
        Some(factor) => AreaLight { radiance: light.radiance * factor, texture: None, ..light },
        None => light,
    }
}

/// Separates the lights of a scene. `candidates` returns at least the triangles whose boxes touch a box.
fn separate_from(
    scene: &Scene,
    largest: f32,
    candidates: impl Fn(Vec3, Vec3) -> Vec<u32>,
) -> (Vec<AreaLight>, Vec<FlushLight>) {
    let (mut lights, mut flush) = (Vec::with_capacity(scene.lights.len()), Vec::new());
    for (number, light) in (0..).zip(&scene.lights) {
        let light = &without_uniform_texture(scene, *light);
        // Geometry that touches a sphere does not hide it either (`spheres`).
        let Some(plane) = Plane::new(light).filter(|_| light.as_sphere().is_none()) else {
            lights.push(*light);
            continue;
        };
        let around = (plane.size.max(f64::from(largest)) * FLUSH * 2.0) as f32;
        let (low, high) = light.bounds();
        let mut triangles = candidates(low - around, high + around);
        triangles.sort_unstable();
        let (mut before, mut behind) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        triangles.retain(|&triangle| {
            let Some((lowest, highest)) = plane.heights(&scene.mesh, triangle) else { return false };
            // Triangles clearly behind a one-sided light never hide it.
            if !light.two_sided && highest < -plane.slack() {
                return false;
            }
            (before, behind) = (before.max(highest), behind.max(-lowest));
            true
        });
        if triangles.is_empty() {
            lights.push(*light);
            continue;
        }
        let [before, behind] = [before, behind].map(|height| (height + plane.slack()).max(0.0));
        let front = AreaLight { two_sided: false, ..*light };
        let moved = |light: AreaLight, by: f64| {
            light.transformed(|point| (point.as_dvec3() + plane.normal * by).as_vec3(), |direction| direction)
        };
        lights.push(moved(front, before));
        if light.two_sided {
            lights.push(moved(front.reversed(), -behind));
        }
        let moved = if light.two_sided { before.max(behind) } else { before } as f32;
        flush.push(FlushLight { light: number, triangles, moved });
    }
    (lights, flush)
}

/// Plane of a light, with the coordinates of its frame.
struct Plane {
    corner: DVec3,
    normal: DVec3,
    /// Vectors whose products with a point relative to the corner are its coordinates, 0 … 1 along each edge.
    dual: [DVec3; 2],
    /// Largest absolute coordinate of the light.
    size: f64,
}

impl Plane {
    fn new(light: &AreaLight) -> Option<Self> {
        let LightFrame { origin, u, v } = light.frame();
        let (u, v) = (u.as_dvec3(), v.as_dvec3());
        let cross = u.cross(v);
        let size = light.corners().iter().fold(0.0f32, |most, p| most.max(p.abs().max_element()));
        Some(Self {
            corner: origin.as_dvec3(),
            normal: cross.try_normalize()?,
            dual: [v.cross(cross) / cross.length_squared(), cross.cross(u) / cross.length_squared()],
            size: f64::from(size),
        })
    }

    fn slack(&self) -> f64 {
        self.size * ROUNDING
    }

    /// Returns the least and the greatest height, along the normal, of the part of a triangle that lies over
    /// the light. None if there is no such part, or if not all of it is flush with the light.
    fn heights(&self, mesh: &Mesh, triangle: u32) -> Option<(f64, f64)> {
        let corners = mesh.corners(triangle as usize).map(Vec3::as_dvec3);
        let largest = corners.iter().fold(self.size, |most, corner| most.max(corner.abs().max_element()));
        // Position on the light, and height.
        let points = corners.map(|corner| {
            let seen = corner - self.corner;
            (DVec2::new(self.dual[0].dot(seen), self.dual[1].dot(seen)), self.normal.dot(seen))
        });
        let mut over = points.to_vec();
        for axis in 0..2 {
            over = clip(&over, |place| place[axis]);
            over = clip(&over, |place| 1.0 - place[axis]);
        }
        let heights = over.iter().map(|&(_, height)| height);
        let range = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
        let flush = !over.is_empty() && range.0.abs().max(range.1.abs()) <= largest * FLUSH;
        (flush && area(&over) > 1e-9).then_some(range)
    }
}

/// Part of a polygon where `inside` is positive (Sutherland and Hodgman 1974).
fn clip(polygon: &[(DVec2, f64)], inside: impl Fn(DVec2) -> f64) -> Vec<(DVec2, f64)> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, &(to, to_height)) in polygon.iter().enumerate() {
        let (from, from_height) = polygon[(index + polygon.len() - 1) % polygon.len()];
        let (a, b) = (inside(from), inside(to));
        if (a > 0.0) != (b > 0.0) {
            let part = a / (a - b);
            kept.push((from.lerp(to, part), from_height + (to_height - from_height) * part));
        }
        if b > 0.0 {
            kept.push((to, to_height));
        }
    }
    kept
}

/// Area of a polygon, relative to the light's area.
fn area(polygon: &[(DVec2, f64)]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let sum: f64 = polygon.iter().zip(next).map(|(&(a, _), &(b, _))| a.perp_dot(b)).sum();
    0.5 * sum.abs()
}
