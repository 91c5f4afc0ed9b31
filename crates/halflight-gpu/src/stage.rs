//! A program on a device: its pipeline, and what is bound to it.

use std::num::NonZeroU64;

use crate::GpuError;
use crate::bindings::Slot;
use crate::buffers::Buffers;
use crate::frame::Frame;
use crate::programs::Program;
use crate::shader;

/// A compute program, ready to be dispatched.
#[derive(Debug)]
pub(crate) struct Stage {
    program: Program,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    bound: Option<wgpu::BindGroup>,
}

/// A shader module and the layout of what it binds.
///
/// # Errors
/// A shader cannot be read or compiled.
pub(crate) fn prepare(
    device: &wgpu::Device,
    program: &Program,
    stages: wgpu::ShaderStages,
    visibility: Option<&str>,
) -> Result<(wgpu::ShaderModule, wgpu::BindGroupLayout), GpuError> {
    let source = shader::source(program, visibility)?;
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(program.name),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    // Ready at once: shaders are parsed on this thread.
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(GpuError::Shader { name: program.name.to_owned(), reason: error.to_string() });
    }
    let uniform = wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: stages,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: NonZeroU64::new(size_of::<Frame>() as u64),
        },
        count: None,
    };
    let entries: Vec<_> = std::iter::once(uniform)
        .chain(program.slots.iter().map(|&(slot, access)| slot.layout(access, stages)))
        .collect();
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(program.name),
        entries: &entries,
    });
    Ok((module, layout))
}

/// Binds what a program asks for; `given` are textures of the caller's.
pub(crate) fn bind(
    device: &wgpu::Device,
    program: &Program,
    layout: &wgpu::BindGroupLayout,
    buffers: &Buffers,
    given: &[(Slot, &wgpu::TextureView)],
) -> wgpu::BindGroup {
    let uniform = wgpu::BindGroupEntry {
        binding: 0,
        resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &buffers.frames,
            offset: 0,
            size: NonZeroU64::new(size_of::<Frame>() as u64),
        }),
    };
    let entry = |slot: Slot| {
        let texture = given.iter().find(|(known, _)| *known == slot);
        let resource = match texture {
            Some((_, view)) => wgpu::BindingResource::TextureView(view),
            None => buffers.resource(slot),
        };
        wgpu::BindGroupEntry { binding: slot.binding(), resource }
    };
    let entries: Vec<_> =
        std::iter::once(uniform).chain(program.slots.iter().map(|&(slot, _)| entry(slot))).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(program.name),
        layout,
        entries: &entries,
    })
}

impl Stage {
    /// Compiles a program with its constants.
    ///
    /// # Errors
    /// A shader cannot be read.
    pub(crate) fn new(
        device: &wgpu::Device,
        program: Program,
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        Self::with_visibility(device, program, constants, None)
    }

    /// The same with another module that decides on shadow rays.
    ///
    /// # Errors
    /// A shader cannot be read or compiled.
    pub(crate) fn with_visibility(
        device: &wgpu::Device,
        program: Program,
        constants: &[(&str, f64)],
        visibility: Option<&str>,
    ) -> Result<Self, GpuError> {
        let (module, layout) = prepare(device, &program, wgpu::ShaderStages::COMPUTE, visibility)?;
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(program.name),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(program.name),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(program.entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: None,
        });
        Ok(Self { program, pipeline, layout, bound: None })
    }

    /// Binds buffers that are new.
    pub(crate) fn bind(&mut self, device: &wgpu::Device, buffers: &Buffers) {
        self.bound = Some(bind(device, &self.program, &self.layout, buffers, &[]));
    }

    /// Binds buffers and textures of the caller's.
    pub(crate) fn bind_given(
        &mut self,
        device: &wgpu::Device,
        buffers: &Buffers,
        given: &[(Slot, &wgpu::TextureView)],
    ) {
        self.bound = Some(bind(device, &self.program, &self.layout, buffers, given));
    }

    /// Its name.
    pub(crate) fn name(&self) -> &'static str {
        self.program.name
    }

    /// Makes it what is dispatched next; `frame` is where its uniform begins.
    pub(crate) fn set(&self, compute: &mut wgpu::ComputePass, frame: u32) {
        compute.set_pipeline(&self.pipeline);
        compute.set_bind_group(0, self.bound.as_ref(), &[frame]);
    }
}
