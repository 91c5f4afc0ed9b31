//! What every upsampler must do, and what only ours do.

mod support;

use halflight_core::fragment::Fragments;
use halflight_core::gbuffer::GBuffer;
use halflight_core::glam::Vec3;
use halflight_core::stages::Upsampler;
use proptest::prelude::*;

use super::*;
use support::{Plane, Random, WALL, all, corner_cells, planes, quadtree, upsample, values_by};

/// The first pixel that is not `expected` within `tolerance`, with its value. Sky must be exactly 0.
fn first_off(gbuffer: &GBuffer, out: &[f32], expected: f32, tolerance: f32) -> Option<(usize, f32)> {
    first_outside(gbuffer, out, expected - tolerance, expected + tolerance)
}

/// The first receiver outside the bounds, or other pixel that is not 0.
fn first_outside(gbuffer: &GBuffer, out: &[f32], low: f32, high: f32) -> Option<(usize, f32)> {
    out.iter().copied().enumerate().find(|&(pixel, value)| {
        let (low, high) = if gbuffer.is_receiver(pixel) { (low, high) } else { (0.0, 0.0) };
        !(low..=high).contains(&value)
    })
}

/// Slanted floor planes that face the camera at various angles.
fn random_plane(random: &mut Random) -> Plane {
    let normal = Vec3::new(random.unit() - 0.5, random.unit() - 0.5, 0.6).normalize();
    Plane { normal, distance: -(3.0 + 4.0 * random.unit()) * normal.z }
}

/// A random image of planes in random rectangles, some of them sky, with random cells.
fn random_case(seed: u32, width: u32, height: u32) -> (GBuffer, Fragments) {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9));
    let count = 1 + random.below(4) as usize;
    let patches: Vec<_> = (0..count)
        .map(|_| {
            let (x, y) = (random.below(width), random.below(height));
            let plane = (random.below(5) > 0).then(|| random_plane(&mut random));
            (x, y, x + random.below(width), y + random.below(height), plane)
        })
        .collect();
    let base = random_plane(&mut random);
    let gbuffer = planes(width, height, |x, y| {
        let hit = patches.iter().rev().find(|p| (p.0..p.2).contains(&x) && (p.1..p.3).contains(&y));
        hit.map_or(Some(base), |patch| patch.4)
    });
    let (top, share) = (random.below(7) as u8, random.below(100));
    let additional = random.below(2) == 1;
    let fragments = quadtree(width, height, top, additional, &mut |_, _, _| random.below(100) < share);
    (gbuffer, fragments)
}

fn ours() -> [(&'static str, Box<dyn Upsampler>); 3] {
    [
        ("bilinear", Box::new(Bilinear::default())),
        ("rbf-robust", Box::new(RbfRobust::default())),
        ("delaunay", Box::new(Delaunay::default())),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn flat_fields_stay_flat(seed: u32, width in 1u32..150, height in 1u32..150, value in 0.0f32..1e3) {
        let (gbuffer, fragments) = random_case(seed, width, height);
        let values = values_by(&fragments, |_, _| value);
        for (name, mut upsampler) in ours() {
            let out = upsample(&mut *upsampler, &gbuffer, &fragments, &values);
            prop_assert_eq!(first_off(&gbuffer, &out, value, 1e-5 * value), None, "{}", name);
        }
    }

    #[test]
    fn outputs_lie_within_the_samples_bounds(seed: u32, width in 1u32..150, height in 1u32..150) {
        let (gbuffer, fragments) = random_case(seed, width, height);
        let mut random = Random(seed);
        let values: Vec<_> =
            fragments.samples().iter().map(|_| (random.below(8) > 0).then(|| random.unit())).collect();
        // One value more than there are, so that images without any defined sample may be 0.
        let known = || values.iter().flatten().copied();
        let (low, high) = (known().fold(f32::INFINITY, f32::min), known().fold(0.0, f32::max));
        for (name, mut upsampler) in ours() {
            let out = upsample(&mut *upsampler, &gbuffer, &fragments, &values);
            // A pixel that no sample reaches is 0. The average of bilinear is rounded.
            let low = if name == "bilinear" || known().count() < 40 { 0.0 } else { low };
            prop_assert_eq!(first_outside(&gbuffer, &out, low, high * (1.0 + 1e-6)), None, "{}", name);
        }
    }
}

#[test]
fn the_papers_rbf_fails_the_flat_field_check() {
    let gbuffer = planes(64, 64, |_, _| Some(WALL));
    let fragments = quadtree(64, 64, 4, true, &mut |_, _, _| false);
    let values = values_by(&fragments, |_, _| 1.0);
    for upsampler in [&mut RbfFixed::default() as &mut dyn Upsampler, &mut RbfAdaptive::default()] {
        let out = upsample(upsampler, &gbuffer, &fragments, &values);
        assert!(first_off(&gbuffer, &out, 1.0, 1e-3).is_some());
        assert!(first_outside(&gbuffer, &out, 1.0, 1.0).is_some());
    }
}
