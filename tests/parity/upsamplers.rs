//! Parity of upsampled values from identical samples.

use halflight::config::{Named as _, PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::frame::Frame;
use halflight::irradiance::Shading;
use halflight::pyramid::Pyramid;
use halflight::refine::{GeometryThresholds, LatticeConfig, NicholsConfig, SfvtGassConfig};
use halflight::upsample::{
    BilinearConfig, RbfAdaptiveConfig, RbfFixedConfig, RbfRobustConfig, SurfaceLimits,
};
use halflight_gpu::Inside;

use crate::device::Bench;
use crate::scenes::{SCENES, Twins, per_pixel, values};

/// Upsampled values of the CPU for the fragments of its last frame.
fn cpu_plane(twins: &Twins, config: &PipelineConfig) -> Vec<f32> {
    let gbuffer = twins.cpu.gbuffer();
    let frame = Frame {
        scene: &twins.stage.scene,
        gbuffer,
        pyramid: &Pyramid::default(),
        pattern: config.sampling.pattern().unwrap(),
        sharing: config.sampling.sharing,
        index: 0,
        seed: config.seed,
    };
    let mut plane = vec![0.0; gbuffer.pixels()];
    let values = values(twins, config.shading);
    let (mut stage, fragments) = (config.upsampler.stage(&config.refiner), twins.cpu.fragments());
    stage.upsample(&frame, fragments, values.channel(0), &mut plane);
    plane
}

/// Number of pixels whose light differs by more than a fraction of the largest that any pixel gets, and the
/// largest such fraction.
///
/// Values are weighted with the light, so that pixels with almost no light hardly count: where no light
/// sample is above the horizon any value is acceptable.
fn differing(bench: &Bench, twins: &Twins, config: &PipelineConfig, tolerance: f32) -> (usize, f32) {
    let expected = cpu_plane(twins, config);
    let found: Vec<f32> = bench.read(twins.gpu.inside(Inside::Plane));
    let light = &twins.stage.scene.lights[0];
    let lit = |pixel: usize| match (config.shading, twins.cpu.gbuffer().receiver(pixel)) {
        (Shading::Ratio, Some(r)) => halflight::unshadowed::unshadowed(light, r.origin, r.normal),
        _ => 1.0,
    };
    let weights: Vec<f32> = (0..expected.len()).map(lit).collect();
    let most = weights.iter().zip(&expected).map(|(weight, value)| weight * value).fold(0.0, f32::max);
    let off = weights.iter().zip(expected.iter().zip(&found)).map(|(w, (a, b))| w * (a - b).abs() / most);
    let off: Vec<f32> = off.collect();
    (
        off.iter().filter(|&&off| off.is_nan() || off > tolerance).count(),
        off.iter().copied().fold(0.0, f32::max),
    )
}

/// Checks that almost no pixel differs by more than a tolerance; the error tells the number.
pub(crate) fn check(
    bench: &Bench,
    twins: &Twins,
    config: &PipelineConfig,
    tolerance: f32,
) -> Result<(), String> {
    let (count, worst) = differing(bench, twins, config, tolerance);
    let pixels = twins.cpu.gbuffer().pixels();
    // Rays within the rounding error of an edge (see `masks`) may change a cell or two.
    (count * 500 <= pixels).then_some(()).ok_or(format!("{count} of {pixels} pixels by up to {worst:e}"))
}

/// Upsamplers, each with a tolerance relative to the largest light. Bilinear weights are exact in few digits.
/// Agreements at the limits of a surface amplify rounding. Exponentials are accurate to a few units in the
/// last place, and the papers' matrices are used down to determinants of 1e-6, which wide variances approach.
pub(crate) fn with_defaults() -> [(UpsamplerConfig, f32); 4] {
    let of = |name| UpsamplerConfig::named(name).unwrap();
    [(of("bilinear"), 1e-6), (of("rbf-fixed"), 1e-3), (of("rbf-adaptive"), 1e-2), (of("rbf-robust"), 1e-3)]
}

/// Upsamplers with constants that no default has.
fn with_constants() -> [(UpsamplerConfig, f32); 4] {
    let surface = SurfaceLimits { offset_px: 0.5, bend: 1.0, smooth_deg: 5.0, break_deg: 20.0 };
    // Everything is one surface.
    let loose = SurfaceLimits { offset_px: 1e6, bend: 1e3, smooth_deg: 178.0, break_deg: 179.0 };
    let robust = RbfRobustConfig { surface, radius: 1.5, softness_px: 2.0, stiffness: 0.3 };
    [
        (UpsamplerConfig::Bilinear(BilinearConfig { surface: loose }), 1e-6),
        (UpsamplerConfig::RbfFixed(RbfFixedConfig { variance: 1.5, copied_level: 1, reach: 1.5 }), 1e-3),
        (
            UpsamplerConfig::RbfAdaptive(RbfAdaptiveConfig { variance: 1.5, copied_level: 1, reach: 1.5 }),
            1e-2,
        ),
        (UpsamplerConfig::RbfRobust(robust), 1e-3),
    ]
}

#[test]
fn constants_reach_the_device() {
    let Some(bench) = Bench::open() else { return };
    // Geometry splits no cell, so that cells reach across edges.
    let geometry = GeometryThresholds { depth: 1e6, curvature: 1e6 };
    let refiner = RefinerConfig::Nichols(NicholsConfig { geometry, ..NicholsConfig::default() });
    for ((upsampler, tolerance), (usual, _)) in with_constants().into_iter().zip(with_defaults()) {
        let config = PipelineConfig { refiner, upsampler, ..per_pixel(110, 83, Shading::Ratio) };
        let twins = Twins::render(&bench, "few toys", &config, true);
        check(&bench, &twins, &config, tolerance).unwrap_or_else(|off| panic!("{upsampler:?}: {off}"));
        // The constants matter: with the defaults the planes differ.
        let config = PipelineConfig { upsampler: usual, ..config };
        assert!(check(&bench, &twins, &config, tolerance).is_err(), "{upsampler:?}");
    }
}

#[test]
fn planes_are_equal() {
    let Some(bench) = Bench::open() else { return };
    let nichols = RefinerConfig::Nichols(NicholsConfig::default());
    let sfvt = RefinerConfig::SfvtGass(SfvtGassConfig::default());
    // Upsamplers see fragments, whoever made them: one refiner a scene, and both in one.
    for (scene, refiners) in [("toys", &[nichols][..]), ("atrium", &[nichols, sfvt]), ("tree", &[sfvt])] {
        for &refiner in refiners {
            for (upsampler, tolerance) in with_defaults() {
                let config = PipelineConfig { refiner, upsampler, ..per_pixel(110, 83, Shading::Ratio) };
                let twins = Twins::render(&bench, scene, &config, true);
                check(&bench, &twins, &config, tolerance)
                    .unwrap_or_else(|off| panic!("{scene} {} {upsampler:?}: {off}", refiner.name()));
            }
        }
    }
}

#[test]
fn the_lattice_interpolates_as_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    for scene in SCENES {
        for shading in [Shading::Ratio, Shading::Sampled] {
            let refiner = RefinerConfig::Lattice(LatticeConfig::default());
            let config = PipelineConfig {
                refiner,
                upsampler: UpsamplerConfig::Lattice(Default::default()),
                ..per_pixel(140, 100, shading)
            };
            let twins = Twins::render(&bench, scene, &config, true);
            // The analytic irradiance that weights the values differs by as much (see `whole`).
            check(&bench, &twins, &config, 1e-4).unwrap_or_else(|off| panic!("{scene} {shading:?}: {off}"));
        }
    }
}
