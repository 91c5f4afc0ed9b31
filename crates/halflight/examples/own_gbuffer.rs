//! A G-buffer of one's own: surfaces of a distance function, shadows of a mesh.
//!
//! `cargo run --example own_gbuffer [PICTURE.png]` finds a ball on a floor by sphere tracing, hands points and normals to the
//! pipeline, and writes the picture. A rasterizer would hand over its depths instead ([`SurfacePoints::Depths`]).

use std::error::Error;
use std::f32::consts::FRAC_1_PI;
use std::path::PathBuf;
use std::sync::Arc;

use halflight::camera::{Camera, View};
use halflight::gbuffer::{GBuffer, SurfacePoints};
use halflight::glam::{DVec3, Vec2, Vec3};
use halflight::light::AreaLight;
use halflight::metrics;
use halflight::pipeline::Pipeline;
use halflight::prepared::PreparedScene;
use halflight::refine::{Lattice, LatticeConfig};
use halflight::scene::{Material, Mesh, Scene};

const SIZE: (u32, u32) = (480, 320);

/// Centre and radius of the ball, metres. It rests on the floor y = 0.
const CENTRE: DVec3 = DVec3::new(0.0, 1.0, 0.0);
const RADIUS: f64 = 1.0;

/// Distance from a point to the nearest surface, metres.
fn distance(point: DVec3) -> f64 {
    (point.distance(CENTRE) - RADIUS).min(point.y)
}

/// Returns the first surface point of a ray within 30 m. Shadow rays start by about 1e-6 m off their surface, so points must
/// be far more exact: double precision, and steps down to 1e-9 m.
fn march(origin: DVec3, direction: DVec3) -> Option<DVec3> {
    let (mut along, mut point) = (0.0, origin);
    for _ in 0..1000 {
        let step = distance(point);
        if step < 1e-9 {
            return Some(point);
        }
        along += step;
        if along > 30.0 {
            return None;
        }
        point = origin + direction * along;
    }
    None
}

/// Returns the unit normal at a surface point: the gradient of the distance, by central differences.
fn normal(point: DVec3) -> Vec3 {
    let slope = |axis: DVec3| distance(point + axis * 1e-5) - distance(point - axis * 1e-5);
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize_or_zero().as_vec3()
}

/// Returns the mesh that casts the shadows: the ball as six bent faces of a cube. Its triangles lie just inside of the ball, so
/// that they do not shade its lit side.
fn ball() -> Mesh {
    const CELLS: u32 = 32;
    let mut mesh = Mesh { materials: vec![Material::default()], ..Mesh::default() };
    for face in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
        let (u, v) = face.any_orthonormal_pair();
        let first = mesh.positions.len() as u32;
        for corner in 0..(CELLS + 1) * (CELLS + 1) {
            let at = |step: u32| f64::from(step) / f64::from(CELLS) * 2.0 - 1.0;
            let towards = face + u * at(corner % (CELLS + 1)) + v * at(corner / (CELLS + 1));
            mesh.positions.push((CENTRE + towards.normalize() * RADIUS * 0.9999).as_vec3());
        }
        for cell in 0..CELLS * CELLS {
            let corner = first + cell / CELLS * (CELLS + 1) + cell % CELLS;
            let below = corner + CELLS + 1;
            mesh.triangles.extend([[corner, below, corner + 1], [corner + 1, below, below + 1]]);
        }
    }
    // Needed by textures and shading only, of which there are none here.
    mesh.normals = vec![Vec3::Y; mesh.positions.len()];
    mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    mesh.material_ids = vec![0; mesh.triangles.len()];
    mesh
}

fn main() -> Result<(), Box<dyn Error>> {
    let picture = std::env::args_os().nth(1).map_or_else(|| "own_gbuffer.png".into(), PathBuf::from);
    let camera = Camera::look_at(Vec3::new(0.0, 2.5, 6.0), Vec3::new(0.3, 0.7, 0.0), Vec3::Y, 40.0);
    let light = AreaLight::parallelogram(
        Vec3::new(-3.5, 4.0, -0.5),
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::Z * 1.5,
        Vec3::splat(40.0),
    )
    .two_sided();
    let scene = Scene { mesh: Arc::new(ball()), lights: vec![light], camera, ..Scene::default() };
    let scene = PreparedScene::new(scene)?;

    // One point, normal and albedo a pixel; a normal of zero where nothing is seen.
    let view = View::new(&camera, SIZE.0, SIZE.1);
    let pixels = SIZE.0 as usize * SIZE.1 as usize;
    let (mut points, mut normals) = (vec![Vec3::ZERO; pixels], vec![Vec3::ZERO; pixels]);
    let mut albedo = vec![Vec3::ZERO; pixels];
    for pixel in 0..pixels {
        let (x, y) = (pixel % SIZE.0 as usize, pixel / SIZE.0 as usize);
        let direction = view.direction(x, y).as_dvec3().normalize();
        let Some(point) = march(view.eye.as_dvec3(), direction) else { continue };
        let dark = point.y < 1e-3 && (point.x.floor() + point.z.floor()).rem_euclid(2.0) < 1.0;
        (points[pixel], normals[pixel]) = (point.as_vec3(), normal(point));
        albedo[pixel] = Vec3::splat(if dark { 0.3 } else { 0.7 });
    }
    let gbuffer =
        GBuffer::from_surfaces(&camera, SIZE, SurfacePoints::Positions(&points), &normals, Some(&albedo))?;

    // A tenth of the default quality's error target: penumbras without noise that could be seen.
    let refiner = Lattice::new(LatticeConfig { target: 1e-5, ..LatticeConfig::default() });
    let mut pipeline = Pipeline::builder(&scene).size(SIZE.0, SIZE.1).refiner(refiner).build()?;
    let image = pipeline.render_gbuffer(&gbuffer)?;
    let radiance: Vec<Vec3> =
        image.irradiance.iter().zip(&albedo).map(|(light, albedo)| light * albedo * FRAC_1_PI).collect();
    metrics::write_png(&picture, SIZE.0, SIZE.1, &metrics::tone_map(&radiance, 1.0))?;
    println!("{} rays for {pixels} pixels: {}", image.stats.rays.total, picture.display());
    Ok(())
}
