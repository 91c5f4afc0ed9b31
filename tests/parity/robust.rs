//! Sizes, several lights and frames, and what is refused.

use halflight::config::{PipelineConfig, UpsamplerConfig};
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::scene::{Mesh, Scene};
use halflight_gpu::{GpuError, Inputs, Renderer, visibility_module};
use halflight_tests::{Stage, blocker_over_floor};

use crate::device::Bench;
use crate::scenes::{Twins, full};
use crate::whole::nmse2;

fn renderer(bench: &Bench, scene: &Scene, config: &PipelineConfig) -> Result<Renderer, GpuError> {
    Renderer::new(&bench.gpu.device, &bench.gpu.queue, scene, config)
}

#[test]
fn sizes_may_change_with_every_frame() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let mut gpu = renderer(&bench, &stage.scene, &full(64, 48, Shading::Ratio)).unwrap();
    for (width, height) in [(1, 1), (17, 9), (64, 64), (3, 100), (1, 1), (65, 1), (64, 48)] {
        gpu.resize(width, height).unwrap();
        let stats = bench.render(&mut gpu, &Inputs::default());
        let image: Vec<[f32; 4]> = bench.read(gpu.image());
        assert_eq!(image.len(), (width * height) as usize);
        let expected = stage.render(&full(width, height, Shading::Ratio)).unwrap();
        assert!(nmse2(&image, &expected) < 1e-3, "{width}x{height}");
        assert_eq!(stats.frame.rays.skipped, expected.stats.rays.skipped, "{width}x{height}");
        assert_eq!(stats.frame.rays.last, expected.stats.rays.last);
        assert_eq!(stats.frame.fragments, expected.stats.fragments);
    }
    assert!(matches!(gpu.resize(0, 48), Err(GpuError::Pipeline(_))));
    assert!(matches!(gpu.resize(64, 40_000), Err(GpuError::Pipeline(_))));
    // 32,768² points of 16 bytes are more than any device binds.
    assert!(matches!(gpu.resize(32_768, 32_768), Err(GpuError::TooLarge { .. })));
    // It goes on as it was.
    bench.render(&mut gpu, &Inputs::default());
    assert_eq!(bench.read::<[f32; 4]>(gpu.image()).len(), 64 * 48);
}

#[test]
fn frames_repeat_bit_for_bit_and_differ_by_number() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::bundled("toys").unwrap();
    let mut gpu = renderer(&bench, &stage.scene, &full(64, 48, Shading::Ratio)).unwrap();
    let mut image = |frame: u32| {
        bench.render(&mut gpu, &Inputs { frame, ..Inputs::default() });
        bench.read::<[u32; 4]>(gpu.image())
    };
    let first = image(3);
    assert_ne!(first, image(4));
    assert_eq!(first, image(3));
}

#[test]
fn lights_are_summed() {
    let Some(bench) = Bench::open() else { return };
    let mut scene = blocker_over_floor();
    let small = AreaLight {
        corner: scene.lights[0].corner + halflight::glam::Vec3::new(2.0, 1.0, 0.0),
        edge_u: halflight::glam::Vec3::X * 0.05,
        two_sided: true,
        ..scene.lights[0]
    };
    scene.lights.push(small);
    let stage = Stage::new(scene).unwrap();
    for shading in [Shading::Ratio, Shading::Sampled] {
        let twins = Twins::of(&bench, stage.clone(), &full(64, 48, shading), true);
        let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let off = nmse2(&image, twins.cpu.image());
        // Cubature and Lambert's formula in double precision agree to 1e-5, whose square this is.
        assert!(off < 1e-10, "{shading:?}: {off:e}");
    }
}

#[test]
fn scenes_without_triangles_are_dark() {
    let Some(bench) = Bench::open() else { return };
    let scene = Scene { mesh: Mesh::default(), ..blocker_over_floor() };
    let mut gpu = renderer(&bench, &scene, &full(20, 10, Shading::Ratio)).unwrap();
    bench.render(&mut gpu, &Inputs::default());
    let image: Vec<[f32; 4]> = bench.read(gpu.image());
    assert!(image.iter().all(|&[r, g, b, _]| r == 0.0 && g == 0.0 && b == 0.0));
}

#[test]
fn what_cannot_be_rendered_is_refused() {
    let Some(bench) = Bench::open() else { return };
    let scene = blocker_over_floor();
    let config = full(20, 10, Shading::Ratio);
    let refused = |scene: &Scene, config: &PipelineConfig| renderer(&bench, scene, config).unwrap_err();
    let dark = Scene { lights: Vec::new(), ..blocker_over_floor() };
    assert!(matches!(refused(&dark, &config), GpuError::Pipeline(_)));
    let triangulated = PipelineConfig { upsampler: UpsamplerConfig::Delaunay, ..config };
    assert!(matches!(refused(&scene, &triangulated), GpuError::Unsupported { stage: "delaunay", .. }));
    let module = visibility_module().unwrap().replace("fn occluded", "fn hidden");
    let (device, queue) = (&bench.gpu.device, &bench.gpu.queue);
    let other = Renderer::with_visibility(device, queue, &scene, &config, &module);
    assert!(matches!(other.unwrap_err(), GpuError::Shader { .. }));
}
