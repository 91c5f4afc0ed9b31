//! Devices with low limits: identical results where these suffice, otherwise an error that names the limit.

use halflight::config::{PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::irradiance::Shading;
use halflight::refine::{LatticeConfig, NicholsConfig, SfvtGassConfig};
use halflight_gpu::wgpu::Limits;
use halflight_gpu::{GpuError, Inputs, required_limits};
use halflight_tests::blocker_over_floor;

use crate::device::Bench;
use crate::scenes::{Twins, bundled, per_pixel};
use crate::upsamplers::with_defaults;
use crate::{masks, refiners, upsamplers};

/// Limits of software and small devices, with the storage buffers that WebGPU guarantees.
fn small() -> Limits {
    Limits {
        max_storage_buffers_per_shader_stage: 8,
        max_compute_invocations_per_workgroup: 64,
        max_compute_workgroup_size_x: 64,
        max_compute_workgroup_size_y: 8,
        max_compute_workgroup_size_z: 1,
        ..Limits::downlevel_defaults()
    }
}

fn all_refiners() -> [RefinerConfig; 4] {
    [
        RefinerConfig::PerPixel,
        RefinerConfig::Nichols(NicholsConfig::default()),
        RefinerConfig::SfvtGass(SfvtGassConfig::default()),
        RefinerConfig::Lattice(LatticeConfig::default()),
    ]
}

fn config(refiner: RefinerConfig) -> PipelineConfig {
    let upsampler = match refiner {
        RefinerConfig::Lattice(_) => UpsamplerConfig::Lattice(Default::default()),
        _ => UpsamplerConfig::RbfRobust(Default::default()),
    };
    PipelineConfig { refiner, upsampler, ..per_pixel(110, 83, Shading::Ratio) }
}

#[test]
fn small_devices_render_the_same() {
    let Some(bench) = Bench::open() else { return };
    let bench = bench.limited(small());
    let [per_pixel, nichols, sfvt, lattice] = all_refiners();
    let twins = |config: &PipelineConfig| Twins::render(&bench, "toys", config, true);
    let (flips, rays) = masks::compare(&bench, &twins(&config(per_pixel))).unwrap();
    assert!(flips * 100_000 <= rays, "{flips} of {rays}");
    for refiner in [nichols, sfvt] {
        refiners::check(&bench, &twins(&config(refiner)), Shading::Ratio).unwrap();
    }
    for (upsampler, tolerance) in with_defaults() {
        let config = PipelineConfig { upsampler, ..config(nichols) };
        upsamplers::check(&bench, &twins(&config), &config, tolerance).unwrap();
    }
    let twins = twins(&config(lattice));
    refiners::check_lattice(&bench, &twins, Shading::Ratio).unwrap();
    upsamplers::check(&bench, &twins, &config(lattice), 1e-4).unwrap();
}

/// Number and unit of a refused resource, and the limit.
fn refused(error: GpuError) -> (&'static str, u64) {
    let text = error.to_string();
    let GpuError::TooLarge { needed, unit, limit, .. } = error else { panic!("{error:?}") };
    assert!(needed > limit && text.contains(&limit.to_string()) && text.contains(unit), "{text}");
    (unit, limit)
}

#[test]
fn what_a_device_cannot_bind_or_run_is_refused() {
    let Some(bench) = Bench::open() else { return };
    let scene = blocker_over_floor();
    let refusal = |limits: Limits, refiner| {
        let bench = bench.limited(limits);
        let error = bench.renderer(&scene, &config(refiner)).unwrap_err();
        bench.check();
        error
    };
    for refiner in all_refiners() {
        let few = Limits { max_storage_buffers_per_shader_stage: 4, ..small() };
        assert_eq!(refused(refusal(few, refiner)), ("storage buffers a stage", 4));
        let none = Limits::downlevel_webgl2_defaults();
        assert_eq!(refused(refusal(none, refiner)), ("workgroups along a side", 0));
        // The limits named by the compiler's message.
        let narrow = Limits { max_compute_invocations_per_workgroup: 32, ..small() };
        let error = refusal(narrow, refiner);
        assert!(matches!(error, GpuError::Shader { .. }) && error.to_string().contains("32"), "{error}");
    }
    let crowded = Limits { max_compute_workgroup_storage_size: 4096, ..small() };
    assert_eq!(refused(refusal(crowded, RefinerConfig::PerPixel)), ("bytes of shared memory", 4096));
}

#[test]
fn what_does_not_fit_is_refused_and_never_cut_off() {
    let Some(bench) = Bench::open() else { return };
    let scene = blocker_over_floor();
    const MIB: u64 = 1 << 20;
    for limits in [
        Limits { max_storage_buffer_binding_size: MIB, ..small() },
        Limits { max_storage_buffer_binding_size: MIB, max_buffer_size: MIB, ..small() },
    ] {
        let bench = bench.limited(limits);
        // 256² points of 16 bytes are a mebibyte, and so are the queries of this refiner.
        let config = per_pixel(256, 256, Shading::Ratio);
        let mut gpu = bench.renderer(&scene, &config).unwrap();
        assert_eq!(refused(gpu.resize(257, 256).unwrap_err()), ("bytes", MIB));
        let larger = PipelineConfig { width: 257, ..config };
        assert_eq!(refused(bench.renderer(&scene, &larger).unwrap_err()), ("bytes", MIB));
        // The renderer keeps working.
        bench.render(&mut gpu, &Inputs::default());
        let image: Vec<[f32; 4]> = bench.read(gpu.image());
        assert!(image.len() == 256 * 256 && image.iter().any(|pixel| pixel[0] > 0.0));
    }
    let tiny = bench.limited(Limits { max_storage_buffer_binding_size: MIB / 16, ..small() });
    let toys = &bundled("toys").scene;
    assert_eq!(
        refused(tiny.renderer(toys, &per_pixel(16, 16, Shading::Ratio)).unwrap_err()),
        ("bytes", MIB / 16)
    );
    // The largest images, in bytes and in pixels along a side, that WebGPU promises.
    let plain = bench.limited(required_limits());
    let mut gpu = plain.renderer(&scene, &per_pixel(16, 16, Shading::Ratio)).unwrap();
    assert_eq!(refused(gpu.resize(8192, 8192).unwrap_err()), ("bytes", 128 * MIB));
    assert_eq!(refused(gpu.resize(8193, 1).unwrap_err()), ("pixels along a side", 8192));
    gpu.resize(8192, 1).unwrap();
    plain.render(&mut gpu, &Inputs::default());
    gpu.resize(1, 8192).unwrap();
    plain.render(&mut gpu, &Inputs::default());
}

#[test]
fn sizes_beyond_32_bits_do_not_wrap() {
    let Some(bench) = Bench::open() else { return };
    let scene = blocker_over_floor();
    let sixteen = SfvtGassConfig { sixteen_from_level: 1, ..SfvtGassConfig::default() };
    for refiner in all_refiners().into_iter().chain([RefinerConfig::SfvtGass(sixteen)]) {
        let mut gpu =
            bench.renderer(&scene, &PipelineConfig { width: 16, height: 16, ..config(refiner) }).unwrap();
        let error = gpu.resize(32_768, 32_768).unwrap_err();
        assert!(matches!(error, GpuError::TooLarge { .. }), "{error}");
        assert_eq!(gpu.size(), (16, 16));
    }
}
