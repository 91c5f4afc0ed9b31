//! Buffers by slot, of the sizes that the stages declare.

use std::ops::Index;

use crate::bindings::Slot;
use crate::error::{GpuError, caught};
use crate::frame::Frame;
use crate::memory::Memory;
use crate::needs::Needs;

const ADVICE: &str =
    "smaller images, fewer light samples or triangles, or a backend of fewer cells or voxels fit";

/// Buffers and textures of an image, and the scene's.
#[derive(Debug)]
pub(crate) struct Buffers {
    pub(crate) needs: Needs,
    /// Number that is another one whenever a buffer has been replaced.
    pub(crate) generation: u64,
    /// Bytes from one uniform to the next.
    pub(crate) frame_stride: u32,
    pub(crate) frames: wgpu::Buffer,
    pub(crate) ids: wgpu::TextureView,
    pub(crate) depth: wgpu::TextureView,
    /// One a slot, in the order of [`Slot::ALL`].
    table: Vec<wgpu::Buffer>,
}

impl Index<Slot> for Buffers {
    type Output = wgpu::Buffer;

    fn index(&self, slot: Slot) -> &wgpu::Buffer {
        &self.table[slot.memory() as usize]
    }
}

impl Buffers {
    /// Creates all buffers but those of the scene, which are given by slot.
    ///
    /// # Errors
    /// The image is too large for the device, or the device is full.
    pub(crate) fn new(
        memory: &Memory,
        scene: &[(Slot, wgpu::Buffer)],
        needs: Needs,
    ) -> Result<Self, GpuError> {
        caught(&memory.device, GpuError::Memory, || Self::make(memory, scene, needs))
    }

    fn make(memory: &Memory, scene: &[(Slot, wgpu::Buffer)], needs: Needs) -> Result<Self, GpuError> {
        let limits = memory.device.limits();
        let side = u64::from(needs.width.max(needs.height));
        if side > u64::from(limits.max_texture_dimension_2d) {
            return Err(GpuError::TooLarge {
                what: "the G-buffer",
                needed: side,
                unit: "pixels along a side",
                limit: limits.max_texture_dimension_2d.into(),
                advice: "smaller images fit",
            });
        }
        let frame_stride =
            (size_of::<Frame>() as u32).next_multiple_of(limits.min_uniform_buffer_offset_alignment);
        let texture = |label: &'static str, format: wgpu::TextureFormat, usage: wgpu::TextureUsages| {
            memory
                .device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: wgpu::Extent3d {
                        width: needs.width,
                        height: needs.height,
                        depth_or_array_layers: 1,
                    },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                    view_formats: &[],
                })
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        let buffer = |&slot: &Slot| match scene.iter().find(|(known, _)| *known == slot) {
            Some((_, buffer)) => Ok(buffer.clone()),
            None => slot_buffer(memory, slot, needs.bytes(slot)),
        };
        let frames = uniforms(memory, frame_stride, needs.uniforms)?;
        let table = Slot::ALL.iter().map(buffer).collect::<Result<_, _>>()?;
        Ok(Self {
            generation: memory.created(),
            frame_stride,
            frames,
            ids: texture("triangles", wgpu::TextureFormat::R32Uint, wgpu::TextureUsages::TEXTURE_BINDING),
            depth: texture("depth", wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::empty()),
            table,
            needs,
        })
    }

    /// Replaces the buffers that are smaller than `needs`, for an image of the same size. The others keep their size and their
    /// contents.
    ///
    /// # Errors
    /// The device allows no buffer of a size, or is full; nothing is replaced then.
    pub(crate) fn grow(&mut self, memory: &Memory, needs: Needs) -> Result<(), GpuError> {
        let stride = self.frame_stride;
        let small = |slot: &&Slot| needs.bytes(**slot) > self[**slot].size();
        let (frames, larger) = caught(&memory.device, GpuError::Memory, || {
            let grows = u64::from(stride) * u64::from(needs.uniforms) > self.frames.size();
            let frames = grows.then(|| uniforms(memory, stride, needs.uniforms)).transpose()?;
            let larger = Slot::ALL
                .iter()
                .filter(small)
                .map(|&slot| slot_buffer(memory, slot, needs.bytes(slot)).map(|buffer| (slot, buffer)));
            Ok((frames, larger.collect::<Result<Vec<_>, _>>()?))
        })?;
        if frames.is_some() || !larger.is_empty() {
            self.generation = memory.created();
        }
        if let Some(frames) = frames {
            self.frames = frames;
        }
        for (slot, buffer) in larger {
            self.table[slot as usize] = buffer;
        }
        self.needs = needs;
        Ok(())
    }

    /// Replaces the buffer of a slot, which no stage declares.
    pub(crate) fn replace(&mut self, memory: &Memory, slot: Slot, buffer: wgpu::Buffer) {
        self.table[slot as usize] = buffer;
        self.generation = memory.created();
    }

    /// Returns the resource that a slot binds.
    pub(crate) fn resource(&self, slot: Slot) -> wgpu::BindingResource<'_> {
        // The caller's textures are bound by the pass that reads them.
        if slot.is_texture() {
            return wgpu::BindingResource::TextureView(&self.ids);
        }
        self[slot].as_entire_binding()
    }
}

fn uniforms(memory: &Memory, stride: u32, count: u32) -> Result<wgpu::Buffer, GpuError> {
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    memory.empty("uniforms", u64::from(stride) * u64::from(count), usage, ADVICE)
}

fn slot_buffer(memory: &Memory, slot: Slot, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
    let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let indirect =
        if slot == Slot::Arguments { wgpu::BufferUsages::INDIRECT } else { wgpu::BufferUsages::empty() };
    memory.empty(slot.label(), bytes, storage | indirect, ADVICE)
}
