//! Unoccluded floor: every method must give the closed form stated in the scene file.

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::irradiance::Shading;
use halflight_tests::Stage;

/// Function `g` of the scene file's closed form, at height `h`.
fn corner_term(a: f64, b: f64, h: f64) -> f64 {
    let (da, db) = ((a * a + h * h).sqrt(), (b * b + h * h).sqrt());
    a / da * (b / da).atan() + b / db * (a / db).atan()
}

/// Irradiance per unit radiance at (x, 0, z) under a light over −1 … 1 at height `h`.
fn closed_form(x: f64, z: f64, h: f64) -> f64 {
    let mut sum = 0.0;
    for (corner_x, sign_x) in [(1.0, 1.0), (-1.0, -1.0)] {
        for (corner_z, sign_z) in [(1.0, 1.0), (-1.0, -1.0)] {
            sum += sign_x * sign_z * corner_term(corner_x - x, corner_z - z, h);
        }
    }
    0.5 * sum
}

#[test]
fn ratio_shading_is_exact_for_every_refiner_and_upsampler() {
    let stage = Stage::bundled("open-floor").unwrap();
    for refiner in RefinerConfig::NAMES {
        for upsampler in [
            UpsamplerConfig::Bilinear(Default::default()),
            UpsamplerConfig::RbfRobust(Default::default()),
            UpsamplerConfig::Delaunay(Default::default()),
            UpsamplerConfig::Lattice(Default::default()),
        ] {
            let config = PipelineConfig {
                width: 160,
                height: 120,
                refiner: RefinerConfig::named(refiner).unwrap(),
                upsampler,
                shading: Shading::Ratio,
                ..PipelineConfig::default()
            };
            let mut pipeline = config.builder(&stage.prepared).build().unwrap();
            let image = pipeline.render().unwrap().clone();
            let gbuffer = pipeline.gbuffer();
            let radiance = f64::from(stage.scene.lights[0].radiance.x);
            let mut checked = 0;
            for pixel in 0..gbuffer.pixels() {
                let Some(receiver) = gbuffer.receiver(pixel) else { continue };
                // The receiver is offset from the floor; the closed form is evaluated at its exact position.
                let p = receiver.origin.as_dvec3();
                let expected = radiance * closed_form(p.x, p.z, 3.0 - p.y);
                let found = f64::from(image.irradiance[pixel].x);
                // Upsamplers reproduce constants to 1e-5; U in single precision adds less than 1e-4.
                assert!(
                    (found / expected - 1.0).abs() < 1.1e-4,
                    "{refiner} {upsampler:?} {pixel}: {found} {expected}"
                );
                checked += 1;
            }
            assert!(checked > 10_000, "{refiner}: only {checked} pixels see the floor");
        }
    }
}

#[test]
fn the_origin_has_the_value_in_the_scene_file() {
    assert!((closed_form(0.0, 0.0, 3.0) - 0.387_414).abs() < 1e-6);
}
