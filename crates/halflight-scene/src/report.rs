//! Report of loading a scene's meshes.

use std::path::PathBuf;

/// Report of loading a scene's meshes, one entry per `[[mesh]]` in the order of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// Entries, one per mesh.
    pub meshes: Vec<MeshReport>,
    /// Files of material libraries and textures that were looked for, in the order of their paths.
    pub files: Vec<PathBuf>,
    /// Warnings about content that is not supported or had to be guessed; each occurs once.
    pub warnings: Vec<String>,
}

/// Report of loading one mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshReport {
    /// File or generator of the mesh.
    pub source: String,
    /// Number of triangles in the scene.
    pub triangles: usize,
    /// Number of triangles without an area, which were dropped.
    pub zero_area_dropped: usize,
    /// Number of vertices whose missing shading normal was computed.
    pub normals_computed: usize,
    /// Number of lights of its emissive faces.
    pub lights: usize,
}

impl LoadReport {
    /// Number of triangles in the scene.
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles).sum()
    }

    /// Number of triangles without an area, which were dropped.
    pub fn zero_area_dropped(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.zero_area_dropped).sum()
    }

    /// Number of vertices whose shading normal was computed.
    pub fn normals_computed(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.normals_computed).sum()
    }
}
