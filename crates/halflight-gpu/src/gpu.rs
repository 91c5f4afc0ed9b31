//! Devices, for callers that do not bring their own.

use std::sync::mpsc;

use crate::error::{GpuError, caught};
use crate::recorder::SIDE;

/// Features that a device must have: none beyond WebGPU.
pub fn required_features() -> wgpu::Features {
    wgpu::Features::empty()
}

/// Features that are used where a device has them: timestamps, for times a stage.
pub fn optional_features() -> wgpu::Features {
    wgpu::Features::TIMESTAMP_QUERY
}

/// Limits that a device must have: WebGPU's defaults. Larger images and scenes take larger buffers, and `beam` and
/// `raster4d` take 9 storage buffers a stage instead of 8, so a device should be asked for as much as its adapter has.
pub fn required_limits() -> wgpu::Limits {
    wgpu::Limits::default()
}

/// Most memory that the workgroups of a stage share, bytes.
pub(crate) const WORKGROUP_BYTES: u64 = 12 << 10;

/// Checks the limits of a device that wgpu itself does not check before frames are submitted.
///
/// # Errors
/// A limit is too low.
pub(crate) fn check_limits(limits: &wgpu::Limits) -> Result<(), GpuError> {
    let refused = |what, needed: u64, unit, limit: u32| {
        let advice = "ask the device for WebGPU's defaults";
        let error = GpuError::TooLarge { what, needed, unit, limit: limit.into(), advice };
        if needed <= limit.into() { Ok(()) } else { Err(error) }
    };
    refused("a dispatch", SIDE, "workgroups along a side", limits.max_compute_workgroups_per_dimension)?;
    let memory = limits.max_compute_workgroup_storage_size;
    refused("a workgroup", WORKGROUP_BYTES, "bytes of shared memory", memory)
}

/// An adapter with its device and queue.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The adapter.
    pub adapter: wgpu::Adapter,
    /// Device of the adapter.
    pub device: wgpu::Device,
    /// Queue of the device.
    pub queue: wgpu::Queue,
}

impl Gpu {
    /// Finds the fastest adapter that can be used. It blocks until the driver has answered.
    ///
    /// The environment variables of wgpu (`WGPU_BACKEND` and others) are honoured.
    ///
    /// # Errors
    /// No adapter is found, with what to install, or it gave no device.
    pub fn find() -> Result<Self, GpuError> {
        pollster::block_on(Self::find_async())
    }

    async fn find_async() -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                ..Default::default()
            })
            .await
            .map_err(|_| GpuError::NoAdapter)?;
        let available = adapter.limits();
        let required_limits = wgpu::Limits {
            max_buffer_size: available.max_buffer_size,
            max_storage_buffer_binding_size: available.max_storage_buffer_binding_size,
            max_texture_dimension_2d: available.max_texture_dimension_2d,
            max_storage_buffers_per_shader_stage: available.max_storage_buffers_per_shader_stage,
            ..required_limits()
        };
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("halflight"),
                required_features: required_features() | (optional_features() & adapter.features()),
                required_limits,
                ..Default::default()
            })
            .await
            .map_err(|error| GpuError::Device {
                adapter: adapter.get_info().name,
                reason: error.to_string(),
            })?;
        Ok(Self { adapter, device, queue })
    }

    /// Reads a buffer that can be copied from, after all that has been submitted. It blocks.
    ///
    /// # Errors
    /// The device is lost or out of memory.
    pub fn read<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
        caught(&self.device, GpuError::Readback, || self.read_uncaught(buffer))
    }

    fn read_uncaught<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        let failed = |error: &dyn std::fmt::Display| GpuError::Readback(error.to_string());
        let (send, receive) = mpsc::channel();
        staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The other end waits below.
            let _ = send.send(result);
        });
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        let mapped = receive.try_recv().map_err(|error| failed(&error))?;
        mapped.map_err(|error| failed(&error))?;
        let view = staging.slice(..).get_mapped_range().map_err(|error| failed(&error))?;
        Ok(bytemuck::pod_collect_to_vec(&view))
    }
}
