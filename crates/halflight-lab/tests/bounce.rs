//! Reference of indirect light: closed forms, darkness, and runs that do not depend on threads or stops.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::f32::consts::{PI, TAU};
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use halflight_core::light::AreaLight;
use halflight_core::scene::{Camera, Material, Mesh, Scene};
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::unshadowed::unshadowed;
use halflight_lab::reference::bounce::{OneBounce, one_bounce};
use halflight_lab::reference::{ReferenceConfig, ReferenceError, seen};

const ALBEDO: Vec3 = Vec3::new(0.5, 0.25, 0.8);

fn config(samples: u32) -> ReferenceConfig {
    ReferenceConfig { width: 32, height: 24, samples, ..ReferenceConfig::default() }
}

fn found(scene: &PreparedScene, samples: u32) -> OneBounce {
    one_bounce(scene, &config(samples), None, &mut |_, _| {}).unwrap()
}

fn mesh(albedo: Vec3) -> Mesh {
    Mesh { materials: vec![Material { albedo, ..Material::default() }], ..Mesh::default() }
}

fn add_quad(mesh: &mut Mesh, corners: [Vec3; 4]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.uvs.extend([Vec2::ZERO; 4]);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.material_ids.extend([0, 0]);
}

fn add_box(mesh: &mut Mesh, low: Vec3, high: Vec3) {
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [low, high] {
            let corner = |a: Vec3, b: Vec3| {
                let mut point = side;
                (point[u], point[v]) = (a[u], b[v]);
                point
            };
            add_quad(mesh, [corner(low, low), corner(high, low), corner(high, high), corner(low, high)]);
        }
    }
}

fn scene(mesh: Mesh, light: AreaLight, eye: Vec3, target: Vec3) -> PreparedScene {
    let camera = Camera { eye, target, up: Vec3::Y, fov_y_deg: 70.0, ..Camera::default() };
    PreparedScene::new(Scene { mesh: Arc::new(mesh), lights: vec![light], camera, ..Scene::default() })
        .unwrap()
}

/// Sphere of radius 1 with a light of 0.2 × 0.3 m off its centre, and the sphere's area.
fn integrating_sphere() -> (PreparedScene, f32) {
    const ROWS: usize = 128;
    let point = |row: usize, column: usize| {
        let column = column % (2 * ROWS);
        let (theta, phi) = (PI * row as f32 / ROWS as f32, TAU * column as f32 / (2 * ROWS) as f32);
        Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let mut mesh = mesh(ALBEDO);
    for (row, column) in (0..ROWS).flat_map(|row| (0..2 * ROWS).map(move |column| (row, column))) {
        let [a, b, c, d] =
            [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(down, right)| point(row + down, column + right));
        // At the poles two corners are one.
        let triangles = [(row > 0, [a, b, c]), (row + 1 < ROWS, [a, c, d])];
        for (_, corners) in triangles.into_iter().filter(|(there, _)| *there) {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.uvs.extend([Vec2::ZERO; 3]);
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.material_ids.push(0);
        }
    }
    let area = |index: usize| {
        let [a, b, c] = mesh.corners(index);
        0.5 * (b - a).cross(c - a).length()
    };
    let area = (0..mesh.triangle_count()).map(area).sum();
    let corner = Vec3::new(0.2, 0.1, -0.3);
    let light = AreaLight::parallelogram(corner, Vec3::X * 0.2, Vec3::Y * 0.3, Vec3::new(1.0, 2.0, 3.0));
    (scene(mesh, light, Vec3::new(0.0, 0.0, 0.1), Vec3::Z), area)
}

fn mean(image: &[Vec3]) -> Vec3 {
    image.iter().sum::<Vec3>() / image.len() as f32
}

#[test]
fn an_integrating_sphere_is_lit_evenly_by_one_reflection() {
    let (scene, area) = integrating_sphere();
    let found = found(&scene, 256);
    // Inside a sphere the form factor between any two places is 1 / area: the flux π L A of the light, reflected, falls on all alike.
    let expected = ALBEDO * Vec3::new(1.0, 2.0, 3.0) * (PI * 0.2 * 0.3) / area;
    // Facets of 1.4° instead of a sphere: their normals are off by 0.7° to all sides, which cancels but for its square, 1.5e-4. Noise: the direct
    // light varies as much as its mean, over 32 · 24 · 256 rays, 2.3e-3; four of these.
    let all = mean(&found.irradiance) / expected;
    assert!((all - 1.0).abs().max_element() < 0.011, "{all}");
    // The light is one-sided, and yet both halves of the picture receive as much.
    for part in [0..384, 384..768] {
        let part = mean(&found.irradiance[part]) / expected;
        assert!((part - 1.0).abs().max_element() < 0.015, "{part}");
    }
    assert!(found.noise_nmse2 > 0.0 && found.noise_nmse2 < 1e-2, "{}", found.noise_nmse2);
    // The image is even but for noise and the facets, whose normals add a tenth to it, so that its variance is the noise. Both are sums over 768 pixels, each known to about 5 %: six of these.
    let squares = |value: Vec3| value.as_dvec3().length_squared();
    let variance: f64 = found.irradiance.iter().map(|value| squares(*value - expected)).sum();
    let noise = variance / found.irradiance.iter().map(|value| squares(*value)).sum::<f64>();
    assert!((noise / found.noise_nmse2 - 1.0).abs() < 0.3, "{noise} {}", found.noise_nmse2);
}

#[test]
fn a_lit_square_lights_another_by_its_form_factor() {
    let square = |y: f32, half: f32| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x * half, y, z * half))
    };
    let mut mesh = mesh(ALBEDO);
    let half = 0.25f32;
    add_quad(&mut mesh, square(0.0, half));
    add_quad(&mut mesh, square(1.0, 0.02));
    // The light shines down from afar; the upper square turns its back to it and hides nothing.
    let light =
        AreaLight::parallelogram(Vec3::new(9.0, 9.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0, Vec3::splat(100.0));
    let scene = scene(mesh, light, Vec3::new(0.0, 0.9, 0.0), Vec3::new(0.0, 1.0, 0.03));
    let direct = unshadowed(&scene.scene().lights[0], Vec3::ZERO, Vec3::Y) * 100.0;
    // Form factor of a square of side 2a at distance 1, centred: 4/π · s · atan s with s = a / √(1 + a²).
    let slope = half / (1.0 + half * half).sqrt();
    let factor = 4.0 / PI * slope * slope.atan();
    let config = ReferenceConfig { width: 16, height: 16, samples: 4096, ..ReferenceConfig::default() };
    let found = one_bounce(&scene, &config, None, &mut |_, _| {}).unwrap();
    let seen = seen(&scene, [16, 16]);
    // Pixels in the middle see the upper square.
    let receivers: Vec<usize> = (0..256).filter(|&pixel| seen.is_receiver(pixel)).collect();
    let light: Vec<Vec3> = receivers.iter().map(|&pixel| found.irradiance[pixel]).collect();
    assert!(light.len() > 8, "{}", light.len());
    let relative = mean(&light) / (ALBEDO * direct * factor);
    // 1 %: the light falls off over the lower square by 5 % to either side, of which the square is left, and the upper square is no point.
    // And twice the noise of as many independent rays, of which one in 14 hits.
    let noise = (1.0 / factor / (4096 * light.len()) as f32).sqrt();
    assert!(
        (relative - 1.0).abs().max_element() < 0.01 + 2.0 * noise,
        "{relative} of {} pixels",
        light.len()
    );
}

#[test]
fn a_closed_room_without_light_is_black() {
    let mut mesh = mesh(ALBEDO);
    add_box(&mut mesh, Vec3::ZERO, Vec3::ONE);
    add_box(&mut mesh, Vec3::new(1.25, 0.0, 0.0), Vec3::new(2.25, 1.0, 1.0));
    let light = AreaLight::parallelogram(Vec3::new(1.5, 0.9, 0.25), Vec3::X * 0.5, Vec3::Z * 0.5, Vec3::ONE);
    let eye = Vec3::new(0.5, 0.5, 0.9);
    let dark = scene(mesh.clone(), light, eye, Vec3::new(0.5, 0.4, 0.0));
    let black = found(&dark, 16);
    assert!(black.irradiance.iter().all(|&value| value == Vec3::ZERO));
    assert_eq!((black.noise_nmse2, black.rays), (0.0, 16));
    // The other room is lit.
    let lit = scene(mesh, light, eye + Vec3::X * 1.25, Vec3::new(1.75, 0.4, 0.0));
    assert!(found(&lit, 16).irradiance.iter().all(|value| value.min_element() > 0.0));
}

#[test]
fn threads_and_stops_do_not_matter() {
    let (scene, _) = integrating_sphere();
    let expected = found(&scene, 8);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| found(&scene, 8)), expected);
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("bounce-stopped");
    let _ = fs::remove_dir_all(&folder);
    let cached = |samples| {
        let mut first = None;
        let found = one_bounce(&scene, &config(samples), Some(&folder), &mut |done, _| {
            first.get_or_insert(done);
        });
        (first.unwrap(), found.unwrap())
    };
    assert_eq!(cached(3).1.rays, 4);
    assert_eq!(cached(8), (4, expected.clone()));
    assert_eq!(cached(2), (2, expected));
    // Another albedo is another image.
    let mut other = scene.scene().clone();
    Arc::make_mut(&mut other.mesh).materials[0].albedo = Vec3::ONE;
    let other = PreparedScene::new(other).unwrap();
    let started = one_bounce(&other, &config(2), Some(&folder), &mut |_, _| {}).unwrap();
    assert_eq!(started.rays, 2);
    let refused = one_bounce(&scene, &config(0), None, &mut |_, _| {});
    assert!(matches!(refused, Err(ReferenceError::Samples(0))));
}
