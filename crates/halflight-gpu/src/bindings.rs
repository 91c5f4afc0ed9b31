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
    /// All textures, texel by texel.
    Textures,
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
    /// Where geometry breaks.
    Pyramid,
    /// What is known of cells, level by level.
    Cells,
    /// The level of the cell that each pixel lies in.
    Owners,
    /// Mask bits taken over from coarser cells.
    Reused,
    /// Values between cells, level by level.
    Texels,
    /// How far samples stand for one surface.
    Trusts,
    /// What parts neighbouring pixels, level by level.
    Breaks,
    /// Visible fractions of pixels.
    Fractions,
    /// Queries that are left to rays, behind their number.
    Spilled,
    /// The caller's points or depths, and normals.
    GivenPoint,
    GivenNormal,
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
            Self::Textures => ("textures", "array<vec4<f32>>"),
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
            Self::Pyramid => ("pyramid", "array<atomic<u32>>"),
            Self::Cells => ("cells", "array<Cell>"),
            Self::Owners => ("owners", "array<u32>"),
            Self::Reused => ("reused", "array<vec2<u32>>"),
            Self::Texels => ("texels", "array<Texel>"),
            Self::Trusts => ("trusts", "array<f32>"),
            Self::Breaks => ("breaks", "array<u32>"),
            Self::Fractions => ("fractions", "array<u32>"),
            Self::Spilled => ("spilled", "array<atomic<u32>>"),
            Self::GivenPoint => ("given_point", "texture_2d<f32>"),
            Self::GivenNormal => ("given_normal", "texture_2d<f32>"),
        }
    }

    /// Its declaration in a shader.
    pub(crate) fn declaration(self, access: Access) -> String {
        let (name, kind) = self.wgsl();
        let binding = self.binding();
        let space = match (self, access) {
            (Self::Ids | Self::GivenPoint | Self::GivenNormal, _) => "",
            (_, Access::Read) => "<storage, read>",
            (_, Access::Write) => "<storage, read_write>",
        };
        format!("@group(0) @binding({binding}) var{space} {name}: {kind};\n")
    }

    /// Its entry in the layout of a stage.
    pub(crate) fn layout(self, access: Access, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let ty = match self {
            Self::Ids => texture(wgpu::TextureSampleType::Uint),
            Self::GivenPoint | Self::GivenNormal => {
                texture(wgpu::TextureSampleType::Float { filterable: false })
            }
            _ => wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: access == Access::Read },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
        };
        wgpu::BindGroupLayoutEntry { binding: self.binding(), visibility, ty, count: None }
    }
}
