//! Harness of the tests: scenes that are ready to render, and functions to render and compare them.

use std::sync::Arc;

use halflight::bvh::Bvh;
use halflight::config::PipelineConfig;
use halflight::glam::{DQuat, DVec3, Vec2, Vec3};
use halflight::light::AreaLight;
use halflight::pipeline::{Image, Pipeline, PipelineBuilder};
use halflight::prepared::PreparedScene;
use halflight::scene::{Camera, Material, Mesh, Scene};

/// Programs of a document, which run as tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/using-from-rust.md")]
pub struct UsingFromRust;

/// Error while a test is set up.
pub type SetupError = Box<dyn std::error::Error>;

/// A scene with its BVH.
#[derive(Clone)]
pub struct Stage {
    /// The scene.
    pub scene: Arc<Scene>,
    /// BVH over its mesh.
    pub bvh: Arc<Bvh>,
    /// Both together.
    pub prepared: PreparedScene,
}

impl Stage {
    /// Builds the BVH of a scene.
    ///
    /// # Errors
    /// An error if the mesh is invalid.
    pub fn new(scene: Scene) -> Result<Self, SetupError> {
        let prepared = PreparedScene::new(scene)?;
        Ok(Self { scene: Arc::new(prepared.scene().clone()), bvh: Arc::clone(prepared.bvh()), prepared })
    }

    /// A bundled scene.
    ///
    /// # Errors
    /// An error if there is no scene of this name.
    pub fn bundled(name: &str) -> Result<Self, SetupError> {
        Self::new(halflight::scene_file::load_bundled(name)?.scene)
    }

    /// A pipeline builder for the scene.
    pub fn builder(&self) -> PipelineBuilder {
        Pipeline::builder(&self.prepared)
    }

    /// Renders one frame of a configuration.
    ///
    /// # Errors
    /// An error if the pipeline cannot be built.
    pub fn render(&self, config: &PipelineConfig) -> Result<Image, SetupError> {
        let mut pipeline = config.builder(&self.prepared).build()?;
        Ok(pipeline.render()?.clone())
    }
}

/// A mesh of separate quadrilaterals, each given by a corner and two edges.
pub fn quads(list: &[(Vec3, Vec3, Vec3)]) -> Mesh {
    let mut mesh = Mesh { materials: vec![Material::default()], ..Mesh::default() };
    for &(corner, u, v) in list {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([corner, corner + u, corner + u + v, corner + v]);
        mesh.normals.extend([u.cross(v).normalize_or_zero(); 4]);
        mesh.uvs.extend([Vec2::ZERO; 4]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.material_ids.extend([0, 0]);
    }
    mesh
}

/// Floor of 20 × 20 m with a blocker of 1 × 1 m a metre above it, under a square light, seen from the side:
/// umbra, penumbra and open floor, and background above the horizon.
pub fn blocker_over_floor() -> Scene {
    Scene {
        mesh: Arc::new(quads(&[
            (Vec3::new(-10.0, 0.0, -10.0), Vec3::Z * 20.0, Vec3::X * 20.0),
            (Vec3::new(-0.5, 1.0, -0.5), Vec3::Z, Vec3::X),
        ])),
        lights: vec![square_light(Vec3::new(0.0, 4.0, 0.0), 1.0)],
        camera: Camera {
            eye: Vec3::new(0.5, 3.0, 5.0),
            target: Vec3::new(0.0, 0.2, 0.0),
            up: Vec3::Y,
            fov_y_deg: 50.0,
            ..Camera::default()
        },
        ..Scene::default()
    }
}

/// Square light that faces down, centred at a point.
pub fn square_light(centre: Vec3, side: f32) -> AreaLight {
    let corner = centre - Vec3::new(side, 0.0, side) * 0.5;
    AreaLight::parallelogram(corner, Vec3::X * side, Vec3::Z * side, Vec3::new(10.0, 9.0, 8.0))
}

/// Floor below a lamp of 1 × 1 m that is flush with a surface or hangs above one.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Rotation about the world's origin, applied before the shift.
    pub turn: DQuat,
    /// Translation, metres.
    pub shift: DVec3,
    /// Height of the lamp above the floor, metres.
    pub height: f64,
    /// Side of the square surface at the lamp, metres.
    pub cover: f64,
    /// Distance of that surface below the lamp, metres.
    pub gap: f64,
    /// True if the lamp also emits upwards.
    pub two_sided: bool,
}

impl Default for Room {
    fn default() -> Self {
        Self {
            turn: DQuat::IDENTITY,
            shift: DVec3::ZERO,
            height: 2.5,
            cover: 8.0,
            gap: 0.0,
            two_sided: false,
        }
    }
}

impl Room {
    /// Builds the scene: the floor, triangles 0 and 1, and the surface, 2 and 3, whose corners are rounded
    /// independently of the lamp's.
    pub fn scene(&self) -> Scene {
        let place = |p: DVec3| self.turn * p + self.shift;
        let rounded = |p: DVec3| (place(p) * 100.0).as_vec3() * 0.01;
        let square = |y: f64, half: f64| {
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
                .map(|(x, z)| DVec3::new(x * half, y, z * half))
        };
        let mut mesh = quads(&[(Vec3::ZERO, Vec3::X, Vec3::Z), (Vec3::ZERO, Vec3::X, Vec3::Z)]);
        let corners = square(0.0, 4.0).into_iter().chain(square(self.height - self.gap, self.cover * 0.5));
        mesh.positions = corners.map(rounded).collect();
        mesh.normals.clear();
        let [corner, u, v] = [DVec3::new(-0.5, self.height, -0.5), DVec3::X, DVec3::Z];
        let (corner, [u, v]) = (place(corner).as_vec3(), [u, v].map(|edge| (self.turn * edge).as_vec3()));
        let light = AreaLight::parallelogram(corner, u, v, Vec3::splat(10.0));
        let light = AreaLight { two_sided: self.two_sided, ..light };
        let camera = Camera {
            eye: place(DVec3::new(0.0, 1.6, 3.6)).as_vec3(),
            target: place(DVec3::new(0.0, 0.0, 0.5)).as_vec3(),
            up: (self.turn * DVec3::Y).as_vec3(),
            fov_y_deg: 40.0,
            ..Camera::default()
        };
        Scene { mesh: Arc::new(mesh), lights: vec![light], camera, ..Scene::default() }
    }
}

/// Squared error `SSE / Σ reference²` of the irradiance of two images of one size.
pub fn nmse2(image: &Image, reference: &Image) -> f64 {
    nmse2_of(&image.irradiance, &reference.irradiance)
}

/// Squared error `SSE / Σ reference²` over pixels of linear RGB.
pub fn nmse2_of(image: &[Vec3], reference: &[Vec3]) -> f64 {
    let (mut error, mut energy) = (0.0, 0.0);
    for (a, b) in image.iter().zip(reference) {
        error += f64::from((*a - *b).length_squared());
        energy += f64::from(b.length_squared());
    }
    error / energy
}

/// True if the open segment between two points meets a triangle, in double precision (Möller and Trumbore 1997).
pub fn hides(mesh: &Mesh, from: DVec3, to: DVec3) -> bool {
    let d = to - from;
    (0..mesh.triangle_count()).any(|triangle| {
        let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
        let (u, v) = (b - a, c - a);
        let across = d.cross(v);
        let determinant = u.dot(across);
        let offset = from - a;
        let (s, turned) = (offset.dot(across) / determinant, offset.cross(u));
        let (t, at) = (d.dot(turned) / determinant, v.dot(turned) / determinant);
        s >= 0.0 && t >= 0.0 && s + t <= 1.0 && at > 0.0 && at < 1.0
    })
}
