//! Parity of frames under textured lights.

use std::sync::Arc;

use halflight::config::{Named, PipelineConfig, RefinerConfig};
use halflight::glam::Vec3;
use halflight::hash;
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::light_texture::LightTexture;
use halflight::refine::{LatticeConfig, Quality};
use halflight::scene::Scene;
use halflight_gpu::Inputs;
use halflight_tests::Stage;

use crate::device::Bench;
use crate::scenes::{Twins, bundled, per_pixel};
use crate::whole::nmse2;

/// Colours that differ in every texel, some of them black.
pub(crate) fn picture(columns: u32, rows: u32, seed: u32) -> LightTexture {
    let channel =
        |at: u32, channel: u32| (hash::mix(hash::fold(hash::fold(seed, at), channel)) & 0xff) as f32 / 64.0;
    let texel = |at: u32| match at % 5 {
        0 => Vec3::ZERO,
        1 => Vec3::new(channel(at, 0), 0.0, 0.0),
        _ => Vec3::new(channel(at, 0), channel(at, 1), channel(at, 2)),
    };
    LightTexture::new(columns, rows, (0..columns * rows).map(texel).collect()).unwrap()
}

/// A screen beside the toys, so near that its texels differ in what they light, and a plain lamp after it.
fn toys(lights: Vec<AreaLight>) -> Stage {
    let light_textures = vec![Arc::new(picture(4, 3, 1)), Arc::new(picture(16, 9, 2))];
    Stage::new(Scene { lights, light_textures, ..Scene::clone(&bundled("few toys").scene) }).unwrap()
}

pub(crate) fn screen() -> AreaLight {
    let (corner, up) = (Vec3::new(-1.6, 0.1, -0.9), Vec3::new(0.2, 1.2, 0.0));
    AreaLight::parallelogram(corner, Vec3::Z * 1.8, up, Vec3::new(6.0, 5.0, 7.0)).two_sided()
}

fn lamp() -> AreaLight {
    bundled("few toys").scene.lights[0]
}

fn stages() -> Vec<(&'static str, Stage)> {
    let disk = AreaLight::disk(Vec3::new(-2.4, 2.6, 0.0), Vec3::new(0.3, -1.0, 0.1), 0.6, Vec3::splat(30.0));
    vec![
        ("screen", toys(vec![screen().textured(0)])),
        ("screen and lamp", toys(vec![screen().textured(1), lamp()])),
        ("disk and lamp", toys(vec![disk, lamp().textured(1)])),
    ]
}

/// Error of the GPU's image against the CPU's.
fn error(bench: &Bench, twins: &Twins) -> f64 {
    let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
    nmse2(&image, twins.cpu.image())
}

#[test]
fn frames_are_equal() {
    let Some(bench) = Bench::open() else { return };
    for (name, stage) in stages() {
        let config = per_pixel(96, 72, Shading::Ratio);
        let twins = Twins::of(&bench, stage, &config, true);
        let off = error(&bench, &twins);
        // Ellipses are polygons on the GPU. Receivers that see a sliver of the screen, but none of its samples, take the fraction of their
        // neighbours on the CPU, and none on the GPU: seven pixels.
        assert!(off < 1e-6, "{name}: {off:e}");
        assert!(twins.cpu.image().irradiance.iter().any(|light| light.x > 1.2 * light.y), "{name}");
    }
}

#[test]
fn every_refiner_interpolates_colours() {
    let Some(bench) = Bench::open() else { return };
    for refiner in RefinerConfig::NAMES {
        let refiner = RefinerConfig::named(refiner).unwrap();
        let config =
            PipelineConfig { refiner, upsampler: refiner.upsampler(), ..per_pixel(128, 96, Shading::Ratio) };
        let twins = Twins::of(&bench, toys(vec![lamp(), screen().textured(1)]), &config, true);
        let off = error(&bench, &twins);
        // As in `whole`: a ray that rounding decides differently may split a fragment.
        assert!(off < 1e-3, "{refiner:?}: {off:e}");
    }
}

#[test]
fn error_targets_and_qualities_are_reached() {
    let Some(bench) = Bench::open() else { return };
    let stage = toys(vec![screen().textured(1)]);
    let exact = PipelineConfig {
        sampling: halflight::frame::LightSampling { count: 1024, ..Default::default() },
        ..per_pixel(160, 120, Shading::Ratio)
    };
    let mut reference = exact.builder(&stage.prepared).build().unwrap();
    reference.render().unwrap();
    let target = 1e-3;
    let lattice = RefinerConfig::Lattice(LatticeConfig { target, ..LatticeConfig::default() });
    let quality = RefinerConfig::Lattice(Quality::Good.lattice());
    for (refiner, bound) in [(lattice, target), (quality, 3e-4)] {
        let config = PipelineConfig { refiner, upsampler: refiner.upsampler(), ..exact };
        let twins = Twins::of(&bench, stage.clone(), &config, true);
        let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let off = nmse2(&image, reference.image());
        let cpu: Vec<[f32; 4]> =
            twins.cpu.image().irradiance.iter().map(|light| light.extend(1.0).to_array()).collect();
        // Targets are of luminance, and colours err more; the device has no validation, and the CPU asks some receivers twice.
        let most = f64::from(bound).max(1.1 * nmse2(&cpu, reference.image()));
        assert!(off < most && most < 5.0 * f64::from(bound), "{refiner:?}: {off:e} {most:e}");
    }
}

#[test]
fn textures_come_change_and_go() {
    let Some(bench) = Bench::open() else { return };
    let config = per_pixel(64, 48, Shading::Ratio);
    let plain = toys(vec![lamp()]);
    let mut renderer = bench.renderer(&plain.scene, &config).unwrap();
    let textures = [1, 2].map(|seed| vec![Arc::new(picture(8, 8, seed))]);
    let mut show = |lights: &[AreaLight], textures: &[Arc<LightTexture>]| -> Vec<[f32; 4]> {
        renderer.set_textured_lights(lights, textures).unwrap();
        bench.render(&mut renderer, &Inputs::default());
        bench.read(renderer.image())
    };
    let fresh = |lights: &[AreaLight], textures: &[Arc<LightTexture>]| -> Vec<[f32; 4]> {
        let scene = Scene {
            lights: lights.to_vec(),
            light_textures: textures.to_vec(),
            ..Scene::clone(&plain.scene)
        };
        let mut renderer = bench.renderer(&scene, &config).unwrap();
        bench.render(&mut renderer, &Inputs::default());
        bench.read(renderer.image())
    };
    let before = show(&[lamp()], &[]);
    let lights = [screen().textured(0), lamp()];
    let first = show(&lights, &textures[0]);
    let second = show(&lights, &textures[1]);
    assert!(first == fresh(&lights, &textures[0]) && second == fresh(&lights, &textures[1]));
    assert!(first != second && first != before);
    assert!(show(&[lamp()], &[]) == before);
    let error = renderer.set_textured_lights(&[lamp().textured(3)], &textures[0]).unwrap_err();
    assert!(error.to_string().contains("texture"), "{error}");
}

#[test]
fn irradiance_is_sampled_by_texels() {
    let Some(bench) = Bench::open() else { return };
    for refiner in ["per-pixel", "sfvt-gass", "lattice"] {
        let refiner = RefinerConfig::named(refiner).unwrap();
        let config =
            PipelineConfig { refiner, upsampler: refiner.upsampler(), ..per_pixel(96, 72, Shading::Sampled) };
        let twins = Twins::of(&bench, toys(vec![lamp(), screen().textured(1)]), &config, true);
        let off = error(&bench, &twins);
        let bound = if refiner == RefinerConfig::PerPixel { 1e-6 } else { 1e-3 };
        assert!(off < bound, "{refiner:?}: {off:e}");
    }
    let config = per_pixel(96, 72, Shading::Sampled);
    let mut twins = Twins::of(&bench, toys(vec![screen().textured(1)]), &config, true);
    twins.alter(&bench, &config, ["textured/texel", "size.y - 1u - at.y", "at.y"]);
    assert!(error(&bench, &twins) > 1e-3);
}

#[test]
fn wrong_shaders_are_noticed() {
    let Some(bench) = Bench::open() else { return };
    let plain = per_pixel(96, 72, Shading::Ratio);
    let quality = RefinerConfig::Lattice(Quality::Good.lattice());
    let good = PipelineConfig { refiner: quality, upsampler: quality.upsampler(), ..plain };
    let of_plain = [
        ["textured/sums", "lit += light;", "lit += light.zyx;"],
        ["textured/sums", "emitted[strata + index]", "emitted[strata + index + 1u]"],
        ["textured/value", "channels[place]", "channels[place + 1u]"],
        ["textured/channel", "found[CHANNEL]", "found[0]"],
        ["textured/values", "2u * pixels", "pixels"],
        ["textured/seen", "cell_emission(grid, cell)", "cell_emission(grid, cell.yx)"],
    ];
    let of_good = [
        ["textured/strata", "(2u * number - 1u) / 6u", "(2u * number) / 6u"],
        ["textured/value", "channels[place]", "channels[place + 1u]"],
        ["textured/lattice_smooth", "fractions += pair;", "fractions += 2.0 * pair;"],
        ["textured/noise", "differ), squares, dot3", "differ), 100.0 * squares, dot3"],
    ];
    for (config, altered) in [(plain, &of_plain[..]), (good, &of_good)] {
        let mut twins = Twins::of(&bench, toys(vec![screen().textured(1)]), &config, true);
        let right_image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let right_off = error(&bench, &twins);
        for &[module, right, wrong] in altered {
            twins.alter(&bench, &config, [module, right, wrong]);
            let off = error(&bench, &twins);
            let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
            // Other noise changes the plan: the picture, but its error hardly.
            let noticed = off > 2.0 * right_off + 1e-6 || module == "textured/noise" && image != right_image;
            assert!(noticed, "{module}: {off:e} {right_off:e}");
        }
    }
}
