//! Converged reflection of Phong lobes: directions distributed as the lobe, exact visibility, single texels.

use std::f32::consts::TAU;

use glam::Vec3;
use halflight_core::hash;
use halflight_core::pattern::{Pattern, PatternError, PatternKind};
use rayon::prelude::*;

use super::Surfaces;
use super::config::{LobeVisibility, PhongConfig};
use super::gather::{Light, inside};
use super::lobe::Lobe;

/// Distinguishes the random numbers from those of other stages.
const DIRECTIONS: u32 = 0x9b0f_17c3;

/// Returns what each pixel reflects specularly of all lights, W/m²/sr: `directions` of each lobe, distributed as the lobe is, and a shadow ray for each that meets
/// the light. `visibility` other than none takes exact visibility. Samples with other seeds are independent.
///
/// # Errors
/// Never for at least one direction.
pub fn truth(
    surfaces: &Surfaces,
    directions: u32,
    visibility: LobeVisibility,
    seed: u32,
) -> Result<Vec<Vec3>, PatternError> {
    let pattern = Pattern::with_count(PatternKind::Grid, 1)?;
    let frame = surfaces.frame(pattern);
    let mut out = vec![Vec3::ZERO; surfaces.gbuffer.pixels()];
    for number in 0..frame.scene.lights.len() as u32 {
        let config = PhongConfig { cull_threshold: 1e-12, cull_outline: true, ..PhongConfig::default() };
        let light = Light::new(surfaces, &frame, number, &config);
        let texture = frame.light_texture(number);
        let inside = inside(light.light);
        out.par_iter_mut().enumerate().with_min_len(64).for_each(|(pixel, out)| {
            if !surfaces.is_glossy(pixel) {
                return;
            }
            let Some((lobe, origin)) = light.lobe(pixel) else { return };
            if light.misses(&lobe, origin) {
                return;
            }
            let key = hash::fold(hash::pattern_key(pixel as u32, number, 0, seed), DIRECTIONS);
            let (shift, turn) = hash::unit_pair(hash::sample_bits(key, 0));
            let (mut ends, mut values) = (Vec::new(), Vec::new());
            for index in 0..directions {
                let along = (index as f32 + shift) / directions as f32;
                let around = (index.reverse_bits() >> 8) as f32 / (1 << 24) as f32 + turn;
                let direction = sampled(&lobe, along, around);
                let cosine = lobe.normal.dot(direction);
                let Some((distance, uv)) = light.meets(origin, direction) else { continue };
                if cosine > 0.0 && inside(uv) {
                    ends.push(origin + direction * distance);
                    values.push(texture.as_ref().map_or(Vec3::ONE, |texture| texture.at(uv)) * cosine);
                }
            }
            let mut parts = vec![f32::INFINITY; ends.len()];
            if visibility != LobeVisibility::None {
                surfaces.scene.bvh().first_hits(&frame.scene.mesh, origin, &ends, &mut parts);
            }
            let seen = values.iter().zip(&parts).filter(|(_, part)| **part >= 1.0);
            let sum: Vec3 = seen.map(|(value, _)| *value).sum();
            // The lobe over the density of its directions, (n + 1) / 2π · (R·L)ⁿ.
            let scale = (lobe.exponent + 2.0) / ((lobe.exponent + 1.0) * directions.max(1) as f32);
            *out += sum * scale * light.light.radiance * surfaces.specular(pixel).f0;
        });
    }
    Ok(out)
}

/// Returns a direction distributed as (R·L)ⁿ, from two numbers in 0 … 1.
fn sampled(lobe: &Lobe, along: f32, around: f32) -> Vec3 {
    let cosine = (1.0 - along).powf(1.0 / (lobe.exponent + 1.0));
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (right, up) = lobe.mirrored.any_orthonormal_pair();
    let (s, c) = (around * TAU).sin_cos();
    lobe.mirrored * cosine + (right * c + up * s) * sine
}
