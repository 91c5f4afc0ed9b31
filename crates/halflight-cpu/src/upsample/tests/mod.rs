//! Properties of all upsamplers, and of the robust ones.

mod support;

use halflight_core::fragment::Fragments;
use halflight_core::gbuffer::GBuffer;
use halflight_core::glam::Vec3;
use halflight_core::stages::Upsampler;
use halflight_core::values::{NO_VALUE, Values};
use proptest::prelude::*;

use super::*;
use crate::tangent_plane::DiscontinuityLimits;
use support::{
    Plane, Random, WALL, all, corner_cells, planes, push_cell, quadtree, sample_at, upsample,
    upsample_channels, values_by,
};

/// First pixel that is not `expected` within `tolerance`, with its value. Background must be exactly 0.
fn first_off(gbuffer: &GBuffer, out: &[f32], expected: f32, tolerance: f32) -> Option<(usize, f32)> {
    first_outside(gbuffer, out, expected - tolerance, expected + tolerance)
}

/// First receiver outside the bounds, or first other pixel that is not 0.
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

/// Random image of planes in random rectangles, some of them background, with random cells.
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

/// Random values in 0 … 1, of which one in eight does not exist.
fn some_values(fragments: &Fragments, random: &mut Random) -> Vec<f32> {
    let mut value = |_: &_| if random.below(8) > 0 { random.unit() } else { NO_VALUE };
    fragments.samples().iter().map(&mut value).collect()
}

fn ours() -> [(&'static str, Box<dyn Upsampler>); 4] {
    [
        ("bilinear", Box::new(Bilinear::default())),
        ("rbf-robust", Box::new(RbfRobust::default())),
        ("delaunay", Box::new(Delaunay::default())),
        ("lattice", Box::new(Lattice::default())),
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
        let values = some_values(&fragments, &mut random);
        // One value more than there are, so that images without any defined sample may be 0.
        let known = || values.iter().copied().filter(|value| !value.is_nan());
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
        assert!(first_outside(&gbuffer, &out, 0.0, 1.0).is_some());
    }
}

/// Root-mean-square error, least and largest value on a flat field of ones in a 16² fragment, amid samples of
/// random levels at random positions along its edges.
fn flat_field_error(upsampler: &mut dyn Upsampler) -> (f64, f32, f32) {
    let gbuffer = planes(48, 48, |_, _| Some(WALL));
    let mut random = Random(1);
    let (mut sum, mut low, mut high) = (0.0, f32::INFINITY, f32::NEG_INFINITY);
    const SETS: u32 = 400;
    for _ in 0..SETS {
        let mut fragments = Fragments::default();
        fragments.reset(48, 48, 0);
        for (x, y) in (0..3).flat_map(|y| (0..3).map(move |x| (x, y))) {
            let level = if (x, y) == (1, 1) { 4 } else { random.below(5) as u8 };
            let half = 0.5 * f32::from(level).exp2();
            // Adjacent to the fragment, anywhere along its edge.
            let place = |cell: u32, random: &mut Random| match cell {
                0 => 16.0 - half,
                1 if level < 4 => 16.0 + 16.0 * random.unit(),
                1 => 24.0,
                _ => 32.0 + half,
            };
            let (sx, sy) = (place(x, &mut random), place(y, &mut random));
            let sample = sample_at(&mut fragments, sx, sy, level);
            fragments.push_cell(4, x, y, &[sample]);
        }
        let values = values_by(&fragments, |_, _| 1.0);
        let out = upsample(upsampler, &gbuffer, &fragments, &values);
        for value in (16..32).flat_map(|y| (16..32).map(move |x| y * 48 + x)).map(|pixel| out[pixel]) {
            sum += f64::from(value - 1.0).powi(2);
            (low, high) = (low.min(value), high.max(value));
        }
    }
    ((sum / f64::from(SETS * 256)).sqrt(), low, high)
}

#[test]
fn the_papers_rbf_errs_on_flat_fields_as_measured() {
    // An independent experiment with other random sample sets found 7.6 % (0.92 … 1.18) with the fixed
    // variance and 3.1 % (0.98 … 1.08) with the adaptive one: within a quarter, the artefact is the same on
    // other sets.
    let (fixed, low, high) = flat_field_error(&mut RbfFixed::default());
    assert!((0.057..0.095).contains(&fixed) && low < 0.92 && high > 1.1, "{fixed} {low} {high}");
    let (adaptive, low, high) = flat_field_error(&mut RbfAdaptive::default());
    assert!((0.023..0.039).contains(&adaptive) && low < 0.98 && high > 1.05, "{adaptive} {low} {high}");
    assert!(flat_field_error(&mut RbfRobust::default()).0 < 1e-6);
}

/// Largest error against a function over receiver pixels at least `margin` from the border.
fn worst(gbuffer: &GBuffer, out: &[f32], margin: u32, truth: impl Fn(f32, f32) -> f32) -> f32 {
    let (width, height) = (gbuffer.width, gbuffer.height);
    let mut worst = 0.0f32;
    for y in margin..height - margin {
        for x in margin..width - margin {
            let error = (out[gbuffer.index(x, y)] - truth(x as f32 + 0.5, y as f32 + 0.5)).abs();
            // NaN must not be lost in the comparison.
            worst = if error > worst || error.is_nan() { error } else { worst };
        }
    }
    worst
}

#[test]
fn ramps_are_followed() {
    let gbuffer = planes(160, 128, |_, _| Some(WALL));
    let mut random = Random(3);
    let fragments = quadtree(160, 128, 4, true, &mut |_, _, _| random.below(100) < 50);
    let ramp = |x: f32, y: f32| 0.1 + 0.004 * x + 0.002 * y;
    let values = values_by(&fragments, ramp);
    let error = |upsampler: &mut dyn Upsampler| {
        worst(&gbuffer, &upsample(upsampler, &gbuffer, &fragments, &values), 16, ramp)
    };
    // Exact inside triangles; rounding of the weights (1e-6) and the least weight of a corner (1e-5 of the
    // ramp's range) remain. The fit's stiffness leaves part of the slope to the average: half of what copying
    // would err by at a fragment's corner, 8 × 0.006.
    assert!(error(&mut Delaunay::default()) < 1e-5);
    assert!(error(&mut RbfRobust::default()) < 0.024);
    assert!(error(&mut Bilinear::default()) > 0.024);
    assert!(error(&mut RbfFixed::default()) > 0.024);
}

#[test]
fn values_do_not_bleed_across_a_step_between_two_planes() {
    let near = Plane { normal: WALL.normal, distance: -4.8 };
    let on_near = |x: u32, y: u32| 3 * x + y > 190;
    let gbuffer = planes(96, 96, |x, y| Some(if on_near(x, y) { near } else { WALL }));
    let size = |level: u8| 1u32 << level;
    // Refined at the depth discontinuity down to 2×2 pixels, as in the papers; the value of a mixed fragment
    // is wrong on either side.
    let fragments = quadtree(96, 96, 5, true, &mut |level, cx, cy| {
        let mut sides = (0..size(level)).flat_map(|dy| (0..size(level)).map(move |dx| (dx, dy)));
        let first = on_near(cx << level, cy << level);
        level > 1 && sides.any(|(dx, dy)| on_near((cx << level) + dx, (cy << level) + dy) != first)
    });
    let side = |pixel: usize| if on_near(pixel as u32 % 96, pixel as u32 / 96) { 1.0f32 } else { 0.0 };
    let values: Vec<_> = fragments
        .samples()
        .iter()
        .map(|sample| {
            let (x, y) = (sample.pixel as usize % 96, sample.pixel as usize / 96);
            let quad =
                [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| side((y - dy.min(y)) * 96 + x - dx.min(x)));
            if sample.level == 1 { quad.iter().sum::<f32>() / 4.0 } else { side(sample.pixel as usize) }
        })
        .collect();
    let bleeding = |upsampler: &mut dyn Upsampler| {
        let out = upsample(upsampler, &gbuffer, &fragments, &values);
        out.iter().enumerate().map(|(pixel, value)| (value - side(pixel)).abs()).fold(0.0, f32::max)
    };
    // Samples on the other side weigh nothing and mixed ones a ten-thousandth. Where the nearest good sample
    // is twenty pixels away, and so weighs a four-hundredth itself, a twentieth may bleed.
    let [robust, triangles] = [bleeding(&mut RbfRobust::default()), bleeding(&mut Delaunay::default())];
    assert!(robust < 0.05 && triangles < 0.05, "{robust} {triangles}");
    assert!(bleeding(&mut RbfFixed::default()) > 0.2);
    // Without surface limits the robust upsampler bleeds as well.
    let blind = SurfaceLimits { offset_px: 1e6, break_deg: 180.0, ..SurfaceLimits::default() };
    assert!(bleeding(&mut RbfRobust::new(RbfRobustConfig { surface: blind, ..Default::default() })) > 0.2);
    assert!(bleeding(&mut Delaunay::new(DelaunayConfig { surface: blind })) > 0.2);
}

#[test]
fn thread_counts_do_not_matter() {
    let (gbuffer, fragments) = random_case(11, 333, 222);
    let mut random = Random(5);
    let values: Vec<_> = fragments.samples().iter().map(|_| random.unit()).collect();
    let run = |threads: usize, index: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| upsample(&mut *all()[index].1, &gbuffer, &fragments, &values))
    };
    for (index, (name, mut upsampler)) in all().into_iter().enumerate() {
        let bits = |out: Vec<f32>| out.into_iter().map(f32::to_bits).collect::<Vec<_>>();
        let one = bits(run(1, index));
        assert_eq!(one, bits(run(2, index)), "{name}");
        assert_eq!(one, bits(run(8, index)), "{name}");
        // A used upsampler gives the same values as a new one, with the same memory.
        let first = upsample(&mut *upsampler, &gbuffer, &fragments, &values);
        let bytes = upsampler.bytes();
        assert_eq!(bits(first), one, "{name}");
        assert_eq!(bits(upsample(&mut *upsampler, &gbuffer, &fragments, &values)), one, "{name}");
        assert!(bytes > 0 && upsampler.bytes() == bytes, "{name}");
        assert_ne!(one.iter().filter(|&&bits| bits != 0).count(), 0, "{name}");
    }
}

#[test]
fn channels_are_computed_as_if_each_were_alone() {
    let bits = |plane: &[f32]| plane.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let (mixed, corners) = (random_case(7, 133, 102), corner_cells(70, 45, 4));
    for (gbuffer, fragments) in [mixed, (planes(70, 45, |x, _| (x != 31).then_some(WALL)), corners)] {
        let single = some_values(&fragments, &mut Random(9));
        let mut values = Values::default();
        values.reset(3, single.len());
        for (channel, factor) in [1.0, 2.0, 3.0].into_iter().enumerate() {
            for (value, single) in values.channel_mut(channel).iter_mut().zip(&single) {
                *value = factor * single;
            }
        }
        for (index, (name, mut upsampler)) in all().into_iter().enumerate() {
            let out = upsample_channels(&mut *upsampler, &gbuffer, &fragments, &values);
            assert!(out.channel(0).iter().any(|&value| value > 0.0), "{name}");
            for channel in 0..3 {
                let alone = upsample(&mut *all()[index].1, &gbuffer, &fragments, values.channel(channel));
                assert_eq!(bits(out.channel(channel)), bits(&alone), "{name} {channel}");
            }
        }
    }
}

#[test]
fn samples_at_shared_corners_work() {
    let gbuffer = planes(70, 45, |x, _| (x != 31).then_some(WALL));
    let fragments = corner_cells(70, 45, 4);
    let ramp = |x: f32, y: f32| 0.2 + 0.003 * x + 0.002 * y;
    let values = values_by(&fragments, ramp);
    for (name, mut upsampler) in all() {
        let out = upsample(&mut *upsampler, &gbuffer, &fragments, &values);
        // Upsamplers of the papers may overshoot, but not by more than the values themselves.
        assert_eq!(first_outside(&gbuffer, &out, 0.0, 2.0), None, "{name}");
        if matches!(name, "rbf-robust" | "delaunay" | "lattice") {
            assert_eq!(first_outside(&gbuffer, &out, ramp(0.5, 0.5), ramp(69.5, 44.5)), None, "{name}");
            for (sample, value) in fragments.samples().iter().zip(&values) {
                assert_eq!(out[sample.pixel as usize], *value, "{name}");
            }
        }
    }
}

#[test]
fn between_corners_ramps_are_exact_and_steps_are_kept() {
    let gbuffer = planes(70, 45, |_, _| Some(WALL));
    let fragments = corner_cells(70, 45, 4);
    let ramp = |x: f32, y: f32| 0.2 + 0.003 * x + 0.002 * y;
    let out = upsample(&mut Lattice::default(), &gbuffer, &fragments, &values_by(&fragments, ramp));
    // Four products and a division of numbers below 1.
    assert!(worst(&gbuffer, &out, 0, ramp) < 1e-6);
    // A depth discontinuity inside cells: every pixel takes the values of its own side. Without surface
    // limits it would not.
    let near = Plane { normal: WALL.normal, distance: -4.0 };
    let gbuffer = planes(70, 45, |x, _| Some(if x < 23 { near } else { WALL }));
    let values = values_by(&fragments, |x, _| if x < 23.0 { 0.0 } else { 1.0 });
    let side = |x: f32, _: f32| if x < 23.0 { 0.0 } else { 1.0 };
    let out = upsample(&mut Lattice::default(), &gbuffer, &fragments, &values);
    assert_eq!(worst(&gbuffer, &out, 0, side), 0.0);
    let discontinuity = DiscontinuityLimits { crease_deg: 90.0, step_px: 1e9 };
    let blind = LatticeConfig { discontinuity, ..LatticeConfig::default() };
    let out = upsample(&mut Lattice::new(blind), &gbuffer, &fragments, &values);
    assert!(worst(&gbuffer, &out, 0, side) > 0.2);
}

#[test]
fn cells_of_other_refiners_are_computed_like_rbf_robust() {
    let (gbuffer, _) = random_case(4, 90, 70);
    let fragments =
        quadtree(90, 70, 4, true, &mut |level, x, y| (u32::from(level) + x + y).is_multiple_of(3));
    let values = values_by(&fragments, |x, y| (0.1 * x).sin() + (0.07 * y).cos() + 2.0);
    let robust = upsample(&mut RbfRobust::default(), &gbuffer, &fragments, &values);
    let lattice = upsample(&mut Lattice::default(), &gbuffer, &fragments, &values);
    let sample = |pixel: usize| fragments.samples().iter().any(|s| s.level == 0 && s.pixel as usize == pixel);
    for pixel in 0..gbuffer.pixels() {
        assert!(robust[pixel] == lattice[pixel] || sample(pixel), "{pixel}");
    }
}

#[test]
fn cells_without_values_take_them_from_their_neighbours() {
    let gbuffer = planes(64, 64, |_, _| Some(WALL));
    let fragments = quadtree(64, 64, 3, true, &mut |_, _, _| false);
    let hidden = |x: f32, y: f32| (x - 20.0).abs() < 4.5 && (y - 20.0).abs() < 4.5;
    let values = values_by(&fragments, |x, y| if hidden(x, y) { NO_VALUE } else { 0.5 });
    assert!(values.iter().any(|value| value.is_nan()));
    for (name, mut upsampler) in ours() {
        let out = upsample(&mut *upsampler, &gbuffer, &fragments, &values);
        // At its coarsest level bilinear has no source, and leaves 0.
        let low = if name == "bilinear" { 0.0 } else { 0.5 };
        assert_eq!(first_outside(&gbuffer, &out, low, 0.5), None, "{name}");
    }
    let none = vec![NO_VALUE; values.len()];
    for (name, mut upsampler) in all() {
        let out = upsample(&mut *upsampler, &gbuffer, &fragments, &none);
        assert!(out.iter().all(|&value| value == 0.0), "{name}");
    }
}

#[test]
fn pixels_without_a_cell_and_arguments_that_disagree_give_zero() {
    let gbuffer = planes(20, 10, |_, _| Some(WALL));
    let mut fragments = Fragments::default();
    fragments.reset(20, 10, 0);
    push_cell(&mut fragments, 3, 0, 0, true);
    let values = values_by(&fragments, |_, _| 1.0);
    for (name, mut upsampler) in all() {
        let out = upsample(&mut *upsampler, &gbuffer, &fragments, &values);
        let inside = |pixel: usize| pixel % 20 < 8 && pixel / 20 < 8;
        assert!(out.iter().enumerate().all(|(pixel, &value)| (value > 0.5) == inside(pixel)), "{name}");
        let out = upsample(&mut *upsampler, &gbuffer, &fragments, &values[1..]);
        assert!(out.iter().all(|&value| value == 0.0), "{name}");
        let out = upsample(&mut *upsampler, &planes(10, 20, |_, _| Some(WALL)), &fragments, &values);
        assert!(out.iter().all(|&value| value == 0.0), "{name}");
    }
}

#[test]
fn a_pole_thinner_than_any_fragment_takes_its_mixture() {
    let near = Plane { normal: WALL.normal, distance: -4.0 };
    let gbuffer = planes(32, 32, |x, _| Some(if x == 20 { near } else { WALL }));
    let fragments = quadtree(32, 32, 4, true, &mut |level, x, _| level > 1 && x == 20 >> level);
    let mixed = |x: f32| (19.0..23.0).contains(&x);
    let values: Vec<_> =
        fragments.samples().iter().map(|s| if s.level == 1 && mixed(s.x) { 0.5 } else { 0.0 }).collect();
    let out = upsample(&mut RbfRobust::default(), &gbuffer, &fragments, &values);
    // No sample lies on the pole; the wall beside it must not be affected by the mixture.
    for y in 0..32 {
        assert!((0.3..=0.5).contains(&out[y * 32 + 20]), "{}", out[y * 32 + 20]);
        assert!(out[y * 32 + 18] < 0.01 && out[y * 32 + 23] < 0.01);
    }
}
