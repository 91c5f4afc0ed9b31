//! Light that a lobe reflects: of light samples, or of directions on a grid inside the lobe.

use glam::{Vec2, Vec3};
use halflight_core::frame::Frame;
use halflight_core::light::{AreaLight, LightFrame};
use halflight_core::light_texture::PlacedTexture;

use super::Surfaces;
use super::config::{LobeVisibility, PhongConfig};
use super::lobe::Lobe;

/// Most directions of a grid.
pub(super) const MOST: usize = 64;

/// Light sample.
struct Sample {
    point: Vec3,
    /// Factors of the radiance: the mean of the texture in its stratum.
    factors: Vec3,
}

/// Light of a frame, as lobes gather it.
pub(super) struct Light<'a> {
    surfaces: &'a Surfaces<'a>,
    pub(super) light: &'a AreaLight,
    texture: Option<PlacedTexture<'a>>,
    samples: Vec<Sample>,
    /// Area of a sample's stratum, m².
    stratum: f32,
    frame: LightFrame,
    unit: Vec3,
    config: PhongConfig,
}

/// Samples of a grid inside a lobe.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Light of each sample if it is seen, over the light's radiance.
    pub(super) light: Vec<Vec3>,
    /// Part of the segment to each sample before the nearest occluder, 1 where there is none; negative where it was not traced.
    pub(super) parts: Vec<f32>,
}

/// Light that a lobe gathers.
#[derive(Clone, Debug)]
pub(super) enum Gathered {
    /// Its value, over the light's radiance.
    Value(Vec3),
    /// Samples whose visibility is yet to be told.
    Grid(Grid),
}

impl<'a> Light<'a> {
    pub(super) fn new(
        surfaces: &'a Surfaces<'a>,
        frame: &Frame<'a>,
        number: u32,
        config: &PhongConfig,
    ) -> Self {
        let scene = surfaces.scene.scene();
        let light = &scene.lights[number as usize];
        let (texture, pattern, key) = (scene.light_texture(light), frame.pattern, frame.shared_key(number));
        let inside = inside(light);
        let scale = Vec2::new(1.0 / f32::from(pattern.columns), 1.0 / f32::from(pattern.rows));
        let sample = |index: usize| {
            let uv = pattern.position(index, key);
            let columns = usize::from(pattern.columns);
            let low = Vec2::new((index % columns) as f32, (index / columns) as f32) * scale;
            let factors =
                texture.as_ref().map_or(Vec3::ONE, |texture| texture.mean_over(low, low + scale).truncate());
            inside(uv).then(|| Sample { point: light.point(uv), factors })
        };
        Self {
            surfaces,
            light,
            texture,
            samples: (0..pattern.len()).filter_map(sample).collect(),
            stratum: light.frame_area() / pattern.len().max(1) as f32,
            frame: light.frame(),
            unit: light.normal(),
            config: *config,
        }
    }

    /// Lobe of a pixel, and the point from which rays leave it; none where it sees no surface.
    pub(super) fn lobe(&self, pixel: usize) -> Option<(Lobe, Vec3)> {
        let Surfaces { gbuffer, scene, .. } = self.surfaces;
        let receiver = gbuffer.receiver(pixel)?;
        let view = (scene.scene().camera.eye - gbuffer.position[pixel]).normalize_or_zero();
        let lobe = Lobe::new(gbuffer.shading_normals()[pixel], view, &self.surfaces.specular(pixel));
        Some((lobe, receiver.origin))
    }

    /// Distance along a direction to the light's plane, in lengths of the direction, and the place there in the unit square of the light's frame.
    pub(super) fn meets(&self, origin: Vec3, direction: Vec3) -> Option<(f32, Vec2)> {
        let along = direction.dot(self.unit);
        let distance = (self.frame.origin - origin).dot(self.unit) / along;
        if !(distance > 0.0 && distance.is_finite()) {
            return None;
        }
        let LightFrame { origin: corner, u, v } = self.frame;
        let from = origin + direction * distance - corner;
        // Coordinates along edges that need not be perpendicular.
        let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
        let (fu, fv) = (from.dot(u), from.dot(v));
        let determinant = uu * vv - uv * uv;
        Some((distance, Vec2::new(fu * vv - fv * uv, fv * uu - fu * uv) / determinant))
    }

    /// Returns whether a lobe misses the light (§3.2.1): it lies behind it or below the horizon, or the mirrored direction misses it and the lobe is weak towards all corners.
    pub(super) fn misses(&self, lobe: &Lobe, origin: Vec3) -> bool {
        let corners = self.light.corners().map(|corner| (corner - origin).normalize_or_zero());
        if !self.light.emits_towards(origin) || corners.iter().all(|&to| lobe.normal.dot(to) <= 0.0) {
            return true;
        }
        let (inside, met) = (inside(self.light), self.meets(origin, lobe.mirrored));
        if met.is_some_and(|(_, uv)| inside(uv)) {
            return false;
        }
        let weak = |to: Vec3| lobe.power(to) < self.config.cull_threshold;
        let LightFrame { origin: corner, u, v } = self.frame;
        let towards = |uv: Vec2| (corner + u * uv.x + v * uv.y - origin).normalize_or_zero();
        let nearest = || match met {
            Some((_, uv)) => weak(towards(uv.clamp(Vec2::ZERO, Vec2::ONE))),
            None => [[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]]
                .into_iter()
                .all(|uv| weak(towards(Vec2::from_array(uv)))),
        };
        corners.into_iter().all(weak) && (!self.config.cull_outline || nearest())
    }

    /// Width of a lobe's cross-section where it meets the light, m, and the distance to there. Where it misses the light's plane, that is the distance of the light's middle.
    pub(super) fn width(&self, lobe: &Lobe, origin: Vec3) -> (f32, f32) {
        let middle = (self.light.centre() - origin).length();
        let distance =
            self.meets(origin, lobe.mirrored).map_or(middle, |(distance, _)| distance.min(4.0 * middle));
        (2.0 * distance * lobe.reach(self.config.lobe_edge), distance)
    }

    /// Gathers what a lobe reflects. `phase` is the fragment's place in its 2 × 2 block. Returns also the number of shadow rays.
    pub(super) fn gather(&self, lobe: &Lobe, origin: Vec3, phase: usize) -> (Gathered, u64) {
        let edge = self.config.lobe_edge;
        let (mut value, mut inside) = (Vec3::ZERO, 0);
        let (mut ends, mut light) = (Vec::new(), Vec::new());
        for sample in &self.samples {
            let away = sample.point - origin;
            let squared = away.length_squared().max(f32::MIN_POSITIVE);
            let to = away / squared.sqrt();
            let power = lobe.power(to);
            inside += u32::from(power >= edge);
            let geometry = to.dot(self.unit).abs() / squared * self.stratum;
            let reflected = lobe.reflected(to) * geometry;
            if reflected > 0.0 && power > 1e-4 {
                value += sample.factors * reflected;
                ends.push(sample.point);
                light.push(sample.factors * reflected);
            }
        }
        if inside < self.config.few {
            return self.grid(lobe, origin, phase);
        }
        if self.config.visibility == LobeVisibility::None {
            return (Gathered::Value(value), 0);
        }
        let mut parts = vec![0.0; ends.len()];
        self.trace(origin, &ends, &mut parts);
        let seen = light.iter().zip(&parts).filter(|(_, part)| **part >= 1.0);
        (Gathered::Value(seen.map(|(light, _)| *light).sum()), ends.len() as u64)
    }

    fn trace(&self, origin: Vec3, ends: &[Vec3], parts: &mut [f32]) {
        let scene = self.surfaces.scene;
        scene.bvh().first_hits(&scene.scene().mesh, origin, ends, parts);
    }

    /// Gathers from directions on a grid around the mirrored one, as wide as the lobe. Weights are those of the lobe, normalised over all directions, also those that
    /// miss the light.
    fn grid(&self, lobe: &Lobe, origin: Vec3, phase: usize) -> (Gathered, u64) {
        let side = self.config.grid as usize;
        let (right, up) = lobe.mirrored.any_orthonormal_pair();
        let spacing = 2.0 * lobe.reach(self.config.lobe_edge) / side as f32;
        let inside = inside(self.light);
        let variance = self.config.visibility == LobeVisibility::Variance;
        let mut grid = Grid { light: vec![Vec3::ZERO; side * side], parts: vec![1.0; side * side] };
        let (mut all, mut ends, mut places) = (0.0, Vec::new(), Vec::new());
        // With the variance, one corner is left out (§3.3.3: 24 of 25).
        for place in usize::from(variance)..side * side {
            let shift = |index: usize| (index as f32 + 0.5 - 0.5 * side as f32) * spacing;
            let (x, y) = (shift(place % side), shift(place / side));
            let direction = lobe.mirrored + right * x + up * y;
            let squared = direction.length_squared();
            // Solid angle of a cell of the grid, which lies on a plane at distance 1.
            let weight = lobe.power(direction / squared.sqrt()) / (squared * squared.sqrt());
            all += weight;
            let Some((distance, uv)) = self.meets(origin, direction) else { continue };
            if !inside(uv) || lobe.normal.dot(direction) <= 0.0 {
                continue;
            }
            let half =
                Vec2::new(self.frame.u.length(), self.frame.v.length()).recip() * (0.5 * spacing * distance);
            grid.light[place] = self.factors(uv, half) * weight;
            if self.config.visibility != LobeVisibility::None {
                let traced = !(variance && self.config.interleaved) || place % 4 == phase;
                grid.parts[place] = -1.0;
                if traced {
                    ends.push(origin + direction * distance);
                    places.push(place);
                }
            }
        }
        let scale = if all > 0.0 { lobe.whole() / all } else { 0.0 };
        grid.light.iter_mut().for_each(|light| *light *= scale);
        let mut parts = [0.0; MOST];
        self.trace(origin, &ends, &mut parts[..ends.len()]);
        for (&place, part) in places.iter().zip(parts) {
            grid.parts[place] = part.min(1.0);
        }
        (Gathered::Grid(grid), ends.len() as u64)
    }

    /// Factors of the radiance around a place on the light.
    fn factors(&self, uv: Vec2, half: Vec2) -> Vec3 {
        let Some(texture) = &self.texture else { return Vec3::ONE };
        let (low, high) = ((uv - half).max(Vec2::ZERO), (uv + half).min(Vec2::ONE));
        if self.config.filtered && (high - low).min_element() > 0.0 {
            texture.mean_over(low, high).truncate()
        } else {
            texture.at(uv)
        }
    }
}

/// Returns the test for places of a light's frame that emit.
pub(super) fn inside(light: &AreaLight) -> impl Fn(Vec2) -> bool + use<> {
    let extent = light.extent();
    move |uv: Vec2| uv.min_element() >= 0.0 && uv.max_element() <= 1.0 && extent.contains(uv)
}
