//! Voxel marching (Nichols10), approximate as on the CPU: the same voxels, set by atomic OR once a frame, and the same rays.
//! Coarser copies of the voxels are left out: they change no answer.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::scene::Camera;
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::voxel::{Frustum, Traversal, VoxelConfig};

use super::backend::{Backend, Both};
use crate::bindings::Slot;
use crate::error::GpuError;
use crate::light::{TurnedLight, deepest};
use crate::masked::Parted;
use crate::needs::Needs;
use crate::pass::{Compiler, Pass};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    RANGE: "voxel: range" = find_range in "visibility/voxel_range";
    CLEARANCE: "voxel: clearance" = find_clearance in "visibility/voxel_clearance";
    DISPATCH: "voxel: dispatch" = size_large in "visibility/voxel_dispatch";
    FILL: "voxel: fill" = fill in "visibility/voxel_fill";
    MASKS: "voxel: masks" = masks in "visibility/masks", "visibility/voxel", "shared/query_batch";
}

/// Words before the voxels besides one a light: `LIGHTS` in `shaders/visibility/voxel_space.wgsl`.
const LIGHTS: usize = 4;

/// Twin of `Space` in `shaders/visibility/voxel_space.wgsl`; the lights follow it.
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

/// Passes of voxel marching.
#[derive(Debug)]
pub(super) struct Voxel {
    config: VoxelConfig,
    /// Number of triangles that fill voxels.
    triangles: u64,
    /// Number of corners that voxels reach to: those of all triangles.
    corners: u64,
    range: Pass,
    clearance: Pass,
    small: Pass,
    dispatch: Pass,
    large: Pass,
    masks: Both,
}

impl Voxel {
    /// Compiles the passes for the triangles of a scene.
    ///
    /// # Errors
    /// A constant is out of range, or a shader cannot be compiled.
    pub(super) fn new(compiler: &Compiler, parted: &Parted, config: VoxelConfig) -> Result<Self, GpuError> {
        config.validate().map_err(PipelineError::from)?;
        let steps = match config.traversal {
            Traversal::Steps { count } => count,
            Traversal::Dda => 0,
        };
        let constants = [
            ("RESOLUTION", config.resolution.into()),
            ("BITS", config.depth_bits.into()),
            ("BIAS", config.bias.into()),
            ("TRIANGLES", parted.opaque.len() as f64),
        ];
        let pass = |program, own: &[_]| compiler.pass(program, &[&constants, own].concat());
        let march = [("STEPS", steps.into()), ("THICKNESS", config.thickness.into())];
        Ok(Self {
            config,
            triangles: parted.opaque.len() as u64,
            corners: 3 * parted.count() as u64,
            range: pass(RANGE, &[])?,
            clearance: pass(CLEARANCE, &[])?,
            small: pass(FILL, &[("LARGE", 0.0)])?,
            dispatch: pass(DISPATCH, &[])?,
            large: pass(FILL, &[("LARGE", 1.0)])?,
            masks: Both::new(|purpose| pass(MASKS, &[march[0], march[1], purpose]))?,
        })
    }
}

impl Backend for Voxel {
    fn declare(&self, needs: &mut Needs, lights: &[AreaLight]) {
        let VoxelConfig { resolution, depth_bits, .. } = self.config;
        let space = size_of::<Space>() + lights.len() * size_of::<TurnedLight>();
        needs.declare(Slot::Space, space as u64);
        // Texels are words of 64 bits, as on the CPU.
        let texels = u64::from(resolution).pow(2) * 2 * u64::from(depth_bits.div_ceil(64));
        needs.declare(Slot::Voxels, 4 * ((LIGHTS + lights.len()) as u64 + texels));
        needs.declare(Slot::Large, 4 * (1 + self.triangles));
    }

    fn space(&self, camera: &Camera, needs: &Needs, lights: &[AreaLight]) -> Vec<u8> {
        let aspect = needs.width as f32 / needs.height as f32;
        // The device finds out where the voxels begin and end.
        let depths = (1.0, 2.0);
        let VoxelConfig { resolution, depth_bits, .. } = self.config;
        let frustum = &Frustum::new(camera, aspect, depths, resolution as usize, depth_bits as usize);
        let row = |axis: usize| frustum.rows[axis].as_vec3();
        let padded = |v: Vec3| v.extend(0.0).to_array();
        let space = Space {
            across: row(0).to_array(),
            lights_deepest: deepest(lights, frustum.eye, frustum.forward),
            down: padded(row(1)),
            texel_right: padded(frustum.texel[0]),
            texel_up: padded(frustum.texel[1]),
            forward: padded(frustum.forward),
        };
        let mut bytes = bytemuck::bytes_of(&space).to_vec();
        for light in lights {
            bytes.extend_from_slice(bytemuck::bytes_of(&TurnedLight::new(frustum, light)));
        }
        bytes
    }

    /// Records the voxels that the scene fills.
    fn prepare(&self, recorder: &mut Recorder, stride: u32) {
        let pixels = recorder.buffers.needs.pixels();
        let lights = recorder.lights.len() as u32;
        recorder.clear(Slot::Voxels);
        recorder.clear_words(Slot::Large, 0, 1);
        let mut run = |pass, frame, groups| recorder.run(pass, Timed::Visibility, frame, groups);
        run(&self.range, 0, Groups::Count(pixels.max(self.corners)));
        for light in 0..lights {
            run(&self.clearance, light * stride, Groups::Count(1));
        }
        run(&self.small, 0, Groups::Count(self.triangles));
        run(&self.dispatch, 0, Groups::Count(1));
        run(&self.large, 0, Groups::Tasks);
    }

    fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        self.masks.run(recorder, frame, last, Groups::Rays);
    }
}
