//! Sphere lights against quadrature and independent integration in double precision, and what their geometry hides.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use halflight::config::{Named, PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight::cpu::brute_force::BruteForce;
use halflight::frame::LightSampling;
use halflight::glam::{DVec3, Vec3};
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::pipeline::{Image, Pipeline, PipelineError};
use halflight::refine::Quality;
use halflight::scene::{Camera, Mesh, Scene};
use halflight::unshadowed::unshadowed;
use halflight_tests::{Stage, blocker_over_floor, hides, nmse2, nmse2_of, quads};

/// Sum over many small parts of a sphere's surface, in the order of angles from the axis to the receiver, so that grazing parts are as dense as
/// others.
fn quadrature(centre: DVec3, radius: f64, origin: DVec3, normal: DVec3) -> f64 {
    let (rings, spokes) = (1500, 3000);
    let away = origin - centre;
    let axis = away.normalize();
    let (x, y) = axis.any_orthonormal_pair();
    // Beyond this angle the surface faces away.
    let most = (radius / away.length()).acos();
    let mut sum = 0.0;
    for ring in 0..rings {
        let angle = most * (f64::from(ring) + 0.5) / f64::from(rings);
        for spoke in 0..spokes {
            let (sine, cosine) = (TAU * (f64::from(spoke) + 0.5) / f64::from(spokes)).sin_cos();
            let out = axis * angle.cos() + (x * cosine + y * sine) * angle.sin();
            let to = centre + out * radius - origin;
            sum +=
                normal.dot(to).max(0.0) * (-out.dot(to)).max(0.0) / to.length_squared().powi(2) * angle.sin();
        }
    }
    sum * radius * radius * most / f64::from(rings) * TAU / f64::from(spokes)
}

#[test]
fn irradiance_is_that_of_the_surface() {
    let (centre, radius) = (Vec3::new(0.5, 2.0, -1.0), 0.75f32);
    let light = AreaLight::sphere(centre, radius, Vec3::ONE);
    let (middle, r) = (centre.as_dvec3(), f64::from(radius));
    let directions = [DVec3::NEG_Y, DVec3::new(0.6, -0.8, 0.0), DVec3::new(0.36, 0.48, 0.8), DVec3::Y];
    for (index, (direction, far)) in directions.into_iter().zip([1.05, 1.3, 3.0, 20.0]).enumerate() {
        let origin = (middle + direction * (r * far)).as_vec3();
        let to = middle - origin.as_dvec3();
        let axis = to.normalize();
        let across = axis.any_orthonormal_vector();
        let half = (r / to.length()).asin();
        // From all of the sphere above the horizon to grazing, cut in the middle, and all but a sliver below it.
        for angle in
            [0.0, 0.9 * (FRAC_PI_2 - half), FRAC_PI_2 - 0.99 * half, FRAC_PI_2, FRAC_PI_2 + 0.8 * half]
        {
            let normal = (axis * angle.cos() + across * angle.sin()).as_vec3();
            let exact = quadrature(middle, r, origin.as_dvec3(), normal.as_dvec3());
            let found = f64::from(unshadowed(&light, origin, normal));
            // The horizon cuts through the quadrature's parts: a few of 3,000 along it. Normals are single precision.
            let slack = 2e-6 * exact + 3e-5 * PI * half.sin().powi(3);
            assert!((found - exact).abs() < slack, "{index} {angle}: {found} {exact}");
        }
        for angle in [FRAC_PI_2 + 1.001 * half, PI] {
            let normal = (axis * angle.cos() + across * angle.sin()).as_vec3();
            assert_eq!(unshadowed(&light, origin, normal), 0.0, "{index} {angle}");
        }
    }
    for inside in [Vec3::ZERO, Vec3::X * 0.7, Vec3::new(0.1, -0.5, 0.4)] {
        assert_eq!(f64::from(unshadowed(&light, centre + inside, Vec3::Z)), f64::from(PI as f32));
    }
}

const WIDTH: u32 = 44;
const HEIGHT: u32 = 33;

fn config(refiner: RefinerConfig, count: u32) -> PipelineConfig {
    PipelineConfig {
        width: WIDTH,
        height: HEIGHT,
        refiner,
        antialias: 1,
        sampling: LightSampling { count, ..LightSampling::default() },
        ..PipelineConfig::default()
    }
}

fn lattice(quality: Quality) -> RefinerConfig {
    RefinerConfig::Lattice(quality.lattice())
}

/// A lamp over the blocker, beside it.
fn lamp() -> AreaLight {
    AreaLight::sphere(Vec3::new(0.3, 2.2, 0.4), 0.5, Vec3::new(10.0, 9.0, 8.0))
}

/// The blocker over a floor and a wall under `lights`: the horizon of the wall cuts the lamp.
fn scene(lights: Vec<AreaLight>) -> Scene {
    let mesh = quads(&[
        (Vec3::new(-10.0, 0.0, -10.0), Vec3::Z * 20.0, Vec3::X * 20.0),
        (Vec3::new(-0.5, 1.0, -0.5), Vec3::Z, Vec3::X),
        (Vec3::new(0.4, 0.0, -6.0), Vec3::Z * 5.0, Vec3::Y * 4.0),
    ]);
    Scene { mesh: Arc::new(mesh), lights, ..blocker_over_floor() }
}

/// Irradiance of a receiver by segments to points of the sphere's surface, which are uniform over the cone that it fills: a grid of azimuths and of
/// cosines from the axis.
fn integrated(mesh: &Mesh, light: &AreaLight, origin: Vec3, normal: Vec3, side: usize) -> DVec3 {
    let sphere = light.as_sphere().unwrap();
    let (from, normal, radius) = (origin.as_dvec3(), normal.as_dvec3(), f64::from(sphere.radius));
    let to = sphere.centre.as_dvec3() - from;
    let (distance, axis) = (to.length(), to.normalize());
    let (x, y) = axis.any_orthonormal_pair();
    let least = (1.0 - (radius / distance).powi(2)).sqrt();
    let mut sum = 0.0;
    for index in 0..side * side {
        let part = |place: usize| (place as f64 + 0.5) / side as f64;
        let cosine = 1.0 - (1.0 - least) * part(index / side);
        let sine = (1.0 - cosine * cosine).sqrt();
        let (across, along) = (TAU * part(index % side)).sin_cos();
        let direction = axis * cosine + (x * along + y * across) * sine;
        let middle = to.dot(direction);
        let reach = middle - (middle * middle - distance * distance + radius * radius).max(0.0).sqrt();
        let term = normal.dot(direction);
        if term > 0.0 && !hides(mesh, from, from + direction * reach) {
            sum += term;
        }
    }
    light.radiance.as_dvec3() * (sum * TAU * (1.0 - least) / (side * side) as f64)
}

fn truth(pipeline: &Pipeline, scene: &Scene, side: usize) -> Vec<Vec3> {
    let gbuffer = pipeline.gbuffer();
    let of = |pixel: usize| {
        let Some(receiver) = gbuffer.receiver(pixel) else { return Vec3::ZERO };
        let lights = scene.lights.iter();
        let sum: DVec3 =
            lights.map(|light| integrated(&scene.mesh, light, receiver.origin, receiver.normal, side)).sum();
        sum.as_vec3()
    };
    (0..gbuffer.pixels()).map(of).collect()
}

#[test]
fn shadows_are_those_of_independent_integration() {
    let small = AreaLight::sphere(Vec3::new(-1.5, 1.2, 0.5), 0.1, Vec3::new(30.0, 40.0, 60.0));
    let stage = Stage::new(scene(vec![lamp(), small])).unwrap();
    let mut reference = None;
    for (refiner, shading, count, most) in [
        (RefinerConfig::PerPixel, Shading::Ratio, 1024, 8e-6),
        (RefinerConfig::PerPixel, Shading::Sampled, 1024, 6e-5),
        (lattice(Quality::Good), Shading::Ratio, 64, 1e-4),
        (lattice(Quality::Final), Shading::Ratio, 64, 1.2e-5),
        (RefinerConfig::named("nichols").unwrap(), Shading::Ratio, 64, 4e-3),
        (RefinerConfig::named("sfvt-gass").unwrap(), Shading::Ratio, 64, 4e-3),
    ] {
        let mut pipeline =
            PipelineConfig { shading, ..config(refiner, count) }.builder(&stage.prepared).build().unwrap();
        let image = pipeline.render().unwrap().clone();
        let reference = reference.get_or_insert_with(|| truth(&pipeline, &stage.scene, 48));
        let found = nmse2_of(&image.irradiance, reference);
        assert!(found < most, "{refiner:?} {shading:?} {count}: {found:e}");
    }
    // The comparison rejects another radius.
    let other =
        Stage::new(scene(vec![AreaLight::sphere(Vec3::new(0.3, 2.2, 0.4), 0.52, lamp().radiance), small]));
    let image = other.unwrap().render(&config(RefinerConfig::PerPixel, 256)).unwrap();
    assert!(nmse2_of(&image.irradiance, &reference.unwrap()) > 1e-3);
}

#[test]
fn exact_backends_agree_bit_for_bit_with_brute_force() {
    let plain = Stage::bundled("contact").unwrap();
    // One of them touches the floor, so that its samples are traced to its surface.
    let lights =
        vec![lamp(), AreaLight::sphere(Vec3::new(-1.0, 0.3, 1.0), 0.3, Vec3::ONE), plain.scene.lights[0]];
    let stage = Stage::new(Scene { lights, ..Scene::clone(&plain.scene) }).unwrap();
    for count in [64, 100] {
        let config = config(RefinerConfig::PerPixel, count);
        let expected = config.builder(&stage.prepared).visibility(BruteForce).build();
        let expected = expected.unwrap().render().unwrap().clone();
        assert!(expected.irradiance.iter().any(|light| light.max_element() > 0.1));
        for name in ["bvh", "beam", "auto"] {
            let visibility = VisibilityConfig::named(name).unwrap();
            let found = stage.render(&PipelineConfig { visibility, ..config }).unwrap();
            assert_eq!(found.irradiance, expected.irradiance, "{name} {count}");
        }
    }
}

#[test]
fn geometry_inside_a_sphere_does_not_hide_it_and_outside_does() {
    let bulb = |size: f32| {
        let mut scene = scene(vec![lamp()]);
        let (low, edge) = (Vec3::new(0.3, 2.2, 0.4) - size * 0.5, size);
        let (x, y, z) = (Vec3::X * edge, Vec3::Y * edge, Vec3::Z * edge);
        let high = low + edge;
        let list = [(low, x, z), (low, z, y), (low, y, x), (high, -z, -x), (high, -y, -z), (high, -x, -y)];
        let (bulb, mesh) = (quads(&list), Arc::make_mut(&mut scene.mesh));
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(bulb.positions);
        mesh.normals.extend(bulb.normals);
        mesh.uvs.extend(bulb.uvs);
        mesh.triangles.extend(bulb.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
        mesh.material_ids.extend(bulb.material_ids);
        // The bulb is above the picture.
        scene.camera = Camera { target: Vec3::new(0.0, -2.0, 0.0), ..scene.camera };
        Stage::new(scene).unwrap().render(&config(RefinerConfig::PerPixel, 64)).unwrap()
    };
    // The corners of a cube of 0.55 m are within the radius of 0.5 m.
    let (tiny, inside, around) = (bulb(1e-3), bulb(0.55), bulb(1.05));
    assert!(tiny.irradiance == inside.irradiance);
    assert!(inside.irradiance.iter().any(|light| light.max_element() > 0.1));
    assert!(around.irradiance.iter().all(|&light| light == Vec3::ZERO));
}

#[test]
fn receivers_inside_a_sphere_see_it_everywhere() {
    let light = AreaLight::sphere(Vec3::new(0.0, 1.0, 0.0), 6.0, Vec3::new(10.0, 9.0, 8.0));
    let stage = Stage::new(scene(vec![light])).unwrap();
    for refiner in [RefinerConfig::PerPixel, lattice(Quality::Good)] {
        for shading in [Shading::Ratio, Shading::Sampled] {
            let config = PipelineConfig { shading, ..config(refiner, 64) };
            let mut pipeline = config.builder(&stage.prepared).build().unwrap();
            let image = pipeline.render().unwrap().clone();
            let (mut inside, mut outside) = (0, 0);
            for (pixel, found) in image.irradiance.iter().enumerate() {
                let Some(receiver) = pipeline.gbuffer().receiver(pixel) else { continue };
                let expected = light.radiance * std::f32::consts::PI;
                if (receiver.origin - Vec3::Y).length() < 5.99 {
                    inside += 1;
                    let off = (*found / expected - 1.0).abs().max_element();
                    // Interpolation mixes inside and outside at the sphere's edge, where the irradiance jumps and the visible fraction does not.
                    let most = match (refiner, shading) {
                        (RefinerConfig::PerPixel, _) => 1e-6,
                        (_, Shading::Ratio) => 1e-3,
                        (_, Shading::Sampled) => 1.0,
                    };
                    assert!(off < most, "{shading:?} {pixel}: {found}");
                } else {
                    outside += 1;
                    assert!(found.is_finite() && found.max_element() < 0.8 * expected.max_element());
                }
            }
            assert!(inside > 500 && outside > 50, "{inside} {outside}");
        }
    }
}

#[test]
fn what_has_no_answers_refuses_by_name() {
    let stage = Stage::new(scene(vec![lamp()])).unwrap();
    let config = config(RefinerConfig::PerPixel, 64);
    let raster4d = VisibilityConfig::named("raster4d").unwrap();
    let in_rows = PipelineConfig { visibility: raster4d, sampling: raster4d.fit(config.sampling), ..config };
    let error = in_rows.builder(&stage.prepared).build().map(|_| ()).unwrap_err();
    assert!(matches!(error, PipelineError::UnsupportedLight { index: 0, .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("light 0") && text.contains("raster4d") && text.contains("use bvh"), "{text}");
    // A pipeline stays as it was.
    let flat = Stage::new(blocker_over_floor()).unwrap();
    let mut pipeline = in_rows.builder(&flat.prepared).build().unwrap();
    let before = pipeline.render().unwrap().irradiance.clone();
    assert!(matches!(pipeline.set_lights(&[lamp()]), Err(PipelineError::UnsupportedLight { .. })));
    pipeline.set_frame_index(0);
    assert_eq!(pipeline.render().unwrap().irradiance, before);
}

#[test]
fn the_camera_sees_spheres() {
    let (centre, radius) = (Vec3::new(0.4, -0.3, 0.0), 0.8f32);
    let light = AreaLight::sphere(centre, radius, Vec3::new(3.0, 2.0, 1.0)).visible();
    let wall = (Vec3::new(-9.0, -9.0, -2.0), Vec3::X * 18.0, Vec3::Y * 18.0);
    let screen = (Vec3::new(-2.0, -2.0, 1.0), Vec3::X * 2.0, Vec3::Y * 4.0);
    let at = |eye: Vec3, list: &[(Vec3, Vec3, Vec3)]| {
        let camera = Camera { eye, target: eye - Vec3::Z, up: Vec3::Y, fov_y_deg: 40.0, ..Camera::default() };
        let scene = Scene { mesh: Arc::new(quads(list)), lights: vec![light], camera, ..Scene::default() };
        let config = PipelineConfig { width: 200, height: 200, ..config(RefinerConfig::PerPixel, 16) };
        Stage::new(scene).unwrap().render(&config).unwrap()
    };
    let count = |image: &Image| image.emission.iter().filter(|&&light| light != Vec3::ZERO).count() as f64;
    let eye = Vec3::new(0.0, 0.0, 4.0);
    let image = at(eye, &[wall]);
    // Pixels have 2 tan 20° / 200 m at 1 m. A ray meets the sphere if its angle to the centre is below that of the cone.
    let pixel = 2.0 * 20f64.to_radians().tan() / 200.0;
    let (to, mut expected) = ((centre - eye).as_dvec3(), 0.0);
    let least = (1.0 - f64::from(radius).powi(2) / to.length_squared()).sqrt();
    for index in 0..200 * 200 {
        let (x, y) = (f64::from(index % 200) - 99.5, 99.5 - f64::from(index / 200));
        let inside = DVec3::new(x * pixel, y * pixel, -1.0).normalize().dot(to.normalize()) > least;
        expected += f64::from(u8::from(inside));
    }
    assert!(expected > 3000.0 && (count(&image) - expected).abs() <= 4.0, "{} {expected}", count(&image));
    assert!(image.emission.iter().all(|&seen| seen == Vec3::ZERO || seen == light.radiance));
    // A fifth of it is behind a screen; from inside all is light but for surfaces inside the sphere.
    let half = at(eye, &[wall, screen]);
    assert!(count(&half) > 1500.0 && count(&half) < 0.85 * expected);
    // Its right edge passes through the middle of the view.
    let nearer = (Vec3::new(-0.2, -1.0, -0.1), Vec3::X * 0.6, Vec3::Y * 2.0);
    let within = at(Vec3::new(0.4, -0.3, 0.3), &[wall, nearer]);
    assert!((count(&within) - 20_000.0).abs() <= 200.0, "{}", count(&within));
}

#[test]
fn one_sphere_is_its_own_copy_elsewhere() {
    // Ten thousand times as large, and moved by a kilometre: the same picture.
    let stage = Stage::new(scene(vec![lamp()])).unwrap();
    let config = config(RefinerConfig::PerPixel, 64);
    let plain = stage.render(&config).unwrap();
    for (scale, offset, most) in [(1e4, Vec3::ZERO, 1e-7), (1.0, Vec3::splat(1e3), 1e-4)] {
        let mut scene = Scene::clone(&stage.scene);
        let place = |point: Vec3| point * scale + offset;
        Arc::make_mut(&mut scene.mesh).positions.iter_mut().for_each(|point| *point = place(*point));
        scene.lights[0] = scene.lights[0].transformed(place, |direction| direction * scale);
        (scene.camera.eye, scene.camera.target) = (place(scene.camera.eye), place(scene.camera.target));
        let found = Stage::new(scene).unwrap().render(&config).unwrap();
        let off = nmse2(&found, &plain);
        assert!(off < most, "{scale} {offset}: {off:e}");
    }
}
