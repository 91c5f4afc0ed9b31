//! Scenes with the BVH over their triangles.

use std::sync::Arc;

use halflight_core::camera::Camera;
use halflight_core::light::AreaLight;
use halflight_core::scene::{Mesh, Scene};

use crate::bvh::{Bvh, BvhError};

/// A scene and the BVH over its triangles, which cannot disagree.
///
/// Geometry is shared: a clone, other lights and another camera copy and build nothing that grows with the mesh.
#[derive(Clone, Debug)]
pub struct PreparedScene {
    scene: Scene,
    bvh: Arc<Bvh>,
}

impl PreparedScene {
    /// Builds the BVH of a scene.
    ///
    /// # Errors
    /// The mesh does not validate. Lights and camera are checked where a pipeline is built.
    pub fn new(scene: Scene) -> Result<Self, BvhError> {
        let bvh = Arc::new(Bvh::build(&scene.mesh)?);
        Ok(Self { scene, bvh })
    }

    /// Takes a BVH that has been built or refitted already.
    ///
    /// # Errors
    /// The mesh does not validate, or the BVH is not over it as it is: its number of triangles or their corners differ.
    pub fn with_bvh(scene: Scene, bvh: Arc<Bvh>) -> Result<Self, BvhError> {
        scene.mesh.validate()?;
        if bvh.is_over(&scene.mesh) { Ok(Self { scene, bvh }) } else { Err(BvhError::Foreign) }
    }

    /// Geometry, lights and camera.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The BVH over the scene's triangles.
    pub fn bvh(&self) -> &Arc<Bvh> {
        &self.bvh
    }

    /// Replaces the lights.
    pub fn set_lights(&mut self, lights: Vec<AreaLight>) {
        self.scene.lights = lights;
    }

    /// Replaces the camera.
    pub fn set_camera(&mut self, camera: Camera) {
        self.scene.camera = camera;
    }

    /// Replaces the mesh by one with the same triangles, whose vertices have moved. The BVH is refitted, or built anew
    /// where triangles have moved far against each other ([`Bvh::follow`]).
    ///
    /// # Errors
    /// The mesh does not validate or has another number of triangles; nothing has changed then.
    pub fn move_mesh(&mut self, mesh: Arc<Mesh>) -> Result<(), BvhError> {
        self.bvh = Arc::new(self.bvh.follow(&mesh)?);
        self.scene.mesh = mesh;
        Ok(())
    }
}
