//! Voxel marching (Nichols10), approximate as on the CPU: the same voxels, set by atomic OR once a frame, and the same rays.
//! There are no coarser copies of the voxels: they change no answer.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use halflight_core::light::{AreaLight, LightFrame};
use halflight_core::scene::{Camera, Scene};
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::voxel::{Frustum, Traversal, VoxelConfig, turned};

use super::for_both;
use crate::GpuError;
use crate::buffers::Size;
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::{Compiler, Stage};
use crate::stats::Timed;

/// Words before the voxels besides one a light: `LIGHTS` in `shaders/visibility/voxel_space.wgsl`.
const LIGHTS: usize = 4;

/// Twin of `Space` there.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Space {
    pub(crate) across: [f32; 3],
    pub(crate) lights_deepest: f32,
    pub(crate) down: [f32; 4],
    pub(crate) texel_right: [f32; 4],
    pub(crate) texel_up: [f32; 4],
    pub(crate) forward: [f32; 4],
}

/// Twin of `TurnedLight` there.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct TurnedLight {
    pub(crate) corner: [f32; 4],
    pub(crate) u: [f32; 4],
    pub(crate) v: [f32; 4],
    pub(crate) normal: [f32; 4],
}

/// Passes of voxel marching.
#[derive(Debug)]
pub(crate) struct Voxel {
    config: VoxelConfig,
    lights: Vec<AreaLight>,
    triangles: u64,
    range: Stage,
    clearance: Stage,
    small: Stage,
    dispatch: Stage,
    large: Stage,
    pub(super) masks: [Stage; 2],
}

impl Voxel {
    /// Compiles them.
    ///
    /// # Errors
    /// A constant is out of range, or a shader cannot be compiled.
    pub(super) fn new(compiler: &Compiler, scene: &Scene, config: VoxelConfig) -> Result<Self, GpuError> {
        config.validate().map_err(PipelineError::from)?;
        let steps = match config.traversal {
            Traversal::Steps { count } => count,
            Traversal::Dda => 0,
        };
        let triangles = scene.mesh.triangle_count();
        let constants = [
            ("RESOLUTION", config.resolution.into()),
            ("BITS", config.depth_bits.into()),
            ("BIAS", config.bias.into()),
            ("TRIANGLES", triangles as f64),
            ("HEAD", (LIGHTS + scene.lights.len()) as f64),
        ];
        let stage = |program, own: &[_]| compiler.stage(program, &[&constants, own].concat());
        let march = [("STEPS", steps.into()), ("THICKNESS", config.thickness.into())];
        Ok(Self {
            config,
            lights: scene.lights.clone(),
            triangles: triangles as u64,
            range: stage(programs::VOXEL_RANGE, &[])?,
            clearance: stage(programs::VOXEL_CLEARANCE, &[])?,
            small: stage(programs::VOXEL_FILL, &[("LARGE", 0.0)])?,
            dispatch: stage(programs::VOXEL_DISPATCH, &[])?,
            large: stage(programs::VOXEL_FILL, &[("LARGE", 1.0)])?,
            masks: for_both(|purpose| stage(programs::VOXEL_MASKS, &[march[0], march[1], purpose]))?,
        })
    }

    /// What it takes.
    pub(super) fn size(&self, size: Size) -> Size {
        let VoxelConfig { resolution, depth_bits, .. } = self.config;
        let lights = self.lights.len();
        Size {
            space: (size_of::<Space>() + lights * size_of::<TurnedLight>()) as u64,
            // Texels are words of 64 bits, as on the CPU.
            voxels: (LIGHTS + lights) as u64
                + u64::from(resolution).pow(2) * 2 * u64::from(depth_bits.div_ceil(64)),
            large: self.triangles,
            ..size
        }
    }

    /// Sets the voxels that the scene fills; the uniforms of each light begin `stride` after those of the one before.
    pub(super) fn prepare(&self, recorder: &mut Recorder, stride: u32) {
        let Size { width, height, .. } = recorder.buffers.size;
        recorder.encoder.clear_buffer(&recorder.buffers.voxels, 0, None);
        recorder.encoder.clear_buffer(&recorder.buffers.large, 0, Some(4));
        let pixels = u64::from(width) * u64::from(height);
        let mut run = |stage, frame, groups| recorder.run(stage, Timed::Visibility, frame, groups);
        run(&self.range, 0, Groups::Count(pixels.max(3 * self.triangles)));
        for light in 0..self.lights.len() as u32 {
            run(&self.clearance, light * stride, Groups::Count(1));
        }
        run(&self.small, 0, Groups::Count(self.triangles));
        run(&self.dispatch, 0, Groups::Count(1));
        run(&self.large, 0, Groups::Tasks);
    }

    /// All stages, to bind.
    pub(super) fn stages(&mut self) -> Vec<&mut Stage> {
        let Self { range, clearance, small, dispatch, large, masks: [first, second], .. } = self;
        vec![range, clearance, small, dispatch, large, first, second]
    }

    /// What the shaders' `space` holds for a camera.
    pub(super) fn space(&self, camera: &Camera, size: Size) -> Vec<u8> {
        let aspect = size.width as f32 / size.height as f32;
        // The device finds out where it begins and ends.
        let depths = (1.0, 2.0);
        let VoxelConfig { resolution, depth_bits, .. } = self.config;
        let frustum = &Frustum::new(camera, aspect, depths, resolution as usize, depth_bits as usize);
        let depth = |point: Vec3| frustum.forward.dot(point - frustum.eye);
        let corners = self.lights.iter().flat_map(AreaLight::corners);
        let row = |axis: usize| frustum.rows[axis].as_vec3();
        let padded = |v: Vec3| v.extend(0.0).to_array();
        let space = Space {
            across: row(0).to_array(),
            lights_deepest: corners.map(depth).fold(f32::NEG_INFINITY, f32::max),
            down: padded(row(1)),
            texel_right: padded(frustum.texel[0]),
            texel_up: padded(frustum.texel[1]),
            forward: padded(frustum.forward),
        };
        let mut bytes = bytemuck::bytes_of(&space).to_vec();
        for light in &self.lights {
            let LightFrame { origin, u, v } = turned(frustum, light).frame();
            let normal = frustum.turn(light.normal().as_dvec3()).as_vec3();
            let light = [origin, u, v, normal].map(padded);
            bytes.extend_from_slice(bytemuck::cast_slice(&light));
        }
        bytes
    }
}
