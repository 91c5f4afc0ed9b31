//! GPU device whose errors fail tests.

use std::sync::{Arc, Mutex};

use halflight::config::PipelineConfig;
use halflight::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight::scene::Scene;
use halflight_gpu::wgpu;
use halflight_gpu::{Gpu, GpuError, GpuStats, Inputs, Renderer};

/// Device, with the errors that it reported.
pub(crate) struct Bench {
    pub(crate) gpu: Gpu,
    errors: Arc<Mutex<Vec<String>>>,
}

impl Bench {
    /// Opens a device; none if there is no adapter and none is required.
    pub(crate) fn open() -> Option<Self> {
        match Gpu::find() {
            Ok(gpu) => Some(Self::of(gpu)),
            Err(error @ GpuError::NoAdapter) => {
                assert!(
                    std::env::var_os("HALFLIGHT_REQUIRE_GPU").is_none_or(|value| value != "1"),
                    "{error}"
                );
                eprintln!("skipped: {error}");
                None
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// Opens another device of the same adapter, with these limits.
    pub(crate) fn limited(&self, required_limits: wgpu::Limits) -> Self {
        let adapter = self.gpu.adapter.clone();
        let descriptor = wgpu::DeviceDescriptor { required_limits, ..wgpu::DeviceDescriptor::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        Self::of(Gpu { adapter, device, queue })
    }

    fn of(gpu: Gpu) -> Self {
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&errors);
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            sink.lock().unwrap().push(error.to_string());
        }));
        Self { gpu, errors }
    }

    /// A renderer for a scene.
    pub(crate) fn renderer(&self, scene: &Scene, config: &PipelineConfig) -> Result<Renderer, GpuError> {
        Renderer::new(&self.gpu.device, &self.gpu.queue, scene, config)
    }

    /// Records and submits one frame.
    pub(crate) fn render(&self, renderer: &mut Renderer, inputs: &Inputs) -> GpuStats {
        let stats = self.gpu.render(renderer, inputs).unwrap();
        assert_eq!(stats.lost, 0);
        self.check();
        stats
    }

    /// Content of a buffer.
    pub(crate) fn read<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer) -> Vec<T> {
        let read = self.gpu.read(buffer).unwrap();
        self.check();
        read
    }

    /// Replaces the GPU's G-buffer by the CPU's.
    pub(crate) fn keep(&self, renderer: &Renderer, gbuffer: &GBuffer) {
        let pixels = 0..gbuffer.pixels();
        let position: Vec<[f32; 4]> = pixels
            .map(|pixel| {
                let seen = gbuffer.primitive[pixel] != NO_PRIMITIVE;
                gbuffer.position[pixel].extend(if seen { gbuffer.depth[pixel] } else { -1.0 }).to_array()
            })
            .collect();
        // Shading normals follow, where the scene has smooth surfaces.
        let room = renderer.normal().size() as usize / 16 / gbuffer.pixels();
        let normal: Vec<[u32; 4]> = [&gbuffer.normal, &gbuffer.shading]
            .into_iter()
            .take(room)
            .flat_map(|normals| normals.iter().zip(&gbuffer.primitive))
            .map(|(normal, &primitive)| {
                let [x, y, z] = normal.to_array().map(f32::to_bits);
                [x, y, z, primitive]
            })
            .collect();
        if let Some(gloss) = renderer.gloss() {
            let surfaces: Vec<[f32; 4]> = gbuffer
                .specular
                .iter()
                .map(|surface| surface.f0.extend(surface.roughness).to_array())
                .collect();
            self.gpu.queue.write_buffer(gloss, 0, bytemuck::cast_slice(&surfaces));
        }
        let albedo: Vec<[f32; 4]> =
            gbuffer.albedo.iter().map(|albedo| albedo.extend(1.0).to_array()).collect();
        self.gpu.queue.write_buffer(renderer.albedo(), 0, bytemuck::cast_slice(&albedo));
        self.gpu.queue.write_buffer(renderer.position(), 0, bytemuck::cast_slice(&position));
        self.gpu.queue.write_buffer(renderer.normal(), 0, bytemuck::cast_slice(&normal));
    }

    /// Fails if the device has reported an error.
    pub(crate) fn check(&self) {
        let errors = self.errors.lock().unwrap();
        assert!(errors.is_empty(), "{}", errors.join("\n"));
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.check();
        }
    }
}
