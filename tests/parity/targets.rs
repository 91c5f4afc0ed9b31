//! Error targets: what a trial chooses, and whether the image comes out as on the CPU.

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::irradiance::Shading;
use halflight::pattern::PatternKind;
use halflight::refine::LatticeConfig;
use halflight_gpu::{Inputs, Inside, Surfaces};

use crate::device::Bench;
use crate::scenes::{Twins, full};

fn config(target: f32) -> PipelineConfig {
    PipelineConfig {
        refiner: RefinerConfig::Lattice(LatticeConfig { target, ..LatticeConfig::default() }),
        upsampler: UpsamplerConfig::Lattice,
        ..full(406, 234, Shading::Ratio)
    }
}

/// Samples along one side that the GPU has chosen, and those of the CPU's last batch.
fn sides(bench: &Bench, twins: &Twins) -> [u32; 2] {
    let chosen: Vec<u32> = bench.read(twins.gpu.inside(Inside::Chosen));
    assert_eq!(chosen[1], chosen[2]);
    let fragments = twins.cpu.fragments();
    // Where the CPU goes over to every pixel, it chooses once more.
    assert!(fragments.cells().iter().any(|cell| cell.level > 0));
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
        // The sums are the same but for rounding.
        assert_eq!(found, expected, "{scene} {target}");
        chosen.push(found);
        // Both have noise of their own where corners of the trial are asked again on one side alone.
        let error = error(&bench, &twins);
        assert!(error < f64::from(target), "{scene} {target}: {error}");
    }
    assert!(chosen[0] < chosen[1], "{chosen:?}");
}

/// Samples that the GPU's fragments and the CPU's have.
fn samples(bench: &Bench, twins: &mut Twins) -> [u64; 2] {
    let stats = bench.render(&mut twins.gpu, &Inputs { surfaces: Surfaces::Kept, ..Inputs::default() });
    [&stats.frame, &twins.cpu.image().stats].map(|stats| stats.fragments.per_level.iter().sum())
}

#[test]
fn small_targets_ask_along_edges() {
    let Some(bench) = Bench::open() else { return };
    let config = PipelineConfig { width: 203, height: 117, ..config(1e-5) };
    let mut twins = Twins::render(&bench, "toys", &config, true);
    let [found, expected] = samples(&bench, &mut twins);
    assert!(expected > 5000 && found.abs_diff(expected) * 200 < expected, "{found} {expected}");
    twins.alter(&bench, &config, ["refine/breaks", ") < EDGE)", ") < -2.0)"]);
    let [found, expected] = samples(&bench, &mut twins);
    assert!((expected - found) * 50 > expected, "{found} {expected}");
}

#[test]
fn targets_are_reached_by_all_exact_backends() {
    let Some(bench) = Bench::open() else { return };
    let target = 1e-3;
    let mut chosen = Vec::new();
    for name in ["beam", "raster4d"] {
        // All take samples in rows.
        let sampling = LightSampling { kind: PatternKind::ShiftedRows, ..LightSampling::default() };
        let visibility = VisibilityConfig::named(name).unwrap();
        let twins =
            Twins::render(&bench, "toys", &PipelineConfig { visibility, sampling, ..config(target) }, true);
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
    let mut twins = Twins::render(&bench, "toys", &config(1e-4), true);
    let [found, expected] = sides(&bench, &twins);
    assert_eq!(found, expected);
    assert!(error(&bench, &twins) < 1e-4);
    twins.alter(&bench, &config(1e-4), ["refine/target_show", "NOISE: f32 = 0.12", "NOISE: f32 = 0.6"]);
    let [found, expected] = sides(&bench, &twins);
    assert!(found > expected, "{found} {expected}");
    // One that takes no notice of what was chosen has the error of the fewest samples.
    let wrong = ["refine/target_choose", "chosen[0] = choice_of(side)", "chosen[0] = choice_of(0u)"];
    twins.alter(&bench, &config(1e-4), wrong);
    assert!(error(&bench, &twins) > 1e-4);
}
