//! Parity of frames under disks, ellipses and polygons, and refusal of alpha masks.

use std::sync::Arc;

use halflight::config::{Named, PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::light_texture::LightTexture;
use halflight::pattern::PatternKind;
use halflight::scene::Scene;
use halflight_tests::Stage;

use crate::device::Bench;
use crate::scenes::{Twins, bundled, per_pixel};
use crate::whole::nmse2;

/// Toys under one light of each shape.
fn toys(light: AreaLight) -> Stage {
    Stage::new(Scene { lights: vec![light], ..Scene::clone(&bundled("few toys").scene) }).unwrap()
}

fn shapes() -> [(&'static str, AreaLight); 4] {
    let (centre, radiance) = (Vec3::new(-2.4, 2.6, 0.0), Vec3::new(30.0, 29.0, 27.0));
    let hexagon: Vec<Vec3> = (0..6)
        .map(|k| (std::f32::consts::TAU * k as f32 / 6.0).sin_cos())
        .map(|(sine, cosine)| centre + Vec3::new(0.7 * cosine, 0.0, 0.5 * sine))
        .collect();
    [
        ("disk", AreaLight::disk(centre, Vec3::new(0.3, -1.0, 0.1), 0.6, radiance)),
        (
            "ellipse",
            AreaLight::ellipse(centre, Vec3::X * 0.9, Vec3::new(0.2, 0.1, 0.4), radiance).two_sided(),
        ),
        ("hexagon", AreaLight::polygon(&hexagon, radiance).unwrap()),
        // Across the horizon of the floor, which sees it from afar.
        ("upright disk", AreaLight::disk(Vec3::new(-3.0, 0.1, 0.0), Vec3::X, 0.4, radiance)),
    ]
}

#[test]
fn frames_under_every_shape_are_equal() {
    let Some(bench) = Bench::open() else { return };
    for (name, light) in shapes() {
        for shading in [Shading::Ratio, Shading::Sampled] {
            let config = per_pixel(96, 72, shading);
            let twins = Twins::of(&bench, toys(light), &config, true);
            let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
            let off = nmse2(&image, twins.cpu.image());
            // Ellipses are polygons of 64 corners on the GPU where they are not sampled; else as in plain frames, and samples on the rim may be
            // decided differently.
            assert!(off < 1e-6, "{name} {shading:?}: {off:e}");
            assert!(twins.cpu.image().irradiance.iter().any(|light| light.max_element() > 0.1), "{name}");
        }
    }
}

/// Sphere lights: beside the toys, low so that horizons cut it, half in the floor, and around everything.
fn spheres() -> [(&'static str, AreaLight); 4] {
    let radiance = Vec3::new(30.0, 29.0, 27.0);
    [
        ("above", AreaLight::sphere(Vec3::new(-2.4, 2.6, 0.0), 0.6, radiance)),
        ("low", AreaLight::sphere(Vec3::new(-1.6, 0.3, 0.8), 0.28, radiance)),
        ("in the floor", AreaLight::sphere(Vec3::new(-1.2, 0.1, 0.8), 0.4, radiance)),
        ("around", AreaLight::sphere(Vec3::ZERO, 500.0, radiance)),
    ]
}

#[test]
fn frames_under_spheres_are_equal() {
    let Some(bench) = Bench::open() else { return };
    for (name, light) in spheres() {
        for shading in [Shading::Ratio, Shading::Sampled] {
            let config = per_pixel(96, 72, shading);
            let twins = Twins::of(&bench, toys(light), &config, true);
            let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
            let off = nmse2(&image, twins.cpu.image());
            // Disks are computed in single precision, so that samples at edges may be decided differently. Near the sphere's surface the
            // distance to it has few digits.
            assert!(off < 2e-6, "{name} {shading:?}: {off:e}");
            assert!(twins.cpu.image().irradiance.iter().any(|light| light.max_element() > 0.1), "{name}");
        }
    }
}

#[test]
fn leaves_hide_spheres() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(96, 72, Shading::Ratio);
    let garden = bundled("garden").scene;
    let light = AreaLight::sphere(garden.lights[0].centre(), 0.7, Vec3::splat(20.0));
    let stage = Stage::new(Scene { lights: vec![light], ..Scene::clone(&garden) }).unwrap();
    let mut twins = Twins::of(&bench, stage, &config, true);
    let error = |twins: &Twins| nmse2(&bench.read::<[f32; 4]>(twins.gpu.image()), twins.cpu.image());
    let off = error(&twins);
    assert!(off < 1e-5, "{off:e}");
    let wrong = ["visibility/hide", "seen_point(seen_light(origin), place)", "light_point(place)"];
    twins.alter(&bench, &config, wrong);
    let off = error(&twins);
    assert!(off > 1e-4, "{off:e}");
}

#[test]
fn the_lattice_refines_alike_under_spheres() {
    let Some(bench) = Bench::open() else { return };
    let light = spheres()[1].1;
    let config = PipelineConfig { width: 96, height: 72, antialias: 1, ..PipelineConfig::default() };
    let refiner = RefinerConfig::named("lattice").unwrap();
    let config = PipelineConfig { refiner, upsampler: refiner.upsampler(), ..config };
    let twins = Twins::of(&bench, toys(light), &config, true);
    let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
    let off = nmse2(&image, twins.cpu.image());
    // A sample that is decided differently may split a cell, whose interpolated values are within the refiner's tolerance.
    assert!(off < 1e-4, "{off:e}");
}

#[test]
fn a_sphere_that_is_another_is_noticed() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(96, 72, Shading::Sampled);
    for (light, [module, right, wrong]) in [
        (0, ["shared/sphere", "let rim = radius", "let rim = 0.98 * radius"]),
        (0, ["shared/sphere", "unit * (radius * radius / far)", "unit * radius"]),
        // Toys see the half below the floor through it, but for what the sphere's surface is before.
        (2, ["visibility/ray", "let stop = before_sphere(receiver.origin, end);", "let stop = end;"]),
        (2, ["shared/sums", "if surrounded(receiver.origin)", "if false"]),
    ] {
        let mut twins = Twins::of(&bench, toys(spheres()[light].1), &config, true);
        twins.alter(&bench, &config, [module, right, wrong]);
        let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let off = nmse2(&image, twins.cpu.image());
        assert!(off > 4e-6, "{module}: {off:e}");
    }
}

#[test]
fn backends_that_share_a_plane_refuse_spheres() {
    let Some(bench) = Bench::open() else { return };
    let stage = toys(spheres()[0].1);
    for name in ["beam", "raster4d", "voxel"] {
        let visibility = VisibilityConfig::named(name).unwrap();
        let config = per_pixel(64, 48, Shading::Ratio);
        let sampling = visibility.fit(config.sampling);
        let error = bench.renderer(&stage.scene, &PipelineConfig { visibility, sampling, ..config });
        let error = error.map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("a sphere light") && error.contains("use bvh or auto"), "{name}: {error}");
    }
}

#[test]
fn every_backend_knows_the_rim() {
    let Some(bench) = Bench::open() else { return };
    for (name, light) in [shapes()[0], shapes()[2]] {
        for visibility in ["bvh", "beam", "raster4d"] {
            let config = PipelineConfig {
                visibility: VisibilityConfig::named(visibility).unwrap(),
                sampling: LightSampling {
                    count: 64,
                    kind: PatternKind::ShiftedRows,
                    ..LightSampling::default()
                },
                ..per_pixel(64, 48, Shading::Ratio)
            };
            let twins = Twins::of(&bench, toys(light), &config, true);
            let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
            let off = nmse2(&image, twins.cpu.image());
            assert!(off < 1e-6, "{name} {visibility}: {off:e}");
            assert!(twins.cpu.image().irradiance.iter().any(|light| light.max_element() > 0.1), "{name}");
        }
    }
}

#[test]
fn a_rim_that_is_not_looked_at_is_noticed() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(96, 72, Shading::Ratio);
    for [module, right, wrong] in [
        ["visibility/horizon", "!light_contains(place)", "false"],
        ["shared/unshadowed", "const ELLIPSE_SIZE: f32 = 1.00080377", "const ELLIPSE_SIZE: f32 = 1.01"],
    ] {
        let mut twins = Twins::of(&bench, toys(shapes()[0].1), &config, true);
        twins.alter(&bench, &config, [module, right, wrong]);
        let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let off = nmse2(&image, twins.cpu.image());
        assert!(off > 1e-5, "{module}: {off:e}");
    }
}

#[test]
fn pictures_of_one_colour_are_uniform_lights() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(64, 48, Shading::Sampled);
    let toys = bundled("few toys");
    let texture = Arc::new(LightTexture::new(2, 1, vec![Vec3::splat(0.5); 2]).unwrap());
    let lights = vec![toys.scene.lights[0].textured(0)];
    let scene = Scene { lights, light_textures: vec![texture], ..Scene::clone(&toys.scene) };
    let twins = Twins::of(&bench, Stage::new(scene).unwrap(), &config, true);
    let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
    assert!(nmse2(&image, twins.cpu.image()) < 1e-8);
}
