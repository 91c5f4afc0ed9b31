//! External visibility backends.

use halflight::config::{PipelineConfig, RefinerConfig};
use halflight::irradiance::Shading;
use halflight::refine::NicholsConfig;
use halflight_gpu::{Gpu, GpuError, Renderer, shader_module};
use halflight_tests::{Stage, blocker_over_floor};

use crate::device::Bench;
use crate::masks::{compare, gpu_masks};
use crate::scenes::{Twins, bundled, per_pixel};

/// Module that tests all triangles, one after another.
const BRUTE_FORCE: &str = "
//@ needs visibility/triangle
fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool {
    for (var triangle = 0u; triangle < arrayLength(&triangles) / 3u; triangle++) {
        if meets(triangle, origin, end, end - origin) {
            return true;
        }
    }
    return false;
}
";

/// Module for the blocker of `blocker_over_floor`, without any buffer; the floor hides nothing.
const BLOCKER: &str = "
fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool {
    if origin.y >= 1.0 || end.y <= 1.0 {
        return false;
    }
    let at = origin + (end - origin) * ((1.0 - origin.y) / (end.y - origin.y));
    return abs(at.x) <= 0.5 && abs(at.z) <= 0.5;
}
";

fn renderer(bench: &Bench, stage: &Stage, config: &PipelineConfig, text: &str) -> Result<Renderer, GpuError> {
    let Gpu { device, queue, .. } = &bench.gpu;
    Renderer::with_visibility(device, queue, &stage.scene, config, text)
}

/// Twins whose GPU uses a module.
fn twins(bench: &Bench, stage: &Stage, text: &str) -> Twins {
    let config = per_pixel(64, 48, Shading::Ratio);
    let mut twins = Twins::of(bench, stage.clone(), &config, true);
    twins.gpu = renderer(bench, stage, &config, text).unwrap();
    twins.render_gpu(bench);
    twins
}

#[test]
fn the_same_module_gives_the_same_masks() {
    let Some(bench) = Bench::open() else { return };
    let stage = bundled("few toys");
    let refiners = [RefinerConfig::PerPixel, RefinerConfig::Nichols(NicholsConfig::default())];
    for refiner in refiners {
        let config = PipelineConfig { refiner, ..per_pixel(64, 48, Shading::Ratio) };
        let mut twins = Twins::of(&bench, stage.clone(), &config, true);
        let words = config.sampling.pattern().unwrap().len().div_ceil(32);
        let masks = |gpu: &Renderer| gpu_masks(&bench, gpu, words);
        let (expected, image) = (masks(&twins.gpu), bench.read::<[u32; 4]>(twins.gpu.image()));
        let text = shader_module("visibility/bvh").unwrap();
        twins.gpu = renderer(&bench, &stage, &config, &text).unwrap();
        twins.render_gpu(&bench);
        assert!(masks(&twins.gpu) == expected && expected.len() > 500, "{refiner:?}");
        assert!(bench.read::<[u32; 4]>(twins.gpu.image()) == image, "{refiner:?}");
        // Module without any occluder.
        let open = "fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool { return false; }";
        twins.gpu = renderer(&bench, &stage, &config, open).unwrap();
        twins.render_gpu(&bench);
        assert!(masks(&twins.gpu) != expected, "{refiner:?}");
    }
}

#[test]
fn other_modules_are_compared_with_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::new(blocker_over_floor()).unwrap();
    for text in [BRUTE_FORCE, BLOCKER] {
        let (flips, rays) = compare(&bench, &twins(&bench, &stage, text)).unwrap();
        // Samples are aligned with edges of the blocker; rounding decides only a few of these.
        assert!(rays > 10_000 && flips * 10_000 <= rays, "{flips} of {rays}: {text}");
    }
    // Blocker that is a centimetre too small, and one that never ends a ray.
    for (right, wrong) in [("abs(at.x) <= 0.5", "abs(at.x) <= 0.49"), ("abs(at.z) <= 0.5", "false")] {
        assert!(BLOCKER.contains(right));
        assert!(compare(&bench, &twins(&bench, &stage, &BLOCKER.replace(right, wrong))).is_err(), "{wrong}");
    }
}

#[test]
fn modules_that_cannot_be_used_say_why() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let bodies = [
        // Fault of the module, and part of the message.
        ("fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool { return of_nobody(end); }", "of_nobody"),
        ("fn occluded(origin: vec3<f32>) -> bool { return false; }", "occluded"),
        ("fn hidden(origin: vec3<f32>, end: vec3<f32>) -> bool { return false; }", "occluded"),
        ("fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool { return 1u; }", "occluded"),
        ("fn occluded(", "expected"),
        ("//@ reads nonsense\n", "nonsense"),
        ("//@ needs visibility/nothing\n", "visibility/nothing"),
    ];
    for (text, expected) in bodies {
        let error = renderer(&bench, &stage, &per_pixel(64, 48, Shading::Ratio), text).unwrap_err();
        assert!(matches!(error, GpuError::Shader { .. }), "{text}: {error:?}");
        assert!(error.to_string().contains(expected), "{text}: {error}");
    }
    let Gpu { device, queue, .. } = &bench.gpu;
    let config = per_pixel(64, 48, Shading::Ratio);
    let unknown = Renderer::with_modules(device, queue, &stage.scene, &config, &[("visibility/nothing", "")]);
    assert!(unknown.unwrap_err().to_string().contains("visibility/nothing"));
}
