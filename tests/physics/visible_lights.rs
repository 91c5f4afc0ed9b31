//! Lights that the camera sees.

use std::sync::Arc;

use halflight::config::{PipelineConfig, RefinerConfig};
use halflight::glam::Vec3;
use halflight::light::AreaLight;
use halflight::light_texture::LightTexture;
use halflight::pipeline::Image;
use halflight::scene::{Camera, Scene};
use halflight_tests::{Stage, quads};

const SIZE: u32 = 40;

/// A view along −z with 0.1 m a pixel at a distance of 4 m: pixel (x, y) sees (0.1 · (x − 19.5), 0.1 · (19.5 − y)) there.
fn camera() -> Camera {
    let fov_y_deg = 2.0 * 0.5f32.atan().to_degrees();
    Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, fov_y_deg)
}

/// Light in the plane z = 0 that faces the viewer, 2 m wide and 1 m high.
fn screen() -> AreaLight {
    let light = AreaLight::parallelogram(
        Vec3::new(-1.0, -0.5, 0.0),
        Vec3::X * 2.0,
        Vec3::Y,
        Vec3::new(3.0, 2.0, 1.0),
    );
    light.visible()
}

/// A wall behind the light, and an occluder before its left half.
fn scene(lights: Vec<AreaLight>) -> Scene {
    let mesh = quads(&[
        (Vec3::new(-9.0, -9.0, -2.0), Vec3::X * 18.0, Vec3::Y * 18.0),
        (Vec3::new(-2.0, -2.0, 1.0), Vec3::X * 2.0, Vec3::Y * 4.0),
    ]);
    Scene { mesh: Arc::new(mesh), lights, camera: camera(), ..Scene::default() }
}

fn render(scene: Scene, antialias: u32) -> Image {
    let config = PipelineConfig {
        width: SIZE,
        height: SIZE,
        refiner: RefinerConfig::PerPixel,
        antialias,
        ..PipelineConfig::default()
    };
    Stage::new(scene).unwrap().render(&config).unwrap()
}

#[test]
fn lights_are_seen_where_nothing_is_before_them() {
    let image = render(scene(vec![screen()]), 1);
    for pixel in 0..SIZE * SIZE {
        let (x, y) = ((pixel % SIZE) as f32 - 19.5, 19.5 - (pixel / SIZE) as f32);
        // The occluder ends at x = 0, which is before the pixels right of the middle.
        let seen = (0.0..10.0).contains(&x) && y.abs() < 5.0;
        let expected = if seen { screen().radiance } else { Vec3::ZERO };
        assert_eq!(image.emission[pixel as usize], expected, "{x} {y}");
        if seen {
            assert_eq!(image.radiance[pixel as usize], expected);
        }
    }
}

#[test]
fn irradiance_is_that_of_lights_that_are_not_seen() {
    let hidden = render(scene(vec![AreaLight { visible: false, ..screen() }]), 1);
    assert!(hidden.emission.is_empty() && hidden.radiance.is_empty());
    assert_eq!(hidden.irradiance, render(scene(vec![screen()]), 1).irradiance);
}

#[test]
fn backs_are_seen_where_they_emit() {
    let seen =
        |light: AreaLight| render(scene(vec![light]), 1).emission.iter().any(|&light| light != Vec3::ZERO);
    assert!(!seen(screen().reversed()));
    assert!(seen(screen().reversed().two_sided()));
}

#[test]
fn edges_are_means_over_sub_samples_and_the_nearest_light_is_seen() {
    // Its right edge passes through the middles of pixels.
    let wide = AreaLight::parallelogram(Vec3::new(0.55, -0.5, 0.0), Vec3::X, Vec3::Y, Vec3::ONE).visible();
    let image = render(scene(vec![wide]), 16);
    let row = (SIZE * SIZE / 2) as usize;
    let half = image.emission[row + 25].x;
    assert!((half - 0.5).abs() < 0.07, "{half}");
    assert_eq!(image.emission[row + 27], Vec3::ONE);
    // A nearer one hides it.
    let near = wide.moved(Vec3::Z * 0.5);
    let near = AreaLight { radiance: Vec3::new(0.0, 7.0, 0.0), ..near };
    let both = render(scene(vec![near, wide]), 1);
    assert_eq!(both.emission[row + 28], near.radiance);
}

#[test]
fn textures_and_disks_are_seen() {
    let texels = vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
    let texture = Arc::new(LightTexture::new(2, 2, texels).unwrap());
    let upper = screen().moved(Vec3::X * 1.0).textured(0);
    let image = render(Scene { light_textures: vec![texture], ..scene(vec![upper]) }, 1);
    let at = |x: u32, y: u32| image.emission[(y * SIZE + x) as usize];
    // Red is the upper left texel, green the upper right, blue the lower left.
    assert_eq!(at(22, 17), Vec3::X * upper.radiance);
    assert_eq!(at(36, 17), Vec3::Y * upper.radiance);
    assert_eq!(at(22, 22), Vec3::Z * upper.radiance);
    let disk = AreaLight::disk(Vec3::new(0.8, 0.0, 0.0), Vec3::Z, 0.5, Vec3::ONE).visible();
    let image = render(scene(vec![disk]), 1);
    let count = image.emission.iter().filter(|&&light| light != Vec3::ZERO).count() as f32;
    // A hundred pixels a square metre; the circumference passes through some thirty of them.
    assert!((count - 25.0 * std::f32::consts::PI).abs() < 8.0, "{count}");
}

#[test]
fn a_light_before_the_background_is_seen() {
    let mesh = quads(&[(Vec3::new(-2.0, -2.0, 1.0), Vec3::X * 2.0, Vec3::Y * 4.0)]);
    let image = render(Scene { mesh: Arc::new(mesh), ..scene(vec![screen()]) }, 1);
    assert_eq!(image.radiance, render(scene(vec![screen()]), 1).emission);
}

/// The rim of an occluder before a light is the mean of both: its edge passes through the middles of pixels.
#[test]
fn rims_before_a_light_are_means() {
    // At a distance of 3 m a pixel has 7.5 cm.
    let mesh = quads(&[(Vec3::new(-2.0, -2.0, 1.0), Vec3::X * (2.0 + 0.075 * 2.5), Vec3::Y * 4.0)]);
    for antialias in [4, 8, 16] {
        let image = render(Scene { mesh: Arc::new(mesh.clone()), ..scene(vec![screen()]) }, antialias);
        let row = (SIZE * SIZE / 2) as usize;
        let part = image.emission[row + 22].x / screen().radiance.x;
        assert!((part - 0.5).abs() < 0.13, "{antialias}: {part}");
        assert_eq!(image.radiance[row + 22], image.emission[row + 22]);
        assert_eq!((image.emission[row + 21], image.emission[row + 23]), (Vec3::ZERO, screen().radiance));
    }
}

/// Lamps before their own faces, which lie aslant to the view: every pixel of a face has the lamp's whole radiance, with and without sub-samples, and a
/// surface a little before the lamp hides it.
#[test]
fn lamps_are_seen_whole_before_their_own_faces() {
    let (corner, u, v) = (Vec3::new(-1.13, -0.71, 0.37), Vec3::new(2.2, 0.3, -3.1), Vec3::new(0.2, 1.3, 0.4));
    let lamp = AreaLight::parallelogram(corner, u, v, Vec3::new(6.0, 3.0, 1.5)).visible();
    let normal = u.cross(v).normalize();
    // The lamp's face and a wall behind it.
    let seen = |above: f32, antialias: u32| {
        let wall = (Vec3::new(-9.0, -9.0, -7.0), Vec3::X * 18.0, Vec3::Y * 18.0);
        let mesh = quads(&[wall, (corner + normal * above, u, v)]);
        render(Scene { mesh: Arc::new(mesh), ..scene(vec![lamp]) }, antialias)
    };
    let lit = |image: &Image| image.emission.iter().filter(|&&light| light != Vec3::ZERO).count();
    let partly = |image: &Image| {
        image.emission.iter().filter(|&&light| light != Vec3::ZERO && light != lamp.radiance).count()
    };
    let alone = render(Scene { mesh: Arc::new(quads(&[])), ..scene(vec![lamp]) }, 1);
    assert!(lit(&alone) > 100);
    assert_eq!(seen(0.0, 1).emission, alone.emission);
    for antialias in [4, 8, 16] {
        let image = seen(0.0, antialias);
        let edges = partly(&image);
        assert!(lit(&image) >= lit(&alone) && edges < lit(&alone) / 3, "{antialias}: {edges}");
        // Pixels inside, those around which all are lit, have all of it.
        for pixel in (0..(SIZE * SIZE) as usize).filter(|&pixel| image.emission[pixel] != Vec3::ZERO) {
            let (x, y) = (pixel % SIZE as usize, pixel / SIZE as usize);
            let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| y * SIZE as usize + x));
            if around.into_iter().all(|pixel| alone.emission[pixel] != Vec3::ZERO) {
                let light = image.emission[pixel];
                assert!(light.abs_diff_eq(lamp.radiance, 1e-5), "{antialias}: {x} {y} {light}");
            }
        }
        // Beside the rim of a face a millimetre before the lamp a ray may pass.
        assert!(lit(&seen(1e-3, antialias)) <= 2);
    }
    assert_eq!((lit(&seen(1e-3, 1)), lit(&seen(-1e-3, 1))), (0, lit(&alone)));
}
