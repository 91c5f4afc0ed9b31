//! Grain of noise of known size in a penumbra, and of errors that are none.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use glam::Vec3;
use halflight_metrics::{CompareError, Image, Role, compare};

const WIDTH: usize = 160;
const HEIGHT: usize = 120;
/// First and last column of the penumbra.
const EDGES: (usize, usize) = (40, 120);

/// Visible fraction: umbra on the left, penumbra in the middle, all of the light on the right.
fn fraction(i: usize) -> f32 {
    let x = (i % WIDTH) as f32 - EDGES.0 as f32;
    (x / (EDGES.1 - EDGES.0) as f32).clamp(0.0, 1.0)
}

fn fractions() -> Vec<f32> {
    (0..WIDTH * HEIGHT).map(fraction).collect()
}

/// A gray image of a value for each pixel.
fn image(value: impl Fn(usize) -> f32) -> Vec<Vec3> {
    (0..WIDTH * HEIGHT).map(|i| Vec3::splat(value(i))).collect()
}

/// Grain against the penumbra, of an error added to it.
fn grain(error: impl Fn(usize) -> f32) -> f64 {
    let (noisy, reference) = (image(|i| fraction(i) + error(i)), image(fraction));
    measured(&noisy, &reference, &fractions()).unwrap()
}

fn measured(image: &[Vec3], reference: &[Vec3], fractions: &[f32]) -> Option<f64> {
    let view = |pixels| Image::new(WIDTH as u32, HEIGHT as u32, pixels).unwrap();
    let reference = view(reference).with_visible_fractions(fractions).unwrap();
    compare(view(image), reference).unwrap().grain
}

/// A number in -1..1 that depends on all bits of its argument.
fn noise(i: usize) -> f32 {
    let mut h = (i as u32).wrapping_mul(0x9e37_79b9);
    for _ in 0..3 {
        h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    }
    (h >> 7) as f32 / (1 << 24) as f32 - 1.0
}

/// Noise blurred by a Gaussian of 3 pixels, as blotches are, of standard deviation 1.
fn blotches() -> Vec<f32> {
    let taps: Vec<f32> = (-9i32..=9).map(|x| (-(x * x) as f32 / 18.0).exp()).collect();
    let blurred = |plane: &[f32], step: isize, size: isize| -> Vec<f32> {
        let tap = |i: usize, (k, tap): (usize, &f32)| {
            // Around the edges: all pixels have noise of one size.
            let place = (i as isize / step) % size;
            let moved = (place + k as isize - 9).rem_euclid(size) - place;
            tap * plane[(i as isize + moved * step) as usize]
        };
        (0..plane.len()).map(|i| taps.iter().enumerate().map(|t| tap(i, t)).sum()).collect()
    };
    let plane: Vec<f32> = (0..WIDTH * HEIGHT).map(noise).collect();
    let plane = blurred(&blurred(&plane, 1, WIDTH as isize), WIDTH as isize, HEIGHT as isize);
    let deviation = (plane.iter().map(|v| v * v).sum::<f32>() / plane.len() as f32).sqrt();
    plane.iter().map(|v| v / deviation).collect()
}

#[test]
fn blotches_are_ranked_and_grow_in_proportion() {
    let blotches = blotches();
    let [whole, quarter, none] = [0.04, 0.01, 0.0].map(|size| grain(|i| size * blotches[i]));
    assert_eq!(none, 0.0);
    assert!(whole > quarter && quarter > none);
    // Rounding of values near 1 in `f32`, 6e-8, over a penumbra that is as dark as 0.01.
    assert!((whole / quarter - 4.0).abs() < 1e-3, "{whole} {quarter}");
    // A 99th percentile is two to three deviations, and darker than half of the light is half of the penumbra.
    assert!((2.0 * 0.04..20.0 * 0.04).contains(&whole), "{whole}");
}

#[test]
fn noise_of_a_pixel_counts_as_blotches_do() {
    let blotches = blotches();
    // Uniform noise has a deviation of 1/√3.
    let fine = grain(|i| 0.01 * 3.0f32.sqrt() * noise(i));
    let coarse = grain(|i| 0.01 * blotches[i]);
    assert!((0.6..1.7).contains(&(fine / coarse)), "{fine} {coarse}");
}

#[test]
fn constant_offsets_have_no_grain_and_smooth_bias_little() {
    // Rounding of values near 1 in `f32`, 6e-8, over the least light, the floor of 0.02.
    assert!(grain(|_| 0.1) < 6e-6);
    let blotches = blotches();
    let noisy = grain(|i| 0.05 * blotches[i]);
    let smooth = grain(|i| 0.05 * 2.0f32.sqrt() * ((i / WIDTH) as f32 * std::f32::consts::TAU / 100.0).sin());
    // Of a period of 100 pixels 7 % are left, and more where the image ends.
    assert!(smooth < 0.25 * noisy, "{smooth} {noisy}");
}

#[test]
fn errors_outside_of_the_penumbra_do_not_count() {
    let outside = |i: usize| !(EDGES.0 + 1..EDGES.1).contains(&(i % WIDTH));
    assert_eq!(grain(|i| if outside(i) { noise(i) } else { 0.0 }), 0.0);
    let reference = image(|i| fraction(i) + 0.1);
    let noisy = image(|i| fraction(i) + 0.1 + 0.05 * noise(i));
    assert!(measured(&noisy, &reference, &fractions()).unwrap() > 0.0);
    // Neither where all is lit, nor where no light could arrive.
    for everywhere in [0.0, 0.001, 0.999, 1.0, f32::NAN] {
        let fractions = vec![everywhere; WIDTH * HEIGHT];
        assert_eq!(measured(&noisy, &reference, &fractions), None, "{everywhere}");
    }
}

#[test]
fn grain_is_relative_to_the_light_around() {
    let reference = |light: f32| image(|i| if i == 0 { 1.0 } else { light });
    let noisy = |light: f32| image(|i| if i == 0 { 1.0 } else { light + 0.001 * noise(i) });
    let half = vec![0.5; WIDTH * HEIGHT];
    let [bright, dim, black] =
        [0.8, 0.08, 0.0].map(|light| measured(&noisy(light), &reference(light), &half).unwrap());
    // Contrasts over 0.82, 0.1 and the floor of 0.02 alone; the brightest pixel lifts the light around it.
    assert!((dim / bright / 8.2 - 1.0).abs() < 0.05, "{dim} {bright}");
    assert!((black / bright / 41.0 - 1.0).abs() < 0.05, "{black} {bright}");
}

#[test]
fn masked_pixels_have_no_grain() {
    let (reference, fractions) = (image(fraction), fractions());
    let mask: Vec<bool> = (0..WIDTH * HEIGHT).map(|i| i % WIDTH < 80).collect();
    fn view<'a>(pixels: &'a [Vec3], mask: &'a [bool]) -> Image<'a> {
        Image::new(WIDTH as u32, HEIGHT as u32, pixels).unwrap().with_mask(mask).unwrap()
    }
    let found = |error: &dyn Fn(usize) -> f32| {
        let noisy = image(|i| fraction(i) + error(i));
        compare(view(&noisy, &mask), view(&reference, &mask).with_visible_fractions(&fractions).unwrap())
    };
    let plain = found(&|i| 0.01 * noise(i)).unwrap();
    let worse = found(&|i| if mask[i] { 0.01 * noise(i) } else { f32::NAN }).unwrap();
    assert!(plain.grain.is_some() && plain == worse);
    let refused = found(&|_| f32::INFINITY).unwrap_err();
    assert!(matches!(refused, CompareError::NotFinite { role: Role::Image, x: 0, y: 0, .. }), "{refused}");
}

#[test]
fn only_the_reference_tells_where_the_penumbra_is() {
    let (reference, fractions) = (image(fraction), fractions());
    let noisy = image(|i| fraction(i) + 0.01 * noise(i));
    let view = |pixels| Image::new(WIDTH as u32, HEIGHT as u32, pixels).unwrap();
    let told = view(&noisy).with_visible_fractions(&fractions).unwrap();
    assert_eq!(compare(told, view(&reference)).unwrap().grain, None);
}

#[test]
fn the_worst_hundredth_of_flip_is_seen_where_the_mean_is_not_moved() {
    let reference = image(|_| 1.0);
    // Six tiles of 6 × 6 pixels: a little more than 1 % of the image.
    let spots = image(|i| if i % WIDTH < 36 && i / WIDTH < 6 { 0.5 } else { 1.0 });
    let view = |pixels| Image::new(WIDTH as u32, HEIGHT as u32, pixels).unwrap();
    let found = compare(view(&spots), view(&reference)).unwrap();
    assert!(found.flip < 0.02 && found.flip_p99 > 0.3, "{found:?}");
}
