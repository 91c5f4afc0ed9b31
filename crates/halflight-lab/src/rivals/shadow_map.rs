//! Shadow maps: depths of the surfaces nearest to a light, as seen from its centre.

use glam::{DVec3, Vec2, Vec3};
use halflight_core::camera::{Camera, View};
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use halflight_core::scene::Scene;
use halflight_cpu::bvh::Bvh;
use halflight_cpu::gbuffer;
use rayon::prelude::*;

/// Largest tangent of the angle between the light's normal and a direction that the map covers: 80°. Surfaces beyond are
/// left unshadowed; light leaves towards them with less than a fifth of its strength.
const WIDEST: f32 = 5.67;

/// Share of the map's width that is left free on either side of the receivers.
const MARGIN: f32 = 0.05;

/// Samples of a map that are taken together.
pub(super) const LANES: usize = 16;

/// Surface point as the light sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Place in the map, in texels from its top left corner.
    place: Vec2,
    /// Inverse depth, 1/m, with the depth bias.
    pub(super) inverse: f32,
    /// Inverse depth of the surface's tangent plane at the map's corner, and its growth from texel to texel; zeros where the
    /// light's centre is below its horizon.
    plane: (f32, Vec2),
}

/// Map of inverse depths along a light's normal, from its centre.
#[derive(Debug)]
pub(super) struct ShadowMap {
    eye: Vec3,
    /// Unit axes: columns, rows and depth.
    axes: [Vec3; 3],
    /// Tangents at the top left corner, and of a texel.
    corner: Vec2,
    texel: Vec2,
    /// Texels along a side.
    resolution: u32,
    /// Inverse depths, 1/m, row by row, with a texel more on each side; 0 there and where nothing is seen.
    inverse: Vec<f32>,
    /// Largest inverse depths of squares of 2, 4, 8 … texels, each level with the squares along a side, the whole map last.
    levels: Vec<(usize, Vec<f32>)>,
    /// Edges of the light in the map's plane, m.
    edges: [Vec2; 2],
}

impl ShadowMap {
    /// Traces the map of a light towards `axis`, its unit normal or the opposite of it, over the receivers of a G-buffer.
    /// `None` where no receiver lies on that side. `scratch` is kept between maps.
    pub(super) fn trace(
        scene: &Scene,
        bvh: &Bvh,
        light: &AreaLight,
        axis: Vec3,
        seen: &GBuffer,
        resolution: u32,
        scratch: &mut GBuffer,
    ) -> Option<Self> {
        let eye = light.centre();
        let right = axis.any_orthonormal_vector();
        let down = axis.cross(right);
        let tangents = |pixel: usize| {
            let away = seen.position[pixel] - eye;
            let depth = away.dot(axis);
            let across = Vec2::new(away.dot(right), away.dot(down)) / depth;
            (depth > 0.0 && seen.is_receiver(pixel) && across.is_finite())
                .then(|| across.clamp(Vec2::splat(-WIDEST), Vec2::splat(WIDEST)))
        };
        let bounds = (0..seen.pixels()).into_par_iter().filter_map(tangents).map(|across| (across, across));
        let (low, high) = bounds.reduce_with(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
        // At least wide enough for a camera to exist.
        let half = (0.5 * (1.0 + 2.0 * MARGIN) * (high - low)).max(Vec2::splat(1e-4));
        let middle = 0.5 * (low + high);
        let camera = Camera {
            eye,
            // As far away as the eye from the origin, so that the direction keeps its precision.
            target: eye + axis * eye.abs().max_element().max(1.0),
            up: -down,
            fov_y_deg: 2.0 * half.y.atan().to_degrees(),
            aspect: Some(half.x / half.y),
            shift: Vec2::new(middle.x, -middle.y) / half,
        };
        let view = View::new(&camera, resolution, resolution);
        gbuffer::trace(bvh, &Scene { camera, ..scene.clone() }, resolution, resolution, scratch);
        let side = resolution as usize;
        let mut inverse = vec![0.0; (side + 2).pow(2)];
        let rows = inverse.par_chunks_exact_mut(side + 2).skip(1).zip(scratch.depth.par_chunks_exact(side));
        rows.for_each(|(row, depths)| {
            row[1..].iter_mut().zip(depths).for_each(|(to, depth)| *to = 1.0 / depth);
        });
        let axes = [view.right, view.down, view.forward].map(|axis| axis.normalize().as_vec3());
        let flat = |direction: DVec3| {
            Vec2::new(direction.dot(axes[0].as_dvec3()) as f32, direction.dot(axes[1].as_dvec3()) as f32)
        };
        let frame = light.frame();
        Some(Self {
            eye,
            axes,
            corner: flat(view.corner),
            texel: Vec2::new(view.right.length() as f32, view.down.length() as f32),
            resolution,
            levels: levels(&inverse, side),
            inverse,
            edges: [flat(frame.u.as_dvec3()), flat(frame.v.as_dvec3())],
        })
    }

    /// Returns a surface point as the light sees it, with a depth bias of that many texels' widths; `None` outside of the map.
    #[inline(always)]
    pub(super) fn project(&self, point: Vec3, normal: Vec3, bias: f32) -> Option<Seen> {
        let away = point - self.eye;
        let [right, down, forward] = self.axes;
        let inverse = 1.0 / away.dot(forward);
        let place = (Vec2::new(away.dot(right), away.dot(down)) * inverse - self.corner) / self.texel;
        let size = self.resolution as f32;
        if !(inverse > 0.0 && place.min_element() >= 0.0 && place.max_element() <= size) {
            return None;
        }
        let margin = 1.0 + bias * self.texel.max_element();
        // On the plane n·x = n·away, the inverse depth in the direction (a, b, 1) is n·(a, b, 1) / n·away.
        let height = normal.dot(away);
        let plane = if height < -1e-3 * away.length() {
            let flat = Vec2::new(normal.dot(right), normal.dot(down)) * (margin / height);
            (flat.dot(self.corner) + normal.dot(forward) * (margin / height), flat * self.texel)
        } else {
            (0.0, Vec2::ZERO)
        };
        Some(Seen { place, inverse: inverse * margin, plane })
    }

    /// Returns the inverse depth by which the nearest surface that may hide the light is nearer than a receiver; 0 where no
    /// surface is.
    #[inline(always)]
    pub(super) fn reach(&self, seen: &Seen) -> f32 {
        let half = 0.5 * (self.edges[0].abs() + self.edges[1].abs()) / self.texel;
        let whole = self.levels.last().map_or(0.0, |(_, level)| level[0]);
        // Nearer surfaces lie in a smaller part of the map, where the nearest surface may be farther away.
        (0..3).fold((whole - seen.inverse).max(0.0), |nearer, _| {
            let (low, high) = (seen.place - half * nearer - 1.0, seen.place + half * nearer + 1.0);
            (self.largest(low, high) - seen.inverse).clamp(0.0, nearer)
        })
    }

    /// Returns the largest inverse depth in a rectangle of the map, or in a little more.
    #[inline(always)]
    fn largest(&self, low: Vec2, high: Vec2) -> f32 {
        let width = (high - low).max_element().max(2.0) as u32;
        // Squares of at least the width: four of them cover the rectangle.
        let level = (width.ilog2() as usize).min(self.levels.len() - 1);
        let (side, squares) = &self.levels[level];
        let square = 1.0 / (2 << level) as f32;
        let last = *side as f32 - 1.0;
        let (low, high) = (
            (low * square).clamp(Vec2::ZERO, Vec2::splat(last)),
            (high * square).clamp(Vec2::ZERO, Vec2::splat(last)),
        );
        let at = |x: f32, y: f32| squares[y as usize * side + x as usize];
        at(low.x, low.y).max(at(high.x, low.y)).max(at(low.x, high.y)).max(at(high.x, high.y))
    }

    /// Returns the inverse depths in the map between a receiver and places on the light (−½ … ½ along its edges), 0 where
    /// nothing is nearer than the receiver. `nearer` is the inverse depth by which blockers are assumed to be nearer. Places
    /// are spread over a texel more, so that texels do not show.
    ///
    /// Geometry on or behind the receiver's tangent plane hides nothing (receiver-plane depth bias, Isidoro 2006).
    #[inline(always)]
    pub(super) fn blockers(&self, seen: &Seen, nearer: f32, places: &[[f32; LANES]; 2]) -> [f32; LANES] {
        let [u, v] = self.edges.map(|edge| edge / self.texel * nearer);
        let (size, (corner, slope)) = (self.resolution as f32, seen.plane);
        let (mut limit, mut index) = ([0.0f32; LANES], [0u32; LANES]);
        for lane in 0..LANES {
            let (s, t) = (places[0][lane], places[1][lane]);
            // Texels around the map hold 0.
            let x = (seen.place.x + u.x * s + v.x * t + s).floor().clamp(-1.0, size);
            let y = (seen.place.y + u.y * s + v.y * t + t).floor().clamp(-1.0, size);
            limit[lane] = (corner + slope.x * (x + 0.5) + slope.y * (y + 0.5)).max(seen.inverse);
            index[lane] = (y as i32 + 1) as u32 * (self.resolution + 2) + (x as i32 + 1) as u32;
        }
        let mut found = [0.0; LANES];
        for lane in 0..LANES {
            let value = self.inverse[index[lane] as usize];
            found[lane] = if value > limit[lane] { value } else { 0.0 };
        }
        found
    }
}

/// Returns the largest values of squares of 2, 4, 8 … texels, without the texels around the map.
fn levels(inverse: &[f32], side: usize) -> Vec<(usize, Vec<f32>)> {
    let halved = |from: &[f32], side: usize, stride: usize| -> (usize, Vec<f32>) {
        let half = side.div_ceil(2);
        let mut to = vec![0.0; half * half];
        to.par_chunks_exact_mut(half).enumerate().for_each(|(y, row)| {
            for (x, to) in row.iter_mut().enumerate() {
                let (x2, y2) = ((2 * x + 1).min(side - 1), (2 * y + 1).min(side - 1));
                let at = |x: usize, y: usize| from[y * stride + x];
                *to = at(2 * x, 2 * y).max(at(x2, 2 * y)).max(at(2 * x, y2)).max(at(x2, y2));
            }
        });
        (half, to)
    };
    let mut levels = vec![halved(&inverse[side + 3..], side, side + 2)];
    while let Some((side, last)) = levels.last().filter(|(side, _)| *side > 1) {
        levels.push(halved(last, *side, *side));
    }
    levels
}
