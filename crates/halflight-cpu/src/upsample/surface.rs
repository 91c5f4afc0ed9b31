//! Surface test for upsamplers: decides if two pixels see the same surface.

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use serde::{Deserialize, Serialize};

/// Limits on the bending and offset of a surface within which values are mixed.
///
/// A point is compared with another's tangent plane and not with its depth, so that slanted floors stay
/// connected.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SurfaceLimits {
    /// Distance between a point and a tangent plane above which they are separate, in pixel footprints at the
    /// point's depth.
    pub offset_px: f32,
    /// Increase of that distance with the turn of the normal, as a multiple of the turn (radians) times the
    /// distance between the points. A facet's neighbour deviates by 1, a sphere by 1/2.
    pub bend: f32,
    /// Turn of the normal, in degrees, up to which values are mixed freely.
    pub smooth_deg: f32,
    /// Turn of the normal, in degrees, from which values are not mixed at all.
    pub break_deg: f32,
}

impl Default for SurfaceLimits {
    fn default() -> Self {
        Self { offset_px: 1.0, bend: 1.5, smooth_deg: 10.0, break_deg: 30.0 }
    }
}

/// Point with its tangent plane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patch {
    /// World space.
    pub(super) position: Vec3,
    /// Geometric unit normal.
    pub(super) normal: Vec3,
    /// Squared distance off a plane up to which values are mixed, square metres.
    pub(super) allowed: f32,
}

/// Surfaces of the G-buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surfaces<'a> {
    gbuffer: &'a GBuffer,
    footprint: f32,
    bend: f32,
    cos_break: f32,
    turn_scale: f32,
}

impl<'a> Surfaces<'a> {
    pub(super) fn new(frame: &Frame<'a>, limits: &SurfaceLimits) -> Self {
        let gbuffer = frame.gbuffer;
        let half_angle = frame.scene.camera.fov_y_deg.to_radians() * 0.5;
        let cos_break = limits.break_deg.to_radians().cos();
        let cos_smooth = limits.smooth_deg.to_radians().cos();
        Self {
            gbuffer,
            footprint: limits.offset_px * 2.0 * half_angle.tan() / gbuffer.height.max(1) as f32,
            // 2 (1 - cos t) is t² for small turns.
            bend: 2.0 * limits.bend * limits.bend,
            cos_break,
            turn_scale: 1.0 / (cos_smooth - cos_break).max(1e-6),
        }
    }

    /// Surface at a pixel.
    #[inline]
    pub(super) fn patch(&self, pixel: usize) -> Patch {
        let position = self.gbuffer.position[pixel];
        // Far from the origin single precision is coarser than a pixel.
        let rounding = position.abs().max_element() * (8.0 * f32::EPSILON);
        let allowed = self.footprint * self.gbuffer.depth[pixel] + rounding;
        Patch { position, normal: self.gbuffer.normal[pixel], allowed: allowed * allowed + f32::MIN_POSITIVE }
    }

    /// True if the pixel sees geometry.
    #[inline]
    pub(super) fn is_receiver(&self, pixel: usize) -> bool {
        self.gbuffer.is_receiver(pixel)
    }

    /// True if two pixels see the same triangle, and so the same plane. Indices outside the image see
    /// nothing.
    #[inline]
    pub(super) fn same_primitive(&self, a: u32, b: u32) -> bool {
        match (self.gbuffer.primitive.get(a as usize), self.gbuffer.primitive.get(b as usize)) {
            (Some(a), Some(b)) => a == b && *a != NO_PRIMITIVE,
            _ => false,
        }
    }

    /// Agreement of two patches: 1 on one surface, 0 on separate ones, in between near the limits.
    #[inline(always)]
    pub(super) fn agreement(&self, a: &Patch, position: Vec3, normal: Vec3) -> f32 {
        let (misfit, cos) = self.misfit(a, position, normal);
        let flat = (2.0 - 2.0 * misfit).clamp(0.0, 1.0);
        let turn = ((cos - self.cos_break) * self.turn_scale).clamp(0.0, 1.0);
        flat * turn
    }

    /// True if a point lies so close to a plane that it fully agrees with every other such point: a quarter
    /// of the distance at which agreement starts to fall, and a normal that is the same except for rounding.
    #[inline(always)]
    pub(super) fn lies_on(&self, plane: &Patch, position: Vec3, normal: Vec3, allowed: f32) -> bool {
        let off = plane.normal.dot(position - plane.position);
        16.0 * off * off < 0.5 * allowed.min(plane.allowed)
            && (normal - plane.normal).length_squared() < 1e-12
    }

    /// Match of two patches, never 0: orders patches where none agrees, see [`Self::agreement`].
    pub(super) fn likeness(&self, a: &Patch, position: Vec3, normal: Vec3) -> f32 {
        let (misfit, cos) = self.misfit(a, position, normal);
        let facing = (0.5 + 0.5 * cos).clamp(0.0, 1.0);
        (1.0 / (1.0 + misfit)).max(1e-6) * (facing * facing).max(1e-3)
    }

    /// Squared distance off each other's planes, relative to the allowed one, and the cosine between the
    /// normals.
    #[inline(always)]
    fn misfit(&self, a: &Patch, position: Vec3, normal: Vec3) -> (f32, f32) {
        let between = a.position - position;
        let (off_a, off_b) = (a.normal.dot(between), normal.dot(between));
        let off = (off_a * off_a).max(off_b * off_b);
        let cos = a.normal.dot(normal);
        let allowed = a.allowed + self.bend * (1.0 - cos).max(0.0) * between.length_squared();
        (off / allowed, cos)
    }
}
