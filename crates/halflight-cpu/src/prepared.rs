//! Scenes with the BVH over their triangles.

use std::sync::Arc;

use halflight_core::scene::{Mesh, Scene};

use crate::bvh::{Bvh, BvhError};

/// A scene and the BVH over its triangles, which cannot disagree.
///
/// Geometry is shared: a clone, other lights and another camera copy and build nothing that grows with the mesh.
#[derive(Clone, Debug)]
pub struct PreparedScene {
    scene: Scene,
    bvh: Arc<Bvh>,
    rest: Arc<Mesh>,
}

impl PreparedScene {
    /// Builds the BVH of a scene.
    ///
    /// # Errors
    /// The mesh does not validate. Lights and camera are checked where a pipeline is built.
    pub fn new(scene: Scene) -> Result<Self, BvhError> {
        let bvh = Arc::new(Bvh::build(&scene.mesh)?);
        let rest = Arc::clone(&scene.mesh);
        Ok(Self { scene, bvh, rest })
    }

    /// Takes a BVH that has been built or refitted already.
    ///
    /// # Errors
    /// The mesh does not validate, or the BVH is not over it as it is: its number of triangles or their corners differ.
    pub fn with_bvh(scene: Scene, bvh: Arc<Bvh>) -> Result<Self, BvhError> {
        scene.mesh.validate()?;
        let rest = Arc::clone(&scene.mesh);
        if bvh.is_over(&scene.mesh) { Ok(Self { scene, bvh, rest }) } else { Err(BvhError::Foreign) }
    }

    /// Geometry, lights and camera.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The mesh before its vertices moved: that of the scene that was prepared first. Indirect light places its points on it, so that they stay where
    /// they are on the triangles whatever frames came before.
    pub fn rest(&self) -> &Arc<Mesh> {
        &self.rest
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
        let (mesh, rest) = (&scene.mesh, &self.rest);
        let alike = Arc::ptr_eq(mesh, rest)
            || mesh.triangles == rest.triangles
                && mesh.material_ids == rest.material_ids
                && mesh.uvs == rest.uvs
                && mesh.alpha_masks == rest.alpha_masks;
        let rest = Arc::clone(if alike { rest } else { mesh });
        Ok(Self { scene, bvh, rest })
    }
}
