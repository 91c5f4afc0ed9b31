//! Buffers on a device: the one place that creates them.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::GpuError;

/// Least size of a buffer, bytes: something must be bound where there is nothing. A pixel of the image takes as much.
const LEAST: u64 = 16;

/// Contents of a buffer that has none: one element of any type.
const NOTHING: [u8; 32] = [0; 32];

/// A device, and how many bytes of buffers have been created on it.
#[derive(Debug)]
pub(crate) struct Memory {
    pub(crate) device: wgpu::Device,
    created: AtomicU64,
}

impl Memory {
    /// Returns the memory of a device.
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        Self { device: device.clone(), created: AtomicU64::new(0) }
    }

    /// Bytes of all buffers created so far.
    pub(crate) fn created(&self) -> u64 {
        self.created.load(Ordering::Relaxed)
    }

    /// Checks that a buffer of this size can be bound.
    ///
    /// # Errors
    /// The device allows less, with `advice`.
    pub(crate) fn check(
        &self,
        what: &'static str,
        needed: u64,
        advice: &'static str,
    ) -> Result<(), GpuError> {
        let limits = self.device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if needed > limit {
            return Err(GpuError::TooLarge { what, needed, unit: "bytes", limit, advice });
        }
        Ok(())
    }

    /// Creates a buffer whose contents are zero.
    ///
    /// # Errors
    /// The device binds no buffer of this size, with `advice`.
    pub(crate) fn empty(
        &self,
        label: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
        advice: &'static str,
    ) -> Result<wgpu::Buffer, GpuError> {
        self.check(label, bytes, advice)?;
        Ok(self.create(label, bytes.max(LEAST), usage, false))
    }

    /// Creates a buffer that holds `bytes`. Nothing panics where the device gives no memory.
    ///
    /// # Errors
    /// The device is full or lost.
    pub(crate) fn filled(
        &self,
        label: &'static str,
        bytes: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let bytes = if bytes.is_empty() { &NOTHING } else { bytes };
        let buffer = self.create(label, bytes.len() as u64, usage, true);
        let view = buffer.get_mapped_range_mut(..);
        view.map_err(|error| GpuError::Memory(format!("{label}: {error}")))?.copy_from_slice(bytes);
        buffer.unmap();
        Ok(buffer)
    }

    /// Records copies of `bytes` to buffers, so that several frames can be recorded before one submission.
    ///
    /// # Errors
    /// The device is full or lost; nothing has been recorded then.
    pub(crate) fn write(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        contents: &[(&'static str, &[u8], &wgpu::Buffer)],
    ) -> Result<(), GpuError> {
        let some = contents.iter().filter(|(_, bytes, _)| !bytes.is_empty());
        let staged = |&(label, bytes, to): &(&'static str, &[u8], _)| {
            self.filled(label, bytes, wgpu::BufferUsages::COPY_SRC).map(|staging| (staging, to))
        };
        for (staging, to) in some.map(staged).collect::<Result<Vec<_>, _>>()? {
            encoder.copy_buffer_to_buffer(&staging, 0, to, 0, staging.size());
        }
        Ok(())
    }

    fn create(
        &self,
        label: &'static str,
        size: u64,
        usage: wgpu::BufferUsages,
        mapped_at_creation: bool,
    ) -> wgpu::Buffer {
        self.created.fetch_add(size, Ordering::Relaxed);
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation,
        })
    }
}
