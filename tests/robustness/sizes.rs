//! Any image size, and sizes that are refused.

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::irradiance::Shading;
use halflight::pipeline::PipelineError;
use halflight_tests::{Stage, blocker_over_floor};

fn check(
    stage: &Stage,
    width: u32,
    height: u32,
    refiner: &str,
    upsampler: UpsamplerConfig,
    shading: Shading,
) {
    let config = PipelineConfig {
        width,
        height,
        refiner: RefinerConfig::named(refiner).unwrap(),
        upsampler,
        shading,
        ..PipelineConfig::default()
    };
    let mut pipeline = config.builder(&stage.prepared).layers(true).build().unwrap();
    let image = pipeline.render().unwrap().clone();
    let name = format!("{width}x{height} {refiner} {upsampler:?} {shading:?}");
    assert_eq!(image.irradiance.len(), (width * height) as usize);
    assert!(image.irradiance.iter().all(|v| v.is_finite() && v.min_element() >= 0.0), "{name}");
    assert!(image.irradiance.iter().all(|v| v.is_finite()), "{name}");
    let gbuffer = pipeline.gbuffer();
    let mut covered = vec![0; gbuffer.pixels()];
    for cell in pipeline.fragments().cells() {
        let (x0, y0, x1, y1) = cell.pixels(width, height);
        for y in y0..y1 {
            for x in x0..x1 {
                covered[gbuffer.index(x, y)] += 1;
            }
        }
    }
    for (pixel, &cells) in covered.iter().enumerate() {
        assert_eq!(image.level[pixel] == u8::MAX, !gbuffer.is_receiver(pixel), "{name}: level at {pixel}");
        assert!(
            cells <= 1 && (cells == 1 || !gbuffer.is_receiver(pixel)),
            "{name}: pixel {pixel} lies in {cells} cells"
        );
    }
}

#[test]
fn odd_sizes_are_covered_by_cells_exactly_once() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    for (width, height) in [(1, 1), (2, 1), (1, 7), (1, 200), (200, 1), (127, 129), (129, 65)] {
        for refiner in RefinerConfig::NAMES {
            for upsampler in UpsamplerConfig::all() {
                for shading in [Shading::Sampled, Shading::Ratio] {
                    check(&stage, width, height, refiner, upsampler, shading);
                }
            }
        }
    }
}

#[test]
fn the_papers_size_is_covered_too() {
    // 960 is 7.5 × 128: clipped border fragments.
    let stage = Stage::new(blocker_over_floor()).unwrap();
    for refiner in ["nichols", "sfvt-gass", "lattice"] {
        check(&stage, 1280, 960, refiner, UpsamplerConfig::RbfRobust(Default::default()), Shading::Ratio);
    }
}

#[test]
fn sizes_without_pixels_or_beyond_the_limit_are_refused() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    for (width, height) in [(0, 10), (10, 0), (40_000, 10)] {
        let Err(error) = stage.builder().size(width, height).build() else {
            panic!("{width}x{height} was accepted")
        };
        assert!(matches!(error, PipelineError::Size { .. }), "{error}");
        assert!(error.to_string().contains(&format!("{width}x{height}")));
    }
}
