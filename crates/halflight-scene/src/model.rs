//! Meshes in the coordinates of their files.

use glam::{DVec3, Vec2, Vec3};
use halflight_core::scene::{Material, Mesh};

use crate::emission::Emission;
use crate::faces::Faces;
use crate::polygon::triangulate;

/// Mesh in model space, with positions in double precision: survey files have coordinates that single
/// precision rounds to half a metre, and only the scene file's transform brings them near the origin.
#[derive(Clone, Default)]
pub(crate) struct ModelMesh {
    pub(crate) positions: Vec<DVec3>,
    /// Unit normals; zero where one is to be computed.
    pub(crate) normals: Vec<Vec3>,
    pub(crate) uvs: Vec<Vec2>,
    /// Corners as vertex indices. Faces are triangulated in world space, so that no rounding flips one.
    pub(crate) faces: Faces<u32>,
    /// First face and material of each run; material 0 before the first run.
    pub(crate) runs: Vec<(usize, u32)>,
    pub(crate) materials: Vec<Material>,
    /// Emission of each material; empty where none emits.
    pub(crate) emission: Vec<Option<Emission>>,
}

impl ModelMesh {
    /// Material of each face; faces must be queried in order.
    pub(crate) fn material_of(&self) -> impl FnMut(usize) -> u32 {
        let mut runs = self.runs.iter().peekable();
        let mut current = 0;
        move |face| {
            while let Some(&(_, material)) = runs.next_if(|(start, _)| *start <= face) {
                current = material;
            }
            current
        }
    }

    /// Removes faces with a position that is not finite. Returns their number, and the first such vertex.
    pub(crate) fn drop_faces_that_are_not_finite(&mut self) -> Option<(usize, u32)> {
        if self.positions.iter().all(|position| position.is_finite()) {
            return None;
        }
        let mut dropped = None;
        let mut faces = Faces::default();
        let mut runs: Vec<(usize, u32)> = Vec::new();
        let mut material = self.material_of();
        for (number, corners) in self.faces.iter().enumerate() {
            let bad = corners.iter().find(|&&vertex| !self.positions[vertex as usize].is_finite());
            if let Some(&vertex) = bad {
                dropped.get_or_insert((0, vertex)).0 += 1;
                continue;
            }
            let material = material(number);
            if runs.last().is_none_or(|&(_, last)| last != material) {
                runs.push((faces.count(), material));
            }
            faces.push(corners);
        }
        drop(material);
        self.faces = faces;
        self.runs = runs;
        dropped
    }

    /// Replaces texture coordinates that are not finite by zero, so that texture lookups are safe. Returns
    /// true if a textured face used one of them.
    pub(crate) fn replace_uvs_that_are_not_finite(&mut self) -> bool {
        if self.uvs.iter().all(|uv| uv.is_finite()) {
            return false;
        }
        let mut material = self.material_of();
        let used = self.faces.iter().enumerate().any(|(number, corners)| {
            let material = &self.materials[material(number) as usize];
            (material.texture.is_some() || material.alpha_mask.is_some())
                && corners.iter().any(|&vertex| !self.uvs[vertex as usize].is_finite())
        });
        drop(material);
        for uv in self.uvs.iter_mut().filter(|uv| !uv.is_finite()) {
            *uv = Vec2::ZERO;
        }
        used
    }

    /// Triangles of the mesh, with `positions` instead of its own.
    pub(crate) fn into_mesh(self, positions: Vec<Vec3>) -> Mesh {
        let mut triangles = Vec::with_capacity(self.faces.triangles());
        let mut material_ids = Vec::with_capacity(self.faces.triangles());
        let mut material = self.material_of();
        for (number, corners) in self.faces.iter().enumerate() {
            triangulate(corners, &positions, &mut triangles);
            material_ids.resize(triangles.len(), material(number));
        }
        drop(material);
        Mesh {
            positions,
            normals: self.normals,
            uvs: self.uvs,
            triangles,
            material_ids,
            materials: self.materials,
            ..Mesh::default()
        }
    }
}
