//! Swaying: a horizontal displacement that grows with the square of the height.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

/// Swaying of a mesh, such as a tree in the wind. Points move horizontally, so no triangle loses its area;
/// lengths along the trunk are preserved to first order in amplitude over height.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sway {
    /// Displacement of the highest vertex at full swing, horizontal, metres.
    pub(super) amplitude: Vec3,
    /// Duration of one swing to both sides, seconds.
    pub(super) period: f32,
    /// Height below which nothing moves, world space, metres.
    pub(super) foot: f32,
    /// Height of the highest vertex above the foot, metres.
    pub(super) height: f32,
}

/// Displacement of a swaying body at one time.
pub(super) struct Bend {
    /// Displacement of the highest vertex.
    top: DVec3,
    foot: f64,
    height: f64,
}

impl Sway {
    /// Displacement at `time`; none where the body is straight, bit for bit.
    pub(super) fn at(&self, time: f32) -> Option<Bend> {
        let swing = (TAU * f64::from(time) / f64::from(self.period)).sin();
        (swing != 0.0).then(|| Bend {
            top: self.amplitude.as_dvec3() * swing,
            foot: self.foot.into(),
            height: self.height.into(),
        })
    }
}

impl Bend {
    /// Displaced vertex and its unit normal.
    pub(super) fn vertex(&self, position: Vec3, normal: Vec3) -> (Vec3, Vec3) {
        let share = (f64::from(position.y) - self.foot) / self.height;
        if share <= 0.0 {
            return (position, normal);
        }
        let bent = position.as_dvec3() + self.top * (share * share);
        // The inverse transpose of the displacement's derivative, which changes with height alone.
        let normal = normal.as_dvec3();
        let slope = self.top.dot(normal) * (2.0 * share / self.height);
        (bent.as_vec3(), (normal - DVec3::Y * slope).normalize_or(normal).as_vec3())
    }
}
