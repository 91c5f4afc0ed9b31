//! What shaders can bind: each buffer has one number, one name and one type in all of them.

/// A slot a line, with its name and type in shaders.
macro_rules! slots {
    ($(#[doc = $doc:literal] $slot:ident: $name:ident = $kind:literal,)+) => {
        /// Something that a shader binds. All bindings are in group 0, where binding 0 is the uniform `frame`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub(crate) enum Slot {
            $(#[doc = $doc] $slot),+
        }

        impl Slot {
            const ALL: &[Self] = &[$(Self::$slot),+];

            /// Its name and type in shaders.
            fn wgsl(self) -> (&'static str, &'static str) {
                match self {
                    $(Self::$slot => (stringify!($name), $kind)),+
                }
            }
        }
    };
}

slots! {
    /// Nodes of the BVH, five vectors each.
    Nodes: nodes = "array<vec4<u32>>",
    /// Corners of triangles, three vectors each, with the unit normal in the fourth components.
    Triangles: triangles = "array<vec4<f32>>",
    /// A triangle's number in the mesh, and its material.
    Faces: faces = "array<vec2<u32>>",
    /// Albedos and textures.
    Materials: materials = "array<Material>",
    /// Texture coordinates, three a triangle.
    Uvs: uvs = "array<vec2<f32>>",
    /// Linear values of the 256 values of a channel, then all textures, texel by texel, red in the lowest byte.
    Textures: textures = "array<u32>",
    /// Triangles that pixels see, by their place among [`Slot::Triangles`].
    Ids: ids = "texture_2d<u32>",
    /// Points and depths.
    Position: position = "array<vec4<f32>>",
    /// Normals and triangles' numbers in the mesh.
    Normal: normal = "array<vec4<u32>>",
    /// Albedos.
    Albedo: albedo = "array<vec4<f32>>",
    /// Questions to the visibility backend.
    Queries: queries = "array<Query>",
    /// Masks of samples that are asked for.
    Wanted: wanted = "array<u32>",
    /// Masks of samples that are seen.
    Visible: visible = "array<u32>",
    /// The same, to take from side by side.
    Seen: seen = "array<atomic<u32>>",
    /// What is counted.
    Counters: counters = "array<atomic<u32>>",
    /// Sizes of dispatches.
    Arguments: arguments = "array<u32>",
    /// Values, one a cell, level by level.
    Samples: samples = "array<Sample>",
    /// One value a pixel.
    Plane: plane = "array<f32>",
    /// The image.
    Image: image = "array<vec4<f32>>",
    /// Where geometry has discontinuities.
    Pyramid: pyramid = "array<atomic<u32>>",
    /// What is known of cells, level by level.
    Cells: cells = "array<Cell>",
    /// The level of the cell that each pixel lies in.
    Owners: owners = "array<u32>",
    /// Mask bits taken over from coarser cells.
    Reused: reused = "array<vec2<u32>>",
    /// Values between cells, level by level.
    Texels: texels = "array<Texel>",
    /// How far samples stand for one surface.
    Trusts: trusts = "array<f32>",
    /// What parts neighbouring pixels, level by level.
    Discontinuities: discontinuities = "array<u32>",
    /// Visible fractions of pixels, and their noise.
    Fractions: fractions = "array<vec2<u32>>",
    /// What an error target takes.
    Chosen: chosen = "array<Choice>",
    /// Sums over tiles.
    Sums: tile_sums = "array<f32>",
    /// Queries that are left to rays, behind their number.
    Spilled: spilled = "array<atomic<u32>>",
    /// Triangles and receivers by cell, to fill.
    Bins: bins = "array<atomic<u32>>",
    /// The same, to look into.
    BinsRead: bins_read = "array<u32>",
    /// Where triangles are projected to.
    Rectangles: rectangles = "array<vec4<f32>>",
    /// What voxels cover.
    Space: space = "Space",
    /// Voxels, to set.
    Voxels: voxels = "array<atomic<u32>>",
    /// The same, to look into.
    Grid: grid = "array<u32>",
    /// Triangles that cover many texels of voxels, behind their number.
    Large: large = "array<atomic<u32>>",
    /// The caller's points or depths.
    GivenPoint: given_point = "texture_2d<f32>",
    /// The caller's normals.
    GivenNormal: given_normal = "texture_2d<f32>",
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
        self as u32 + 1
    }

    /// The one of a name in shaders.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|slot| slot.wgsl().0 == name)
    }

    /// Whether it is a texture; all others are storage buffers.
    pub(crate) fn is_texture(self) -> bool {
        matches!(self, Self::Ids | Self::GivenPoint | Self::GivenNormal)
    }

    /// Its declaration in a shader.
    pub(crate) fn declaration(self, access: Access) -> String {
        let (name, kind) = self.wgsl();
        let binding = self.binding();
        let space = match access {
            _ if self.is_texture() => "",
            Access::Read => "<storage, read>",
            Access::Write => "<storage, read_write>",
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
