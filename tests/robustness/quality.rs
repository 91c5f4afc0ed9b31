//! Visible errors of the qualities, on scenes of different kinds.

use halflight::config::{PipelineConfig, Quality, RefinerConfig};
use halflight::frame::LightSampling;
use halflight::metrics::{Image, compare};
use halflight::refine::LatticeConfig;
use halflight_tests::Stage;

const SIZE: (u32, u32) = (240, 180);

/// Largest grain of a quality in scenes without and with foliage, and largest 99th percentile of ꟻLIP in both.
fn bounds(quality: Quality) -> ([f64; 2], f64) {
    match quality {
        Quality::Draft => ([0.25, 0.3], 0.1),
        Quality::Good => ([0.1, 0.2], 0.08),
        Quality::Final => ([0.05, 0.1], 0.045),
    }
}

#[test]
fn qualities_keep_visible_errors_within_their_bounds() {
    let mut faults = Vec::new();
    for (scene, foliage) in [("contact", false), ("atrium", false), ("toys", false), ("tree", true)] {
        let stage = Stage::bundled(scene).unwrap();
        let config = |refiner: RefinerConfig| PipelineConfig {
            width: SIZE.0,
            height: SIZE.1,
            refiner,
            upsampler: refiner.upsampler(),
            ..PipelineConfig::default()
        };
        let truth = PipelineConfig {
            sampling: LightSampling { count: 4096, ..LightSampling::default() },
            seed: 7,
            ..config(RefinerConfig::PerPixel)
        };
        let mut pipeline = truth.builder(&stage.prepared).layers(true).build().unwrap();
        let truth = pipeline.render().unwrap().clone();
        let seen: Vec<bool> =
            pipeline.gbuffer().primitive.iter().map(|&primitive| primitive != u32::MAX).collect();
        let reference = Image::new(SIZE.0, SIZE.1, &truth.irradiance).unwrap().with_mask(&seen).unwrap();
        let reference = reference.with_visible_fractions(&truth.visibility).unwrap();
        let errors = |refiner: LatticeConfig| {
            let image = stage.render(&config(RefinerConfig::Lattice(refiner))).unwrap();
            let image = Image::new(SIZE.0, SIZE.1, &image.irradiance).unwrap().with_mask(&seen).unwrap();
            let errors = compare(image, reference).unwrap();
            (errors.grain.unwrap(), errors.flip_p99, errors.nmse2)
        };
        let mut before = f64::INFINITY;
        for quality in Quality::ALL {
            let (grain, flip, nmse2) = errors(quality.lattice());
            let ([plain, leaves], flip_bound) = bounds(quality);
            let grain_bound = if foliage { leaves } else { plain };
            println!("{scene} {quality}: grain {grain:.3}, FLIP {flip:.3}, NMSE2 {nmse2:.1e}");
            let kept = grain < grain_bound && flip < flip_bound && grain < before;
            faults.extend(
                (!kept).then(|| format!("{scene} {quality}: {grain:.3} {flip:.3} after {before:.3}")),
            );
            before = grain;
        }
        // The bound on visible errors is what does it.
        let (grain, ..) = errors(Quality::Good.lattice());
        let (without, ..) = errors(LatticeConfig { visible_error: 0.0, ..Quality::Good.lattice() });
        println!("{scene}: {without:.3} without a bound");
        // Foliage takes the most samples for its NMSE₂ alone.
        let better = foliage || without > 1.25 * grain;
        faults
            .extend((!better).then(|| format!("{scene}: {without:.3} without a bound, {grain:.3} with it")));
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
