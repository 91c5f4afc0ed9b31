//! Image sizes, several lights and frames, and refusals.

use halflight::camera::View;
use halflight::config::{IndirectConfig, PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::glam::{Vec3, Vec4};
use halflight::irradiance::Shading;
use halflight::light::{AreaLight, LightFrame};
use halflight::refine::LatticeConfig;
use halflight::scene::{Mesh, Scene};
use halflight_gpu::{GpuError, Inputs, Renderer, Surfaces, shader_module, wgpu};
use halflight_tests::{Stage, blocker_over_floor};
use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use crate::device::Bench;
use crate::present::presented;
use crate::scenes::{Twins, bundled, per_pixel};
use crate::whole::nmse2;

#[test]
fn sizes_may_change_with_every_frame() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let mut gpu = bench.renderer(&stage.scene, &per_pixel(64, 48, Shading::Ratio)).unwrap();
    for (width, height) in [(1, 1), (17, 9), (64, 64), (3, 100), (1, 1), (65, 1), (64, 48)] {
        gpu.resize(width, height).unwrap();
        let stats = bench.render(&mut gpu, &Inputs::default());
        let image: Vec<[f32; 4]> = bench.read(gpu.image());
        assert_eq!(image.len(), (width * height) as usize);
        let expected = stage.render(&per_pixel(width, height, Shading::Ratio)).unwrap();
        assert!(nmse2(&image, &expected) < 1e-3, "{width}x{height}");
        assert_eq!(stats.frame.rays.skipped, expected.stats.rays.skipped, "{width}x{height}");
        assert_eq!(stats.frame.rays.last, expected.stats.rays.last);
        assert_eq!(stats.frame.fragments, expected.stats.fragments);
    }
    assert!(matches!(gpu.resize(0, 48), Err(GpuError::Pipeline(_))));
    assert!(matches!(gpu.resize(64, 40_000), Err(GpuError::Pipeline(_))));
    // Points of 32,768² pixels, 16 bytes each, exceed the binding limit of any device.
    assert!(matches!(gpu.resize(32_768, 32_768), Err(GpuError::TooLarge { .. })));
    // The renderer keeps working.
    bench.render(&mut gpu, &Inputs::default());
    assert_eq!(bench.read::<[f32; 4]>(gpu.image()).len(), 64 * 48);
}

#[test]
fn frames_repeat_bit_for_bit_and_differ_by_number() {
    let Some(bench) = Bench::open() else { return };
    let stage = bundled("few toys");
    let mut gpu = bench.renderer(&stage.scene, &per_pixel(64, 48, Shading::Ratio)).unwrap();
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
    let LightFrame { origin, v, .. } = scene.lights[0].frame();
    let (corner, u) = (origin + Vec3::new(2.0, 1.0, 0.0), Vec3::X * 0.05);
    let small = AreaLight::parallelogram(corner, u, v, scene.lights[0].radiance).two_sided();
    scene.lights.push(small);
    let stage = Stage::new(scene).unwrap();
    for shading in [Shading::Ratio, Shading::Sampled] {
        let twins = Twins::of(&bench, stage.clone(), &per_pixel(64, 48, shading), true);
        let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let off = nmse2(&image, twins.cpu.image());
        // Cubature and Lambert's formula in double precision agree to 1e-5; this is the square.
        assert!(off < 1e-10, "{shading:?}: {off:e}");
    }
}

#[test]
fn scenes_without_triangles_are_dark() {
    let Some(bench) = Bench::open() else { return };
    let scene = Scene { mesh: Arc::new(Mesh::default()), ..blocker_over_floor() };
    let mut gpu = bench.renderer(&scene, &per_pixel(20, 10, Shading::Ratio)).unwrap();
    bench.render(&mut gpu, &Inputs::default());
    let image: Vec<[f32; 4]> = bench.read(gpu.image());
    assert!(image.iter().all(|&[r, g, b, _]| r == 0.0 && g == 0.0 && b == 0.0));
}

#[test]
fn what_cannot_be_rendered_is_refused() {
    let Some(bench) = Bench::open() else { return };
    let scene = blocker_over_floor();
    let config = per_pixel(20, 10, Shading::Ratio);
    let refused = |scene: &Scene, config: &PipelineConfig| bench.renderer(scene, config).unwrap_err();
    let dark = Scene { lights: Vec::new(), ..blocker_over_floor() };
    assert!(matches!(refused(&dark, &config), GpuError::Pipeline(_)));
    let triangulated = PipelineConfig { upsampler: UpsamplerConfig::Delaunay(Default::default()), ..config };
    assert!(matches!(refused(&scene, &triangulated), GpuError::Unsupported { stage: "delaunay", .. }));
    let refiner = RefinerConfig::Lattice(LatticeConfig { certify: true, ..LatticeConfig::default() });
    let error = refused(&scene, &PipelineConfig { refiner, ..config });
    assert!(matches!(error, GpuError::Unsupported { .. }) && error.to_string().contains("certificates"));
    let indirect = IndirectConfig::Gather(Default::default());
    let error = refused(&scene, &PipelineConfig { indirect, ..config });
    assert!(matches!(error, GpuError::Unsupported { stage: "indirect light", .. }), "{error}");
    let module = shader_module("visibility/bvh").unwrap().replace("fn occluded", "fn hidden");
    let (device, queue) = (&bench.gpu.device, &bench.gpu.queue);
    let other = Renderer::with_visibility(device, queue, &scene, &config, &module);
    assert!(matches!(other.unwrap_err(), GpuError::Shader { .. }));
}

/// Texture of four floats per pixel, with these texels.
fn texture(bench: &Bench, (width, height): (u32, u32), texels: &[[f32; 4]]) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = bench.gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * width), rows_per_image: None };
    bench.gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

#[test]
fn surfaces_and_images_may_be_textures() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::new(blocker_over_floor()).unwrap();
    // Rows of 16 texels are 256 bytes, which copies to buffers need.
    let size @ (width, height): (u32, u32) = (16, 12);
    let twins = Twins::of(&bench, stage, &per_pixel(width, height, Shading::Ratio), true);
    let gbuffer = twins.cpu.gbuffer();
    // Points on the surface: the GPU offsets them itself.
    let view = View::new(&twins.stage.scene.camera, width, height);
    let point = |pixel: usize| {
        let d = view.direction(pixel % width as usize, pixel / width as usize);
        let depth = gbuffer.depth[pixel];
        if depth.is_finite() { (view.eye + d * depth).extend(0.0) } else { Vec4::ZERO }.to_array()
    };
    let points: Vec<[f32; 4]> = (0..gbuffer.pixels()).map(point).collect();
    let depths: Vec<[f32; 4]> = gbuffer.depth.iter().map(|&depth| [depth, 0.0, 0.0, 0.0]).collect();
    let normals: Vec<[f32; 4]> = gbuffer.normal.iter().map(|n| n.extend(0.0).to_array()).collect();
    let [points, depths, normal] = [points, depths, normals].map(|texels| texture(&bench, size, &texels));
    let mut gpu = twins.gpu;
    for surfaces in [
        Surfaces::Points { position: &points, normal: &normal },
        Surfaces::Depths { depth: &depths, normal: &normal },
    ] {
        bench.render(&mut gpu, &Inputs { surfaces, ..Inputs::default() });
        let image: Vec<[f32; 4]> = bench.read(gpu.image());
        // Points from depths are wrong by a unit in the last place, which moves almost no edge over a sample.
        let off = nmse2(&image, twins.cpu.image());
        assert!(off < 1e-4, "{surfaces:?}: {off:e}");
    }
    let expected: Vec<[f32; 4]> = bench.read(gpu.image());
    // Surfaces without an albedo are shown white.
    let shown = presented(&bench, &mut gpu, wgpu::TextureFormat::Rgba32Float);
    let shown: &[[f32; 4]] = bytemuck::cast_slice(&shown);
    for (pixel, (shown, light)) in shown.iter().zip(&expected).enumerate() {
        let close = |axis: usize| (shown[axis] - light[axis] * FRAC_1_PI).abs() <= 1e-6 * light[axis];
        assert!((0..3).all(close), "{pixel}: {shown:?} {light:?}");
    }
}
