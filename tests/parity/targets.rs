//! Error targets: the sampling plan that pilot samples give, and the image's agreement with the CPU.

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::irradiance::Shading;
use halflight::pattern::PatternKind;
use halflight::refine::LatticeConfig;
use halflight::scene::Scene;
use halflight::stats::FrameStats;
use halflight_gpu::{Inputs, Inside, Surfaces};
use halflight_tests::Stage;

use crate::device::Bench;
use crate::scenes::{Twins, bundled, per_pixel};

/// Lattice without validation, as on the GPU.
fn lattice(target: f32) -> LatticeConfig {
    LatticeConfig { target, validate: false, ..LatticeConfig::default() }
}

fn config(target: f32) -> PipelineConfig {
    PipelineConfig {
        refiner: RefinerConfig::Lattice(lattice(target)),
        upsampler: UpsamplerConfig::Lattice(Default::default()),
        ..per_pixel(303, 175, Shading::Ratio)
    }
}

/// Samples along one side of the light: the GPU's plan, and the CPU's last batch.
fn sides(bench: &Bench, twins: &Twins) -> [u32; 2] {
    let chosen: Vec<u32> = bench.read(twins.gpu.inside(Inside::Chosen));
    assert_eq!(chosen[1], chosen[2]);
    let fragments = twins.cpu.fragments();
    let last = fragments.samples().last().map(|sample| fragments.batch(sample.batch).pattern());
    [chosen[1], last.unwrap().columns.into()]
}

/// NMSE₂ of the GPU's image against the CPU's.
fn error(bench: &Bench, twins: &Twins) -> f64 {
    let found: Vec<[f32; 4]> = bench.read(twins.gpu.image());
    let (mut sum, mut all) = (0.0, 0.0);
    for (found, expected) in found.iter().zip(&twins.cpu.image().irradiance) {
        sum += f64::from(found[1] - expected.y).powi(2);
        all += f64::from(expected.y).powi(2);
    }
    sum / all
}

#[test]
fn targets_take_the_samples_that_they_take_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let mut chosen = Vec::new();
    for (scene, target) in [("toys", 1e-3), ("toys", 1e-4), ("tree", 1e-3)] {
        let twins = Twins::render(&bench, scene, &config(target), true);
        let [found, expected] = sides(&bench, &twins);
        // The sums are equal except for rounding.
        assert_eq!(found, expected, "{scene} {target}");
        chosen.push(found);
        // Both have independent noise where corners with pilot samples are traced again on one side alone.
        let error = error(&bench, &twins);
        assert!(error < f64::from(target), "{scene} {target}: {error}");
    }
    assert!(chosen[0] < chosen[1], "{chosen:?}");
}

/// Statistics of the GPU and of the CPU.
fn stats(bench: &Bench, twins: &mut Twins) -> [FrameStats; 2] {
    let found = bench.render(&mut twins.gpu, &Inputs { surfaces: Surfaces::Kept, ..Inputs::default() });
    [found.frame, twins.cpu.image().stats.clone()]
}

/// Numbers of samples of the GPU's fragments and of the CPU's.
fn samples(bench: &Bench, twins: &mut Twins) -> [u64; 2] {
    stats(bench, twins).map(|stats| stats.fragments.total)
}

fn small(target: f32) -> PipelineConfig {
    PipelineConfig { width: 151, height: 87, ..config(target) }
}

#[test]
fn small_targets_ask_along_edges() {
    let Some(bench) = Bench::open() else { return };
    for coarsest_level in [3, 2] {
        let lattice = LatticeConfig { coarsest_level, ..lattice(1e-5) };
        let config = PipelineConfig { refiner: RefinerConfig::Lattice(lattice), ..small(1e-5) };
        let mut twins = Twins::render(&bench, "contact", &config, true);
        let [found, expected] = samples(&bench, &mut twins);
        // Corners with pilot samples have other masks here, which moves a few cells across the threshold.
        assert!(found.abs_diff(expected) * 200 < expected, "{coarsest_level}: {found} {expected}");
        twins.alter(&bench, &config, ["refine/discontinuities", ") < EDGE)", ") < -2.0)"]);
        let [fewer, _] = samples(&bench, &mut twins);
        assert!(fewer + expected / 100 < found, "{coarsest_level}: {fewer} {found}");
    }
}

/// Scene with a second light like its first, with a tenth of its edges in another position.
fn with_second_light(stage: &Stage) -> Stage {
    let mut scene = Scene::clone(&stage.scene);
    let first = scene.lights[0];
    let offset = 2.0 * first.frame().u;
    scene.lights.push(first.transformed(|corner| corner + offset, |edge| 0.1 * edge));
    Stage::new(scene).unwrap()
}

#[test]
fn lights_have_choices_and_errors_of_their_own() {
    let Some(bench) = Bench::open() else { return };
    // Smaller images have the same plan for both lights.
    let config = PipelineConfig { width: 203, height: 117, ..small(2e-5) };
    let mut twins = Twins::of(&bench, with_second_light(&bundled("toys")), &config, true);
    // Plan of the second light.
    let [chosen, expected] = sides(&bench, &twins);
    assert_eq!(chosen, expected);
    let mut alone = Twins::render(&bench, "toys", &config, true);
    assert_ne!(sides(&bench, &alone)[0], chosen);
    // Corners with pilot samples have other masks here, which moves a few cells across the threshold.
    let [found, expected] = samples(&bench, &mut twins);
    assert!(found.abs_diff(expected) * 100 < expected, "{found} {expected}");
    let [one, _] = samples(&bench, &mut alone);
    assert!(found > one + one / 10, "{found} {one}");
    let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.1;
    let [found, expected] = stats(&bench, &mut twins).map(|stats| stats.expected_nmse2.unwrap());
    assert!(near(found, expected), "{found} {expected}");
    assert!(error(&bench, &twins) < 2e-5);
    // Error of the last light alone.
    let wrong =
        ["refine/target_sum", "var all = bitcast<f32>(atomicLoad(&counters[COUNTER]))", "var all = 0.0"];
    twins.alter(&bench, &config, wrong);
    let [found, _] = stats(&bench, &mut twins).map(|stats| stats.expected_nmse2.unwrap());
    assert!(!near(found, expected), "{found} {expected}");
}

#[test]
fn where_most_pixels_are_left_all_are_traced() {
    let Some(bench) = Bench::open() else { return };
    let config = small(1e-5);
    // Masks change their length between passes.
    let beams = PipelineConfig { visibility: VisibilityConfig::Beam, ..config };
    let beams = Twins::render(&bench, "toys", &beams, true);
    let mut twins = Twins::render(&bench, "toys", &config, true);
    for twins in [&twins, &beams] {
        let [chosen, expected] = sides(&bench, twins);
        assert_eq!(chosen, expected);
        assert!(error(&bench, twins) < 1e-5);
    }
    assert!(twins.cpu.fragments().cells().iter().all(|cell| cell.level == 0));
    let [found, expected] = samples(&bench, &mut twins);
    assert_eq!(found, expected);
    let owners: Vec<u32> = bench.read(twins.gpu.inside(Inside::Owners));
    assert!(owners.iter().all(|&level| level == 0 || level == u32::MAX));
    twins.alter(&bench, &config, ["refine/target_decide", "> share * f32(", "> 2.0 * f32("]);
    let [fewer, _] = samples(&bench, &mut twins);
    assert!(fewer < found, "{fewer} {found}");
}

#[test]
fn as_much_error_is_expected_as_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let expected = |twins: &mut Twins| stats(&bench, twins).map(|stats| stats.expected_nmse2.unwrap());
    let cells = ["refine/target_predict", "CURVATURE: f32 = 0.06", "CURVATURE: f32 = 0.2"];
    let pixels =
        ["refine/target_predict", "variance_at(pixel_of(first))", "1.5 * variance_at(pixel_of(first))"];
    let energy = ["refine/target_energy", "bright * bright", "bright"];
    // The estimate is dominated by cells, by pixels, and by cells along depth discontinuities. The energy is summed alike in all.
    let cases = [
        ("toys", config(1e-3), &[cells, energy][..]),
        ("toys", small(1e-5), &[pixels]),
        ("railing", small(1e-4), &[cells]),
    ];
    for (scene, config, wrong) in cases {
        let mut twins = Twins::render(&bench, scene, &config, true);
        let [found, cpu] = expected(&mut twins);
        // The CPU measures a subset if there are more than 16,384 cells, and corners with pilot samples have
        // other masks.
        let near = |found: f64| (found / cpu - 1.0).abs() < 0.1;
        assert!(near(found), "{scene}: {found} {cpu}");
        for &wrong in wrong {
            twins.alter(&bench, &config, wrong);
            let [found, _] = expected(&mut twins);
            assert!(!near(found), "{scene} {wrong:?}: {found} {cpu}");
        }
    }
}

#[test]
fn targets_are_reached_by_all_exact_backends() {
    let Some(bench) = Bench::open() else { return };
    let target = 1e-3;
    let mut chosen = Vec::new();
    for name in ["beam", "raster4d"] {
        // Pattern that all backends support.
        let sampling = LightSampling { kind: PatternKind::ShiftedRows, ..LightSampling::default() };
        let visibility = VisibilityConfig::named(name).unwrap();
        let config = PipelineConfig { visibility, sampling, ..config(target) };
        let twins = Twins::of(&bench, bundled("few toys"), &config, true);
        let [found, expected] = sides(&bench, &twins);
        assert_eq!(found, expected, "{name}");
        let error = error(&bench, &twins);
        assert!(error < f64::from(target), "{name}: {error}");
        chosen.push(found);
    }
    assert!(chosen[0] == chosen[1] && chosen[0] < 8, "{chosen:?}");
}

#[test]
fn a_trial_that_sees_more_noise_takes_more_samples() {
    let Some(bench) = Bench::open() else { return };
    // In smaller images so many cells are split that the fewest samples are enough.
    let config = PipelineConfig { width: 406, height: 234, ..config(1e-4) };
    let mut twins = Twins::render(&bench, "toys", &config, true);
    let [found, expected] = sides(&bench, &twins);
    assert_eq!(found, expected);
    assert!(error(&bench, &twins) < 1e-4);
    twins.alter(&bench, &config, ["shared/noise_estimate", "NOISE: f32 = 0.12", "NOISE: f32 = 0.6"]);
    let [found, expected] = sides(&bench, &twins);
    assert!(found > expected, "{found} {expected}");
    // A plan that ignores the choice has the error of the fewest samples.
    let wrong = ["refine/target_choose", "chosen[0] = choice_of(side)", "chosen[0] = choice_of(0u)"];
    twins.alter(&bench, &config, wrong);
    assert!(error(&bench, &twins) > 1e-4);
}

#[test]
fn visible_errors_are_bounded_as_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let quality = |visible_error: f32| {
        let refiner = RefinerConfig::Lattice(LatticeConfig { visible_error, ..lattice(1e-4) });
        PipelineConfig { refiner, ..config(1e-4) }
    };
    let error = |twins: &Twins| error(&bench, twins);
    let (plain, bounded) = (quality(0.0), quality(0.04));
    let mut twins = Twins::render(&bench, "contact", &bounded, true);
    // Both have noise of their own, which smoothing takes away, and the GPU's samples are more.
    let smoothed = error(&twins);
    let noisy = error(&Twins::render(&bench, "contact", &plain, true));
    assert!(smoothed < 0.7 * noisy, "{smoothed} {noisy}");
    let [found, expected] = stats(&bench, &mut twins).map(|stats| stats.expected_nmse2.unwrap());
    assert!((0.2..3.0).contains(&(found / expected)), "{found} {expected}");
    // Without smoothing, and with smoothing over everything.
    twins.alter(&bench, &bounded, ["refine/lattice_smooth", "if found.varies {", "if false {"]);
    let unsmoothed = error(&twins);
    assert!(unsmoothed > 1.2 * smoothed, "{unsmoothed} {smoothed}");
    twins.alter(&bench, &bounded, ["shared/smoothing", "if !agree(sum, pair) {", "if false {"]);
    let blurred = error(&twins);
    assert!(blurred > 5.0 * smoothed, "{blurred} {smoothed}");
    // With cells as coarse as the target alone allows.
    let [cells, _] = samples(&bench, &mut twins);
    twins.alter(
        &bench,
        &bounded,
        ["shared/visible_tolerance", "if VISIBLE_ERROR <= 0.0", "if VISIBLE_ERROR <= 1.0"],
    );
    let [fewer, _] = samples(&bench, &mut twins);
    assert!(fewer < cells, "{fewer} {cells}");
}
