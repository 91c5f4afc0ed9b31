//! Determinism: equal input gives equal images, bit for bit.

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight_tests::{Stage, blocker_over_floor};

fn bits(image: &[Vec3]) -> Vec<[u32; 3]> {
    image.iter().map(|v| v.to_array().map(f32::to_bits)).collect()
}

#[test]
fn images_are_identical_for_one_two_and_eight_threads() {
    let stage = Stage::bundled("atrium").unwrap();
    for refiner in RefinerConfig::NAMES {
        for (upsampler, shading) in UpsamplerConfig::all().into_iter().zip([
            Shading::Sampled,
            Shading::Ratio,
            Shading::Sampled,
            Shading::Ratio,
            Shading::Ratio,
            Shading::Ratio,
        ]) {
            let config = PipelineConfig {
                width: 160,
                height: 120,
                refiner: RefinerConfig::named(refiner).unwrap(),
                upsampler,
                shading,
                ..PipelineConfig::default()
            };
            let render = |threads| {
                let builder = config.builder(&stage.prepared).threads(threads);
                let mut pipeline = builder.build().unwrap();
                // The second frame, so that reused buffers are covered too.
                pipeline.render().unwrap();
                bits(&pipeline.render().unwrap().irradiance)
            };
            let one = render(1);
            assert_eq!(one, render(2), "{refiner} {upsampler:?}: two threads");
            assert_eq!(one, render(8), "{refiner} {upsampler:?}: eight threads");
        }
    }
}

#[test]
fn frames_and_seeds_differ_and_repeat() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let config = PipelineConfig { width: 64, height: 48, ..PipelineConfig::default() };
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    let first = bits(&pipeline.render().unwrap().irradiance);
    let second = bits(&pipeline.render().unwrap().irradiance);
    assert_ne!(first, second, "another frame has other light samples");
    pipeline.set_frame_index(0);
    assert_eq!(first, bits(&pipeline.render().unwrap().irradiance));
    let seeded = PipelineConfig { seed: 1, ..config };
    assert_ne!(first, bits(&stage.render(&seeded).unwrap().irradiance));
}
