//! Light samples, horizons and shadow rays, bit for bit.

use std::collections::HashMap;

use halflight::config::PipelineConfig;
use halflight::frame::{LightSampling, Sharing};
use halflight::irradiance::Shading;
use halflight::pattern::PatternKind;
use halflight_gpu::{Inside, Renderer};
use halflight_tests::Stage;

use crate::device::Bench;
use crate::rays::clearance;
use crate::scenes::{SCENES, Twins, per_pixel};

/// Masks of the GPU by pixel: key, wanted, visible.
pub(crate) fn gpu_masks(
    bench: &Bench,
    gpu: &Renderer,
    words: usize,
) -> HashMap<u32, (u32, Vec<u32>, Vec<u32>)> {
    let queries: Vec<[u32; 4]> = bench.read(gpu.inside(Inside::Queries));
    let wanted: Vec<u32> = bench.read(gpu.inside(Inside::Wanted));
    let visible: Vec<u32> = bench.read(gpu.inside(Inside::Visible));
    let masks = wanted.chunks(words).zip(visible.chunks(words));
    queries
        .iter()
        .zip(masks)
        .filter(|(query, _)| query[2] > 0)
        .map(|(query, (wanted, visible))| (query[0], (query[1], wanted.to_vec(), visible.to_vec())))
        .collect()
}

/// Words of 64 bits as words of 32.
pub(crate) fn halves(words: &[u64]) -> Vec<u32> {
    words.iter().flat_map(|&word| [word as u32, (word >> 32) as u32]).collect()
}

/// Compares all masks of a frame in which every pixel has a query: keys and wanted samples must be equal, and
/// samples whose visibility differs must be within the rounding error. Returns the number of differing
/// samples, and of all.
pub(crate) fn compare(bench: &Bench, twins: &Twins) -> Result<(usize, usize), String> {
    let fragments = twins.cpu.fragments();
    let batch = fragments.batch(0);
    let words = batch.pattern().len().div_ceil(32);
    let found = gpu_masks(bench, &twins.gpu, words);
    assert_eq!(found.len(), batch.len());
    let light = twins.stage.scene.lights[0];
    let (mut flips, mut rays) = (0, 0);
    for (index, query) in batch.queries().iter().enumerate() {
        let (key, wanted, visible) = &found[&query.pixel];
        if *key != query.key {
            return Err(format!("pixel {}: another key", query.pixel));
        }
        let (expected_wanted, expected) = (halves(batch.wanted(index)), halves(batch.visible(index)));
        if wanted[..] != expected_wanted[..words] {
            return Err(format!("pixel {}: other samples wanted", query.pixel));
        }
        for sample in 0..batch.pattern().len() {
            let bit = |mask: &[u32]| mask[sample / 32] >> (sample % 32) & 1;
            if bit(wanted) == 0 {
                assert_eq!(bit(visible), 0);
                continue;
            }
            rays += 1;
            if bit(visible) != bit(&expected) {
                flips += 1;
                let end = light.point(batch.pattern().position(sample, query.key));
                // Products of three lengths have an error of a few units in the last place of the largest:
                // distances of a few 2⁻²⁴ of the scene's size, 16 of them allowed.
                let slack = f64::from(twins.stage.bvh.diagonal()) * 16.0 / f64::from(1 << 24);
                let clear = clearance(&twins.stage.scene.mesh, query.origin, end);
                if clear >= slack {
                    return Err(format!("pixel {} sample {sample}: {clear} of {slack} m", query.pixel));
                }
            }
        }
    }
    Ok((flips, rays))
}

#[test]
fn rays_are_decided_as_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    for scene in SCENES {
        let twins = Twins::render(&bench, scene, &per_pixel(80, 60, Shading::Ratio), true);
        let (flips, rays) = compare(&bench, &twins).unwrap();
        // Fewer than one ray in a hundred thousand passes within the rounding error of an edge.
        assert!(rays > 100_000 && flips * 100_000 <= rays, "{scene}: {flips} of {rays}");
    }
}

#[test]
fn patterns_of_all_kinds_and_sizes_have_the_same_samples() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::new(halflight_tests::blocker_over_floor()).unwrap();
    for kind in [PatternKind::Grid, PatternKind::ShiftedRows, PatternKind::Jittered] {
        for (count, sharing) in [
            (1, Sharing::Frame),
            (4, Sharing::Receiver),
            (7, Sharing::Fragment),
            (16, Sharing::Fragment),
            (48, Sharing::Receiver),
            (64, Sharing::Frame),
            (100, Sharing::Fragment),
            (256, Sharing::Receiver),
        ] {
            let sampling = LightSampling { count, kind, sharing };
            let config = PipelineConfig { sampling, seed: 5, ..per_pixel(33, 17, Shading::Ratio) };
            let twins = Twins::of(&bench, stage.clone(), &config, true);
            let (flips, rays) = compare(&bench, &twins).unwrap();
            // Samples of grids are aligned with edges of the blocker; rounding decides only a few of these.
            assert!(rays > 0 && flips * 10_000 <= rays, "{kind:?} {count}: {flips} of {rays}");
        }
    }
}

/// True if the comparison accepts a shader with an alteration.
fn accepts(bench: &Bench, altered: [&str; 3]) -> bool {
    let mut twins = Twins::render(bench, "atrium", &per_pixel(80, 60, Shading::Ratio), true);
    twins.alter(bench, &per_pixel(80, 60, Shading::Ratio), altered);
    compare(bench, &twins).is_ok_and(|(flips, rays)| flips * 100_000 <= rays)
}

#[test]
fn wrong_shaders_are_found() {
    let Some(bench) = Bench::open() else { return };
    let triangle = "visibility/triangle";
    assert!(accepts(&bench, [triangle, "let a = first.xyz - origin;", "let a = first.xyz - (origin);"]));
    // Boxes that end too early, triangles that are open on one side, and a light half way to the receiver.
    for altered in [
        ["visibility/traversal", "vec4(1.0)));", "vec4(0.5)));"],
        [triangle, "ca >= 0.0)", "ca >= 1e-3)"],
        [
            triangle,
            "let to = dot3(up, first.xyz - end);",
            "let to = dot3(up, first.xyz - (origin + d * 0.5));",
        ],
    ] {
        assert!(!accepts(&bench, altered), "{altered:?}");
    }
}
