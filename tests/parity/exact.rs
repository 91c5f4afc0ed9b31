//! Beams, which find triangles in another way than rays; and backends that are not there.

use halflight::config::{PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight::glam::{Vec2, Vec3};
use halflight::irradiance::Shading;
use halflight::raster4d::Raster4dConfig;
use halflight::refine::{NicholsConfig, SfvtGassConfig};
use halflight::scene::Scene;
use halflight::voxel::VoxelConfig;
use halflight_gpu::{GpuError, Inputs, Inside, Renderer, Surfaces, required_limits};
use halflight_tests::{Stage, blocker_over_floor, quads};

use crate::device::Bench;
use crate::masks::compare;
use crate::scenes::{SCENES, Twins, bundled, full};

fn beams() -> PipelineConfig {
    PipelineConfig { visibility: VisibilityConfig::Beam, ..full(64, 48, Shading::Ratio) }
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
    Scene { mesh: quads(&list), lights, ..scene }
}

/// Queries that were left to rays.
fn spilled(bench: &Bench, gpu: &Renderer) -> usize {
    bench.read::<u32>(gpu.inside(Inside::Spilled))[0] as usize
}

#[test]
fn masks_are_those_of_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    for scene in SCENES {
        let twins = Twins::render(&bench, scene, &beams(), true);
        let (flips, rays) = compare(&bench, &twins).unwrap();
        // As for rays: few pass an edge within rounding of it.
        assert!(rays > 50_000 && flips * 50_000 <= rays, "{scene}: {flips} of {rays}");
        let (all, left) = (twins.cpu.fragments().batch(0).len(), spilled(&bench, &twins.gpu));
        // Both ways of answering are compared: some shafts are full, others are not.
        assert!(0 < left && left < all, "{scene}: {left} of {all}");
    }
    let twins = Twins::of(&bench, Stage::new(stress()).unwrap(), &beams(), true);
    let (flips, rays) = compare(&bench, &twins).unwrap();
    // Quads that cross the light and each other have more edges in a ray's way than the bundled scenes do.
    assert!(rays > 10_000 && flips * 10_000 <= rays, "{flips} of {rays}");
}

#[test]
fn what_is_dropped_is_found() {
    let Some(bench) = Bench::open() else { return };
    let mut twins = Twins::of(&bench, Stage::new(stress()).unwrap(), &beams(), true);
    assert!(compare(&bench, &twins).is_ok());
    // Every twentieth triangle is lost.
    let mut lossy = stress();
    let mesh = &mut lossy.mesh;
    let kept: Vec<usize> = (0..mesh.triangles.len()).filter(|triangle| triangle % 20 != 7).collect();
    mesh.triangles = kept.iter().map(|&triangle| mesh.triangles[triangle]).collect();
    mesh.material_ids = kept.iter().map(|&triangle| mesh.material_ids[triangle]).collect();
    twins.gpu = bench.renderer(&lossy, &beams()).unwrap();
    bench.keep(&twins.gpu, twins.cpu.gbuffer());
    bench.render(&mut twins.gpu, &Inputs { surfaces: Surfaces::Kept, ..Inputs::default() });
    assert!(compare(&bench, &twins).is_err());
}

#[test]
fn refiners_ask_beams_and_rays_alike() {
    let Some(bench) = Bench::open() else { return };
    let stage = bundled("toys");
    let refiners = [
        RefinerConfig::Nichols(NicholsConfig::default()),
        RefinerConfig::SfvtGass(SfvtGassConfig::default()),
    ];
    for refiner in refiners {
        let image = |visibility| {
            let config = PipelineConfig { refiner, visibility, ..beams() };
            let mut gpu = bench.renderer(&stage.scene, &config).unwrap();
            bench.render(&mut gpu, &Inputs::default());
            bench.read::<[f32; 4]>(gpu.image())
        };
        let [expected, other] = [VisibilityConfig::Bvh, VisibilityConfig::Beam].map(image);
        let pixels = expected.iter().zip(&other).filter(|(a, b)| a != b).count();
        // The triangle test is the same; what rounding decides in the search for triangles changes single samples.
        assert!(pixels * 200 <= expected.len(), "{refiner:?}: {pixels}");
    }
}

#[test]
fn devices_that_bind_too_few_buffers_are_refused() {
    let Some(bench) = Bench::open() else { return };
    let bench = bench.limited(required_limits());
    let renderer = |config: &PipelineConfig| bench.renderer(&blocker_over_floor(), config);
    assert!(matches!(renderer(&beams()).unwrap_err(), GpuError::TooLarge { limit: 8, needed: 9, .. }));
    assert!(renderer(&full(64, 48, Shading::Ratio)).is_ok());
}

#[test]
fn backends_that_are_not_there_are_refused() {
    let Some(bench) = Bench::open() else { return };
    for visibility in [
        VisibilityConfig::Raster4d(Raster4dConfig::default()),
        VisibilityConfig::Voxel(VoxelConfig::default()),
    ] {
        let config = PipelineConfig { visibility, ..beams() };
        let refused = bench.renderer(&blocker_over_floor(), &config);
        assert!(matches!(refused.unwrap_err(), GpuError::Unsupported { .. }));
    }
}
