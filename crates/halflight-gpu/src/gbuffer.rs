//! Surfaces that pixels see: rasterized and resolved, or imported from the caller's textures.

use crate::bindings::Slot;
use crate::buffers::Buffers;
use crate::error::GpuError;
use crate::needs::{Needs, RECORD};
use crate::pass::{Bindings, Compiler, Pass};
use crate::program::{Program, programs};
use crate::recorder::{Groups, Recorder};
use crate::scene::Corners;
use crate::stats::Timed;

programs! {
    GBUFFER: "gbuffer" = corner in "gbuffer";
    GBUFFER_MASKED: "gbuffer with alpha masks" = solid_fragment in "gbuffer_masked";
    RESOLVE: "resolve" = resolve in "resolve";
    RESOLVE_SMOOTH: "resolve smooth" = resolve_smooth in "resolve_smooth";
    IMPORT: "import" = take in "import";
}

/// Source of the G-buffer.
#[derive(Clone, Copy, Debug, Default)]
pub enum Surfaces<'a> {
    /// The scene is rasterized.
    #[default]
    Scene,
    /// The caller has filled [`Renderer::position`](crate::Renderer::position) and
    /// [`Renderer::normal`](crate::Renderer::normal) already, shading normals included where the scene has smooth surfaces.
    Kept,
    /// The caller has drawn it, in textures of the image's size that can be bound and need not be filtered. The textures must show
    /// the scene, seen by the camera. Shadow rays start off the surface by 12 units of 2⁻²⁴ of the point's largest coordinate
    /// and 8 of its depth: points must be rounded no worse than single precision does.
    Points {
        /// World-space points.
        position: &'a wgpu::TextureView,
        /// Geometric unit normals towards the viewer; zero where nothing is seen.
        normal: &'a wgpu::TextureView,
    },
    /// The caller has drawn depths in the place of points.
    Depths {
        /// Distances along the view direction, metres.
        depth: &'a wgpu::TextureView,
        /// Geometric unit normals towards the viewer; zero where nothing is seen.
        normal: &'a wgpu::TextureView,
    },
}

/// Passes of the G-buffer.
#[derive(Debug)]
pub(crate) struct Gbuffer {
    rasterize: Rasterizer,
    /// Rasterizer of triangles with alpha masks, in scenes that have some.
    rasterize_masked: Option<Rasterizer>,
    resolve: Pass,
    /// Pass of scenes with smooth surfaces.
    resolve_smooth: Option<Pass>,
    /// Imports of points, and of depths.
    import: [Pass; 2],
}

impl Gbuffer {
    /// Compiles the passes, for a scene with or without smooth surfaces and alpha masks.
    ///
    /// # Errors
    /// A shader cannot be read or compiled, or binds more than the device allows.
    pub(crate) fn new(compiler: &Compiler, smooth: bool, masked: bool) -> Result<Self, GpuError> {
        let resolve_smooth = if smooth { Some(compiler.pass(RESOLVE_SMOOTH, &[])?) } else { None };
        let import = |depth: f64| compiler.pass(IMPORT, &[("DEPTH", depth)]);
        Ok(Self {
            rasterize: Rasterizer::opaque(compiler)?,
            rasterize_masked: masked.then(|| Rasterizer::masked(compiler)).transpose()?,
            resolve: compiler.pass(RESOLVE, &[])?,
            resolve_smooth,
            import: [import(0.0)?, import(1.0)?],
        })
    }

    /// Declares the buffers of surfaces.
    pub(crate) fn declare(&self, needs: &mut Needs) {
        for slot in [Slot::Position, Slot::Normal, Slot::Albedo] {
            needs.declare(slot, RECORD * needs.pixels());
        }
        if self.resolve_smooth.is_some() {
            needs.declare(Slot::Normal, 2 * RECORD * needs.pixels());
        }
    }

    /// Returns the place of shading normals behind the geometric ones, in pixels; 0 where they are the same.
    pub(crate) fn shading(&self, surfaces: &Surfaces, needs: &Needs) -> u32 {
        match surfaces {
            Surfaces::Scene | Surfaces::Kept if self.resolve_smooth.is_some() => needs.pixels() as u32,
            _ => 0,
        }
    }

    /// Records the G-buffer of a scene with so many corners of triangles, or of the caller's.
    pub(crate) fn record(&self, recorder: &mut Recorder, surfaces: &Surfaces, corners: Corners) {
        let (import, point, normal) = match *surfaces {
            Surfaces::Kept => return,
            Surfaces::Scene => {
                self.rasterize(recorder, corners);
                recorder.run(&self.resolve, Timed::Gbuffer, 0, Groups::Tiles(0));
                if let Some(smooth) = &self.resolve_smooth {
                    recorder.run(smooth, Timed::Gbuffer, 0, Groups::Tiles(0));
                }
                return;
            }
            Surfaces::Points { position, normal } => (&self.import[0], position, normal),
            Surfaces::Depths { depth, normal } => (&self.import[1], depth, normal),
        };
        let given = [(Slot::GivenPoint, point), (Slot::GivenNormal, normal)];
        recorder.run_given(import, Timed::Gbuffer, 0, Groups::Tiles(0), &given);
    }

    /// Records the raster pass over all triangles.
    fn rasterize(&self, recorder: &mut Recorder, Corners { opaque, all }: Corners) {
        let Recorder { encoder, device, buffers, clock, .. } = recorder;
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
        self.rasterize.draw(&mut render, device, buffers, 0..opaque);
        if let Some(masked) = &self.rasterize_masked {
            masked.draw(&mut render, device, buffers, opaque..all);
        }
    }
}

/// Pipeline of the raster pass.
#[derive(Debug)]
struct Rasterizer {
    pipeline: wgpu::RenderPipeline,
    bindings: Bindings,
}

impl Rasterizer {
    /// Pipeline of triangles without alpha masks.
    fn opaque(compiler: &Compiler) -> Result<Self, GpuError> {
        Self::new(compiler, &GBUFFER, "fragment", wgpu::ShaderStages::VERTEX)
    }

    /// Pipeline of triangles with alpha masks.
    fn masked(compiler: &Compiler) -> Result<Self, GpuError> {
        Self::new(compiler, &GBUFFER_MASKED, GBUFFER_MASKED.entry, wgpu::ShaderStages::VERTEX_FRAGMENT)
    }

    /// Compiles a pipeline; `stages` bind something.
    fn new(
        compiler: &Compiler,
        program: &Program,
        fragment: &str,
        stages: wgpu::ShaderStages,
    ) -> Result<Self, GpuError> {
        let (pipeline, bindings) = compiler.pipeline(program, stages, |module, layout| {
            compiler.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(program.name),
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
                    entry_point: Some(fragment),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(wgpu::TextureFormat::R32Uint.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        Ok(Self { pipeline, bindings })
    }

    /// Draws triangles with these corners.
    fn draw(
        &self,
        render: &mut wgpu::RenderPass,
        device: &wgpu::Device,
        buffers: &Buffers,
        corners: std::ops::Range<u32>,
    ) {
        render.set_pipeline(&self.pipeline);
        render.set_bind_group(0, &self.bindings.group(device, buffers), &[0]);
        render.draw(corners, 0..1);
    }
}
