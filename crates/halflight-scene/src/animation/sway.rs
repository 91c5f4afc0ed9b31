//! Swaying: a bend to the side that grows with the square of the height.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

/// Wind in a tree. Points are moved horizontally, so that no triangle loses its area; lengths along the trunk stay up
/// to the square of amplitude over height.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sway {
    /// How far the highest vertex goes to one side, horizontal, metres.
    pub(super) amplitude: Vec3,
    /// Of one swing to both sides, seconds.
    pub(super) period: f32,
    /// Height below which nothing moves, world space, metres.
    pub(super) foot: f32,
    /// From there to the highest vertex, metres.
    pub(super) height: f32,
}

/// A swaying body at one time.
pub(super) struct Bend {
    /// Displacement of the highest vertex.
    top: DVec3,
    foot: f64,
    height: f64,
}

impl Sway {
    /// How it is bent at `time`; none where it stands straight, bit for bit.
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
    /// A vertex and its unit normal, bent.
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
