//! Slots: everything that a shader can bind, with one number, one name and one type in all shaders.

/// Declares one slot a line: name and type in shaders, and what errors call its memory.
macro_rules! slots {
    ($(#[doc = $doc:literal] $slot:ident: $name:ident = $kind:literal, $label:literal;)+) => {
        /// Resource that a shader binds. All bindings are in group 0, where binding 0 is the uniform `frame`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub(crate) enum Slot {
            $(#[doc = $doc] $slot),+
        }

        impl Slot {
            /// All slots, in the order of their bindings.
            pub(crate) const ALL: &[Self] = &[$(Self::$slot),+];

            /// Returns the name of the memory in errors and captures.
            pub(crate) fn label(self) -> &'static str {
                match self {
                    $(Self::$slot => $label),+
                }
            }

            /// Returns the name and type in shaders.
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
    Nodes: nodes = "array<vec4<u32>>", "BVH";
    /// Corners of triangles, three vectors each, with the unit normal in the fourth components.
    Triangles: triangles = "array<vec4<f32>>", "triangles";
    /// Shading normals of the corners of triangles, three vectors each, zero for flat ones; nothing in scenes without smooth surfaces.
    CornerNormals: corner_normals = "array<vec4<f32>>", "shading normals of corners";
    /// Number in the mesh and material of each triangle.
    Faces: faces = "array<vec2<u32>>", "triangle numbers";
    /// Albedos and textures.
    Materials: materials = "array<Material>", "materials";
    /// Texture coordinates, three a triangle.
    Uvs: uvs = "array<vec2<f32>>", "texture coordinates";
    /// Linear values of the 256 values of a channel, then all textures, texel by texel, red in the lowest byte.
    Textures: textures = "array<u32>", "textures";
    /// Triangles that pixels see, by their place in [`Slot::Triangles`].
    Ids: ids = "texture_2d<u32>", "visible triangles";
    /// Points and depths.
    Position: position = "array<vec4<f32>>", "points";
    /// Normals and triangles' numbers in the mesh; then shading normals, in scenes with smooth surfaces.
    Normal: normal = "array<vec4<u32>>", "normals";
    /// Albedos.
    Albedo: albedo = "array<vec4<f32>>", "albedos";
    /// Queries to the visibility backend.
    Queries: queries = "array<Query>", "queries";
    /// Masks of the samples that queries ask for.
    Wanted: wanted = "array<u32>", "wanted samples";
    /// Masks of the samples that receivers see.
    Visible: visible = "array<u32>", "visible samples";
    /// [`Slot::Visible`] as atomics, to clear single bits.
    Seen: seen = "array<atomic<u32>>", "visible samples";
    /// Counters and tallies of a frame.
    Counters: counters = "array<atomic<u32>>", "counters";
    /// Arguments of indirect dispatches.
    Arguments: arguments = "array<u32>", "indirect arguments";
    /// Values, one a cell, level by level.
    Samples: samples = "array<Sample>", "samples";
    /// One value a pixel: irradiance per radiance, or the visible fraction.
    Plane: plane = "array<f32>", "values of pixels";
    /// Irradiance of the image.
    Image: image = "array<vec4<f32>>", "image";
    /// Largest geometry discontinuities of cells, level by level.
    Pyramid: pyramid = "array<atomic<u32>>", "pyramid";
    /// State of cells, level by level.
    Cells: cells = "array<Cell>", "cells";
    /// Level of the cell that each pixel lies in.
    Owners: owners = "array<u32>", "cells of pixels";
    /// Mask bits taken over from coarser cells.
    Reused: reused = "array<vec2<u32>>", "samples taken over";
    /// Values between cells, level by level.
    Texels: texels = "array<Texel>", "values between cells";
    /// Weights of samples by how far they stand for one surface.
    Trusts: trusts = "array<f32>", "surfaces of samples";
    /// Discontinuities between neighbouring pixels and cells, level by level.
    Discontinuities: discontinuities = "array<u32>", "discontinuities";
    /// Visible fractions of pixels, and their noise.
    Fractions: fractions = "array<vec2<u32>>", "visible fractions";
    /// Sampling plan that an error target has chosen.
    Chosen: chosen = "array<Choice>", "choices";
    /// Sums over tiles of 8 × 8 pixels.
    Sums: tile_sums = "array<f32>", "sums over tiles";
    /// Queries that are left to rays, behind their number.
    Spilled: spilled = "array<atomic<u32>>", "queries left to rays";
    /// Triangles and receivers by cell, to write.
    Bins: bins = "array<atomic<u32>>", "triangles and receivers by cell";
    /// [`Slot::Bins`], to read.
    BinsRead: bins_read = "array<u32>", "triangles and receivers by cell";
    /// Rectangles of projected triangles.
    Rectangles: rectangles = "array<vec4<f32>>", "projected triangles";
    /// Coordinates of the space that voxels cover.
    Space: space = "Space", "space of voxels";
    /// Voxels, to write.
    Voxels: voxels = "array<atomic<u32>>", "voxels";
    /// [`Slot::Voxels`], to read.
    Grid: grid = "array<u32>", "voxels";
    /// Triangles that cover many texels of voxels, behind their number.
    Large: large = "array<atomic<u32>>", "large triangles";
    /// Textured lights: means over cells of their area, then emission of the strata of light samples.
    Emitted: emitted = "array<vec4<f32>>", "textured lights";
    /// Visible fractions of red, green and blue, one a cell, level by level, 1 in the fourth component where there is one; then the same, smoothed.
    Channels: channels = "array<vec4<f32>>", "samples by channel";
    /// Values of [`Slot::Plane`] of red, green and blue, one channel after another.
    Planes: planes = "array<f32>", "values of pixels by channel";
    /// Specular part of materials; nothing in scenes without glossy surfaces.
    Glosses: glosses = "array<Gloss>", "glossy materials";
    /// Specular reflection of surfaces: reflectance at normal incidence, and roughness.
    Gloss: gloss = "array<vec4<f32>>", "glossy surfaces";
    /// Specularly reflected radiance of the image.
    Specular: specular = "array<vec4<f32>>", "specular radiance";
    /// The caller's points or depths.
    GivenPoint: given_point = "texture_2d<f32>", "the caller's points";
    /// The caller's normals.
    GivenNormal: given_normal = "texture_2d<f32>", "the caller's normals";
    /// Triangles with alpha masks: where they begin, and their texture coordinates.
    Masked: masked = "Masked", "triangles with alpha masks";
    /// Texels of alpha masks, one bit each.
    Solid: solid = "array<u32>", "alpha masks";
    /// Radiance of the nearest light that each pixel sees, and its distance along the view direction.
    Emission: emission = "array<vec4<f32>>", "visible lights";
}

/// Use that a shader makes of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    /// Reads.
    Read,
    /// Reads and writes.
    Write,
}

impl Slot {
    /// Slot whose memory this one binds: itself, but for slots that bind another's memory with another type.
    pub(crate) fn memory(self) -> Self {
        match self {
            Self::Seen => Self::Visible,
            Self::BinsRead => Self::Bins,
            Self::Grid => Self::Voxels,
            own => own,
        }
    }

    /// Number of the binding.
    pub(crate) fn binding(self) -> u32 {
        self as u32 + 1
    }

    /// Finds the slot of a name in shaders.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|slot| slot.wgsl().0 == name)
    }

    /// Returns true for textures; all others are storage buffers.
    pub(crate) fn is_texture(self) -> bool {
        matches!(self, Self::Ids | Self::GivenPoint | Self::GivenNormal)
    }

    /// Returns the declaration in a shader.
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

    /// Returns the entry in the layout of a program.
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
