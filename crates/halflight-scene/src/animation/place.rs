//! Paths of rigid bodies.

use glam::{DMat3, DVec3, Vec3};

use super::track::{Mix, Track};

/// Differences of what stays below it are finite in single precision.
pub(super) const LIMIT: f64 = f32::MAX as f64 / 4.0;

/// Where a body is, relative to where it stands in the scene: turned about an axis through a pivot, then moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Key {
    pub(super) translate: Vec3,
    /// Counter-clockwise as seen from the tip of the axis.
    pub(super) rotate_deg: f32,
}

/// A rigid body's way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Path {
    pub(super) track: Track<Key>,
    /// Unit.
    pub(super) axis: DVec3,
    /// World space.
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
    /// The motion from the still scene to `time`; none where the body is where it stands, bit for bit.
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

    /// Whether the corners of a box stay within single precision, wherever they are turned to.
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
