//! Picture of the last frame in a texture of the caller's.

use crate::buffers::Buffers;
use crate::error::GpuError;
use crate::pass::{Bindings, Compiler, flag};
use crate::program::{Program, programs};

programs! {
    PLAIN: "present" = pixel in "present", "present/matte", "present/no_lamps";
    LAMPS: "present, lamps" = pixel in "present", "present/matte", "present/lamps";
    GLOSSY: "present, glossy" = pixel in "present", "present/glossy", "present/no_lamps";
    GLOSSY_LAMPS: "present, glossy and lamps" = pixel in "present", "present/glossy", "present/lamps";
}

/// Texture and frame that a pipeline is made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Purpose {
    pub(crate) format: wgpu::TextureFormat,
    /// True if surfaces are glossy.
    pub(crate) glossy: bool,
    /// True if any light is visible.
    pub(crate) lamps: bool,
    /// True if the albedo of surfaces is not known.
    pub(crate) white: bool,
}

impl Purpose {
    fn program(self) -> &'static Program {
        match (self.glossy, self.lamps) {
            (false, false) => &PLAIN,
            (false, true) => &LAMPS,
            (true, false) => &GLOSSY,
            (true, true) => &GLOSSY_LAMPS,
        }
    }

    /// True if a texture keeps values from 0 to 1, and does not encode them itself.
    fn encodes(self) -> bool {
        let bits = matches!(
            self.format,
            wgpu::TextureFormat::Rgba8Unorm
                | wgpu::TextureFormat::Bgra8Unorm
                | wgpu::TextureFormat::Rgb10a2Unorm
                | wgpu::TextureFormat::Rgba16Unorm
        );
        bits && !self.format.is_srgb()
    }
}

/// Pipeline that writes to textures of one format.
#[derive(Debug)]
pub(crate) struct Present {
    pub(crate) purpose: Purpose,
    pipeline: wgpu::RenderPipeline,
    bindings: Bindings,
}

impl Present {
    /// Compiles the pipeline.
    ///
    /// # Errors
    /// As [`Compiler::pipeline`].
    pub(crate) fn new(compiler: &Compiler, purpose: Purpose) -> Result<Self, GpuError> {
        let (stages, program) = (wgpu::ShaderStages::FRAGMENT, purpose.program());
        let constants = [("WHITE", flag(purpose.white)), ("ENCODE", flag(purpose.encodes()))];
        let (pipeline, bindings) = compiler.pipeline(program, stages, |module, layout| {
            compiler.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(program.name),
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
                    entry_point: Some(program.entry),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..Default::default()
                    },
                    targets: &[Some(purpose.format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        Ok(Self { purpose, pipeline, bindings })
    }

    /// Draws the picture.
    pub(crate) fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &Buffers,
        target: &wgpu::TextureView,
    ) {
        let mut render = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(self.purpose.program().name),
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
