//! Measures against their closed forms, their invariances, and images that they must distinguish.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use glam::Vec3;
use halflight_metrics::{
    CompareError, Comparison, Image, ImageError, Role, ShapeMismatch, compare, halves_noise, nmse2,
};

/// Relative rounding error of sums of a few dozen values in `f64`, with a margin.
const ROUNDING: f64 = 1e-12;

fn gray(values: &[f32]) -> Vec<Vec3> {
    values.iter().copied().map(Vec3::splat).collect()
}

/// Errors of an image whose every pixel lies in the penumbra.
fn errors(width: u32, image: &[Vec3], reference: &[Vec3]) -> Comparison {
    let height = reference.len() as u32 / width;
    let view = |pixels| Image::new(width, height, pixels).unwrap();
    let half = vec![0.5; reference.len()];
    compare(view(image), view(reference).with_visible_fractions(&half).unwrap()).unwrap()
}

fn figures(c: &Comparison) -> [(&'static str, f64); 11] {
    [
        ("sse", c.sse),
        ("nmse", c.nmse),
        ("nmse2", c.nmse2),
        ("rmse", c.rmse),
        ("relmse", c.relmse),
        ("max", c.max),
        ("psnr", c.psnr),
        ("ssim", c.ssim),
        ("flip", c.flip),
        ("flip_p99", c.flip_p99),
        ("grain", c.grain.unwrap()),
    ]
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= ROUNDING * expected.abs(), "{found} is not {expected}");
}

/// A number in 0..1 that depends on all bits of its arguments.
fn noise(i: usize, seed: u32) -> f32 {
    let mut h = (i as u32).wrapping_mul(0x9e37_79b9) ^ seed.wrapping_mul(0x85eb_ca6b);
    for _ in 0..3 {
        h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    }
    (h >> 8) as f32 / (1 << 24) as f32
}

/// A picture with gradients, edges and colours, values 0.1..3.2.
fn picture(width: usize, height: usize) -> Vec<Vec3> {
    let pixel = |i: usize| {
        let (x, y) = ((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
        let lit = if (x - 0.5).hypot(y - 0.4) < 0.3 { 0.2 } else { 1.0 };
        Vec3::new(3.0 * lit * x, 2.0 * lit * y, lit) + 0.1 + 0.1 * noise(i, 1)
    };
    (0..width * height).map(pixel).collect()
}

#[test]
fn pointwise_measures_have_their_closed_form() {
    let reference = [Vec3::new(4.0, 2.0, 0.0), Vec3::new(1.0, 0.0, 1.0)];
    let image = [Vec3::new(3.0, 2.0, 2.0), Vec3::new(1.0, 0.0, 1.5)];
    let c = errors(2, &image, &reference);
    // Squared differences 1, 4 and 0.25; Σb = 8, Σb² = 22; peak 4, so ε = 0.04².
    assert_near(c.sse, 5.25);
    assert_near(c.nmse, (5.25 / 16.0) / (8.0 / 4.0));
    assert_near(c.nmse2, 5.25 / 22.0);
    let alone = nmse2(Image::new(2, 1, &image).unwrap(), Image::new(2, 1, &reference).unwrap());
    assert_eq!(alone, Ok(c.nmse2));
    assert_near(c.rmse, (5.25_f64 / 6.0).sqrt());
    let epsilon = 0.04 * 0.04;
    assert_near(c.relmse, (1.0 / (16.0 + epsilon) + 4.0 / epsilon + 0.25 / (1.0 + epsilon)) / 6.0);
    assert_near(c.max, 2.0);
    assert_near(c.psnr, 10.0 * (16.0_f64 / (5.25 / 6.0)).log10());
}

#[test]
fn ssim_of_flat_images_is_its_mean_term() {
    // No variance: (2xy + C₁) / (x² + y² + C₁) in every window, cut off ones included.
    for (width, height) in [(1, 1), (1, 9), (9, 1), (16, 12)] {
        let count = width * height;
        let c = errors(width, &gray(&vec![0.5; count as usize]), &gray(&vec![2.0; count as usize]));
        let (x, y, c1) = (0.25, 1.0, 1e-4);
        let expected = (2.0 * x * y + c1) / (x * x + y * y + c1);
        // Variances of rounding size, 1e-16, stand against C₂ = 9e-4.
        assert!((c.ssim - expected).abs() < 1e-12, "{} is not {expected}", c.ssim);
    }
}

/// SSIM window by window, by its definition, with deviations from the mean instead of moments.
fn ssim_by_definition(width: i32, image: &[f64], reference: &[f64], mask: &[bool]) -> f64 {
    let height = image.len() as i32 / width;
    let (mut sum, mut count) = (0.0, 0.0);
    for center in (0..image.len()).filter(|&i| mask[i]) {
        let (cx, cy) = (center as i32 % width, center as i32 / width);
        let mut window = Vec::new();
        for y in (cy - 5).max(0)..=(cy + 5).min(height - 1) {
            for x in (cx - 5).max(0)..=(cx + 5).min(width - 1) {
                let i = (y * width + x) as usize;
                if mask[i] {
                    let d2 = f64::from((x - cx).pow(2) + (y - cy).pow(2));
                    window.push(((-d2 / 4.5).exp(), image[i], reference[i]));
                }
            }
        }
        let weight: f64 = window.iter().map(|w| w.0).sum();
        let mean =
            |f: &dyn Fn(f64, f64) -> f64| window.iter().map(|w| w.0 * f(w.1, w.2)).sum::<f64>() / weight;
        let (mx, my) = (mean(&|x, _| x), mean(&|_, y| y));
        let (vx, vy) = (mean(&|x, _| (x - mx).powi(2)), mean(&|_, y| (y - my).powi(2)));
        let cov = mean(&|x, y| (x - mx) * (y - my));
        sum += (2.0 * mx * my + 1e-4) * (2.0 * cov + 9e-4) / ((mx * mx + my * my + 1e-4) * (vx + vy + 9e-4));
        count += 1.0;
    }
    sum / count
}

#[test]
fn ssim_equals_its_definition_with_borders_and_masks() {
    for (width, height) in [(23, 17), (1, 13), (4, 3)] {
        let count = width * height;
        let mut reference: Vec<f32> = (0..count).map(|i| noise(i, 1)).collect();
        reference[0] = 1.0;
        let image: Vec<f32> = (0..count).map(|i| 0.7 * reference[i] + 0.3 * noise(i, 2)).collect();
        let mask: Vec<bool> = (0..count).map(|i| i % 7 != 3).collect();
        let (a, b) = (gray(&image), gray(&reference));
        let view =
            |pixels| Image::new(width as u32, height as u32, pixels).unwrap().with_mask(&mask).unwrap();
        let found = compare(view(&a), view(&b)).unwrap().ssim;
        let wide = |values: &[f32]| values.iter().copied().map(f64::from).collect::<Vec<_>>();
        let expected = ssim_by_definition(width as i32, &wide(&image), &wide(&reference), &mask);
        // Moments against deviations: cancellation of 1e-16 against C₂ = 9e-4.
        assert!((found - expected).abs() < 1e-11, "{width}×{height}: {found} is not {expected}");
    }
}

#[test]
fn flip_of_plain_colours_matches_the_authors_program() {
    // From nv-flip 0.1.2 on 8-bit images of one colour, 16×16, at 67 pixels per degree; the crate's `flip`
    // tests explain why its values are accurate to 5e-5.
    let flat = |color: Vec3| vec![color; 256];
    let black_on_white = errors(16, &flat(Vec3::ZERO), &flat(Vec3::ONE)).flip;
    assert!((black_on_white - 0.967_392).abs() < 5e-5, "{black_on_white}");
    let green_on_blue = errors(16, &flat(Vec3::Y), &flat(Vec3::Z)).flip;
    assert!((green_on_blue - 1.0).abs() < 5e-5, "{green_on_blue}");
}

#[test]
fn an_image_equals_itself() {
    for (width, height) in [(1, 1), (1, 40), (40, 1), (33, 21)] {
        let reference = picture(width, height);
        let c = errors(width as u32, &reference, &reference);
        for value in [c.sse, c.nmse, c.nmse2, c.rmse, c.relmse, c.max, c.flip, c.flip_p99, c.grain.unwrap()] {
            assert_eq!(value, 0.0);
        }
        assert_eq!(c.psnr, f64::INFINITY);
        // The square root of a square may be off by an ulp.
        assert!((c.ssim - 1.0).abs() < 1e-12);
    }
}

#[test]
fn every_measure_rejects_a_perturbed_image() {
    for (width, height) in [(1, 1), (1, 40), (40, 1), (33, 21)] {
        let reference = picture(width, height);
        for channel in 0..3 {
            let mut image = reference.clone();
            // Downwards: ꟻLIP clamps pixels brighter than the reference's peak.
            image[width * height / 2][channel] -= 0.01;
            let equal = errors(width as u32, &reference, &reference);
            let perturbed = errors(width as u32, &image, &reference);
            for ((name, equal), (_, perturbed)) in figures(&equal).into_iter().zip(figures(&perturbed)) {
                let worse = if matches!(name, "psnr" | "ssim") { -1.0 } else { 1.0 };
                // The only pixel of an image has no neighbours to be rougher than.
                let told = name != "grain" || width * height > 1;
                assert!(
                    !told || worse * perturbed > worse * equal,
                    "{name}: {perturbed} is no worse than {equal}"
                );
            }
        }
    }
}

#[test]
fn a_larger_error_is_worse_by_every_measure() {
    let reference = picture(33, 21);
    let noisy = |amount: f32| -> Vec<Vec3> {
        reference.iter().enumerate().map(|(i, p)| p + amount * (noise(i, 5) - 0.5)).collect()
    };
    let [small, large] = [0.05, 0.3].map(|amount| errors(33, &noisy(amount), &reference));
    for ((name, small), (_, large)) in figures(&small).into_iter().zip(figures(&large)) {
        let worse = if matches!(name, "psnr" | "ssim") { -1.0 } else { 1.0 };
        assert!(worse * large > worse * small, "{name}: {large} is no worse than {small}");
    }
}

#[test]
fn relative_measures_ignore_exposure() {
    let reference = picture(33, 21);
    let image: Vec<Vec3> = reference.iter().enumerate().map(|(i, p)| p * (0.9 + 0.2 * noise(i, 3))).collect();
    let brighter = |pixels: &[Vec3]| -> Vec<Vec3> { pixels.iter().map(|p| 1024.0 * p).collect() };
    let c = errors(33, &image, &reference);
    let d = errors(33, &brighter(&image), &brighter(&reference));
    for ((name, c), (_, d)) in figures(&c).into_iter().zip(figures(&d)) {
        match name {
            "sse" => assert_eq!(d, c * 1024.0 * 1024.0),
            "rmse" | "max" => assert_eq!(d, c * 1024.0),
            // A power of two changes no bit of a mantissa, but ε = (0.01 · peak)² rounds once more.
            _ => assert!((d - c).abs() <= ROUNDING * c.abs(), "{name}: {d} is not {c}"),
        }
    }
}

#[test]
fn swapping_images_of_one_peak_keeps_the_symmetric_measures() {
    let mut a = picture(33, 21);
    let mut b: Vec<Vec3> = a.iter().enumerate().map(|(i, p)| p * (0.8 + 0.2 * noise(i, 3))).collect();
    (a[5], b[5]) = (Vec3::splat(4.0), Vec3::splat(4.0));
    let (c, d) = (errors(33, &a, &b), errors(33, &b, &a));
    for (name, c, d) in [("sse", c.sse, d.sse), ("ssim", c.ssim, d.ssim), ("flip", c.flip, d.flip)] {
        assert!((d - c).abs() <= ROUNDING * c.abs(), "{name}: {d} is not {c}");
    }
    assert_ne!(c.nmse2, d.nmse2);
}

#[test]
fn masked_pixels_take_no_part() {
    let reference = [Vec3::splat(2.0), Vec3::NAN, Vec3::new(1.0, 3.0, 0.0), Vec3::splat(1e30)];
    let image = [Vec3::splat(2.5), Vec3::ZERO, Vec3::new(1.0, 2.0, 0.0), Vec3::INFINITY];
    let mask = [true, false, true, false];
    fn view(pixels: &[Vec3]) -> Image<'_> {
        Image::new(2, 2, pixels).unwrap()
    }
    let whole = errors(1, &[image[0], image[2]], &[reference[0], reference[2]]);
    // The mask of one image holds for both.
    for (a, b) in [
        (view(&image).with_mask(&mask).unwrap(), view(&reference)),
        (view(&image), view(&reference).with_mask(&mask).unwrap()),
    ] {
        let c = compare(a, b).unwrap();
        assert_eq!(
            [c.sse, c.nmse, c.nmse2, c.rmse, c.relmse, c.max, c.psnr],
            [whole.sse, whole.nmse, whole.nmse2, whole.rmse, whole.relmse, whole.max, whole.psnr]
        );
        // The two remaining pixels are one above the other, as in the whole image.
        assert!((c.ssim - whole.ssim).abs() < 1e-12);
        assert!(c.flip > 0.0 && c.flip < 1.0);
        assert!(c.flip_p99 >= c.flip && c.grain.is_none());
        // Values of masked pixels have no effect.
        let mut other = image;
        other[1] = Vec3::splat(7.0);
        assert_eq!(compare(view(&other).with_mask(&mask).unwrap(), b).unwrap(), c);
    }
}

#[test]
fn images_that_cannot_be_compared_are_refused() {
    let pixels = gray(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let wide = Image::new(3, 2, &pixels).unwrap();
    let high = Image::new(2, 3, &pixels).unwrap();
    let error = compare(wide, high).unwrap_err();
    assert_eq!(error, CompareError::Shape(ShapeMismatch::Size { a: (3, 2), b: (2, 3) }));
    assert_eq!(error.to_string(), "the images differ in size: 3×2 against 2×3");

    let mut broken = pixels.clone();
    broken[4].y = f32::NAN;
    let broken_view = Image::new(3, 2, &broken).unwrap();
    assert_eq!(
        compare(broken_view, wide).unwrap_err().to_string(),
        "pixel (1, 1) of the image is not finite: [5, NaN, 5]"
    );
    broken[4].y = f32::INFINITY;
    let broken_view = Image::new(3, 2, &broken).unwrap();
    let error = compare(wide, broken_view).unwrap_err();
    assert!(matches!(error, CompareError::NotFinite { role: Role::Reference, x: 1, y: 1, .. }), "{error}");

    let black = gray(&[0.0; 6]);
    let black = Image::new(3, 2, &black).unwrap();
    assert_eq!(compare(wide, black), Err(CompareError::ZeroReference));
    assert!(compare(black, wide).is_ok());

    let none = wide.with_mask(&[false; 6]).unwrap();
    assert_eq!(compare(none, wide), Err(CompareError::NoPixels));

    let some = wide.with_mask(&[true, true, false, true, true, true]).unwrap();
    let others = wide.with_mask(&[true, true, true, true, false, false]).unwrap();
    let mismatch = ShapeMismatch::Mask { pixels: 3, x: 2, y: 0 };
    assert_eq!(compare(some, others), Err(CompareError::Shape(mismatch)));
}

#[test]
fn images_that_do_not_fit_their_size_are_refused() {
    let pixels = gray(&[1.0; 6]);
    assert_eq!(Image::new(0, 2, &[]).unwrap_err(), ImageError::Empty { width: 0, height: 2 });
    assert_eq!(Image::new(4, 2, &pixels).unwrap_err().to_string(), "an image of 4×2 needs 8 pixels, found 6");
    assert!(matches!(Image::new(u32::MAX, u32::MAX, &pixels), Err(ImageError::PixelCount { .. })));
    assert_eq!(
        Image::new(3, 2, &pixels).unwrap().with_mask(&[true; 5]).unwrap_err(),
        ImageError::MaskCount { expected: 6, found: 5 }
    );
    assert_eq!(
        Image::new(3, 2, &pixels).unwrap().with_visible_fractions(&[0.5; 7]).unwrap_err(),
        ImageError::FractionCount { expected: 6, found: 7 }
    );
}

#[test]
fn extreme_values_give_figures_without_nan() {
    // Largest and smallest numbers of `f32`.
    let reference = gray(&[f32::from_bits(1), 0.0]);
    let image = gray(&[f32::MAX, -f32::MAX]);
    for (name, value) in figures(&errors(2, &image, &reference)) {
        assert!(!value.is_nan(), "{name}");
    }
    // Signed values, as in a layer of normals: sums are of absolute values.
    let c = errors(2, &gray(&[-1.0, 1.0]), &gray(&[-1.0, 0.5]));
    assert_near(c.nmse2, 0.25 / 1.25);
    assert_near(c.nmse, 0.25 / 1.5);
}

#[test]
fn figures_do_not_depend_on_the_number_of_threads() {
    let reference = picture(127, 65);
    let image: Vec<Vec3> = reference.iter().enumerate().map(|(i, p)| p * (0.9 + 0.2 * noise(i, 3))).collect();
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| figures(&errors(127, &image, &reference)).map(|(_, value)| value.to_bits()))
    };
    let one = with_threads(1);
    assert_eq!(with_threads(2), one);
    assert_eq!(with_threads(8), one);
}

#[test]
fn halves_estimate_the_error_of_their_mean() {
    let a = gray(&[1.0]);
    let b = gray(&[3.0]);
    let view = |pixels| Image::new(1, 1, pixels).unwrap();
    // Each channel: (2² / 4) / 2².
    assert_near(halves_noise(view(&a), view(&b)).unwrap(), 0.25);
    assert_eq!(halves_noise(view(&a), view(&a)), Ok(0.0));
    let negative = gray(&[-1.0]);
    assert_eq!(halves_noise(view(&a), view(&negative)), Err(CompareError::ZeroReference));

    let truth = picture(64, 64);
    let half = |seed: u32| -> Vec<Vec3> {
        let noisy = |(i, p): (usize, &Vec3)| {
            p + 0.3 * Vec3::from_array([0, 1, 2].map(|c| noise(3 * i + c, seed) - 0.5))
        };
        truth.iter().enumerate().map(noisy).collect()
    };
    let (a, b) = (half(11), half(12));
    let mean: Vec<Vec3> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
    let view = |pixels| Image::new(64, 64, pixels).unwrap();
    let estimate = halves_noise(view(&a), view(&b)).unwrap();
    let actual = compare(view(&mean), view(&truth)).unwrap().nmse2;
    // The difference and the mean of two uniform errors are triangular (kurtosis 2.4): each mean square over
    // 12,288 channels has a relative deviation of √(1.4 / 12288) = 1.1 %, the ratio √2 times that; five of
    // them are 7.6 %.
    assert!((estimate / actual - 1.0).abs() < 0.076, "estimate {estimate}, actual {actual}");
}

#[test]
fn figures_survive_json_and_csv() {
    let reference = picture(9, 7);
    let image: Vec<Vec3> = reference.iter().map(|p| 0.9 * p).collect();
    for image in [&image, &reference] {
        let c = errors(9, image, &reference);
        let json = serde_json::to_string(&c).unwrap();
        assert_eq!(json.contains(r#""psnr":null"#), c.psnr.is_infinite(), "{json}");
        let read: Comparison = serde_json::from_str(&json).unwrap();
        for ((name, read), (_, written)) in figures(&read).into_iter().zip(figures(&c)) {
            // The fast number parser of serde_json may be wrong by an ulp.
            let close = (read - written).abs() <= f64::EPSILON * written.abs();
            assert!(read == written || close, "{name}: {read} is not {written}");
        }

        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.serialize(c).unwrap();
        let table = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        assert!(
            table.starts_with("sse,nmse,nmse2,rmse,relmse,max,psnr,ssim,flip,flip_p99,grain\n"),
            "{table}"
        );
        let read: Vec<Comparison> =
            csv::Reader::from_reader(table.as_bytes()).deserialize().map(Result::unwrap).collect();
        assert_eq!(read, [c]);
    }
}
