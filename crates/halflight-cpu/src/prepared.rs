//! Scenes with the BVH over their triangles.

use std::sync::Arc;

use halflight_core::scene::Scene;

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

    /// Returns another state of the scene: other lights, another camera, or the same triangles with vertices that have moved. A
    /// mesh that is shared with the scene keeps its BVH; over one that has moved the BVH is refitted, or built anew where
    /// triangles have moved far against each other ([`Bvh::follow`]).
    ///
    /// # Errors
    /// The mesh does not validate or has another number of triangles.
    pub fn moved(&self, scene: Scene) -> Result<Self, BvhError> {
        let bvh = if Arc::ptr_eq(&scene.mesh, &self.scene.mesh) {
            Arc::clone(&self.bvh)
        } else {
            Arc::new(self.bvh.follow(&scene.mesh)?)
        };
        Ok(Self { scene, bvh })
    }
}
