//! Coarse spheres with vertex normals against the closed form of the smooth sphere, past the shadow terminator.

use std::f32::consts::PI;

use halflight::config::{PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::glam::{Vec2, Vec3};
use halflight::light::AreaLight;
use halflight::scene::{Camera, Material, Mesh, Scene};
use halflight::unshadowed::unshadowed;
use halflight_tests::Stage;

/// Sphere of radius 1 around the origin, of `columns` × `rows` quadrilaterals, whose normals are its positions.
fn sphere(columns: u32, rows: u32) -> Mesh {
    let mut mesh = Mesh { materials: vec![Material::default()], ..Mesh::default() };
    for row in 0..=rows {
        for column in 0..columns {
            let (high, around) = (PI * row as f32 / rows as f32, 2.0 * PI * column as f32 / columns as f32);
            mesh.positions.push(Vec3::new(high.sin() * around.cos(), high.cos(), high.sin() * around.sin()));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let (a, b) = (row * columns + column, row * columns + (column + 1) % columns);
            let (c, d) = (a + columns, b + columns);
            // At the poles one of the two has no area.
            mesh.triangles.extend((row > 0).then_some([a, b, c]));
            mesh.triangles.extend((row + 1 < rows).then_some([b, d, c]));
        }
    }
    mesh.normals = mesh.positions.clone();
    mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    mesh.material_ids = vec![0; mesh.triangles.len()];
    mesh
}

/// Largest error of the irradiance over the sphere that the camera sees, relative to its peak, and the number of pixels
/// that receive light from a part of the lamp only.
fn error(mesh: Mesh) -> (f32, usize) {
    let corner = Vec3::new(-3.5, 2.5, -0.5);
    let light = AreaLight::parallelogram(corner, Vec3::X * 1.5, Vec3::Z * 1.5, Vec3::ONE);
    let camera =
        Camera { eye: Vec3::new(0.0, 1.5, 6.0), target: Vec3::ZERO, fov_y_deg: 22.0, ..Camera::default() };
    let stage =
        Stage::new(Scene { mesh: mesh.into(), lights: vec![light], camera, ..Scene::default() }).unwrap();
    let config = PipelineConfig {
        width: 120,
        height: 120,
        refiner: RefinerConfig::PerPixel,
        visibility: VisibilityConfig::Beam,
        sampling: LightSampling { count: 256, ..LightSampling::default() },
        ..PipelineConfig::default()
    };
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    let image = pipeline.render().unwrap().irradiance.clone();
    let (mut largest, mut peak, mut terminator) = (0.0f32, 0.0f32, 0);
    for (pixel, irradiance) in image.iter().enumerate() {
        let Some(receiver) = pipeline.gbuffer().receiver(pixel) else { continue };
        let point = receiver.origin.normalize();
        let expected = unshadowed(&light, point, point);
        let above = light.corners().into_iter().filter(|corner| point.dot(*corner - point) > 0.0).count();
        terminator += usize::from(expected > 0.0 && above < 4);
        peak = peak.max(expected);
        largest = largest.max((irradiance.x - expected).abs());
    }
    (largest / peak, terminator)
}

#[test]
fn coarse_spheres_are_lit_like_smooth_ones() {
    for (columns, rows, bound) in [(8, 4, 0.025), (16, 8, 0.006), (32, 16, 0.003)] {
        let (smooth, terminator) = error(sphere(columns, rows));
        assert!(smooth < bound, "{columns} x {rows}: {smooth}");
        assert!(terminator > 100, "{columns} x {rows}: {terminator} pixels beside the terminator");
        let (flat, _) = error(Mesh { normals: Vec::new(), ..sphere(columns, rows) });
        assert!(flat > 10.0 * bound, "{columns} x {rows}: {flat}");
    }
}

#[test]
fn normals_on_either_side_are_the_same_surface() {
    let inside_out =
        |mesh: Mesh| Mesh { normals: mesh.normals.iter().map(|normal| -*normal).collect(), ..mesh };
    let (outside, _) = error(sphere(16, 8));
    let (turned, _) = error(inside_out(sphere(16, 8)));
    assert_eq!(outside, turned);
    let mut wound = sphere(16, 8);
    wound.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    let (wound, _) = error(wound);
    assert!((wound - outside).abs() < 1e-3, "{wound} {outside}");
}
