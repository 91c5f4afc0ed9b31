//! The raster pass: which triangle each pixel sees.

use crate::GpuError;
use crate::buffers::Buffers;
use crate::programs::GBUFFER;
use crate::recorder::Recorder;
use crate::stage;
use crate::stats::Timed;

/// Pipeline of the raster pass.
#[derive(Debug)]
pub(crate) struct Rasterizer {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    bound: Option<wgpu::BindGroup>,
}

impl Rasterizer {
    /// Compiles it.
    ///
    /// # Errors
    /// A shader cannot be read.
    pub(crate) fn new(device: &wgpu::Device) -> Result<Self, GpuError> {
        let (module, layout) = stage::prepare(device, &GBUFFER, wgpu::ShaderStages::VERTEX, None)?;
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(GBUFFER.name),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(GBUFFER.name),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
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
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::TextureFormat::R32Uint.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Ok(Self { pipeline, layout, bound: None })
    }

    /// Binds buffers that are new.
    pub(crate) fn bind(&mut self, device: &wgpu::Device, buffers: &Buffers) {
        self.bound = Some(stage::bind(device, &GBUFFER, &self.layout, buffers, &[]));
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
