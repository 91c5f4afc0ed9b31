//! Programs on a device: their pipelines and bindings.

use std::num::NonZeroU64;
use std::sync::{Mutex, PoisonError};

use halflight_cpu::irradiance::Shading;

use crate::bindings::{Access, Slot};
use crate::buffers::Buffers;
use crate::error::{GpuError, caught};
use crate::frame::Frame;
use crate::program::Program;
use crate::shader::{Replaced, Shader};

/// Compiler of programs for a device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compiler<'a> {
    pub(crate) device: &'a wgpu::Device,
    /// True if there are textured lights.
    pub(crate) textured: bool,
    /// Modules from outside, by the names of those that they replace.
    pub(crate) replaced: &'a Replaced<'a>,
}

/// Returns an override constant that is true or false.
pub(crate) fn flag(value: bool) -> f64 {
    if value { 1.0 } else { 0.0 }
}

/// Returns the override constant of a shading.
pub(crate) fn shading_flag(shading: Shading) -> (&'static str, f64) {
    ("SHADING", flag(shading == Shading::Ratio))
}

/// Bindings of a program.
#[derive(Debug)]
pub(crate) struct Bindings {
    name: &'static str,
    layout: wgpu::BindGroupLayout,
    slots: Vec<(Slot, Access)>,
    /// Bind group of the last buffers, and their generation.
    bound: Mutex<Option<(u64, wgpu::BindGroup)>>,
}

/// A compute program, ready to be dispatched.
#[derive(Debug)]
pub(crate) struct Pass {
    pipeline: wgpu::ComputePipeline,
    bindings: Bindings,
}

/// Program for uniform lights, and the one for textured lights where there are any.
#[derive(Debug)]
pub(crate) struct ByLight {
    uniform: Pass,
    textured: Option<Pass>,
}

impl ByLight {
    /// Returns whether there is a program for textured lights.
    pub(crate) fn is_textured(&self) -> bool {
        self.textured.is_some()
    }

    /// Returns the program of a light.
    pub(crate) fn of(&self, textured: bool) -> &Pass {
        self.textured.as_ref().filter(|_| textured).unwrap_or(&self.uniform)
    }
}

impl Compiler<'_> {
    /// Makes the pipeline of a program from its module and layout.
    ///
    /// # Errors
    /// A shader cannot be read or compiled, or binds more than the device allows.
    pub(crate) fn pipeline<T>(
        &self,
        program: &Program,
        stages: wgpu::ShaderStages,
        make: impl FnOnce(&wgpu::ShaderModule, &wgpu::PipelineLayout) -> T,
    ) -> Result<(T, Bindings), GpuError> {
        let Self { device, replaced, .. } = *self;
        let label = Some(program.name);
        let Shader { text, slots } = Shader::new(program, replaced)?;
        check_bindings(device, program.name, &slots)?;
        let failed = |reason| GpuError::Shader { name: program.name.to_owned(), reason };
        caught(device, failed, || {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label,
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
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
            let others = slots.iter().map(|&(slot, access)| slot.layout(access, stages));
            let entries: Vec<_> = std::iter::once(uniform).chain(others).collect();
            let layout = device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label,
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = make(&module, &pipeline_layout);
            let bound = Mutex::new(None);
            Ok((pipeline, Bindings { name: program.name, layout, slots, bound }))
        })
    }

    /// Compiles a compute program with its override constants.
    ///
    /// # Errors
    /// As [`Compiler::pipeline`].
    pub(crate) fn pass(&self, program: Program, constants: &[(&str, f64)]) -> Result<Pass, GpuError> {
        let (pipeline, bindings) =
            self.pipeline(&program, wgpu::ShaderStages::COMPUTE, |module, layout| {
                self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(program.name),
                    layout: Some(layout),
                    module,
                    entry_point: Some(program.entry),
                    compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
                    cache: None,
                })
            })?;
        Ok(Pass { pipeline, bindings })
    }
}

impl Compiler<'_> {
    /// Compiles a program for uniform lights and, where there are textured ones, its twin.
    ///
    /// # Errors
    /// As [`Compiler::pipeline`].
    pub(crate) fn by_light(
        &self,
        (uniform, constants): (Program, &[(&str, f64)]),
        (twin, twin_constants): (Program, &[(&str, f64)]),
    ) -> Result<ByLight, GpuError> {
        let uniform = self.pass(uniform, constants)?;
        let textured = self.textured.then(|| self.pass(twin, twin_constants)).transpose()?;
        Ok(ByLight { uniform, textured })
    }
}

/// Checks that a device allows this many storage buffers in a program.
fn check_bindings(
    device: &wgpu::Device,
    what: &'static str,
    slots: &[(Slot, Access)],
) -> Result<(), GpuError> {
    let limit = device.limits().max_storage_buffers_per_shader_stage.into();
    let needed = slots.iter().filter(|(slot, _)| !slot.is_texture()).count() as u64;
    if needed <= limit {
        return Ok(());
    }
    let advice = "ask the device for more, or choose other stages";
    Err(GpuError::TooLarge { what, needed, unit: "storage buffers a stage", limit, advice })
}

impl Bindings {
    /// Returns the bind group of `buffers`, which is made once for as long as these last.
    pub(crate) fn group(&self, device: &wgpu::Device, buffers: &Buffers) -> wgpu::BindGroup {
        let mut bound = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        match &*bound {
            Some((generation, group)) if *generation == buffers.generation => group.clone(),
            _ => bound.insert((buffers.generation, self.bind(device, buffers, &[]))).1.clone(),
        }
    }

    /// Makes a bind group; `given` are textures of the caller's.
    fn bind(
        &self,
        device: &wgpu::Device,
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
            std::iter::once(uniform).chain(self.slots.iter().map(|&(slot, _)| entry(slot))).collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.name),
            layout: &self.layout,
            entries: &entries,
        })
    }
}

impl Pass {
    /// Returns the name of the program.
    pub(crate) fn name(&self) -> &'static str {
        self.bindings.name
    }

    /// Sets pipeline and bindings for the next dispatch; `frame` is the offset of the uniform in bytes, `given` are textures
    /// of the caller's.
    pub(crate) fn set(
        &self,
        compute: &mut wgpu::ComputePass,
        device: &wgpu::Device,
        buffers: &Buffers,
        frame: u32,
        given: &[(Slot, &wgpu::TextureView)],
    ) {
        let group = match given {
            [] => self.bindings.group(device, buffers),
            _ => self.bindings.bind(device, buffers, given),
        };
        compute.set_pipeline(&self.pipeline);
        compute.set_bind_group(0, &group, &[frame]);
    }
}
