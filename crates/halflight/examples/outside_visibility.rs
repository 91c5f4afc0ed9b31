//! A visibility backend from outside on the GPU: shadows of spheres that are equations, not triangles.
//!
//! `cargo run -p halflight --features gpu --example outside_visibility [PICTURE.png]` renders balls on a floor. What is seen is a
//! coarse mesh; what casts shadows are the spheres themselves, in one WGSL function.

use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use halflight::config::PipelineConfig;
use halflight::glam::{Vec2, Vec3};
use halflight::gpu::{Gpu, Inputs, Renderer};
use halflight::light::AreaLight;
use halflight::metrics;
use halflight::scene::{Camera, Material, Mesh, Scene};

/// Centres and radii, metres.
const BALLS: [(Vec3, f32); 4] = [
    (Vec3::new(-1.1, 0.7, 0.0), 0.7),
    (Vec3::new(0.5, 0.5, 0.6), 0.5),
    (Vec3::new(0.9, 0.9, -1.0), 0.9),
    (Vec3::new(0.3, 1.5, 0.2), 0.2),
];

/// The module: whether the open segment between two points enters one of the balls. One that starts inside is on its way out:
/// that is where the mesh lies.
fn module() -> Result<String, std::fmt::Error> {
    let mut text = String::from(
        "
fn enters(ball: vec4<f32>, origin: vec3<f32>, end: vec3<f32>) -> bool {
    let d = end - origin;
    let away = origin - ball.xyz;
    let nearest = away + d * clamp(-dot3(away, d) / dot3(d, d), 0.0, 1.0);
    return dot3(away, away) > ball.w * ball.w && dot3(nearest, nearest) < ball.w * ball.w;
}

fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool {
    return false",
    );
    for (centre, radius) in BALLS {
        let Vec3 { x, y, z } = centre;
        write!(text, "\n        || enters(vec4({x:?}, {y:?}, {z:?}, {radius:?}), origin, end)")?;
    }
    text.push_str(";\n}\n");
    Ok(text)
}

/// A floor, and balls made of cubes' faces.
fn mesh() -> Mesh {
    let mut mesh = Mesh { materials: vec![Material::default()], ..Mesh::default() };
    let mut patch = |cells: u32, point: &dyn Fn(Vec2) -> Vec3| {
        let first = mesh.positions.len() as u32;
        for row in 0..=cells {
            let at = |column| point(Vec2::new(column as f32, row as f32) / cells as f32 * 2.0 - 1.0);
            mesh.positions.extend((0..=cells).map(at));
        }
        for cell in 0..cells * cells {
            let corner = first + cell / cells * (cells + 1) + cell % cells;
            let below = corner + cells + 1;
            mesh.triangles.extend([[corner, below, corner + 1], [corner + 1, below, below + 1]]);
        }
    };
    patch(1, &|at| Vec3::new(at.x, 0.0, at.y) * 4.0);
    for (centre, radius) in BALLS {
        for face in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
            let (u, v) = face.any_orthonormal_pair();
            patch(12, &|at| centre + radius * (face + u * at.x + v * at.y).normalize());
        }
    }
    mesh.normals = vec![Vec3::Y; mesh.positions.len()];
    mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    mesh.material_ids = vec![0; mesh.triangles.len()];
    mesh
}

fn main() -> Result<(), Box<dyn Error>> {
    let picture = std::env::args_os().nth(1).map_or_else(|| "outside_visibility.png".into(), PathBuf::from);
    let corner = Vec3::new(1.0, 4.0, 0.5);
    let scene = Scene {
        mesh: Arc::new(mesh()),
        lights: vec![AreaLight::parallelogram(corner, Vec3::X * 1.5, Vec3::Z * 1.5, Vec3::splat(12.0))],
        camera: Camera { eye: Vec3::new(0.0, 3.0, 5.0), target: Vec3::Y * 0.5, ..Camera::default() },
        ..Scene::default()
    };
    let config = PipelineConfig { width: 960, height: 640, ..PipelineConfig::default() };
    let gpu = Gpu::find()?;
    let mut renderer = Renderer::with_visibility(&gpu.device, &gpu.queue, &scene, &config, &module()?)?;
    let stats = gpu.render(&mut renderer, &Inputs::default())?;
    let (image, gbuffer) = gpu.download(&renderer)?;
    let lit: Vec<Vec3> = image.irradiance.iter().zip(&gbuffer.albedo).map(|(e, albedo)| e * albedo).collect();
    metrics::write_png(&picture, image.width, image.height, &metrics::tone_map(&lit, 0.3))?;
    let rays = stats.frame.rays.refine + stats.frame.rays.last;
    println!("{rays} rays for {} pixels: {}", lit.len(), picture.display());
    Ok(())
}
