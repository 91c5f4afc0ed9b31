//! Parity of alpha masks: what solid texels hide, and what the camera sees of them.

use std::sync::Arc;

use halflight::alpha::AlphaMask;
use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::gbuffer::NO_PRIMITIVE;
use halflight::glam::{DVec3, Vec2, Vec3};
use halflight::irradiance::Shading;
use halflight::refine::{LatticeConfig, NicholsConfig, SfvtGassConfig};
use halflight::scene::{Material, Mesh, Scene};
use halflight::voxel::VoxelConfig;
use halflight_gpu::{Inputs, Surfaces, required_limits};
use halflight_tests::{Stage, blocker_over_floor};

use crate::device::Bench;
use crate::masks::compare;
use crate::rays::texel_clearance;
use crate::scenes::{Twins, bundled, per_pixel};
use crate::whole::nmse2;
use crate::{moving, voxels};

/// Exact backends.
const BACKENDS: [&str; 3] = ["bvh", "beam", "raster4d"];

fn with(backend: &str, width: u32, height: u32) -> PipelineConfig {
    let usual = per_pixel(width, height, Shading::Ratio);
    let visibility = VisibilityConfig::named(backend).unwrap();
    PipelineConfig { visibility, sampling: visibility.fit(usual.sampling), ..usual }
}

/// Side of [`sieve`]'s mask.
const SIDE: u32 = 6;

/// A blocker with holes: texels have an alpha of 127 and 128, on both sides of the cutoff, in no symmetrical order, and repeat.
fn sieve(alpha: impl Fn(u32) -> u8) -> Scene {
    let mut scene = blocker_over_floor();
    let mesh = Arc::make_mut(&mut scene.mesh);
    let texels = (0..(SIDE * SIDE) as usize).map(|texel| alpha(texel as u32));
    mesh.alpha_masks = vec![AlphaMask::new(SIDE, SIDE, texels, 0.5).unwrap()];
    let red = Material { albedo: Vec3::new(0.8, 0.2, 0.1), ..Material::default() };
    mesh.materials = vec![Material::default(), Material { alpha_mask: Some(0), ..red }];
    mesh.material_ids[2..].fill(1);
    for (uv, at) in mesh.uvs[4..].iter_mut().zip([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]) {
        *uv = Vec2::from(at) * 1.7 + Vec2::new(-3.21, 1000.13);
    }
    // The receivers below it are near, so that its holes are told apart.
    mesh.positions[4..].iter_mut().for_each(|p| *p = Vec3::new(p.x * 2.0, p.y * 0.25, p.z * 2.0));
    scene
}

fn holes(texel: u32) -> u8 {
    if [0, 1, 2, 4, 9, 14, 15, 21, 22, 23, 28, 35].contains(&texel) { 127 } else { 128 }
}

#[test]
fn samples_are_hidden_by_solid_texels_as_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    for backend in BACKENDS {
        let config = with(backend, 64, 48);
        let twins = Twins::render(&bench, "garden", &config, true);
        let (flips, rays) = compare(&bench, &twins).unwrap();
        // Threshold as for other scenes: few rays pass an edge or the border of a texel within rounding.
        assert!(rays > 50_000 && flips * 50_000 <= rays, "{backend}: {flips} of {rays}");
        let twins = Twins::of(&bench, Stage::new(sieve(holes)).unwrap(), &config, true);
        let (flips, rays) = compare(&bench, &twins).unwrap();
        assert!(rays > 50_000 && flips * 50_000 <= rays, "{backend}: {flips} of {rays}");
    }
}

#[test]
fn voxels_leave_masked_triangles_to_rays() {
    let Some(bench) = Bench::open() else { return };
    let config = VoxelConfig::default();
    let marching = PipelineConfig { visibility: VisibilityConfig::Voxel(config), ..with("bvh", 60, 45) };
    let mut twins = Twins::render(&bench, "garden", &marching, true);
    let [flips, strange, rays] = voxels::compare(&bench, &twins, config);
    // Threshold as for voxels without masks.
    assert!(rays > 50_000 && flips * 10_000 <= rays && strange == 0, "{flips} and {strange} of {rays}");
    twins.alter(&bench, &marching, ["visibility/solid_hits", "&& is_solid(triangle, origin, d)", ""]);
    let [flips, strange, _] = voxels::compare(&bench, &twins, config);
    assert!(flips * 100 > rays && strange > 0, "{flips} and {strange} of {rays}");
}

#[test]
fn refiners_know_of_masks() {
    let Some(bench) = Bench::open() else { return };
    let target = LatticeConfig { target: 1e-3, ..LatticeConfig::default() };
    let refiners = [
        RefinerConfig::Nichols(NicholsConfig::default()),
        RefinerConfig::SfvtGass(SfvtGassConfig::default()),
        RefinerConfig::Lattice(LatticeConfig::default()),
        RefinerConfig::Lattice(target),
    ];
    for refiner in refiners {
        for backend in ["bvh", "beam"] {
            let upsampler = match refiner {
                RefinerConfig::Lattice(_) => UpsamplerConfig::Lattice(Default::default()),
                _ => UpsamplerConfig::RbfRobust(Default::default()),
            };
            let config = PipelineConfig { refiner, upsampler, ..with(backend, 64, 48) };
            let twins = Twins::of(&bench, Stage::new(sieve(holes)).unwrap(), &config, true);
            let off = nmse2(&bench.read::<[f32; 4]>(twins.gpu.image()), twins.cpu.image());
            // A ray that rounding decides differently may split a cell, and an error target samples by other plans.
            let most = if refiner == RefinerConfig::Lattice(target) { 1e-4 } else { 1e-5 };
            assert!(off < most, "{refiner:?} {backend}: {off:e}");
        }
    }
}

/// Numbers of pixels that see another triangle than on the CPU, and of those among them that rounding of rasterization does not explain;
/// the pixels that see a triangle with a mask on the CPU.
fn compare_surfaces(bench: &Bench, twins: &Twins) -> [usize; 3] {
    let gbuffer = twins.cpu.gbuffer();
    let (mesh, eye) = (&twins.stage.scene.mesh, twins.stage.scene.camera.eye.as_dvec3());
    let normal: Vec<[u32; 4]> = bench.read(twins.gpu.normal());
    let [mut others, mut strange, mut seen] = [0; 3];
    let (width, height) = (gbuffer.width, gbuffer.height);
    let view = halflight::camera::View::new(&twins.stage.scene.camera, width, height);
    let is_masked = |triangle: u32| triangle != NO_PRIMITIVE && mesh.alpha_mask(triangle as usize).is_some();
    for (pixel, (found, &expected)) in normal.iter().zip(&gbuffer.primitive).enumerate() {
        seen += usize::from(is_masked(expected));
        if found[3] == expected {
            continue;
        }
        others += 1;
        let (x, y) = (pixel as u32 % width, pixel as u32 / width);
        let d = view.through(f64::from(x) + 0.5, f64::from(y) + 0.5).as_dvec3();
        // Rays through the centre pass an outline or a border of one of both triangles.
        let close =
            [found[3], expected].into_iter().filter(|&triangle| triangle != NO_PRIMITIVE).any(|triangle| {
                let corners = mesh.corners(triangle as usize).map(Vec3::as_dvec3);
                // Corners are rounded to 1/256 of a pixel, which at this distance has:
                let size = corners.iter().map(|corner| corner.distance(eye)).fold(0.0, f64::max)
                    * view.down.length();
                outline(corners, eye, d).min(texel_clearance(mesh, triangle as usize, eye, eye + d))
                    < size / 64.0
            });
        strange += usize::from(!close);
    }
    [others, strange, seen]
}

/// Least distance between a line and the lines of a triangle's edges, metres.
fn outline(corners: [DVec3; 3], eye: DVec3, d: DVec3) -> f64 {
    let [a, b, c] = corners;
    let distance = |(p, q): (DVec3, DVec3)| {
        let across = (q - p).cross(d);
        ((p - eye).dot(across) / across.length()).abs()
    };
    [(a, b), (b, c), (c, a)].map(distance).into_iter().fold(f64::INFINITY, f64::min)
}

#[test]
fn pixels_see_solid_texels_and_through_holes() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(160, 120, Shading::Ratio);
    for (name, stage) in [("garden", bundled("garden")), ("sieve", Stage::new(sieve(holes)).unwrap())] {
        let twins = Twins::of(&bench, stage, &config, false);
        let [others, strange, seen] = compare_surfaces(&bench, &twins);
        // Threshold as for other surfaces.
        assert!(others * 200 < 160 * 120 && seen > 500, "{name}: {others}, {seen} masked");
        assert_eq!(strange, 0, "{name}: of {others}");
        let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let off = nmse2(&image, twins.cpu.image());
        // Pixels on outlines and borders see their other side.
        assert!(off < 1e-3, "{name}: {off:e}");
    }
}

#[test]
fn masks_of_one_kind_of_texel_change_nothing() {
    let Some(bench) = Bench::open() else { return };
    for backend in ["bvh", "beam", "raster4d", "voxel"] {
        let config = with(backend, 64, 48);
        let image = |scene: &Scene| {
            let mut gpu = bench.renderer(scene, &config).unwrap();
            bench.render(&mut gpu, &Inputs::default());
            (bench.read::<[u32; 4]>(gpu.image()), bench.read::<[u32; 4]>(gpu.normal()))
        };
        let mut plain = sieve(|_| 255);
        Arc::make_mut(&mut plain.mesh).materials[1].alpha_mask = None;
        let mut bare = sieve(|_| 0);
        let mesh = Arc::make_mut(&mut bare.mesh);
        mesh.triangles.truncate(2);
        mesh.material_ids.truncate(2);
        let (plain, bare) = (image(&plain), image(&bare));
        // Voxels are approximate, but masked triangles are not theirs.
        assert!(backend == "voxel" || image(&sieve(|_| 255)) == plain, "{backend}");
        let found = image(&sieve(|_| 0));
        assert!(found.1 == bare.1 && (backend == "voxel" || found.0 == bare.0), "{backend}");
        assert!(plain != bare && image(&sieve(holes)) != plain && image(&sieve(holes)) != bare, "{backend}");
    }
}

#[test]
fn wrong_shaders_are_found() {
    let Some(bench) = Bench::open() else { return };
    let config = with("bvh", 64, 48);
    let mut twins = Twins::of(&bench, Stage::new(sieve(holes)).unwrap(), &config, true);
    let is_right = |twins: &Twins| compare(&bench, twins).is_ok_and(|(flips, rays)| flips * 10_000 <= rays);
    assert!(is_right(&twins));
    for altered in [
        // Images upside down or mirrored, another corner's weight, and texels of words in another order.
        ["shared/solid", "(own.size.y - 1u - place.y)", "place.y"],
        ["shared/solid", "own.size.x + place.x", "own.size.x + own.size.x - 1u - place.x"],
        ["shared/solid", "* weights.x + (own.c", "* weights.y + (own.c"],
        ["shared/solid", ">> (texel & 31u)", ">> (31u - (texel & 31u))"],
        // Masks that are not looked at, samples that are not taken out, and another sample's.
        ["visibility/solid_hits", "&& is_solid(triangle, origin, d)", ""],
        ["visibility/hide", "&= ~atomicLoad", "&= atomicLoad"],
        ["visibility/hide", "sample_place(ray.index, asked.key)", "sample_place(ray.index, asked.key + 1u)"],
        // The opaque triangles' BVH in the place of the others'.
        ["visibility/solid_hits", "traverse(masked.root,", "traverse(0u,"],
    ] {
        twins.alter(&bench, &config, altered);
        assert!(!is_right(&twins), "{altered:?}");
    }
    let mut twins = Twins::of(&bench, Stage::new(sieve(holes)).unwrap(), &config, false);
    assert_eq!(compare_surfaces(&bench, &twins)[1], 0);
    for altered in [
        ["gbuffer_masked", "if !is_solid", "if is_solid"],
        ["gbuffer_masked", "frame.down * at.y", "frame.down * (at.y + 1.0)"],
        ["shared/solid", "(own.size.y - 1u - place.y)", "place.y"],
    ] {
        twins.alter(&bench, &config, altered);
        assert!(compare_surfaces(&bench, &twins)[1] > 0, "{altered:?}");
    }
}

#[test]
fn meshes_of_masked_triangles_alone_and_odd_coordinates_are_rendered() {
    let Some(bench) = Bench::open() else { return };
    for backend in BACKENDS {
        let config = with(backend, 48, 36);
        let mut scene = sieve(holes);
        let mesh = Arc::make_mut(&mut scene.mesh);
        mesh.material_ids.fill(1);
        mesh.uvs[..4].copy_from_slice(&[Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|uv| uv * 2.3));
        let twins = Twins::of(&bench, Stage::new(scene.clone()).unwrap(), &config, true);
        let (flips, rays) = compare(&bench, &twins).unwrap();
        assert!(rays > 5_000 && flips * 5_000 <= rays, "{backend}: {flips} of {rays}");
        // Infinite coordinates take the first column and row.
        Arc::make_mut(&mut scene.mesh).uvs[4..].fill(Vec2::new(f32::INFINITY, f32::NAN));
        let twins = Twins::of(&bench, Stage::new(scene).unwrap(), &config, true);
        let (flips, rays) = compare(&bench, &twins).unwrap();
        assert!(flips * 5_000 <= rays, "{backend}: {flips} of {rays}");
    }
}

#[test]
fn masked_triangles_move() {
    let Some(bench) = Bench::open() else { return };
    for config in moving::configs() {
        let mut scene: Scene = Scene::clone(&bundled("garden").scene);
        let mut renderer = bench.renderer(&scene, &config).unwrap();
        let first = moving::image(&bench, &mut renderer);
        let still = scene.mesh.positions.clone();
        let mut mesh = Mesh::clone(&scene.mesh);
        mesh.positions.iter_mut().for_each(|p| *p = moving::moved(*p));
        scene.mesh = Arc::new(mesh);
        moving::update(&bench, &mut renderer, &scene.mesh.positions).unwrap();
        assert!(moving::check(&bench, &mut renderer, &scene, &config) != first);
        moving::update(&bench, &mut renderer, &still).unwrap();
        assert!(moving::image(&bench, &mut renderer) == first);
    }
}

#[test]
fn the_storage_buffers_of_webgpu_are_enough() {
    let Some(bench) = Bench::open() else { return };
    let bench = bench.limited(required_limits());
    let config = with("bvh", 64, 48);
    let mut twins = Twins::of(&bench, Stage::new(sieve(holes)).unwrap(), &config, true);
    assert!(compare(&bench, &twins).is_ok_and(|(flips, rays)| flips * 10_000 <= rays));
    bench.render(&mut twins.gpu, &Inputs { surfaces: Surfaces::Scene, ..Inputs::default() });
    let off = nmse2(&bench.read::<[f32; 4]>(twins.gpu.image()), twins.cpu.image());
    assert!(off < 1e-3, "{off:e}");
}
