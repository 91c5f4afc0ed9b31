//! Flicker of synthetic frames, computed by hand.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::Vec3;
use halflight_metrics::{CompareError, Image, ShapeMismatch, flicker};

const WIDTH: u32 = 20;
const HEIGHT: u32 = 10;

/// Grey pixels by their number; the luminance of grey is its value.
fn grey(value: impl Fn(usize) -> f32) -> Vec<Vec3> {
    (0..(WIDTH * HEIGHT) as usize).map(|pixel| Vec3::splat(value(pixel))).collect()
}

fn image(pixels: &[Vec3]) -> Image<'_> {
    Image::new(WIDTH, HEIGHT, pixels).unwrap()
}

/// Sums of 200 products in double precision, of values that single precision holds to 6e-8.
const NEAR: f64 = 1e-6;

#[test]
fn what_stands_still_does_not_flicker_however_wrong() {
    let (reference, wrong) =
        (grey(|pixel| 1.0 + pixel as f32), grey(|pixel| if pixel % 3 == 0 { 0.0 } else { 9.0 }));
    let frame = [image(&wrong), image(&reference)];
    let still = flicker(frame, frame).unwrap();
    assert_eq!((still.mean, still.p99), (0.0, 0.0));
}

#[test]
fn what_changes_with_the_reference_does_not_flicker() {
    let frame =
        |time: f32| (grey(|pixel| 2.0 + time * pixel as f32), grey(|pixel| 1.0 + time * pixel as f32));
    let ((old, old_reference), (new, reference)) = (frame(1.0), frame(2.0));
    let found = flicker([image(&old), image(&old_reference)], [image(&new), image(&reference)]).unwrap();
    // Luminances are rounded in double precision.
    assert!(found.mean < 1e-14 && found.p99 < 1e-14, "{found:?}");
    // With references the wrong way round the reference's own change is counted twice: 2 · pixel, over 1 +
    // pixel.
    let found = flicker([image(&old), image(&reference)], [image(&new), image(&old_reference)]).unwrap();
    assert!((found.mean - 2.0 * 99.5 / 100.5).abs() < NEAR, "{found:?}");
}

#[test]
fn noise_that_alternates_is_told_by_its_size() {
    let reference = grey(|_| 4.0);
    let noisy = |sign: f32| grey(move |pixel| 4.0 + sign * if pixel % 2 == 0 { 0.5 } else { -0.25 });
    let (even, odd) = (noisy(1.0), noisy(-1.0));
    let found = flicker([image(&even), image(&reference)], [image(&odd), image(&reference)]).unwrap();
    // Half of the pixels change by 1 and half by 0.5, under a light of 4.
    assert!((found.mean - 0.75 / 4.0).abs() < NEAR && (found.p99 - 1.0 / 4.0).abs() < NEAR, "{found:?}");
}

#[test]
fn the_percentile_leaves_out_one_pixel_in_a_hundred() {
    let reference = grey(|_| 1.0);
    for (spikes, p99) in [(2, 0.0), (3, 10.0)] {
        let spiky = grey(|pixel| if pixel < spikes { 11.0 } else { 1.0 });
        let found = flicker([image(&reference); 2], [image(&spiky), image(&reference)]).unwrap();
        assert!((found.p99 - p99).abs() < NEAR * 10.0, "{spikes}: {found:?}");
        assert!((found.mean - spikes as f64 * 10.0 / 200.0).abs() < NEAR, "{spikes}: {found:?}");
    }
}

#[test]
fn only_pixels_of_both_frames_count() {
    let (reference, changed) = (grey(|_| 2.0), grey(|pixel| if pixel == 5 { f32::NAN } else { 3.0 }));
    let masks: Vec<Vec<bool>> =
        [0, 5].iter().map(|from| (0..200).map(|pixel| pixel >= *from && pixel != 5).collect()).collect();
    let masked =
        |pixels, mask: &'static str| image(pixels).with_mask(&masks[usize::from(mask == "late")]).unwrap();
    let before = [masked(&reference, "early"), masked(&reference, "early")];
    let after = [masked(&changed, "late"), masked(&reference, "late")];
    let found = flicker(before, after).unwrap();
    assert!((found.mean - 0.5).abs() < NEAR, "{found:?}");
}

#[test]
fn frames_that_cannot_be_compared_are_refused() {
    let (light, dark) = (grey(|_| 1.0), grey(|_| 0.0));
    let small = vec![Vec3::ONE; 4];
    let good = [image(&light); 2];
    let other = [Image::new(2, 2, &small).unwrap(); 2];
    assert!(matches!(flicker(good, other), Err(CompareError::Shape(ShapeMismatch::Size { .. }))));
    assert_eq!(flicker(good, [image(&light), image(&dark)]), Err(CompareError::ZeroReference));
    let (left, right): (Vec<bool>, Vec<bool>) = (0..200).map(|pixel| (pixel < 100, pixel >= 100)).unzip();
    let half = |mask| [image(&light).with_mask(mask).unwrap(); 2];
    assert_eq!(flicker(half(&left), half(&right)), Err(CompareError::NoPixels));
}
