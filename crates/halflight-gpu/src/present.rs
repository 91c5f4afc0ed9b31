//! The image in a texture of the caller's.

use crate::GpuError;
use crate::buffers::Buffers;
use crate::programs::PRESENT;
use crate::stage;

/// Pipeline that writes to textures of one format.
#[derive(Debug)]
pub(crate) struct Present {
    pub(crate) format: wgpu::TextureFormat,
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
}

impl Present {
    /// Compiles it.
    ///
    /// # Errors
    /// A shader cannot be read.
    pub(crate) fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Result<Self, GpuError> {
        let (module, layout) = stage::prepare(device, &PRESENT, wgpu::ShaderStages::FRAGMENT, None)?;
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(PRESENT.name),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(PRESENT.name),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("cover"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(PRESENT.entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Ok(Self { format, pipeline, layout })
    }

    /// Draws the image.
    pub(crate) fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &Buffers,
        target: &wgpu::TextureView,
    ) {
        let mut render = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(PRESENT.name),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        render.set_pipeline(&self.pipeline);
        let bound = stage::bind(device, &PRESENT, &self.layout, buffers, &[]);
        render.set_bind_group(0, &bound, &[0]);
        render.draw(0..3, 0..1);
    }
}
