//! Straight edge between light and floor: the visible part of the light is a rectangle, and the solution is
//! exact.

use halflight::config::{PipelineConfig, RefinerConfig};
use halflight::frame::{LightSampling, Sharing};
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::light::{AreaLight, LightFrame};
use halflight::pattern::PatternKind;
use halflight::unshadowed::unshadowed;
use halflight_tests::Stage;

/// Irradiance (red) at a floor point: that of the part of the light right of the projected edge.
fn exact(light: &AreaLight, point: Vec3, sheet: f32) -> f64 {
    let LightFrame { origin, u, v } = light.frame();
    let height = origin.y;
    // The line from the point through the edge (0, sheet) meets the light's plane at this X.
    let cut = point.x - point.x / (sheet - point.y) * (height - point.y);
    let low = cut.max(origin.x);
    let high = origin.x + u.x;
    if low >= high {
        return 0.0;
    }
    let visible = AreaLight::parallelogram(origin.with_x(low), Vec3::X * (high - low), v, light.radiance);
    let visible = AreaLight { two_sided: light.two_sided, ..visible };
    f64::from(light.radiance.x) * f64::from(unshadowed(&visible, point, Vec3::Y))
}

/// Radiance of the scene's light.
const RADIANCE: f32 = 20.0;

/// Mean square z score and the largest |z| of the mean over `seeds` images against `answer`, the number of
/// pixels with a score, and the number of noise-free pixels whose value is wrong.
fn z_scores(
    stage: &Stage,
    shading: Shading,
    seeds: u32,
    answer: impl Fn(Vec3) -> f64,
) -> (f64, f64, usize, usize) {
    let (width, height) = (48, 36);
    let mut sum = vec![0.0f64; (width * height) as usize];
    let mut square = sum.clone();
    let mut receivers = Vec::new();
    for seed in 0..seeds {
        let config = PipelineConfig {
            width,
            height,
            refiner: RefinerConfig::PerPixel,
            shading,
            sampling: LightSampling { count: 16, kind: PatternKind::Jittered, sharing: Sharing::Receiver },
            seed,
            ..PipelineConfig::default()
        };
        let mut pipeline = config.builder(&stage.prepared).build().unwrap();
        let image = pipeline.render().unwrap();
        for (pixel, value) in image.irradiance.iter().enumerate() {
            sum[pixel] += f64::from(value.x);
            square[pixel] += f64::from(value.x).powi(2);
        }
        if seed == 0 {
            let gbuffer = pipeline.gbuffer();
            receivers.extend(
                (0..gbuffer.pixels()).filter_map(|pixel| Some((pixel, gbuffer.receiver(pixel)?.origin))),
            );
        }
    }
    let count = f64::from(seeds);
    let (mut total, mut largest, mut used, mut strays) = (0.0, 0.0f64, 0, 0);
    for (pixel, origin) in receivers {
        // The floor only: the sheet itself is in view as well, 2 m up.
        if origin.y > 1.0 {
            continue;
        }
        let mean = sum[pixel] / count;
        let variance = (square[pixel] / count - mean * mean).max(0.0) * count / (count - 1.0);
        let expected = answer(origin);
        let error = (variance / count).sqrt();
        if error < 1e-9 * expected.max(1e-9) {
            // All samples agree: umbra, open floor, or so near to them that none of the 800 samples and more
            // in the light's outer strata hits the differing sliver, which has a fraction of at most 0.003.
            strays += usize::from((mean - expected).abs() > 3e-3 * expected.max(0.01 * f64::from(RADIANCE)));
            continue;
        }
        let z = (mean - expected) / error;
        total += z * z;
        largest = largest.max(z.abs());
        used += 1;
    }
    (total / used as f64, largest, used, strays)
}

#[test]
fn sampled_irradiance_is_unbiased() {
    let stage = Stage::bundled("half-plane").unwrap();
    let light = stage.scene.lights[0];
    let (mean_square, largest, used, strays) =
        z_scores(&stage, Shading::Sampled, 200, |point| exact(&light, point, 2.0));
    // z² of a mean over 200 seeds is chi-square with one degree of freedom: mean 1, standard deviation of the
    // mean over `used` pixels √(2/used). The largest of about 1,500 normal numbers lies below 5 with
    // probability 0.999.
    let spread = (2.0 / used as f64).sqrt();
    assert!(used > 800, "{used} pixels");
    assert!((mean_square - 1.0).abs() < 5.0 * spread, "mean z² {mean_square} of {used} pixels");
    assert!(largest < 5.0, "{largest}");
    assert_eq!(strays, 0);
}

#[test]
fn a_wrong_answer_is_noticed() {
    let stage = Stage::bundled("half-plane").unwrap();
    let light = stage.scene.lights[0];
    // Sheet 2 cm too high.
    let (mean_square, largest, ..) =
        z_scores(&stage, Shading::Sampled, 50, |point| exact(&light, point, 2.02));
    assert!(mean_square > 1.5 && largest > 5.0, "{mean_square} {largest}");
}

#[test]
fn the_ratio_estimator_is_within_its_bias() {
    let stage = Stage::bundled("half-plane").unwrap();
    let light = stage.scene.lights[0];
    let (mean_square, largest, used, strays) =
        z_scores(&stage, Shading::Ratio, 200, |point| exact(&light, point, 2.0));
    // A ratio of two means has a bias of a fraction 1/K of its variance: with 16 samples and 200 seeds up to
    // about one standard error more than an unbiased estimate.
    assert!(used > 200, "{used} pixels");
    assert_eq!(strays, 0);
    assert!(mean_square < 2.5 && largest < 6.0, "mean z² {mean_square}, largest {largest}");
}
