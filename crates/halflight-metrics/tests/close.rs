//! Approximate comparison: differences that it accepts and refuses.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use glam::Vec3;
use halflight_metrics::{Image, Mismatch, ShapeMismatch, Tolerance, check_close};

fn view(pixels: &[Vec3]) -> Image<'_> {
    Image::new(pixels.len() as u32, 1, pixels).unwrap()
}

#[test]
fn images_within_the_tolerance_pass() {
    let a = [Vec3::ONE, Vec3::splat(100.0), Vec3::ZERO];
    assert_eq!(check_close(view(&a), view(&a), Tolerance::absolute(0.0)), Ok(()));
    let b = [Vec3::new(1.25, 1.0, 1.0), Vec3::splat(100.25), Vec3::splat(-0.25)];
    assert_eq!(check_close(view(&a), view(&b), Tolerance::absolute(0.25)), Ok(()));
    let c = [Vec3::ONE, Vec3::splat(101.0), Vec3::ZERO];
    assert_eq!(check_close(view(&a), view(&c), Tolerance::relative(0.01)), Ok(()));
    assert_eq!(check_close(view(&c), view(&a), Tolerance::relative(0.01)), Ok(()));
}

#[test]
fn a_perturbed_image_is_refused_with_its_worst_pixel() {
    let a = [Vec3::ONE; 6];
    let mut b = a;
    b[1].x = 1.125;
    b[5].z = 0.5;
    let a = Image::new(3, 2, &a).unwrap();
    let b = Image::new(3, 2, &b).unwrap();
    let mismatch = check_close(a, b, Tolerance::absolute(0.1)).unwrap_err();
    assert_eq!(
        mismatch.to_string(),
        "2 of 6 pixels differ by more than 1e-1 + 0e0 of the larger value; the worst is (2, 1): \
         [1, 1, 1] against [1, 1, 0.5]"
    );
    assert!(check_close(a, b, Tolerance::absolute(0.5)).is_ok());
    assert!(check_close(a, b, Tolerance::absolute(0.499)).is_err());
    assert!(check_close(a, b, Tolerance::relative(0.1)).is_err());
}

#[test]
fn relative_tolerance_is_a_share_of_the_pixel_and_not_of_the_image() {
    let a = [Vec3::splat(1000.0), Vec3::splat(0.001)];
    let b = [Vec3::splat(1000.0), Vec3::splat(0.002)];
    let mismatch = check_close(view(&a), view(&b), Tolerance::relative(0.1)).unwrap_err();
    assert!(matches!(mismatch, Mismatch::Pixels { exceeding: 1, x: 1, y: 0, .. }), "{mismatch}");
}

#[test]
fn what_is_not_finite_is_close_to_nothing() {
    let generous = Tolerance::absolute(1e30);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let a = [Vec3::ONE, Vec3::new(1.0, bad, 1.0)];
        assert!(check_close(view(&a), view(&a), generous).is_err());
        assert!(check_close(view(&a), view(&[Vec3::ONE; 2]), generous).is_err());
        assert!(check_close(view(&[Vec3::ONE; 2]), view(&a), generous).is_err());
    }
    let ones = [Vec3::ONE];
    assert!(check_close(view(&ones), view(&ones), Tolerance::absolute(f64::NAN)).is_err());
    assert!(check_close(view(&ones), view(&ones), Tolerance::absolute(-1.0)).is_err());
}

#[test]
fn masked_pixels_are_not_checked_but_some_must_be() {
    let a = [Vec3::ONE, Vec3::NAN];
    let b = [Vec3::ONE, Vec3::ZERO];
    let exact = Tolerance::absolute(0.0);
    assert_eq!(check_close(view(&a).with_mask(&[true, false]).unwrap(), view(&b), exact), Ok(()));
    assert!(check_close(view(&a).with_mask(&[true, true]).unwrap(), view(&b), exact).is_err());
    let none = view(&a).with_mask(&[false, false]).unwrap();
    assert_eq!(check_close(none, view(&b), exact), Err(Mismatch::NoPixels));
}

#[test]
fn sizes_must_agree() {
    let pixels = [Vec3::ONE; 2];
    let (row, column) = (view(&pixels), Image::new(1, 2, &pixels).unwrap());
    assert_eq!(
        check_close(row, column, Tolerance::absolute(1.0)),
        Err(Mismatch::Shape(ShapeMismatch::Size { a: (2, 1), b: (1, 2) }))
    );
}

#[test]
fn single_values_follow_the_same_rule() {
    let tolerance = Tolerance { absolute: 0.5, relative: 0.25 };
    // 0.5 + 0.25 · 8 = 2.5.
    assert!(tolerance.accepts(8.0, 5.5) && tolerance.accepts(5.5, 8.0));
    assert!(!tolerance.accepts(8.0, 5.4) && !tolerance.accepts(5.4, 8.0));
    assert!(!tolerance.accepts(f64::NAN, f64::NAN));
}
