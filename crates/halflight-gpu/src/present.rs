//! Copy of the image to a texture of the caller's.

use crate::buffers::Buffers;
use crate::error::GpuError;
use crate::pass::{Bindings, Compiler};
use crate::program::programs;

programs! {
    PRESENT: "present" = pixel in "present";
}

/// Pipeline that writes to textures of one format.
#[derive(Debug)]
pub(crate) struct Present {
    pub(crate) format: wgpu::TextureFormat,
    pipeline: wgpu::RenderPipeline,
    bindings: Bindings,
}

impl Present {
    /// Compiles the pipeline.
    ///
    /// # Errors
    /// As [`Compiler::pipeline`].
    pub(crate) fn new(compiler: &Compiler, format: wgpu::TextureFormat) -> Result<Self, GpuError> {
        let stages = wgpu::ShaderStages::FRAGMENT;
        let (pipeline, bindings) = compiler.pipeline(&PRESENT, stages, |module, layout| {
            compiler.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(PRESENT.name),
                layout: Some(layout),
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some("cover"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some(PRESENT.entry),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        Ok(Self { format, pipeline, bindings })
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
        render.set_bind_group(0, &self.bindings.group(device, buffers), &[0]);
        render.draw(0..3, 0..1);
    }
}
