//! Faults while frames are rendered: lists that overflow, and devices that are lost.

use std::sync::mpsc;

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::irradiance::Shading;
use halflight::pattern::PatternKind;
use halflight::refine::{LatticeConfig, NicholsConfig, SfvtGassConfig};
use halflight_gpu::{Gpu, GpuError, GpuStats, Inputs, Inside, Renderer, shader_module, wgpu};
use halflight_tests::blocker_over_floor;

use crate::device::Bench;
use crate::scenes::{bundled, per_pixel};

/// Renderer whose query lists have a fraction of their capacity.
fn cramped(bench: &Bench, config: &PipelineConfig, share: u32, modules: &[&'static str]) -> Renderer {
    let texts: Vec<String> = modules
        .iter()
        .map(|module| {
            let text = shader_module(module).unwrap();
            assert!(text.contains("frame.capacity"), "{module}");
            text.replace("frame.capacity", &format!("(frame.capacity / {share}u)"))
        })
        .collect();
    let modules: Vec<(&str, &str)> = modules.iter().copied().zip(texts.iter().map(String::as_str)).collect();
    let Gpu { device, queue, .. } = &bench.gpu;
    Renderer::with_modules(device, queue, &bundled("few toys").scene, config, &modules).unwrap()
}

/// Renders with unwritten queries marked; returns the statistics, the image and the number of marks left.
fn overflow(bench: &Bench, gpu: &mut Renderer) -> (GpuStats, Vec<[f32; 4]>, usize) {
    let queries = gpu.inside(Inside::Queries);
    bench.gpu.queue.write_buffer(queries, 0, &vec![0xab; queries.size() as usize]);
    let stats = bench.gpu.render(gpu, &Inputs::default()).unwrap();
    let image = bench.read(gpu.image());
    let queries: Vec<[u32; 4]> = bench.read(gpu.inside(Inside::Queries));
    (stats, image, queries.iter().filter(|query| **query == [0xabab_abab; 4]).count())
}

#[test]
fn queries_without_room_are_counted_and_others_are_as_they_were() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(64, 48, Shading::Ratio);
    let mut plain = bench.renderer(&bundled("few toys").scene, &config).unwrap();
    let stats = bench.render(&mut plain, &Inputs::default());
    let expected: Vec<[f32; 4]> = bench.read(plain.image());
    let all: u64 = stats.frame.fragments.per_level.iter().sum();
    let (stats, image, left) =
        overflow(&bench, &mut cramped(&bench, &config, 8, &["refine/per_pixel", "indirect_arguments"]));
    assert_eq!(stats.lost, all - 64 * 48 / 8);
    assert_eq!(left, 64 * 48 * 7 / 8);
    // Pixels have their value or none.
    let mut dark = 0;
    for (found, expected) in image.iter().zip(&expected) {
        let missing = *found == [0.0, 0.0, 0.0, 1.0];
        assert!(missing || found == expected, "{found:?} {expected:?}");
        dark += u64::from(missing && found != expected);
    }
    assert!(dark > 0 && dark <= stats.lost, "{dark} of {}", stats.lost);
}

#[test]
fn refiners_survive_lists_that_overflow() {
    let Some(bench) = Bench::open() else { return };
    let lattice = RefinerConfig::Lattice(LatticeConfig::default());
    let cases: [(RefinerConfig, &[&str]); 3] = [
        (RefinerConfig::Nichols(NicholsConfig::default()), &["refine/nichols_choose", "indirect_arguments"]),
        (
            RefinerConfig::SfvtGass(SfvtGassConfig::default()),
            &["refine/sfvt_classify", "refine/sfvt_finals", "indirect_arguments"],
        ),
        (lattice, &["refine/lattice_request", "indirect_arguments"]),
    ];
    for (refiner, modules) in cases {
        let upsampler = if refiner == lattice {
            UpsamplerConfig::Lattice(Default::default())
        } else {
            UpsamplerConfig::RbfRobust(Default::default())
        };
        // 109 × 83 pixels: shares of these are no multiple of a cell's queries.
        let config = PipelineConfig { refiner, upsampler, ..per_pixel(109, 83, Shading::Ratio) };
        let mut plain = bench.renderer(&bundled("few toys").scene, &config).unwrap();
        bench.render(&mut plain, &Inputs::default());
        let expected: Vec<[f32; 4]> = bench.read(plain.image());
        let brightest = expected.iter().map(|pixel| pixel[0]).fold(0.0, f32::max);
        let (stats, image, left) = overflow(&bench, &mut cramped(&bench, &config, 50, modules));
        assert!(stats.lost > 0, "{refiner:?}");
        let room = plain.inside(Inside::Queries).size() as usize / 16;
        assert!(left >= room - room / 50, "{refiner:?}: {left} of {room}");
        // Values must be finite, and no pixel may be brighter than possible.
        assert!(image.iter().flatten().all(|&value| (0.0..=1.5 * brightest.max(1.0)).contains(&value)));
        // The device keeps working.
        bench.render(&mut plain, &Inputs::default());
        assert!(bench.read::<[f32; 4]>(plain.image()) == expected, "{refiner:?}");
    }
}

#[test]
fn tasks_without_room_are_counted() {
    let Some(bench) = Bench::open() else { return };
    let sampling = LightSampling { kind: PatternKind::ShiftedRows, ..LightSampling::default() };
    let visibility = VisibilityConfig::named("raster4d").unwrap();
    let config = PipelineConfig { visibility, sampling, ..per_pixel(64, 48, Shading::Ratio) };
    let text = shader_module("visibility/raster4d_scan").unwrap();
    assert!(text.contains("SIDE * SIDE"));
    let scene = &bundled("few toys").scene;
    let Gpu { device, queue, .. } = &bench.gpu;
    for (most, lost) in [("1000000u", false), ("1000u", true)] {
        let modules = [("visibility/raster4d_scan", &*text.replace("SIDE * SIDE", most))];
        let mut gpu = Renderer::with_modules(device, queue, scene, &config, &modules).unwrap();
        let stats = bench.gpu.render(&mut gpu, &Inputs::default()).unwrap();
        assert_eq!(stats.lost > 1000, lost, "{most}: {}", stats.lost);
    }
}

#[test]
fn lost_devices_give_errors_and_no_panic() {
    for name in ["bvh", "voxel"] {
        let Some(bench) = Bench::open() else { return };
        let visibility = VisibilityConfig::named(name).unwrap();
        lost_device(&bench, &PipelineConfig { visibility, ..per_pixel(32, 24, Shading::Ratio) });
    }
}

fn lost_device(bench: &Bench, config: &PipelineConfig) {
    let scene = blocker_over_floor();
    let mut gpu = bench.renderer(&scene, config).unwrap();
    bench.render(&mut gpu, &Inputs::default());
    // Frame that is recorded before the loss and submitted after.
    let Gpu { device, queue, .. } = &bench.gpu;
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    gpu.record(&mut encoder, &Inputs::default()).unwrap();
    let pending = gpu.read_stats(&mut encoder);
    device.destroy();
    queue.submit([encoder.finish()]);
    let (send, receive) = mpsc::channel();
    pending.read(move |stats| send.send(stats).unwrap());
    let _ = device.poll(wgpu::PollType::wait_indefinitely());
    assert!(matches!(receive.try_recv().unwrap(), Err(GpuError::Readback(_))));
    // Frame that is recorded after the loss.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    assert!(matches!(gpu.record(&mut encoder, &Inputs::default()), Err(GpuError::Memory(_))));
    let pending = gpu.read_stats(&mut encoder);
    queue.submit([encoder.finish()]);
    let (send, receive) = mpsc::channel();
    pending.read(move |stats| send.send(stats).unwrap());
    assert!(matches!(receive.try_recv().unwrap(), Err(GpuError::Readback(_))));
    assert!(matches!(bench.gpu.render(&mut gpu, &Inputs::default()), Err(GpuError::Memory(_))));
    assert!(matches!(bench.gpu.read::<u32>(gpu.image()), Err(GpuError::Readback(_))));
    assert!(bench.gpu.download(&gpu).is_err());
    // Buffers of another size may be created or not.
    let _ = gpu.resize(20, 10);
    assert!(bench.gpu.render(&mut gpu, &Inputs::default()).is_err());
    assert!(matches!(bench.renderer(&scene, config), Err(GpuError::Memory(_))));
}
