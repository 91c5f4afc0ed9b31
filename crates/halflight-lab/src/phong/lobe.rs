//! Phong lobes of surface points.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::specular::SurfaceSpecular;

/// Largest exponent: that of the smoothest surface that has one.
const MOST: f32 = 1e6;

/// Lobe of a surface point as seen by the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// Unit shading normal.
    pub(super) normal: Vec3,
    /// Unit mirrored direction.
    pub(super) mirrored: Vec3,
    /// Exponent n.
    pub(super) exponent: f32,
}

impl Lobe {
    /// The lobe of a surface with this unit normal, seen along the unit direction `view`.
    pub(super) fn new(normal: Vec3, view: Vec3, surface: &SurfaceSpecular) -> Self {
        let alpha = surface.roughness * surface.roughness;
        let exponent = (2.0 / (alpha * alpha).max(f32::MIN_POSITIVE) - 2.0).clamp(0.0, MOST);
        Self { normal, mirrored: normal * (2.0 * normal.dot(view)) - view, exponent }
    }

    /// (R·L)ⁿ of a unit direction.
    #[inline]
    pub(super) fn power(&self, to: Vec3) -> f32 {
        self.mirrored.dot(to).max(0.0).powf(self.exponent)
    }

    /// The lobe times the cosine of incidence, for unit radiance along a unit direction, 1/sr: (n + 2) / 2π · (R·L)ⁿ · N·L.
    #[inline]
    pub(super) fn reflected(&self, to: Vec3) -> f32 {
        (self.exponent + 2.0) * (0.5 * FRAC_1_PI) * self.power(to) * self.normal.dot(to).max(0.0)
    }

    /// Part that the lobe would reflect of a light that fills it: (n + 2) / (n + 1) · N·R.
    pub(super) fn whole(&self) -> f32 {
        (self.exponent + 2.0) / (self.exponent + 1.0) * self.normal.dot(self.mirrored).max(0.0)
    }

    /// Tangent of the angle to the mirrored direction at which (R·L)ⁿ is `edge`, at most 10.
    pub(super) fn reach(&self, edge: f32) -> f32 {
        let cosine = edge.powf(1.0 / self.exponent.max(1e-3));
        ((1.0 - cosine * cosine).max(0.0).sqrt() / cosine.max(1e-3)).min(10.0)
    }
}
