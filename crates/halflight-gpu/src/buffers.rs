//! The one place that says how large everything is that depends on the image.

use crate::GpuError;
use crate::bindings::Slot;
use crate::error::caught;
use crate::frame::{self, Frame};
use crate::refine::Choice;
use crate::scene::SceneBuffers;

/// Counters before the tallies, and buckets of each: `shaders/shared/counters.wgsl`.
pub(crate) const TALLY: usize = 16;
pub(crate) const BUCKETS: usize = 64;

/// Counters that hold the bits of floats: expected squared error, and the image's square.
pub(crate) const EXPECTED: usize = 5;
pub(crate) const ENERGY: usize = 6;

/// Kinds of tallies: rays to refine, for irradiance alone and skipped, samples of each level, cells of each level.
const TALLIES: usize = CELLS_PER_LEVEL + frame::LEVELS;
const _: () = assert!(SAMPLES_PER_LEVEL + frame::LEVELS == CELLS_PER_LEVEL);
pub(crate) const SAMPLES_PER_LEVEL: usize = 3;
pub(crate) const CELLS_PER_LEVEL: usize = 11;

/// Dispatches whose size the device knows.
const INDIRECT: u64 = 6;

/// Bytes of queries, samples and what is known of cells; all of a cell's are as many.
const RECORD: u64 = 16;

/// What an image of a size takes; in buffers that not every configuration needs, 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Uniforms.
    pub(crate) frames: u32,
    /// Most queries of one light.
    pub(crate) queries: u32,
    /// Words of their masks.
    pub(crate) words: u64,
    /// Places of samples.
    pub(crate) samples: u32,
    /// Cells of all levels.
    pub(crate) cells: u32,
    /// The same where the discontinuity pyramid has them.
    pub(crate) pyramid: u32,
    /// Words of masks that are taken over from coarser cells.
    pub(crate) reused: u64,
    /// Cells of all levels that hold values in between.
    pub(crate) texels: u32,
    /// Samples whose surface is judged.
    pub(crate) trusts: u32,
    /// Queries that may be left to rays.
    pub(crate) spilled: u32,
    /// Words of triangles and receivers by cell.
    pub(crate) bins: u64,
    /// Triangles that are projected, once a side of a light.
    pub(crate) rectangles: u64,
    /// Bytes of what voxels cover.
    pub(crate) space: u64,
    /// Words of voxels.
    pub(crate) voxels: u64,
    /// Triangles that may cover many texels.
    pub(crate) large: u64,
    /// Cells of all levels whose discontinuities are known.
    pub(crate) discontinuities: u32,
    /// Pixels whose visible fraction is known.
    pub(crate) fractions: u32,
    /// Choices of an error target.
    pub(crate) choices: u32,
    /// Tiles whose pixels are added up.
    pub(crate) tiles: u32,
}

/// Buffers and textures of a size.
#[derive(Debug)]
pub(crate) struct Buffers {
    pub(crate) size: Size,
    /// Bytes from one uniform to the next.
    pub(crate) frame_stride: u32,
    pub(crate) frames: wgpu::Buffer,
    pub(crate) ids: wgpu::TextureView,
    pub(crate) depth: wgpu::TextureView,
    pub(crate) position: wgpu::Buffer,
    pub(crate) normal: wgpu::Buffer,
    pub(crate) albedo: wgpu::Buffer,
    pub(crate) queries: wgpu::Buffer,
    pub(crate) wanted: wgpu::Buffer,
    pub(crate) visible: wgpu::Buffer,
    pub(crate) counters: wgpu::Buffer,
    pub(crate) arguments: wgpu::Buffer,
    pub(crate) samples: wgpu::Buffer,
    pub(crate) pyramid: wgpu::Buffer,
    pub(crate) cells: wgpu::Buffer,
    pub(crate) owners: wgpu::Buffer,
    pub(crate) reused: wgpu::Buffer,
    pub(crate) texels: wgpu::Buffer,
    pub(crate) trusts: wgpu::Buffer,
    pub(crate) spilled: wgpu::Buffer,
    pub(crate) bins: wgpu::Buffer,
    pub(crate) rectangles: wgpu::Buffer,
    pub(crate) space: wgpu::Buffer,
    pub(crate) voxels: wgpu::Buffer,
    pub(crate) large: wgpu::Buffer,
    pub(crate) discontinuities: wgpu::Buffer,
    pub(crate) fractions: wgpu::Buffer,
    pub(crate) chosen: wgpu::Buffer,
    pub(crate) sums: wgpu::Buffer,
    pub(crate) plane: wgpu::Buffer,
    pub(crate) image: wgpu::Buffer,
    scene: SceneBuffers,
}

/// Checks that a buffer of this many bytes can be bound.
///
/// # Errors
/// It cannot, with `advice`.
pub(crate) fn check_size(
    limits: &wgpu::Limits,
    what: &'static str,
    needed: u64,
    advice: &'static str,
) -> Result<(), GpuError> {
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if needed > limit {
        Err(GpuError::TooLarge { what, needed, unit: "bytes", limit, advice })
    } else {
        Ok(())
    }
}

/// A buffer that holds something. Nothing panics where the device gives none.
///
/// # Errors
/// The device is full or lost.
pub(crate) fn filled(
    device: &wgpu::Device,
    what: &'static str,
    bytes: &[u8],
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, GpuError> {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(what),
        size: bytes.len() as u64,
        usage,
        mapped_at_creation: true,
    });
    let view = buffer.get_mapped_range_mut(..);
    view.map_err(|error| GpuError::Memory(format!("{what}: {error}")))?.copy_from_slice(bytes);
    buffer.unmap();
    Ok(buffer)
}

impl Buffers {
    /// Makes all of them.
    ///
    /// # Errors
    /// The image is too large for the device, or the device is full.
    pub(crate) fn new(device: &wgpu::Device, scene: &SceneBuffers, size: Size) -> Result<Self, GpuError> {
        caught(device, GpuError::Memory, || Self::make(device, scene, size))
    }

    fn make(device: &wgpu::Device, scene: &SceneBuffers, size: Size) -> Result<Self, GpuError> {
        let limits = device.limits();
        let side = u64::from(size.width.max(size.height));
        if side > u64::from(limits.max_texture_dimension_2d) {
            return Err(GpuError::TooLarge {
                what: "the G-buffer",
                needed: side,
                unit: "pixels along a side",
                limit: limits.max_texture_dimension_2d.into(),
                advice: "smaller images fit",
            });
        }
        let pixels = u64::from(size.width) * u64::from(size.height);
        let storage =
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let buffer = |what: &'static str, bytes: u64, usage: wgpu::BufferUsages| {
            check_size(
                &limits,
                what,
                bytes,
                "smaller images, fewer light samples or triangles, or a backend of fewer cells or voxels fit",
            )?;
            Ok::<_, GpuError>(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(what),
                // Something must be bound where there is nothing.
                size: bytes.max(RECORD),
                usage,
                mapped_at_creation: false,
            }))
        };
        let frame_stride =
            (size_of::<Frame>() as u32).next_multiple_of(limits.min_uniform_buffer_offset_alignment);
        let texture = |label: &'static str, format: wgpu::TextureFormat, usage: wgpu::TextureUsages| {
            device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                    view_formats: &[],
                })
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        Ok(Self {
            size,
            frame_stride,
            frames: buffer(
                "uniforms",
                u64::from(frame_stride) * u64::from(size.frames),
                wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            )?,
            ids: texture("triangles", wgpu::TextureFormat::R32Uint, wgpu::TextureUsages::TEXTURE_BINDING),
            depth: texture("depth", wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::empty()),
            position: buffer("points", 16 * pixels, storage)?,
            normal: buffer("normals", 16 * pixels, storage)?,
            albedo: buffer("albedos", 16 * pixels, storage)?,
            queries: buffer("queries", RECORD * u64::from(size.queries), storage)?,
            wanted: buffer("wanted samples", 4 * size.words, storage)?,
            visible: buffer("visible samples", 4 * size.words, storage)?,
            counters: buffer("counters", 4 * (TALLY + TALLIES * BUCKETS) as u64, storage)?,
            arguments: buffer("dispatches", 12 * INDIRECT, storage | wgpu::BufferUsages::INDIRECT)?,
            samples: buffer("samples", RECORD * u64::from(size.samples), storage)?,
            pyramid: buffer("pyramid", 8 * u64::from(size.pyramid), storage)?,
            cells: buffer("cells", RECORD * u64::from(size.cells), storage)?,
            owners: buffer("cells of pixels", 4 * pixels, storage)?,
            reused: buffer("samples taken over", 8 * size.reused, storage)?,
            texels: buffer("values between cells", 8 * u64::from(size.texels), storage)?,
            trusts: buffer("surfaces of samples", 4 * u64::from(size.trusts), storage)?,
            spilled: buffer("queries left to rays", 4 * (1 + u64::from(size.spilled)), storage)?,
            bins: buffer("triangles and receivers by cell", 4 * size.bins, storage)?,
            rectangles: buffer("projected triangles", 16 * size.rectangles, storage)?,
            space: buffer("space of voxels", size.space, storage)?,
            voxels: buffer("voxels", 4 * size.voxels, storage)?,
            large: buffer("large triangles", 4 * (1 + size.large), storage)?,
            discontinuities: buffer("discontinuities", 4 * u64::from(size.discontinuities), storage)?,
            fractions: buffer("visible fractions", 8 * u64::from(size.fractions), storage)?,
            chosen: buffer("choices", size_of::<Choice>() as u64 * u64::from(size.choices), storage)?,
            sums: buffer("sums over tiles", 4 * u64::from(size.tiles), storage)?,
            plane: buffer("values of pixels", 4 * pixels, storage)?,
            image: buffer("image", 16 * pixels, storage)?,
            scene: scene.clone(),
        })
    }

    /// What a slot is bound to.
    pub(crate) fn resource(&self, slot: Slot) -> wgpu::BindingResource<'_> {
        let own = match slot {
            // The caller's textures are bound by the pass that reads them.
            Slot::Ids | Slot::GivenPoint | Slot::GivenNormal => {
                return wgpu::BindingResource::TextureView(&self.ids);
            }
            Slot::Position => &self.position,
            Slot::Normal => &self.normal,
            Slot::Albedo => &self.albedo,
            Slot::Queries => &self.queries,
            Slot::Wanted => &self.wanted,
            Slot::Visible | Slot::Seen => &self.visible,
            Slot::Counters => &self.counters,
            Slot::Arguments => &self.arguments,
            Slot::Samples => &self.samples,
            Slot::Pyramid => &self.pyramid,
            Slot::Cells => &self.cells,
            Slot::Owners => &self.owners,
            Slot::Reused => &self.reused,
            Slot::Texels => &self.texels,
            Slot::Trusts => &self.trusts,
            Slot::Spilled => &self.spilled,
            Slot::Bins | Slot::BinsRead => &self.bins,
            Slot::Rectangles => &self.rectangles,
            Slot::Space => &self.space,
            Slot::Voxels | Slot::Grid => &self.voxels,
            Slot::Large => &self.large,
            Slot::Discontinuities => &self.discontinuities,
            Slot::Fractions => &self.fractions,
            Slot::Chosen => &self.chosen,
            Slot::Sums => &self.sums,
            Slot::Plane => &self.plane,
            Slot::Image => &self.image,
            Slot::Nodes => &self.scene.nodes,
            Slot::Triangles => &self.scene.triangles,
            Slot::Faces => &self.scene.faces,
            Slot::Materials => &self.scene.materials,
            Slot::Uvs => &self.scene.uvs,
            Slot::Textures => &self.scene.textures,
        };
        own.as_entire_binding()
    }
}
