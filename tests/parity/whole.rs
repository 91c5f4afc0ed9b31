//! Parity of whole frames.

use halflight::config::{Named, PipelineConfig, RefinerConfig};
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::pipeline::Image;

use crate::device::Bench;
use crate::scenes::{SCENES, Twins, per_pixel};

/// Squared error of the GPU's image against the CPU's, NMSE₂.
pub(crate) fn nmse2(image: &[[f32; 4]], reference: &Image) -> f64 {
    let (mut error, mut energy) = (0.0, 0.0);
    for (&[r, g, b, _], expected) in image.iter().zip(&reference.irradiance) {
        error += f64::from((Vec3::new(r, g, b) - *expected).length_squared());
        energy += f64::from(expected.length_squared());
    }
    // Dark images must both be dark.
    error / energy.max(f64::MIN_POSITIVE)
}

#[test]
fn per_pixel_frames_are_equal() {
    let Some(bench) = Bench::open() else { return };
    for scene in SCENES {
        for shading in [Shading::Ratio, Shading::Sampled] {
            let twins = Twins::render(&bench, scene, &per_pixel(96, 72, shading), true);
            let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
            let off = nmse2(&image, twins.cpu.image());
            // Rays that rounding decides differently change a pixel by a 64th, and there are almost none.
            assert!(off < 1e-8, "{scene} {shading:?}: {off:e}");
            let own = Twins::render(&bench, scene, &per_pixel(96, 72, shading), false);
            let image: Vec<[f32; 4]> = bench.read(own.gpu.image());
            let off = nmse2(&image, own.cpu.image());
            // Pixels on outlines see their other side (see `gbuffers`), which in foliage is another leaf.
            assert!(
                off < if scene == "tree" { 5e-3 } else { 1e-3 },
                "{scene} {shading:?}, rasterized: {off:e}"
            );
        }
    }
}

#[test]
fn every_refiner_works_with_the_upsampler_that_fits_it() {
    let Some(bench) = Bench::open() else { return };
    for refiner in RefinerConfig::NAMES {
        let refiner = RefinerConfig::named(refiner).unwrap();
        let config =
            PipelineConfig { refiner, upsampler: refiner.upsampler(), ..per_pixel(64, 48, Shading::Ratio) };
        let twins = Twins::render(&bench, "atrium", &config, true);
        let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let off = nmse2(&image, twins.cpu.image());
        // Threshold as in the tests of each refiner: a ray that rounding decides differently may split a
        // fragment.
        assert!(off < 1e-3, "{refiner:?}: {off:e}");
    }
}
