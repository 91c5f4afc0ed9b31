//! What loading a scene did to its meshes.

/// What loading a scene did to its meshes, one entry a `[[mesh]]` in the order of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// One entry a mesh.
    pub meshes: Vec<MeshReport>,
    /// What was found but is not supported or had to be guessed; each is said once.
    pub warnings: Vec<String>,
}

/// What loading one mesh did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshReport {
    /// The file or the generator it came from.
    pub source: String,
    /// Triangles that the scene holds.
    pub triangles: usize,
    /// Triangles without an area, which the scene does not hold.
    pub zero_area_dropped: usize,
    /// Vertices whose shading normal the file did not give and that was computed.
    pub normals_computed: usize,
}

impl LoadReport {
    /// Triangles that the scene holds.
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles).sum()
    }

    /// Triangles without an area, which the scene does not hold.
    pub fn zero_area_dropped(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.zero_area_dropped).sum()
    }

    /// Vertices whose shading normal was computed.
    pub fn normals_computed(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.normals_computed).sum()
    }
}
