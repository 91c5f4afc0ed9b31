//! Parity of specular reflection.

use std::sync::Arc;

use halflight::config::{Named, PipelineConfig, RefinerConfig};
use halflight::gbuffer::NO_PRIMITIVE;
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::pipeline::Image;
use halflight::refine::Quality;
use halflight::scene::{Scene, Specular};
use halflight_tests::Stage;

use crate::device::Bench;
use crate::scenes::{Twins, bundled, per_pixel};
use crate::textured::{picture, screen};
use crate::whole::nmse2;

/// Toys of metals and coated materials, smooth and rough, under these lights.
fn toys(lights: Vec<AreaLight>) -> Stage {
    let mut scene = Scene { lights, ..Scene::clone(&bundled("few toys").scene) };
    for (number, material) in Arc::make_mut(&mut scene.mesh).materials.iter_mut().enumerate() {
        let roughness = [0.3, 0.15, 0.6, 1.0][number % 4];
        let metallic = if number % 3 == 1 { 1.0 } else { 0.25 * (number % 2) as f32 };
        material.specular = Some(Specular { roughness, metallic, ..Specular::default() });
    }
    Stage::new(scene).unwrap()
}

fn lights() -> Vec<(&'static str, Vec<AreaLight>)> {
    let lamp = bundled("few toys").scene.lights[0];
    let centre = Vec3::new(0.4, 0.9, -1.2);
    let corners =
        [0.0f32, 1.3, 2.4, 3.9, 5.2].map(|turn| centre + 0.8 * Vec3::new(turn.cos(), turn.sin(), 0.0));
    let pentagon = AreaLight::polygon(&corners, Vec3::splat(9.0)).unwrap();
    // Across the horizon of the floor.
    let disk = AreaLight::disk(Vec3::new(-2.0, 0.2, 0.3), Vec3::X, 0.5, Vec3::new(20.0, 18.0, 12.0));
    let sphere = AreaLight::sphere(Vec3::new(-1.4, 0.5, 0.9), 0.3, Vec3::splat(20.0));
    vec![
        ("lamp", vec![lamp]),
        ("sphere", vec![sphere]),
        ("pentagon", vec![pentagon.two_sided()]),
        ("disk and lamp", vec![disk, lamp]),
    ]
}

fn specular(bench: &Bench, twins: &Twins) -> Vec<[f32; 4]> {
    bench.read(twins.gpu.specular().unwrap())
}

/// Error of the GPU's specular radiance against the CPU's.
fn error(bench: &Bench, twins: &Twins) -> f64 {
    let reference = Image { irradiance: twins.cpu.image().specular.clone(), ..Image::default() };
    nmse2(&specular(bench, twins), &reference)
}

#[test]
fn frames_are_equal() {
    let Some(bench) = Bench::open() else { return };
    for (name, lights) in lights() {
        for shading in [Shading::Ratio, Shading::Sampled] {
            let twins = Twins::of(&bench, toys(lights.clone()), &per_pixel(96, 72, shading), true);
            let off = error(&bench, &twins);
            // Rays and lobes are the same; the middle of a narrow lobe and the number of triangles beside it depend on rounding.
            assert!(off < 1e-5, "{name} {shading:?}: {off:e}");
            assert!(twins.cpu.image().specular.iter().any(|light| light.max_element() > 0.1), "{name}");
        }
    }
}

/// Glossy toys before a screen of 149 × 83 texels, which no level of their means divides, and a plain lamp.
fn toys_and_screen() -> Stage {
    let lights = vec![screen().textured(0), bundled("few toys").scene.lights[0]];
    let scene = toys(lights).prepared.scene().clone();
    Stage::new(Scene { light_textures: vec![Arc::new(picture(149, 83, 5))], ..scene }).unwrap()
}

#[test]
fn screens_are_reflected_in_their_colours() {
    let Some(bench) = Bench::open() else { return };
    let stage = toys_and_screen();
    for shading in [Shading::Ratio, Shading::Sampled] {
        let twins = Twins::of(&bench, stage.clone(), &per_pixel(96, 72, shading), true);
        let off = error(&bench, &twins);
        assert!(off < 1e-6, "{shading:?}: {off:e}");
        assert!(twins.cpu.image().specular.iter().any(|light| light.x > 1.5 * light.y), "{shading:?}");
    }
    for refiner in RefinerConfig::NAMES {
        let refiner = RefinerConfig::named(refiner).unwrap();
        let config =
            PipelineConfig { refiner, upsampler: refiner.upsampler(), ..per_pixel(96, 72, Shading::Ratio) };
        let twins = Twins::of(&bench, stage.clone(), &config, true);
        let off = error(&bench, &twins);
        assert!(off < 1e-4, "{refiner:?}: {off:e}");
    }
    let quality = RefinerConfig::Lattice(Quality::Good.lattice());
    let config = PipelineConfig {
        refiner: quality,
        upsampler: quality.upsampler(),
        ..per_pixel(96, 72, Shading::Ratio)
    };
    let twins = Twins::of(&bench, stage, &config, true);
    let off = error(&bench, &twins);
    // The numbers of light samples differ, and with them those of rays.
    assert!(off < 1e-3, "good: {off:e}");
}

#[test]
fn a_texture_that_comes_later_is_reflected() {
    let Some(bench) = Bench::open() else { return };
    let stage = toys_and_screen();
    let config = per_pixel(96, 72, Shading::Ratio);
    let plain = toys(vec![bundled("few toys").scene.lights[0]]);
    let mut twins = Twins::of(&bench, plain, &config, true);
    let scene = stage.prepared.scene();
    twins.gpu.set_textured_lights(&scene.lights, &scene.light_textures).unwrap();
    twins.render_gpu(&bench);
    let found = specular(&bench, &twins);
    let new = specular(&bench, &Twins::of(&bench, stage, &config, true));
    assert!(found.iter().zip(&new).all(|(found, new)| found.map(f32::to_bits) == new.map(f32::to_bits)));
}

#[test]
fn wrong_shaders_of_screens_are_noticed() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(64, 48, Shading::Ratio);
    let mut twins = Twins::of(&bench, toys_and_screen(), &config, true);
    for [module, right, wrong] in [
        ["textured/lobe_light", "select(uv, uv.yx, frame.texture_size.z == 1u)", "uv.yx"],
        ["textured/lobe_light", "bitcast<u32>(emitted[first + level].w) - NORMAL_BITS", "0u"],
        ["textured/lobe_light", "(size + (1u << level) - 1u)", "size"],
        ["textured/lobe_light", "1.0 - end.y", "begin.y"],
        ["textured/known_value", "place + select", "1u + place + select"],
        ["specular/reflect", "factors_at(uv) * (", "vec3(1.0) * ("],
        ["specular/cells", "cell.a + ab * x + ac * y, sqrt(weight)", "cell.a, sqrt(weight)"],
    ] {
        twins.alter(&bench, &config, [module, right, wrong]);
        let off = error(&bench, &twins);
        assert!(off > 2e-5, "{module} {right}: {off:e}");
    }
}

#[test]
fn surfaces_are_equal() {
    let Some(bench) = Bench::open() else { return };
    let twins = Twins::of(&bench, toys(lights()[0].1.clone()), &per_pixel(96, 72, Shading::Ratio), false);
    let (image, gbuffer) = bench.gpu.download(&twins.gpu).unwrap();
    let expected = twins.cpu.gbuffer();
    let mut compared = 0;
    for pixel in 0..expected.pixels() {
        let primitive = expected.primitive[pixel];
        if primitive == NO_PRIMITIVE || primitive != gbuffer.primitive[pixel] {
            continue;
        }
        compared += 1;
        let (found, right) = (gbuffer.specular[pixel], expected.specular[pixel]);
        assert!(found.f0.abs_diff_eq(right.f0, 1e-5) && found.roughness == right.roughness, "{pixel}");
        assert!(gbuffer.albedo[pixel].abs_diff_eq(expected.albedo[pixel], 1e-5), "{pixel}");
    }
    assert!(compared > 5000, "{compared}");
    let off = error(&bench, &twins);
    // Pixels on outlines see their other side.
    assert!(off < 5e-3, "{off:e}");
    let diffuse = image.irradiance[3000] * gbuffer.albedo[3000] * std::f32::consts::FRAC_1_PI;
    assert!(image.radiance[3000].abs_diff_eq(diffuse + image.specular[3000], 1e-6));
}

#[test]
fn every_refiner_tells_what_it_knows() {
    let Some(bench) = Bench::open() else { return };
    for refiner in RefinerConfig::NAMES {
        let refiner = RefinerConfig::named(refiner).unwrap();
        let config =
            PipelineConfig { refiner, upsampler: refiner.upsampler(), ..per_pixel(96, 72, Shading::Ratio) };
        let mut twins = Twins::of(&bench, toys(lights()[3].1.clone()), &config, true);
        let off = error(&bench, &twins);
        // A ray that rounding decides differently may split a fragment, whose lobes are then traced.
        assert!(off < 1e-4, "{refiner:?}: {off:e}");
        let rays = bench.render(&mut twins.gpu, &Default::default()).frame.rays.specular;
        let most = 2 * 96 * 72 * 64;
        assert!(rays > 0 && rays < most * 3 / 4, "{refiner:?}: {rays} of {most}");
    }
}

#[test]
fn holes_of_leaves_let_light_through() {
    let Some(bench) = Bench::open() else { return };
    let mut scene = Scene::clone(&bundled("garden").scene);
    for material in &mut Arc::make_mut(&mut scene.mesh).materials {
        material.specular = Some(Specular { roughness: 0.4, ..Specular::default() });
    }
    let config = per_pixel(96, 72, Shading::Ratio);
    let mut twins = Twins::of(&bench, Stage::new(scene).unwrap(), &config, true);
    let off = error(&bench, &twins);
    assert!(off < 1e-4, "{off:e}");
    let wrong = ["specular/masked_rays", " || traverse(masked.root, origin, end)", ""];
    twins.alter(&bench, &config, wrong);
    let off = error(&bench, &twins);
    assert!(off > 1e-2, "{off:e}");
}

#[test]
fn lights_are_seen_before_glossy_surfaces() {
    let Some(bench) = Bench::open() else { return };
    let mut lamp = bundled("few toys").scene.lights[0];
    lamp.visible = true;
    let mirror = AreaLight { two_sided: true, ..lamp }.moved(Vec3::new(2.0, -1.8, 0.5));
    let twins = Twins::of(&bench, toys(vec![mirror]), &per_pixel(96, 72, Shading::Ratio), true);
    let (image, _) = bench.gpu.download(&twins.gpu).unwrap();
    let expected = twins.cpu.image();
    let seen = expected.emission.iter().filter(|light| **light != Vec3::ZERO).count();
    assert!(seen > 50 && seen < 96 * 72, "{seen}");
    let radiance: Vec<[f32; 4]> = image.radiance.iter().map(|light| light.extend(1.0).to_array()).collect();
    let reference = Image { irradiance: expected.radiance.clone(), ..Image::default() };
    let off = nmse2(&radiance, &reference);
    assert!(off < 1e-4, "{off:e}");
}

#[test]
fn matte_scenes_have_no_specular_light() {
    let Some(bench) = Bench::open() else { return };
    let twins = Twins::render(&bench, "few toys", &per_pixel(32, 24, Shading::Ratio), true);
    assert!(twins.gpu.specular().is_none() && twins.gpu.gloss().is_none());
    let (image, _) = bench.gpu.download(&twins.gpu).unwrap();
    assert!(image.specular.is_empty() && image.radiance.is_empty());
}

#[test]
fn wrong_shaders_are_noticed() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(64, 48, Shading::Ratio);
    let mut twins = Twins::of(&bench, toys(lights()[3].1.clone()), &config, true);
    for [module, right, wrong] in [
        ["specular/lobe", "let fourth = (left * left) * (left * left);", "let fourth = left * left;"],
        ["specular/lobe", "max(roughness * roughness, LEAST_ALPHA)", "max(roughness, LEAST_ALPHA)"],
        ["specular/cells", "BY_ANGLE: f32 = 1.5", "BY_ANGLE: f32 = 30.0"],
        ["specular/cells", "if here > 0.0 {", "if true {"],
        ["specular/cells", "const NARROW_ELLIPSE: u32 = 32u", "const NARROW_ELLIPSE: u32 = 5u"],
        ["specular/reflect", "seen += weight;", "seen += 0.9 * weight;"],
        ["specular/reflect", "!is_lobe_hidden(origin, uv)", "true"],
        ["specular/reflect", "(sum.all - sum.grazing) + sum.grazing", "sum.all"],
        ["specular/known_value", "samples[place].value", "1.0"],
    ] {
        twins.alter(&bench, &config, [module, right, wrong]);
        let off = error(&bench, &twins);
        assert!(off > 2e-5, "{module} {right}: {off:e}");
    }
    let mut twins = Twins::of(&bench, toys(lights()[0].1.clone()), &config, false);
    twins.alter(&bench, &config, ["specular/resolve", "base * (1.0 - metallic)", "base"]);
    let albedo: Vec<[f32; 4]> = bench.read(twins.gpu.albedo());
    let expected = &twins.cpu.gbuffer().albedo;
    let others = albedo.iter().zip(expected).filter(|(found, right)| (found[0] - right.x).abs() > 0.05);
    assert!(others.count() > 100);
}
