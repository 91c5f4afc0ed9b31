//! What shaders can bind: each buffer has one number, one name and one type in all of them.

/// Something that a shader binds. The number is its binding in group 0; binding 0 is the uniform `frame`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub(crate) enum Slot {
    /// Nodes of the hierarchy, five vectors each.
    Nodes = 1,
    /// Corners of triangles, three vectors each, with the unit normal in the fourth components.
    Triangles,
    /// A triangle's number in the mesh, and its material.
    Faces,
    /// Albedos and textures.
    Materials,
    /// Texture coordinates, three a triangle.
    Uvs,
    /// All textures.
    Texels,
    /// Triangles that pixels see, by their place among [`Slot::Triangles`].
    Ids,
    /// Points and depths.
    Position,
    /// Normals and triangles' numbers in the mesh.
    Normal,
    /// Albedos.
    Albedo,
    /// Questions to the visibility backend.
    Queries,
    /// Masks of samples that are asked for.
    Wanted,
    /// Masks of samples that are seen.
    Visible,
    /// What is counted.
    Counters,
    /// Sizes of dispatches.
    Arguments,
    /// Values, one a cell, level by level.
    Samples,
    /// One value a pixel.
    Plane,
    /// The image.
    Image,
}

/// How a shader uses what it binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    /// Reads.
    Read,
    /// Reads and writes.
    Write,
}

impl Slot {
    /// Number of the binding.
    pub(crate) fn binding(self) -> u32 {
        self as u32
    }

    /// Its name and type in shaders.
    fn wgsl(self) -> (&'static str, &'static str) {
        match self {
            Self::Nodes => ("nodes", "array<vec4<u32>>"),
            Self::Triangles => ("triangles", "array<vec4<f32>>"),
            Self::Faces => ("faces", "array<vec2<u32>>"),
            Self::Materials => ("materials", "array<Material>"),
            Self::Uvs => ("uvs", "array<vec2<f32>>"),
            Self::Texels => ("texels", "array<vec4<f32>>"),
            Self::Ids => ("ids", "texture_2d<u32>"),
            Self::Position => ("position", "array<vec4<f32>>"),
            Self::Normal => ("normal", "array<vec4<u32>>"),
            Self::Albedo => ("albedo", "array<vec4<f32>>"),
            Self::Queries => ("queries", "array<Query>"),
            Self::Wanted => ("wanted", "array<u32>"),
            Self::Visible => ("visible", "array<u32>"),
            Self::Counters => ("counters", "array<atomic<u32>>"),
            Self::Arguments => ("arguments", "array<u32>"),
            Self::Samples => ("samples", "array<Sample>"),
            Self::Plane => ("plane", "array<f32>"),
            Self::Image => ("image", "array<vec4<f32>>"),
        }
    }

    /// Its declaration in a shader.
    pub(crate) fn declaration(self, access: Access) -> String {
        let (name, kind) = self.wgsl();
        let binding = self.binding();
        let space = match (self, access) {
            (Self::Ids, _) => "",
            (_, Access::Read) => "<storage, read>",
            (_, Access::Write) => "<storage, read_write>",
        };
        format!("@group(0) @binding({binding}) var{space} {name}: {kind};\n")
    }

    /// Its entry in the layout of a stage.
    pub(crate) fn layout(self, access: Access, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
        let ty = match self {
            Self::Ids => wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            _ => wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: access == Access::Read },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
        };
        wgpu::BindGroupLayoutEntry { binding: self.binding(), visibility, ty, count: None }
    }
}
