//! Textured lights against uniform lights: of one colour, of one lit texel, and piece by piece.

use std::sync::Arc;

use halflight::config::{PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::light::{AreaLight, LightFrame, Parallelogram, Shape};
use halflight::light_texture::LightTexture;
use halflight::pipeline::Image;
use halflight::refine::Quality;
use halflight::scene::Scene;
use halflight_tests::{Stage, nmse2};

/// The scene `contact` under textured lights.
fn contact(lights: Vec<AreaLight>, textures: Vec<LightTexture>) -> Stage {
    let plain = Stage::bundled("contact").unwrap();
    let light_textures = textures.into_iter().map(Arc::new).collect();
    Stage::new(Scene { lights, light_textures, ..Scene::clone(&plain.scene) }).unwrap()
}

fn lamp() -> AreaLight {
    Stage::bundled("contact").unwrap().scene.lights[0]
}

/// Cell of a lamp: column `x` from `edge_u`'s start, row `y` from `edge_v`'s start, of `columns` × `rows`.
fn cell(lamp: &AreaLight, [x, y]: [u32; 2], [columns, rows]: [u32; 2], factor: Vec3) -> AreaLight {
    let LightFrame { origin, u, v } = lamp.frame();
    let (edge_u, edge_v) = (u / columns as f32, v / rows as f32);
    let corner = origin + edge_u * x as f32 + edge_v * y as f32;
    let shape = Shape::Parallelogram(Parallelogram { corner, edge_u, edge_v });
    AreaLight { shape, radiance: lamp.radiance * factor, ..*lamp }
}

/// Four columns and two rows, from the top left.
fn texture() -> LightTexture {
    let rgb = |r: f32, g: f32, b: f32| Vec3::new(r, g, b);
    let top = [rgb(4.0, 0.0, 0.0), rgb(0.0, 0.0, 0.0), rgb(0.2, 0.3, 0.1), rgb(0.0, 2.0, 0.0)];
    let bottom = [rgb(0.0, 0.0, 3.0), rgb(0.5, 0.5, 0.5), rgb(0.0, 0.0, 0.0), rgb(1.0, 1.0, 0.0)];
    LightTexture::new(4, 2, [top, bottom].concat()).unwrap()
}

/// The lamp with the texture as eight uniform lights.
fn pieces() -> Vec<AreaLight> {
    let (lamp, texture) = (lamp(), texture());
    let texels = texture.texels().iter().enumerate();
    texels.map(|(at, &texel)| cell(&lamp, [at as u32 % 4, 1 - at as u32 / 4], [4, 2], texel)).collect()
}

fn render(stage: &Stage, refiner: RefinerConfig, shading: Shading, samples: u32) -> Image {
    let config = PipelineConfig {
        width: 96,
        height: 72,
        refiner,
        shading,
        visibility: VisibilityConfig::Auto,
        sampling: LightSampling { count: samples, ..LightSampling::default() },
        ..PipelineConfig::default()
    };
    stage.render(&config).unwrap()
}

#[test]
fn a_picture_of_one_colour_is_a_uniform_light_bit_for_bit() {
    let factor = Vec3::new(1.0, 0.5, 0.25);
    let texture = LightTexture::new(3, 2, vec![factor; 6]).unwrap();
    let (with, without) = (
        contact(vec![lamp().textured(0)], vec![texture]),
        contact(vec![AreaLight { radiance: lamp().radiance * factor, ..lamp() }], vec![]),
    );
    for refiner in [RefinerConfig::PerPixel, RefinerConfig::Lattice(Quality::Good.lattice())] {
        let [a, b] = [&with, &without].map(|stage| render(stage, refiner, Shading::Ratio, 64));
        assert_eq!(a.irradiance, b.irradiance);
    }
}

#[test]
fn a_lit_texel_is_a_small_light() {
    for (at, place) in [(0, [0, 2]), (5, [2, 1]), (7, [1, 0])] {
        let mut texels = vec![Vec3::ZERO; 9];
        texels[at] = Vec3::new(1.0, 2.0, 3.0);
        let texture = LightTexture::new(3, 3, texels).unwrap();
        let stage = contact(vec![lamp().textured(0)], vec![texture]);
        let small = contact(vec![cell(&lamp(), place, [3, 3], Vec3::new(1.0, 2.0, 3.0))], vec![]);
        let expected = render(&small, RefinerConfig::PerPixel, Shading::Ratio, 1024);
        // 576 samples are 8 × 8 in every texel.
        for shading in [Shading::Ratio, Shading::Sampled] {
            let found = nmse2(&render(&stage, RefinerConfig::PerPixel, shading, 576), &expected);
            assert!(found < 4e-4, "texel {at} {shading:?}: {found:e}");
        }
        // Another texel is another texture.
        let other = contact(vec![cell(&lamp(), [1, 1], [3, 3], Vec3::new(1.0, 2.0, 3.0))], vec![]);
        assert!(nmse2(&render(&other, RefinerConfig::PerPixel, Shading::Ratio, 64), &expected) > 1e-2);
    }
}

#[test]
fn a_picture_is_the_sum_of_its_texels() {
    let whole = contact(vec![lamp().textured(0)], vec![texture()]);
    let parts = contact(pieces(), vec![]);
    let expected = render(&parts, RefinerConfig::PerPixel, Shading::Ratio, 1024);
    for (refiner, shading, samples, most) in [
        (RefinerConfig::PerPixel, Shading::Ratio, 4096, 2e-6),
        (RefinerConfig::PerPixel, Shading::Sampled, 4096, 4e-5),
        (RefinerConfig::PerPixel, Shading::Ratio, 64, 1e-3),
        (RefinerConfig::Lattice(Quality::Good.lattice()), Shading::Ratio, 64, 1e-4),
        (RefinerConfig::Lattice(Quality::Final.lattice()), Shading::Ratio, 64, 1e-5),
    ] {
        let found = nmse2(&render(&whole, refiner, shading, samples), &expected);
        assert!(found < most, "{refiner:?} {shading:?} {samples}: {found:e}");
    }
}

#[test]
fn antialiased_pixels_see_the_picture() {
    let config = |antialias| PipelineConfig { width: 96, height: 72, antialias, ..PipelineConfig::default() };
    let whole = contact(vec![lamp().textured(0)], vec![texture()]);
    let parts = contact(pieces(), vec![]);
    let [a, b] = [&whole, &parts].map(|stage| stage.render(&config(8)).unwrap().radiance.clone());
    let square = |v: Vec3| f64::from(v.length_squared());
    let error: f64 = a.iter().zip(&b).map(|(a, b)| square(*a - *b)).sum();
    let all: f64 = b.iter().map(|b| square(*b)).sum();
    assert!(!a.is_empty() && error < 3e-4 * all, "{}", error / all);
}

#[test]
fn the_back_of_a_two_sided_picture_shows_every_texel_where_it_is() {
    // From below and from above, with the lamp between two floors: the scene with the lamp turned over, whose texture is transposed.
    let lamp = lamp().two_sided();
    let whole = contact(vec![lamp.reversed()], vec![]);
    assert_eq!(whole.scene.lights[0].texture, None);
    let textured = contact(vec![lamp.textured(0).reversed()], vec![texture()]);
    let expected = contact(vec![lamp.textured(0)], vec![texture()]);
    let [a, b] =
        [&textured, &expected].map(|stage| render(stage, RefinerConfig::PerPixel, Shading::Ratio, 4096));
    let error = nmse2(&a, &b);
    assert!(error > 0.0 && error < 4e-6, "{error:e}");
}

#[test]
fn every_refiner_and_backend_renders_pictures() {
    let whole = contact(vec![lamp().textured(0)], vec![texture()]);
    let expected = render(&contact(pieces(), vec![]), RefinerConfig::PerPixel, Shading::Ratio, 1024);
    for refiner in ["nichols", "sfvt-gass", "per-pixel", "lattice"] {
        let refiner = <RefinerConfig as halflight::config::Named>::named(refiner).unwrap();
        let error = nmse2(&render(&whole, refiner, Shading::Ratio, 64), &expected);
        assert!(error < 2e-2, "{refiner:?}: {error:e}");
    }
    for visibility in ["bvh", "beam", "raster4d"] {
        let config = PipelineConfig {
            width: 96,
            height: 72,
            refiner: RefinerConfig::PerPixel,
            visibility: <VisibilityConfig as halflight::config::Named>::named(visibility).unwrap(),
            sampling: LightSampling {
                count: 1024,
                kind: halflight::pattern::PatternKind::ShiftedRows,
                ..LightSampling::default()
            },
            ..PipelineConfig::default()
        };
        let error = nmse2(&whole.render(&config).unwrap(), &expected);
        assert!(error < 1e-4, "{visibility}: {error:e}");
    }
}
