//! Parity of antialiased frames.

use halflight::glam::Vec3;
use halflight::image::picture;
use halflight::irradiance::Shading;
use halflight_gpu::{Inputs, Surfaces};

use crate::device::Bench;
use crate::scenes::{Twins, per_pixel};

#[test]
fn edges_are_those_of_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let mut config = per_pixel(96, 72, Shading::Ratio);
    config.antialias = 8;
    let mut twins = Twins::render(&bench, "few toys", &config, false);
    let (image, gbuffer, stats) =
        bench.gpu.render_antialiased(&mut twins.gpu, &Inputs::default(), 8).unwrap();
    assert_eq!(stats.frame.antialias.sub_samples, 8 * 96 * 72);
    let expected = &twins.cpu.image().radiance;
    let plain = {
        let (image, _, _) = bench.gpu.render_antialiased(&mut twins.gpu, &Inputs::default(), 1).unwrap();
        assert!(image.radiance.is_empty());
        picture::radiance(&image.irradiance, &gbuffer.albedo)
    };
    let error = |image: &[Vec3]| -> f32 {
        let pairs = image.iter().zip(expected);
        pairs.map(|(found, expected)| (*found - *expected).length_squared()).sum()
    };
    assert!(error(&image.radiance) * 4.0 < error(&plain), "{} {}", error(&image.radiance), error(&plain));
    let kept = Inputs { surfaces: Surfaces::Kept, ..Inputs::default() };
    assert!(bench.gpu.render_antialiased(&mut twins.gpu, &kept, 8).is_err());
    assert!(bench.gpu.render_antialiased(&mut twins.gpu, &Inputs::default(), 3).is_err());
}
