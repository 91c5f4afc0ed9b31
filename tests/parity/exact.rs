//! Parity of backends that find occluders otherwise than by rays: beams and 4D rasterization.

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::glam::{Vec2, Vec3};
use halflight::irradiance::Shading;
use halflight::pattern::PatternKind;
use halflight::pipeline::PipelineError;
use halflight::raster4d::Raster4dConfig;
use halflight::refine::{LatticeConfig, NicholsConfig, SfvtGassConfig};
use halflight::scene::Scene;
use halflight_gpu::{GpuError, Inputs, Inside, Renderer, Surfaces, required_limits};
use halflight_tests::{Room, Stage, blocker_over_floor, quads};
use std::sync::Arc;

use crate::device::Bench;
use crate::masks::compare;
use crate::scenes::{SCENES, Twins, bundled, per_pixel};
use crate::whole::nmse2;

fn with(visibility: VisibilityConfig, kind: PatternKind) -> PipelineConfig {
    let sampling = LightSampling { kind, ..LightSampling::default() };
    PipelineConfig { visibility, sampling, ..per_pixel(64, 48, Shading::Ratio) }
}

fn beams() -> PipelineConfig {
    with(VisibilityConfig::Beam, PatternKind::Jittered)
}

/// Configuration whose framebuffer has odd halves, for samples in rows.
fn raster4d() -> PipelineConfig {
    let config = Raster4dConfig { framebuffer: 50, ..Raster4dConfig::default() };
    with(VisibilityConfig::Raster4d(config), PatternKind::ShiftedRows)
}

/// Quads of all sizes around a two-sided light, through its plane and beside it.
fn stress() -> Scene {
    let scene = blocker_over_floor();
    let light = scene.lights[0];
    let middle = light.point(Vec2::splat(0.5));
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let mut list = vec![(Vec3::new(-8.0, 0.0, -8.0), Vec3::X * 16.0, Vec3::Z * 16.0)];
    for number in 0..300 {
        let size = 0.02 * 1.01f32.powi(number);
        let mut vector = |size: f32| Vec3::new(random(), random(), random()) * size;
        let corner = middle * Vec3::new(1.0, 0.75, 1.0) + vector(5.0);
        list.push((corner, vector(2.0 * size), vector(2.0 * size)));
    }
    let mut lights = scene.lights.clone();
    lights[0].two_sided = true;
    Scene { mesh: Arc::new(quads(&list)), lights, ..scene }
}

/// Number of queries that were left to rays.
fn spilled(bench: &Bench, gpu: &Renderer) -> usize {
    bench.read::<u32>(gpu.inside(Inside::Spilled))[0] as usize
}

#[test]
fn masks_are_those_of_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    for config in [beams(), raster4d()] {
        let name = config.visibility.name();
        for scene in SCENES {
            let twins = Twins::render(&bench, scene, &config, true);
            let (flips, rays) = compare(&bench, &twins).unwrap();
            // Threshold as for rays: few pass within the rounding error of an edge.
            assert!(rays > 50_000 && flips * 50_000 <= rays, "{name} {scene}: {flips} of {rays}");
            let (all, left) = (twins.cpu.fragments().batch(0).len(), spilled(&bench, &twins.gpu));
            // Both paths are compared: some shafts overflow, others do not.
            assert!(left < all && (left > 0 || name == "raster4d"), "{name} {scene}: {left} of {all}");
        }
        let twins = Twins::of(&bench, Stage::new(stress()).unwrap(), &config, true);
        let (flips, rays) = compare(&bench, &twins).unwrap();
        // Quads that cross the light and each other put more edges in a ray's way than the bundled scenes do.
        assert!(rays > 10_000 && flips * 10_000 <= rays, "{name}: {flips} of {rays}");
    }
}

#[test]
fn receivers_at_the_plane_of_the_light_go_to_rays() {
    let Some(bench) = Bench::open() else { return };
    let mut scene = blocker_over_floor();
    // Light just above the floor, with a wall beside it that both sides of the light illuminate.
    scene.lights[0] = scene.lights[0].transformed(|p| p.with_y(0.003), |d| d).two_sided();
    let floor = (Vec3::new(-8.0, 0.0, -8.0), Vec3::X * 16.0, Vec3::Z * 16.0);
    scene.mesh = Arc::new(quads(&[floor, (Vec3::new(1.0, -0.1, -0.5), Vec3::Y, Vec3::Z)]));
    let mut twins = Twins::of(&bench, Stage::new(scene).unwrap(), &raster4d(), true);
    let (flips, rays) = compare(&bench, &twins).unwrap();
    let (all, left) = (twins.cpu.fragments().batch(0).len(), spilled(&bench, &twins.gpu));
    assert!(rays > 50_000 && flips * 50_000 <= rays, "{flips} of {rays}");
    assert!(0 < left && left < all, "{left} of {all}");
    let margin = "return p.height > 0.0 && aside + error < MARGIN * 0.25;";
    twins.alter(&bench, &raster4d(), ["visibility/raster4d", margin, "return p.height > 0.0;"]);
    assert!(spilled(&bench, &twins.gpu) < left);
}

#[test]
fn what_is_dropped_is_found() {
    let Some(bench) = Bench::open() else { return };
    for config in [beams(), raster4d()] {
        let mut twins = Twins::of(&bench, Stage::new(stress()).unwrap(), &config, true);
        assert!(compare(&bench, &twins).is_ok());
        // Every twentieth triangle is dropped.
        let mut lossy = stress();
        let mesh = Arc::make_mut(&mut lossy.mesh);
        let kept: Vec<usize> = (0..mesh.triangles.len()).filter(|triangle| triangle % 20 != 7).collect();
        mesh.triangles = kept.iter().map(|&triangle| mesh.triangles[triangle]).collect();
        mesh.material_ids = kept.iter().map(|&triangle| mesh.material_ids[triangle]).collect();
        twins.gpu = bench.renderer(&lossy, &config).unwrap();
        bench.keep(&twins.gpu, twins.cpu.gbuffer());
        bench.render(&mut twins.gpu, &Inputs { surfaces: Surfaces::Kept, ..Inputs::default() });
        assert!(compare(&bench, &twins).is_err());
    }
}

#[test]
fn wrong_shaders_are_found() {
    let Some(bench) = Bench::open() else { return };
    // Rectangles of receivers that are too large, triangles that miss cells, and cells that are not filled.
    let mut twins = Twins::render(&bench, "atrium", &raster4d(), true);
    assert!(compare(&bench, &twins).is_ok());
    for altered in [
        ["visibility/raster4d", "slope(p, -MARGIN) - error", "slope(p, -MARGIN) + 0.1"],
        ["visibility/raster4d_triangles", "squeezed(rectangle.high) + 1e-6", "squeezed(rectangle.low)"],
        ["visibility/raster4d_fill", "corner < 4u * frame.sides", "corner < 3u * frame.sides"],
    ] {
        twins.alter(&bench, &raster4d(), altered);
        assert!(compare(&bench, &twins).is_err(), "{altered:?}");
    }
}

#[test]
fn refiners_ask_all_backends_alike() {
    let Some(bench) = Bench::open() else { return };
    let stage = bundled("few toys");
    let refiners = [
        RefinerConfig::Nichols(NicholsConfig::default()),
        RefinerConfig::SfvtGass(SfvtGassConfig::default()),
        RefinerConfig::Lattice(LatticeConfig::default()),
    ];
    for refiner in refiners {
        for config in [beams(), raster4d()] {
            let upsampler = match refiner {
                RefinerConfig::Lattice(_) => UpsamplerConfig::Lattice(Default::default()),
                _ => config.upsampler,
            };
            let image = |visibility| {
                let config = PipelineConfig { refiner, visibility, upsampler, ..config };
                let mut gpu = bench.renderer(&stage.scene, &config).unwrap();
                let stats = bench.render(&mut gpu, &Inputs::default());
                (bench.read::<[f32; 4]>(gpu.image()), stats.frame.rays.total)
            };
            let [(expected, rays), (other, others)] = [VisibilityConfig::Bvh, config.visibility].map(image);
            let pixels = expected.iter().zip(&other).filter(|(a, b)| a != b).count();
            // The triangle test is identical; rounding in the search for triangles changes single samples.
            let name = config.visibility.name();
            assert!(pixels * 200 <= expected.len(), "{refiner:?} {name}: {pixels}");
            assert!(rays.abs_diff(others) * 200 <= rays, "{refiner:?} {name}: {others} for {rays}");
        }
    }
}

#[test]
fn devices_that_bind_too_few_buffers_are_refused() {
    let Some(bench) = Bench::open() else { return };
    let bench = bench.limited(required_limits());
    let renderer = |config: &PipelineConfig| bench.renderer(&blocker_over_floor(), config);
    for config in [beams(), raster4d()] {
        assert!(matches!(renderer(&config).unwrap_err(), GpuError::TooLarge { limit: 8, needed: 9, .. }));
    }
    assert!(renderer(&per_pixel(64, 48, Shading::Ratio)).is_ok());
}

#[test]
fn what_raster4d_cannot_do_is_refused() {
    let Some(bench) = Bench::open() else { return };
    let refusal = |config: Raster4dConfig, kind| {
        let config = with(VisibilityConfig::Raster4d(config), kind);
        bench.renderer(&blocker_over_floor(), &config).unwrap_err()
    };
    let usual = Raster4dConfig::default();
    // Refusals as on the CPU.
    let jittered = refusal(usual, PatternKind::Jittered);
    assert!(matches!(jittered, GpuError::Pipeline(PipelineError::Unsupported(_))), "{jittered}");
    let empty = refusal(Raster4dConfig { framebuffer: 0, ..usual }, PatternKind::Grid);
    assert!(matches!(empty, GpuError::Pipeline(PipelineError::Raster4d(_))), "{empty}");
    // One workgroup scans all cells, and a word has ten bits for a cell's column.
    let large = refusal(Raster4dConfig { framebuffer: 1025, ..usual }, PatternKind::Grid);
    assert!(matches!(large, GpuError::TooLarge { needed: 1025, .. }), "{large}");
    let parts = refusal(Raster4dConfig { one_cell: false, ..usual }, PatternKind::Grid);
    assert!(matches!(parts, GpuError::Unsupported { .. }), "{parts}");
}

#[test]
fn lamps_in_ceilings_shine() {
    let Some(bench) = Bench::open() else { return };
    for (step, two_sided) in [(0, false), (1, true), (2, false), (3, true)] {
        let height = 2.2 + 0.073 * f64::from(step);
        let stage = Stage::new(Room { height, two_sided, ..Room::default() }.scene()).unwrap();
        for config in [beams(), raster4d(), per_pixel(32, 24, Shading::Ratio)] {
            let twins = Twins::of(&bench, stage.clone(), &config, true);
            assert_eq!(twins.gpu.flush_lights(), twins.cpu.flush_lights());
            assert_eq!(twins.gpu.flush_lights().len(), 1);
            let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
            assert!(image.iter().filter(|rgb| rgb[0] > 0.5).count() > 200);
            assert!(nmse2(&image, twins.cpu.image()) < 1e-8, "{height} {two_sided}");
        }
    }
}
