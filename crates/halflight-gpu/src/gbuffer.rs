//! The raster pass: which triangle each pixel sees.

use crate::GpuError;
use crate::buffers::Buffers;
use crate::programs::GBUFFER;
use crate::recorder::Recorder;
use crate::stage::{Bindings, Compiler};
use crate::stats::Timed;

/// Pipeline of the raster pass.
#[derive(Debug)]
pub(crate) struct Rasterizer {
    pipeline: wgpu::RenderPipeline,
    bindings: Bindings,
    bound: Option<wgpu::BindGroup>,
}

impl Rasterizer {
    /// Compiles it.
    ///
    /// # Errors
    /// As [`Compiler::pipeline`].
    pub(crate) fn new(compiler: &Compiler) -> Result<Self, GpuError> {
        let stages = wgpu::ShaderStages::VERTEX;
        let (pipeline, bindings) = compiler.pipeline(&GBUFFER, stages, |module, layout| {
            compiler.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(GBUFFER.name),
                layout: Some(layout),
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some(GBUFFER.entry),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                // Depth is inverted: nearer is more.
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: wgpu::TextureFormat::Depth32Float,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some("fragment"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(wgpu::TextureFormat::R32Uint.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        Ok(Self { pipeline, bindings, bound: None })
    }

    /// Binds buffers that are new.
    pub(crate) fn bind(&mut self, device: &wgpu::Device, buffers: &Buffers) {
        self.bound = Some(self.bindings.bind(device, buffers, &[]));
    }

    /// Draws all triangles.
    pub(crate) fn run(&self, recorder: &mut Recorder, vertices: u32) {
        let Recorder { encoder, buffers, clock } = recorder;
        let nothing = wgpu::Color { r: f64::from(u32::MAX), g: 0.0, b: 0.0, a: 0.0 };
        let mut render = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(GBUFFER.name),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &buffers.ids,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(nothing), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &buffers.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: clock.as_mut().and_then(|clock| clock.render(Timed::Gbuffer)),
            ..Default::default()
        });
        render.set_pipeline(&self.pipeline);
        render.set_bind_group(0, self.bound.as_ref(), &[0]);
        render.draw(0..vertices, 0..1);
    }
}
