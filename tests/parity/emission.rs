//! Parity of lights that the camera sees.

use std::sync::Arc;

use halflight::config::PipelineConfig;
use halflight::glam::Vec3;
use halflight::image::picture;
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::light_texture::LightTexture;
use halflight::pipeline::Image;
use halflight::scene::{Camera, Scene};
use halflight_gpu::{Inputs, Renderer, Surfaces};
use halflight_tests::{Stage, blocker_over_floor};

use crate::device::Bench;
use crate::scenes::{Twins, per_pixel};

const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

fn config() -> PipelineConfig {
    per_pixel(WIDTH, HEIGHT, Shading::Ratio)
}

/// Lights of every shape before, behind and beside the blocker and before each other; two that show their backs, one of which emits there;
/// and one that is not visible.
fn lights() -> Vec<AreaLight> {
    let towards = Vec3::new(0.1, 0.5, 1.0);
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let pentagon: Vec<Vec3> = (0..5)
        .map(|k| (std::f32::consts::TAU * (k as f32 + 0.3) / 5.0).sin_cos())
        .map(|(sine, cosine)| at(-1.3 + 0.5 * cosine, 1.2 + 0.4 * sine, 0.4))
        .collect();
    let parallelogram =
        |corner, radiance| AreaLight::parallelogram(corner, at(0.8, 0.1, 0.0), at(0.2, 0.6, 0.0), radiance);
    vec![
        AreaLight::disk(at(0.3, 1.1, -0.2), towards, 0.6, at(5.0, 1.0, 1.0)).visible(),
        AreaLight::ellipse(at(1.4, 0.9, 0.2), at(0.7, 0.1, 0.0), at(-0.1, 0.4, 0.0), at(1.0, 5.0, 1.0))
            .visible(),
        AreaLight::polygon(&pentagon, at(1.0, 1.0, 5.0)).unwrap().visible(),
        parallelogram(at(0.9, 0.3, 1.0), at(4.0, 4.0, 1.0)).visible(),
        parallelogram(at(-2.0, 0.1, 0.9), at(9.0, 1.0, 9.0)).reversed().visible(),
        parallelogram(at(-0.6, 0.1, 1.4), at(1.0, 6.0, 6.0)).reversed().two_sided().visible(),
        parallelogram(at(-2.4, 1.6, 0.0), at(2.0, 2.0, 2.0)),
        AreaLight::sphere(at(-1.0, 0.3, 0.3), 0.3, at(3.0, 7.0, 2.0)).visible(),
    ]
}

fn lit(lights: Vec<AreaLight>) -> Scene {
    Scene { lights, ..blocker_over_floor() }
}

/// Numbers of pixels that see another light than on the CPU, and of those that are not beside a pixel that sees another light there.
fn compare(found: &Image, expected: &Image) -> [usize; 2] {
    assert_eq!(
        [found.emission.len(), found.radiance.len()],
        [expected.emission.len(), expected.radiance.len()]
    );
    let others: Vec<usize> = (0..expected.emission.len())
        .filter(|&pixel| found.emission[pixel] != expected.emission[pixel])
        .collect();
    let inside = |&&pixel: &&usize| {
        let (x, y) = (pixel as i64 % i64::from(WIDTH), pixel as i64 / i64::from(WIDTH));
        let around = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| (x + dx, y + dy));
        around.into_iter().all(|(x, y)| {
            let within = (0..i64::from(WIDTH)).contains(&x) && (0..i64::from(HEIGHT)).contains(&y);
            !within || expected.emission[(y * i64::from(WIDTH) + x) as usize] == expected.emission[pixel]
        })
    };
    [others.len(), others.iter().filter(inside).count()]
}

/// Mean over the pixels of the largest difference between channels.
fn off(found: &[Vec3], expected: &[Vec3]) -> f32 {
    let sum: f32 = found.iter().zip(expected).map(|(a, b)| (*a - *b).abs().max_element()).sum();
    sum / expected.len() as f32
}

/// Mean over the pixels of the largest channel.
fn mean(image: &[Vec3]) -> f32 {
    image.iter().map(|rgb| rgb.max_element()).sum::<f32>() / image.len() as f32
}

fn download(bench: &Bench, gpu: &Renderer) -> Image {
    bench.gpu.download(gpu).unwrap().0
}

#[test]
fn pixels_see_the_same_lights() {
    let Some(bench) = Bench::open() else { return };
    let stage = Stage::new(lit(lights())).unwrap();
    for kept in [true, false] {
        let mut twins = Twins::of(&bench, stage.clone(), &config(), kept);
        let ((found, gbuffer), expected) =
            (bench.gpu.download(&twins.gpu).unwrap(), twins.cpu.image().clone());
        let seen = |light: &AreaLight| expected.emission.iter().filter(|&&rgb| rgb == light.radiance).count();
        let counts: Vec<usize> = lights().iter().map(seen).collect();
        let all = [0, 1, 2, 3, 5].into_iter().all(|light| counts[light] > 100);
        assert!(all && counts[4] == 0 && counts[6] == 0, "{counts:?}");
        let [others, strange] = compare(&found, &expected);
        // The rims of six lights pass almost no pixel's centre within rounding; of surfaces, rasterization rounds outlines.
        assert!(others * 2000 <= expected.emission.len() && strange == 0, "{kept}: {others}, {strange}");
        // Irradiance of the pixels that see the same is that of the CPU: see `whole`. Albedos are those of rasterized surfaces.
        if !kept {
            let reflected = picture::radiance(&found.irradiance, &gbuffer.albedo);
            for (pixel, (radiance, reflected)) in found.radiance.iter().zip(reflected).enumerate() {
                let light = found.emission[pixel];
                let right = if light == Vec3::ZERO { reflected } else { light };
                assert!((*radiance - right).abs().max_element() <= 1e-6 * right.max_element(), "{pixel}");
            }
            assert!(off(&found.radiance, &expected.radiance) < 1e-3 * mean(&expected.radiance));
        }
        let wrong = [
            ["emission", "any(facing(frame.eye) != vec3(0.0))", "true"],
            ["emission", "< -slack", "< -slack - 0.2"],
            ["emission", "|| t < nearest", "|| t > nearest"],
            ["emission", "&& light_contains(place))", ")"],
            ["emission", "f32(at.x) + 0.5", "f32(at.x) - 0.5"],
            ["emission", "vec4(emission_at(place), t)", "vec4(emission_at(place).zyx, t)"],
        ];
        for altered in wrong.into_iter().filter(|_| kept) {
            twins.alter(&bench, &config(), altered);
            let [others, strange] = compare(&download(&bench, &twins.gpu), &expected);
            assert!(others * 2000 > expected.emission.len() || strange > 0, "{altered:?}: {others}");
        }
    }
}

#[test]
fn antialiased_rims_are_those_of_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let config = PipelineConfig { antialias: 8, ..per_pixel(96, 72, Shading::Ratio) };
    let mut twins = Twins::of(&bench, Stage::new(lit(lights()[..3].to_vec())).unwrap(), &config, false);
    let render = |twins: &mut Twins, count| {
        bench.gpu.render_antialiased(&mut twins.gpu, &Inputs::default(), count).unwrap().0
    };
    let (found, plain, expected) = (render(&mut twins, 8), render(&mut twins, 1), twins.cpu.image().clone());
    assert_eq!(found.emission.len(), expected.emission.len());
    // On the CPU a pixel without an edge of a surface is a plane at all sub-samples.
    let [smooth, jagged] = [&found, &plain].map(|image| off(&image.emission, &expected.emission));
    assert!(smooth * 10.0 < jagged && jagged > 1e-3, "{smooth} {jagged}");
    let [smooth, jagged] = [&found, &plain].map(|image| off(&image.radiance, &expected.radiance));
    assert!(smooth * 4.0 < jagged, "{smooth} {jagged}");
    assert!(!plain.radiance.is_empty());
}

#[test]
fn visible_lights_come_and_go() {
    let Some(bench) = Bench::open() else { return };
    let hidden: Vec<AreaLight> =
        lights().into_iter().map(|light| AreaLight { visible: false, ..light }).collect();
    let mut renderer = bench.renderer(&lit(hidden.clone()), &config()).unwrap();
    let render = |renderer: &mut Renderer| {
        bench.render(renderer, &Inputs::default());
        download(&bench, renderer)
    };
    let without = render(&mut renderer);
    assert!(renderer.emission().is_none() && without.emission.is_empty() && without.radiance.is_empty());
    let before = renderer.bytes_created();
    renderer.set_lights(&lights()).unwrap();
    assert_eq!(renderer.bytes_created() - before, u64::from(WIDTH * HEIGHT * 16));
    let with = render(&mut renderer);
    assert_eq!(with.irradiance, without.irradiance);
    let mut anew = bench.renderer(&lit(lights()), &config()).unwrap();
    let expected = render(&mut anew);
    assert!(with.emission == expected.emission && with.radiance == expected.radiance);
    renderer.set_lights(&hidden).unwrap();
    renderer.resize(80, 60).unwrap();
    let gone = render(&mut renderer);
    assert!(renderer.emission().is_none() && gone.emission.is_empty() && gone.radiance.is_empty());
}

#[test]
fn the_callers_surfaces_hide_lights() {
    let Some(bench) = Bench::open() else { return };
    // Nothing is seen at all, and then a wall before everything.
    let mut renderer = bench.renderer(&lit(lights()), &config()).unwrap();
    let camera = blocker_over_floor().camera;
    let forward = (camera.target - camera.eye).normalize();
    let [x, y, z] = (-forward).to_array().map(f32::to_bits);
    for (depth, triangle, seen) in [(-1.0f32, u32::MAX, true), (0.5, 0, false)] {
        let pixels = (WIDTH * HEIGHT) as usize;
        // Any point of the wall stands for its plane.
        let position = vec![(camera.eye + 0.5 * forward).extend(depth).to_array(); pixels];
        let normal = vec![[x, y, z, triangle]; pixels];
        bench.gpu.queue.write_buffer(renderer.position(), 0, bytemuck::cast_slice(&position));
        bench.gpu.queue.write_buffer(renderer.normal(), 0, bytemuck::cast_slice(&normal));
        bench.render(&mut renderer, &Inputs { surfaces: Surfaces::Kept, ..Inputs::default() });
        let found = download(&bench, &renderer);
        assert_eq!(found.emission.iter().any(|&light| light != Vec3::ZERO), seen, "{depth}");
    }
}

#[test]
fn textures_are_seen() {
    let Some(bench) = Bench::open() else { return };
    let texels = (0..12).map(|at| Vec3::new(at as f32, (at * 5 % 12) as f32, 1.0)).collect();
    let texture = Arc::new(LightTexture::new(4, 3, texels).unwrap());
    let [plain, reversed] = [lights()[3], lights()[5]];
    let scene = Scene {
        light_textures: vec![texture],
        ..lit(vec![reversed.textured(0), plain.textured(0).reversed().two_sided(), lights()[0]])
    };
    let mut twins = Twins::of(&bench, Stage::new(scene).unwrap(), &config(), true);
    let expected = twins.cpu.image().clone();
    let [others, strange] = compare(&download(&bench, &twins.gpu), &expected);
    // Edges between texels lie inside the light.
    assert!(others * 1000 <= (WIDTH * HEIGHT) as usize, "{others}, {strange}");
    let mut colours: Vec<[u32; 3]> =
        expected.emission.iter().map(|light| light.to_array().map(f32::to_bits)).collect();
    colours.sort_unstable();
    colours.dedup();
    assert!(colours.len() > 12, "{}", colours.len());
    twins.alter(&bench, &config(), ["textured/texel", "size.y - 1u - at.y", "at.y"]);
    let [others, _] = compare(&download(&bench, &twins.gpu), &expected);
    assert!(others > 300, "{others}");
}

#[test]
fn lights_are_seen_from_any_camera() {
    let Some(bench) = Bench::open() else { return };
    for (eye, target) in [
        (Vec3::new(-3.0, 0.7, -2.0), Vec3::new(0.3, 1.0, 0.3)),
        (Vec3::new(0.4, 2.9, 0.6), Vec3::new(0.2, 0.4, 0.0)),
        // In the plane of a light, and before it by a millimetre.
        (Vec3::new(4.0, 1.0, 0.4), Vec3::new(0.0, 1.0, 0.4)),
        (Vec3::new(-1.3, 1.2, 0.401), Vec3::new(-1.3, 1.1, 0.0)),
    ] {
        let camera = Camera { eye, target, ..blocker_over_floor().camera };
        let twins =
            Twins::of(&bench, Stage::new(Scene { camera, ..lit(lights()) }).unwrap(), &config(), true);
        let [others, strange] = compare(&download(&bench, &twins.gpu), twins.cpu.image());
        assert!(others * 2000 <= (WIDTH * HEIGHT) as usize && strange == 0, "{eye}: {others}, {strange}");
    }
}
