//! Scaled and translated scenes, and lights in difficult positions.

use halflight::config::{Named, PipelineConfig, RefinerConfig};
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::scene::Scene;
use halflight_tests::{Stage, blocker_over_floor, nmse2, square_light};
use std::sync::Arc;

fn config(refiner: RefinerConfig) -> PipelineConfig {
    PipelineConfig { width: 96, height: 72, refiner, shading: Shading::Ratio, ..PipelineConfig::default() }
}

fn transformed(scale: f32, offset: Vec3) -> Scene {
    let mut scene = blocker_over_floor();
    let place = |p: Vec3| p * scale + offset;
    for position in &mut Arc::make_mut(&mut scene.mesh).positions {
        *position = place(*position);
    }
    for light in &mut scene.lights {
        *light = light.transformed(place, |direction| direction * scale);
    }
    scene.camera.eye = place(scene.camera.eye);
    scene.camera.target = place(scene.camera.target);
    scene
}

#[test]
fn scale_and_place_do_not_change_the_image() {
    let per_pixel = config(RefinerConfig::PerPixel);
    let expected = Stage::new(transformed(1.0, Vec3::ZERO)).unwrap().render(&per_pixel).unwrap();
    for scale in [1e-3, 0.1, 30.0, 1e4] {
        let image = Stage::new(transformed(scale, Vec3::ZERO)).unwrap().render(&per_pixel).unwrap();
        // Irradiance does not depend on scale; rounding flips single rays at edges only.
        let error = nmse2(&image, &expected);
        assert!(error < 1e-4, "scale {scale}: {error}");
    }
    // At 1e5 m single precision resolves 8 mm: vertices, camera and therefore every edge move by up to that.
    // Shadow acne or a light leak would change whole regions.
    let image = Stage::new(transformed(1.0, Vec3::splat(1e5))).unwrap().render(&per_pixel).unwrap();
    let error = nmse2(&image, &expected);
    assert!(error < 5e-3, "moved by 1e5: {error}");
    // The comparison detects a scene without its blocker.
    let mut bare = blocker_over_floor();
    Arc::make_mut(&mut bare.mesh).triangles.truncate(2);
    Arc::make_mut(&mut bare.mesh).material_ids.truncate(2);
    let error = nmse2(&Stage::new(bare).unwrap().render(&per_pixel).unwrap(), &expected);
    assert!(error > 1e-2, "{error}");
}

#[test]
fn powers_of_two_do_not_change_the_image_within_the_range() {
    for refiner in [RefinerConfig::PerPixel, PipelineConfig::default().refiner] {
        let config = config(refiner);
        let expected = Stage::new(transformed(1.0, Vec3::ZERO)).unwrap().render(&config).unwrap();
        // The scene is 28 m across and reaches 10 m from the origin.
        for power in [-31, -24, -12, 12, 20, 23] {
            let scene = transformed(2f32.powi(power), Vec3::ZERO);
            let image = Stage::new(scene).unwrap().render(&config).unwrap();
            // Products of coordinates are scaled without rounding; bounds in absolute terms are not.
            let error = nmse2(&image, &expected);
            assert!(error < 1e-7, "2^{power}: {error}");
        }
    }
}

#[test]
fn sizes_beyond_the_range_are_refused() {
    for (power, expected) in [(-33, "less than 1e-8 m across"), (24, "1e8 m or more")] {
        let error = Stage::new(transformed(2f32.powi(power), Vec3::ZERO)).err().unwrap().to_string();
        assert!(error.contains(expected) && error.contains("from 1e-8 to 1e8 m"), "{error}");
    }
    let config = config(RefinerConfig::PerPixel);
    let far = |change: fn(&mut Scene)| {
        let mut scene = blocker_over_floor();
        change(&mut scene);
        Stage::new(scene).unwrap().render(&config).err().unwrap().to_string()
    };
    let light = far(|scene| scene.lights[0] = scene.lights[0].moved(Vec3::Y * 1e9));
    assert!(light.contains("light 0 lies 1e8 m or more"), "{light}");
    let camera = far(|scene| scene.camera.eye.y = 1e9);
    assert!(camera.contains("1e8 m or more"), "{camera}");
}

#[test]
fn lights_in_awkward_places_give_finite_images() {
    let lights = [
        ("touching the floor", square_light(Vec3::ZERO, 1.0)),
        ("through the floor", {
            let light = square_light(Vec3::ZERO, 1.0);
            let u = Vec3::new(0.7, 0.7, 0.0);
            AreaLight::parallelogram(light.corners()[0], u, Vec3::Z, light.radiance)
        }),
        ("below the floor", square_light(Vec3::new(0.0, -2.0, 0.0), 1.0)),
        ("around the camera", square_light(Vec3::new(0.5, 3.0, 5.0), 0.2)),
        ("tiny", square_light(Vec3::new(0.0, 4.0, 0.0), 1e-4)),
        ("huge", square_light(Vec3::new(0.0, 4.0, 0.0), 1e4)),
    ];
    for (name, light) in lights {
        for two_sided in [false, true] {
            let mut scene = blocker_over_floor();
            scene.lights = vec![AreaLight { two_sided, ..light }];
            let stage = Stage::new(scene).unwrap();
            for refiner in RefinerConfig::NAMES {
                let config = config(RefinerConfig::named(refiner).unwrap());
                for shading in [Shading::Sampled, Shading::Ratio] {
                    let image = stage.render(&PipelineConfig { shading, ..config }).unwrap();
                    let fine = image.irradiance.iter().all(|v| v.is_finite() && v.min_element() >= 0.0);
                    assert!(fine, "{name}, {refiner}, {shading:?}, two-sided {two_sided}");
                }
            }
        }
    }
}

#[test]
fn lights_add_up() {
    let per_pixel = config(RefinerConfig::PerPixel);
    let (a, b) = (square_light(Vec3::new(-2.0, 4.0, 0.0), 1.0), square_light(Vec3::new(2.0, 3.0, 1.0), 0.5));
    let image = |lights: &[AreaLight]| {
        let mut scene = blocker_over_floor();
        scene.lights = lights.to_vec();
        Stage::new(scene).unwrap().render(&per_pixel).unwrap()
    };
    let (first, both) = (image(&[a]), image(&[a, b]));
    // The samples of the second light depend on its index, so it is rendered as the second one, after a dark
    // first.
    let dark = AreaLight { radiance: Vec3::ZERO, ..a };
    let second = image(&[dark, b]);
    for pixel in 0..both.irradiance.len() {
        let (sum, found) = (first.irradiance[pixel] + second.irradiance[pixel], both.irradiance[pixel]);
        // One rounding of the sum.
        assert!((sum - found).abs().max_element() <= 1e-6 * found.max_element(), "pixel {pixel}");
    }
}
