//! Whether one surface point rises above another's tangent plane.
//!
//! What rises above a point can shadow it at close range, or lies across a step from it; what lies below can do neither. So
//! a visible fraction may be interpolated over convex surfaces, however curved, and not over concave creases and steps.

use halflight_core::frame::Frame;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use serde::{Deserialize, Serialize};

/// How far one point may rise above the other's tangent plane, either way, before nothing is interpolated between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RiseLimits {
    /// Elevation in degrees: 10, so that a concave crease of 20° parts its sides wherever it is seen, and one of 10° may.
    /// Rounder hollows have no contact shadow that interpolation could lose.
    pub crease_deg: f32,
    /// Height, in footprints of a pixel at the nearer one's depth, between pixels that are neighbours; more in proportion
    /// between others: 1. On a floor seen at a glancing angle steps have no elevation to speak of.
    pub step_px: f32,
}

impl Default for RiseLimits {
    fn default() -> Self {
        Self { crease_deg: 10.0, step_px: 1.0 }
    }
}

/// Compares pixels of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rise<'a> {
    gbuffer: &'a GBuffer,
    sine: f32,
    footprint: f32,
}

impl<'a> Rise<'a> {
    pub(crate) fn new(frame: &Frame<'a>, limits: &RiseLimits) -> Self {
        let half_angle = frame.scene.camera.fov_y_deg.to_radians() * 0.5;
        Self {
            gbuffer: frame.gbuffer,
            sine: limits.crease_deg.to_radians().sin(),
            footprint: limits.step_px * 2.0 * half_angle.tan() / frame.gbuffer.height.max(1) as f32,
        }
    }

    /// Whether the pixel sees geometry.
    #[inline]
    pub(crate) fn is_receiver(&self, pixel: usize) -> bool {
        self.gbuffer.is_receiver(pixel)
    }

    /// Whether something parts two pixels that lie `apart` columns or rows from each other.
    #[inline]
    pub(crate) fn parts(&self, a: usize, b: usize, apart: u32) -> bool {
        let GBuffer { primitive, position, normal, depth, .. } = self.gbuffer;
        // One triangle, or nothing on both sides.
        if primitive[a] == primitive[b] {
            return false;
        }
        if primitive[a] == NO_PRIMITIVE || primitive[b] == NO_PRIMITIVE {
            return true;
        }
        let between = position[b] - position[a];
        let (above_a, above_b) = (normal[a].dot(between), -normal[b].dot(between));
        let step = self.footprint * depth[a].min(depth[b]) * apart as f32;
        // Far from the origin single precision is coarser than a pixel.
        let rounding = position[a].abs().max_element() * (8.0 * f32::EPSILON);
        // What is no number is parted.
        let limit = (self.sine * between.length()).min(step) + rounding;
        above_a > limit || above_b > limit || (above_a + above_b).is_nan()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use halflight_core::frame::Sharing;
    use halflight_core::pattern::{Pattern, PatternKind};
    use halflight_core::pyramid::Pyramid;
    use halflight_core::scene::Scene;

    use super::*;

    /// Whether two neighbouring pixels are parted: a point of a floor and one a pixel's footprint to its right and `up`
    /// footprints above, whose normal leans to the right by `lean` degrees.
    fn parted(up: f32, lean: f32, edit: impl Fn(&mut GBuffer)) -> bool {
        let scene = Scene::default();
        let footprint = 2.0 * (scene.camera.fov_y_deg.to_radians() * 0.5).tan();
        let mut gbuffer = GBuffer::default();
        gbuffer.reset(2, 1);
        gbuffer.depth.fill(1.0);
        gbuffer.primitive.copy_from_slice(&[0, 1]);
        gbuffer.position[1] = Vec3::new(1.0, up, 0.0) * footprint;
        let lean = lean.to_radians();
        gbuffer.normal.copy_from_slice(&[Vec3::Y, Vec3::new(lean.sin(), lean.cos(), 0.0)]);
        edit(&mut gbuffer);
        let frame = Frame {
            scene: &scene,
            gbuffer: &gbuffer,
            pyramid: &Pyramid::default(),
            pattern: Pattern { kind: PatternKind::Grid, columns: 1, rows: 1 },
            sharing: Sharing::Frame,
            index: 0,
            seed: 0,
        };
        let rise = Rise::new(&frame, &RiseLimits::default());
        assert_eq!(rise.parts(0, 1, 1), rise.parts(1, 0, 1));
        rise.parts(0, 1, 1)
    }

    #[test]
    fn convex_surfaces_are_one_and_creases_and_steps_part() {
        let as_is = |_: &mut GBuffer| {};
        assert!(!parted(0.0, 0.0, as_is));
        // The edge of a table towards its front, and a sphere.
        assert!(!parted(-1.0, 80.0, as_is));
        assert!(!parted(-0.1, 12.0, as_is));
        // A wall that rises from the floor, and a hollow that hardly does.
        assert!(parted(1.0, -80.0, as_is));
        assert!(!parted(0.05, -6.0, as_is));
        // Steps up and down, and one too low to matter.
        assert!(parted(2.0, 0.0, as_is) && parted(-2.0, 0.0, as_is));
        assert!(!parted(0.1, 0.0, as_is));
        // At a glancing angle a step has a height but no elevation.
        let glancing = |up: f32| parted(up, 0.0, |gbuffer| gbuffer.position[1].x *= 30.0);
        assert!(glancing(1.5) && !glancing(0.5));
    }

    #[test]
    fn triangles_are_one_and_nothing_is_apart() {
        assert!(!parted(2.0, 0.0, |gbuffer| gbuffer.primitive.fill(7)));
        assert!(!parted(2.0, 0.0, |gbuffer| gbuffer.primitive.fill(NO_PRIMITIVE)));
        assert!(parted(0.0, 0.0, |gbuffer| gbuffer.primitive[1] = NO_PRIMITIVE));
        assert!(parted(0.0, 0.0, |gbuffer| gbuffer.normal[0] = Vec3::NAN));
    }
}
