//! Uniform that all shaders read.

use bytemuck::{Pod, Zeroable};
use halflight_core::camera::View;
use halflight_core::frame::Sharing;
use halflight_core::hash;
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::scene::Camera;
use halflight_cpu::upsample::SurfaceLimits;

use crate::needs::{level_places, words};

/// Twin of `Pattern` in `shaders/shared/frame.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuPattern {
    pub(crate) kind: u32,
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    pub(crate) count: u32,
    pub(crate) words: u32,
    pub(crate) stride: u32,
    pub(crate) scale: [f32; 2],
}

impl GpuPattern {
    /// Returns a pattern as shaders read it.
    pub(crate) fn new(pattern: Pattern) -> Self {
        let count = pattern.len() as u32;
        Self {
            kind: match pattern.kind {
                PatternKind::Grid => 0,
                PatternKind::ShiftedRows => 1,
                PatternKind::Jittered => 2,
            },
            columns: pattern.columns.into(),
            rows: pattern.rows.into(),
            count,
            words: words(pattern),
            stride: if count <= 64 { count.next_power_of_two() } else { count.next_multiple_of(64) },
            scale: [1.0 / f32::from(pattern.columns), 1.0 / f32::from(pattern.rows)],
        }
    }
}

/// Twin of `Frame` in `shaders/shared/frame.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Frame {
    pub(crate) eye: [f32; 3],
    pub(crate) width: u32,
    pub(crate) corner: [f32; 3],
    pub(crate) height: u32,
    pub(crate) right: [f32; 3],
    pub(crate) level: u32,
    pub(crate) down: [f32; 3],
    pub(crate) scene_size: f32,
    pub(crate) light_corner: [f32; 3],
    pub(crate) light_area: f32,
    pub(crate) light_u: [f32; 3],
    pub(crate) two_sided: u32,
    pub(crate) light_v: [f32; 3],
    pub(crate) light: u32,
    pub(crate) light_cross: [f32; 3],
    pub(crate) key: u32,
    pub(crate) light_normal: [f32; 3],
    pub(crate) sharing: u32,
    pub(crate) radiance: [f32; 3],
    pub(crate) capacity: u32,
    pub(crate) pattern: GpuPattern,
    pub(crate) depth_break: f32,
    pub(crate) curvature_break: f32,
    pub(crate) enough: f32,
    pub(crate) coarsest: u32,
    pub(crate) slots: u32,
    pub(crate) split_above: u32,
    pub(crate) gradient_above: u32,
    pub(crate) depth_finest: u32,
    pub(crate) surface: [f32; 4],
    pub(crate) crease_sine: f32,
    pub(crate) pixel_footprint: f32,
    pub(crate) error: f32,
    pub(crate) step_level: u32,
    pub(crate) lights: u32,
    pub(crate) sides: u32,
    pub(crate) largest: f32,
    pub(crate) shading: u32,
    pub(crate) levels: [u32; 8],
    pub(crate) outline: [u32; 4],
    pub(crate) outline_corners: [[f32; 4]; 12],
    pub(crate) outline_sides: [[f32; 4]; 12],
    pub(crate) mean_radiance: [f32; 4],
    pub(crate) texture: [u32; 4],
    pub(crate) texture_size: [u32; 4],
}

impl Frame {
    /// Returns the uniform of an image, without what depends on scene and light.
    pub(crate) fn new(
        camera: &Camera,
        (width, height): (u32, u32),
        pattern: Pattern,
        limits: SurfaceLimits,
    ) -> Self {
        let view = View::new(camera, width, height);
        let [cos_smooth, cos_break] =
            [limits.smooth_deg, limits.break_deg].map(|degrees| degrees.to_radians().cos());
        let half_angle = camera.fov_y_deg.to_radians() * 0.5;
        Self {
            eye: view.eye.to_array(),
            corner: view.corner.as_vec3().to_array(),
            right: view.right.as_vec3().to_array(),
            down: view.down.as_vec3().to_array(),
            width,
            height,
            pattern: GpuPattern::new(pattern),
            slots: 1,
            pixel_footprint: 2.0 * half_angle.tan() / height as f32,
            surface: [
                limits.offset_px * 2.0 * half_angle.tan() / height as f32,
                2.0 * limits.bend * limits.bend,
                cos_break,
                1.0 / (cos_smooth - cos_break).max(1e-6),
            ],
            levels: level_places(width, height),
            ..Self::zeroed()
        }
    }

    /// Returns the uniform with the key of its light's patterns.
    pub(crate) fn with_key(self, key: Key) -> Self {
        Self {
            key: hash::fold(hash::fold(hash::mix(key.seed), key.frame), self.light),
            sharing: match key.sharing {
                Sharing::Receiver => 0,
                Sharing::Fragment => 1,
                Sharing::Frame => 2,
            },
            ..self
        }
    }
}

/// Values that pattern keys depend on besides light and place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    pub(crate) seed: u32,
    pub(crate) frame: u32,
    pub(crate) sharing: Sharing,
}
