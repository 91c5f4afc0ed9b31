//! Paths of rigid bodies.

use glam::{DMat3, DVec3, Vec3};

use super::track::{Mix, Track};

/// Bound on coordinates: their differences are finite in single precision.
pub(super) const LIMIT: f64 = f32::MAX as f64 / 4.0;

/// Pose of a body relative to its pose in the scene: a rotation about an axis through a pivot, then a
/// translation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Key {
    pub(super) translate: Vec3,
    /// Angle, counter-clockwise as seen from the tip of the axis.
    pub(super) rotate_deg: f32,
}

/// Path of a rigid body.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Path {
    pub(super) track: Track<Key>,
    /// Rotation axis, unit length.
    pub(super) axis: DVec3,
    /// Point on the axis, world space.
    pub(super) pivot: Vec3,
}

/// A rigid motion, in double precision so that coordinates are rounded only once.
pub(super) struct Rigid {
    rotation: DMat3,
    pivot: DVec3,
    translate: DVec3,
}

impl Mix for Key {
    fn mix(self, to: Self, part: f32) -> Self {
        Self {
            translate: self.translate.mix(to.translate, part),
            rotate_deg: self.rotate_deg.mix(to.rotate_deg, part),
        }
    }
}

impl Path {
    /// Motion from the scene at time 0 to `time`; none where the body has not moved, bit for bit.
    pub(super) fn at(&self, time: f32) -> Option<Rigid> {
        let key = self.track.at(time);
        (key != Key::default()).then(|| Rigid {
            rotation: DMat3::from_axis_angle(self.axis, f64::from(key.rotate_deg).to_radians()),
            pivot: self.pivot.as_dvec3(),
            translate: key.translate.as_dvec3(),
        })
    }

    /// Time of the last key.
    pub(super) fn end(&self) -> f32 {
        self.track.end()
    }

    /// True if the corners of a box stay within single precision at all keys and under any rotation.
    pub(super) fn stays_finite(&self, low: Vec3, high: Vec3) -> bool {
        let pivot = self.pivot.as_dvec3();
        let [low, high] = [low, high].map(|corner| (corner.as_dvec3() - pivot).abs());
        let reach = pivot.abs().max_element() + low.max(high).length();
        let moved = self.track.keys().map(|key| key.translate.as_dvec3().abs().max_element());
        reach + moved.fold(0.0, f64::max) < LIMIT
    }
}

impl Rigid {
    pub(super) fn point(&self, point: Vec3) -> Vec3 {
        (self.rotation * (point.as_dvec3() - self.pivot) + self.pivot + self.translate).as_vec3()
    }

    pub(super) fn direction(&self, direction: Vec3) -> Vec3 {
        (self.rotation * direction.as_dvec3()).as_vec3()
    }
}
