//! Every visibility backend works with every refiner; the exact ones give identical images, bit for bit.

use halflight::config::{Named, PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight::cpu::brute_force::BruteForce;
use halflight::frame::{Frame, LightSampling, Sharing};
use halflight::pattern::PatternKind;
use halflight::pyramid::Pyramid;
use halflight::stages::Visibility;
use halflight_tests::Stage;

fn config(refiner: &str, visibility: &str, kind: PatternKind, count: u32) -> PipelineConfig {
    PipelineConfig {
        width: 100,
        height: 75,
        refiner: RefinerConfig::named(refiner).unwrap(),
        visibility: VisibilityConfig::named(visibility).unwrap(),
        sampling: LightSampling { count, kind, sharing: Sharing::Fragment },
        ..PipelineConfig::default()
    }
}

#[test]
fn exact_backends_give_the_same_image() {
    for name in ["atrium", "nave", "hairball", "tree", "soup"] {
        let stage = Stage::bundled(name).unwrap();
        for &refiner in RefinerConfig::NAMES {
            for (kind, count) in [(PatternKind::ShiftedRows, 64), (PatternKind::Grid, 256)] {
                let image = |backend| stage.render(&config(refiner, backend, kind, count)).unwrap();
                let rays = image("bvh");
                assert!(rays.stats.rays.total > 10_000, "{name} {refiner}");
                for backend in ["beam", "raster4d"] {
                    let other = image(backend);
                    assert_eq!(other.stats.rays, rays.stats.rays, "{name} {refiner} {backend}");
                    assert!(other.irradiance == rays.irradiance, "{name} {refiner} {backend} {kind:?}");
                }
            }
            let image = |backend| stage.render(&config(refiner, backend, PatternKind::Jittered, 64)).unwrap();
            assert!(image("beam").irradiance == image("bvh").irradiance, "{name} {refiner} jittered");
        }
    }
}

/// Compares the exact backends' masks of a few receivers of a scene with brute force; `cargo xtask exactness`
/// compares many.
#[test]
fn exact_backends_say_what_brute_force_says() {
    let (mut asked, mut seen) = (0, 0);
    for name in ["atrium", "nave", "hairball", "tree", "soup"] {
        let stage = Stage::bundled(name).unwrap();
        for kind in [PatternKind::ShiftedRows, PatternKind::Jittered] {
            let config = PipelineConfig { width: 6, height: 4, ..config("per-pixel", "bvh", kind, 4) };
            let mut pipeline = config.builder(&stage.prepared).build().unwrap();
            pipeline.render().unwrap();
            let (gbuffer, pyramid, batch) =
                (pipeline.gbuffer(), Pyramid::default(), pipeline.fragments().batch(0));
            let frame = Frame {
                scene: &stage.scene,
                gbuffer,
                pyramid: &pyramid,
                pattern: batch.pattern(),
                sharing: Sharing::Fragment,
                index: 0,
                seed: 0,
            };
            let answer = |visibility: &mut dyn Visibility| {
                let mut batch = batch.clone();
                visibility.prepare(&frame);
                visibility.masks(&frame, &mut batch);
                let seen = |query: usize| batch.visible(query)[0] & batch.wanted(query)[0];
                (0..batch.len()).map(seen).collect::<Vec<u64>>()
            };
            let truth = answer(&mut BruteForce);
            asked += (0..batch.len()).map(|query| batch.wanted(query)[0].count_ones()).sum::<u32>();
            seen += truth.iter().map(|word| word.count_ones()).sum::<u32>();
            for backend in ["bvh", "raster4d", "beam"] {
                let mut visibility = VisibilityConfig::named(backend).unwrap().stage(&stage.bvh).unwrap();
                if visibility.supports(batch.pattern()).is_ok() {
                    assert_eq!(answer(visibility.as_mut()), truth, "{name} {kind:?} {backend}");
                }
            }
        }
    }
    // Both outcomes must be common, or the comparison has no power.
    assert!(asked > 400 && seen > asked / 10 && seen < asked - asked / 10, "{seen} of {asked}");
}

#[test]
fn voxels_are_near_the_truth_and_not_the_truth() {
    let stage = Stage::bundled("atrium").unwrap();
    for &refiner in RefinerConfig::NAMES {
        let image = |backend| stage.render(&config(refiner, backend, PatternKind::Jittered, 64)).unwrap();
        let (truth, voxels) = (image("bvh"), image("voxel"));
        let sum = |values: &mut dyn Iterator<Item = f32>| f64::from(values.sum::<f32>());
        let all = sum(&mut truth.irradiance.iter().map(|e| e.x));
        let off = sum(&mut truth.irradiance.iter().zip(&voxels.irradiance).map(|(a, b)| (a.x - b.x).abs()));
        // Coarse voxels darken creases and let light through thin things: a tenth of the light, not half.
        assert!(off > 0.0 && off < 0.3 * all, "{refiner}: {off} of {all}");
    }
}

#[test]
fn jitter_is_refused_by_4d_rasterization() {
    let stage = Stage::bundled("contact").unwrap();
    let fault = stage.render(&config("per-pixel", "raster4d", PatternKind::Jittered, 64)).unwrap_err();
    assert!(fault.to_string().contains("shifted-rows"), "{fault}");
}
