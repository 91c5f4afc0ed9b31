//! Specular reflection against an independent integration in double precision, with shadows.

use std::sync::Arc;

use halflight::config::{PipelineConfig, RefinerConfig};
use halflight::frame::LightSampling;
use halflight::glam::{DVec3, Vec2, Vec3};
use halflight::light::{AreaLight, LightFrame};
use halflight::light_texture::LightTexture;
use halflight::pipeline::{Image, Pipeline};
use halflight::scene::{Camera, Material, Mesh, Scene, Specular};
use halflight_tests::{Stage, blocker_over_floor, hides, quads};

const WIDTH: u32 = 44;
const HEIGHT: u32 = 33;

/// The blocker over a floor that reflects specularly, under `lights`.
fn stage(specular: Specular, lights: Vec<AreaLight>, textures: Vec<LightTexture>) -> Stage {
    let scene = blocker_over_floor();
    let materials = vec![Material { specular: Some(specular), ..Material::default() }];
    let mesh = Mesh { materials, ..Mesh::clone(&scene.mesh) };
    let light_textures = textures.into_iter().map(Arc::new).collect();
    Stage::new(Scene { mesh: Arc::new(mesh), lights, light_textures, ..scene }).unwrap()
}

/// A light behind the blocker that faces the viewer, so that the floor mirrors it.
fn screen() -> AreaLight {
    AreaLight::parallelogram(
        Vec3::new(-1.5, 0.4, -4.0),
        Vec3::X * 3.0,
        Vec3::Y * 2.0,
        Vec3::new(3.0, 2.0, 1.0),
    )
}

fn pipeline(stage: &Stage, refiner: RefinerConfig, count: u32) -> Pipeline {
    let config = PipelineConfig {
        width: WIDTH,
        height: HEIGHT,
        refiner,
        antialias: 1,
        sampling: LightSampling { count, ..LightSampling::default() },
        ..PipelineConfig::default()
    };
    config.builder(&stage.prepared).build().unwrap()
}

/// Specular radiance of a pixel by the midpoint rule over `side` · `side` points of every light.
fn integrated(scene: &Scene, origin: Vec3, normal: Vec3, specular: &Specular, side: usize) -> DVec3 {
    let (from, normal) = (origin.as_dvec3(), normal.as_dvec3());
    let view = (scene.camera.eye.as_dvec3() - from).normalize();
    let alpha = f64::from(specular.roughness).powi(2);
    let albedo = Material::default().albedo;
    let f0 = specular.reflectance.lerp(albedo, specular.metallic).as_dvec3();
    let mut radiance = DVec3::ZERO;
    for light in &scene.lights {
        // Of a sphere, the disk that covers it.
        let light = light.seen_from(origin);
        let LightFrame { origin: corner, u, v } = light.frame();
        let (corner, u, v) = (corner.as_dvec3(), u.as_dvec3(), v.as_dvec3());
        let area = u.cross(v);
        for index in 0..side * side {
            let at = |place: usize| (place as f64 + 0.5) / side as f64;
            let (x, y) = (at(index % side), at(index / side));
            let uv = Vec2::new(x as f32, y as f32);
            let point = corner + u * x + v * y;
            let to = point - from;
            let direction = to.normalize();
            let (incidence, cosine) = (normal.dot(direction), normal.dot(view));
            let solid = -direction.dot(area) / to.length_squared();
            if incidence <= 0.0
                || solid <= 0.0
                || !light.extent().contains(uv)
                || hides(&scene.mesh, from, point)
            {
                continue;
            }
            let half = (view + direction).normalize();
            let along = normal.dot(half);
            let spread = along * along * (alpha * alpha - 1.0) + 1.0;
            let distribution = alpha * alpha / (std::f64::consts::PI * spread * spread);
            let g1 = |cosine: f64| {
                2.0 * cosine / (cosine + (alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine).sqrt())
            };
            let fresnel = f0 + (DVec3::ONE - f0) * (1.0 - view.dot(half)).powi(5);
            let texel = scene.light_texture(&light).map_or(Vec3::ONE, |texture| texture.at(uv));
            let emitted = (light.radiance * texel).as_dvec3();
            radiance +=
                emitted * fresnel * (distribution * g1(incidence) * g1(cosine) / (4.0 * cosine) * solid);
        }
    }
    radiance / (side * side) as f64
}

/// Squared error of the specular radiance over the squares of the integral.
fn error(stage: &Stage, specular: &Specular, refiner: RefinerConfig, count: u32, side: usize) -> f64 {
    let mut pipeline = pipeline(stage, refiner, count);
    let image = pipeline.render().unwrap().clone();
    let gbuffer = pipeline.gbuffer();
    let (mut sum, mut energy) = (0.0, 0.0);
    for (pixel, found) in image.specular.iter().enumerate() {
        let Some(receiver) = gbuffer.receiver(pixel) else {
            assert_eq!(*found, Vec3::ZERO);
            continue;
        };
        let expected = integrated(&stage.scene, receiver.origin, receiver.normal, specular, side);
        sum += (found.as_dvec3() - expected).length_squared();
        energy += expected.length_squared();
        // All that leaves the pixel is the sum of both kinds of reflection.
        let diffuse = image.irradiance[pixel] * gbuffer.albedo[pixel] * std::f32::consts::FRAC_1_PI;
        let difference = image.radiance[pixel] - (diffuse + *found);
        assert!(difference.abs().max_element() <= 1e-6 * image.radiance[pixel].max_element());
    }
    assert!(energy > 0.0);
    sum / energy
}

fn refiners() -> [RefinerConfig; 2] {
    [RefinerConfig::PerPixel, PipelineConfig::default().refiner]
}

fn dielectric(roughness: f32) -> Specular {
    Specular { roughness, ..Specular::default() }
}

#[test]
fn shadowed_highlights_are_those_of_brute_force() {
    let metal = Specular { roughness: 0.35, metallic: 1.0, ..Specular::default() };
    for specular in [dielectric(0.2), metal, dielectric(0.8)] {
        let stage = stage(specular, vec![screen()], vec![]);
        for refiner in refiners() {
            let error = error(&stage, &specular, refiner, 256, 96);
            // 256 points of a lobe's own are wrong by a few hundredths of what they see where the blocker covers half of it, which a tenth of the
            // pixels do; the rule of 96 × 96 points is wrong by less than a hundredth in the narrowest of these lobes.
            assert!(error < 1e-3, "{specular:?} {refiner:?} {error:e}");
        }
        // The comparison rejects another roughness.
        let other = Specular { roughness: specular.roughness + 0.1, ..specular };
        let rejected = error(&stage, &other, RefinerConfig::PerPixel, 64, 24);
        assert!(rejected > 4e-3, "{specular:?} {rejected:e}");
    }
}

#[test]
fn disks_spheres_and_textures_are_reflected() {
    let specular = dielectric(0.4);
    let disk = AreaLight::disk(Vec3::new(0.3, 1.5, -3.5), Vec3::Z, 0.9, Vec3::new(4.0, 3.0, 2.0));
    let texels = vec![Vec3::X * 4.0, Vec3::ZERO, Vec3::new(0.1, 0.5, 2.0), Vec3::ONE, Vec3::Y, Vec3::ZERO];
    let texture = LightTexture::new(3, 2, texels).unwrap();
    let sphere = AreaLight::sphere(Vec3::new(-0.2, 1.4, -3.0), 0.8, Vec3::new(2.0, 3.0, 4.0));
    for stage in [
        stage(specular, vec![disk], vec![]),
        stage(specular, vec![sphere], vec![]),
        stage(specular, vec![screen().textured(0), disk], vec![texture]),
    ] {
        for refiner in refiners() {
            let error = error(&stage, &specular, refiner, 256, 48);
            assert!(error < 1e-3, "{refiner:?} {error:e}");
        }
    }
}

#[test]
fn a_texture_of_one_colour_is_a_uniform_light() {
    let specular = dielectric(0.3);
    let factor = Vec3::new(0.5, 2.0, 1.0);
    let texture = LightTexture::new(4, 4, vec![factor; 16]).unwrap();
    let image = |stage: &Stage| -> Image {
        pipeline(stage, PipelineConfig::default().refiner, 64).render().unwrap().clone()
    };
    let textured = image(&stage(specular, vec![screen().textured(0)], vec![texture]));
    let light = AreaLight { radiance: screen().radiance * factor, ..screen() };
    let uniform = image(&stage(specular, vec![light], vec![]));
    assert_eq!(textured.specular, uniform.specular);
    assert_eq!(textured.irradiance, uniform.irradiance);
}

#[test]
fn metals_have_no_diffuse_part_and_matte_scenes_no_layer() {
    let metal = Specular { metallic: 1.0, ..Specular::default() };
    let mut metals = pipeline(&stage(metal, vec![screen()], vec![]), RefinerConfig::PerPixel, 64);
    let radiance = metals.render().unwrap().clone();
    assert_eq!(radiance.radiance, radiance.specular);
    let matte = Stage::new(blocker_over_floor()).unwrap();
    let mut pipeline = pipeline(&matte, RefinerConfig::PerPixel, 64);
    let image = pipeline.render().unwrap().clone();
    assert!(image.specular.is_empty() && image.radiance.is_empty());
    assert!(pipeline.gbuffer().specular.is_empty());
    assert_eq!(image.stats.rays.specular, 0);
}

/// Extreme values give finite light, and no more of it than comes in.
#[test]
fn extremes_are_finite() {
    for (roughness, metallic) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)] {
        let specular = Specular { roughness, metallic, reflectance: Vec3::ONE };
        let above = AreaLight::parallelogram(Vec3::new(-0.5, 0.002, -0.5), Vec3::X, Vec3::Z, Vec3::ONE);
        for light in [screen(), above, above.reversed(), screen().reversed()] {
            let stage = stage(specular, vec![light], vec![]);
            for refiner in refiners() {
                let image = pipeline(&stage, refiner, 16).render().unwrap().clone();
                let brightest = light.radiance.max_element() * 1.01;
                assert!(
                    image.specular.iter().all(|light| light.is_finite() && light.max_element() <= brightest)
                );
            }
        }
    }
}

/// A light through slits: lobes see a few percent of it everywhere, which a first look at some of their rays may miss.
#[test]
fn a_few_percent_of_the_light_are_neither_lost_nor_black() {
    let specular = Specular { roughness: 0.5, metallic: 1.0, ..Specular::default() };
    let slats = (0..24)
        .map(|slat| (Vec3::new(-6.0, 1.0, -4.0 + 0.25 * slat as f32), Vec3::X * 12.0, Vec3::Z * 0.235));
    let floor = (Vec3::new(-10.0, 0.0, -10.0), Vec3::Z * 20.0, Vec3::X * 20.0);
    let materials = vec![Material { specular: Some(specular), ..Material::default() }];
    let mesh = Mesh { materials, ..quads(&[floor].into_iter().chain(slats).collect::<Vec<_>>()) };
    let camera =
        Camera { eye: Vec3::new(0.0, 0.7, 1.6), target: Vec3::new(0.0, 0.0, -0.8), ..Camera::default() };
    let light = AreaLight::parallelogram(Vec3::new(-1.0, 2.0, -2.5), Vec3::X * 2.0, Vec3::Z * 2.0, Vec3::ONE);
    let stage =
        Stage::new(Scene { mesh: Arc::new(mesh), lights: vec![light], camera, ..Scene::default() }).unwrap();
    for refiner in refiners() {
        let mut pipeline = pipeline(&stage, refiner, 4096);
        let image = pipeline.render().unwrap().clone();
        let gbuffer = pipeline.gbuffer();
        let (mut found, mut expected) = (0.0, 0.0);
        for y in (HEIGHT / 2..HEIGHT).step_by(6) {
            for x in (4..WIDTH).step_by(12) {
                let pixel = gbuffer.index(x, y);
                let receiver = gbuffer.receiver(pixel).unwrap();
                let light = integrated(&stage.scene, receiver.origin, receiver.normal, &specular, 600).x;
                found += f64::from(image.specular[pixel].x);
                expected += light;
                assert!(image.specular[pixel].x > 0.3 * light as f32, "{refiner:?} {x} {y} {light}");
            }
        }
        // Twelve pixels of 4,096 rays, of which 6 % arrive: 2 % of noise without stratification.
        assert!((found / expected - 1.0).abs() < 0.03, "{refiner:?}: {found} {expected}");
    }
}
