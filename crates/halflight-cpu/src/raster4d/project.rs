//! Projections of points onto a plane parallel to a light, through every point of the light at once (Wang17
//! §3.1).
//!
//! In the coordinates of the light's frame a point has a position (u, v) over the frame, whose corners are 0 and 1,
//! and a height h above its plane. Through the point q of the light, (u, h) projects to `q + (u − q) · D / h`
//! on a plane at height D: for all of the light that is an interval, and with v a rectangle.

use glam::{DVec3, Vec3};
use halflight_core::light::LightFrame;

/// Margin in edges by which a light is extended. It covers samples that rounding has put outside, and rays
/// that pass the light's plane beside their sample because the sample is slightly off the plane.
const MARGIN: f64 = 1.0 / 64.0;

/// Rounding error of a sample's position, relative to its coordinates, with a safety factor.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// Rectangle on the plane, in edges of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rectangle {
    pub(super) low: [f32; 2],
    pub(super) high: [f32; 2],
}

impl Rectangle {
    /// Rectangle that every other one covers.
    pub(super) const EMPTY: Self = Self { low: [f32::INFINITY; 2], high: [f32::NEG_INFINITY; 2] };

    /// Rectangle that is covered wherever one of the given ones is: a rectangle that does not cover it covers
    /// none of them.
    pub(super) fn within(rectangles: impl Iterator<Item = Self>) -> Self {
        let mut all = Self { low: [f32::NEG_INFINITY; 2], high: [f32::INFINITY; 2] };
        for one in rectangles {
            for axis in 0..2 {
                all.low[axis] = all.low[axis].max(one.low[axis]);
                all.high[axis] = all.high[axis].min(one.high[axis]);
            }
        }
        all
    }
}

/// Side of a light, and the plane on that side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection {
    corner: DVec3,
    /// Vectors whose products with a point are its position over the light.
    across: [DVec3; 2],
    normal: DVec3,
    /// Height of the plane.
    distance: f64,
    /// Upper bound on the distance of samples from the light's plane, metres.
    thickness: f64,
}

impl Projection {
    /// Projection on the side of a light that its normal points to, or on its back; the plane lies beyond all
    /// points within `reach`.
    pub(super) fn new(light: LightFrame, back: bool, reach: f64) -> Self {
        let (u, v) = (light.u.as_dvec3(), light.v.as_dvec3());
        let normal = u.cross(v).normalize_or_zero();
        let (du, dv) = (v.cross(normal), normal.cross(u));
        let size =
            light.origin.abs().max_element() + light.u.abs().max_element() + light.v.abs().max_element();
        Self {
            corner: light.origin.as_dvec3(),
            across: [du / du.dot(u), dv / dv.dot(v)],
            normal: if back { -normal } else { normal },
            distance: reach,
            thickness: f64::from(size) * ROUNDING,
        }
    }

    /// Position and height of a point.
    fn local(&self, point: Vec3) -> [f64; 3] {
        let from = point.as_dvec3() - self.corner;
        [from.dot(self.across[0]), from.dot(self.across[1]), from.dot(self.normal)]
    }

    /// Rectangle of a receiver and its projection through the light's corner. `None` where the receiver is so
    /// near the light's plane that the two do not bound the triangles that hide the light from it.
    pub(super) fn receiver(&self, point: Vec3) -> Option<(Rectangle, [f32; 2])> {
        let [u, v, h] = self.local(point);
        // Upper bound on the distance between a ray and its sample where the ray passes the light's plane.
        let aside = self.thickness / h * (u.abs().max(v.abs()) + 2.0);
        if !(h > 0.0 && aside < MARGIN / 2.0) {
            return None;
        }
        let scale = self.distance / h;
        let interval = |x: f64| {
            let (low, high) = (-MARGIN, 1.0 + MARGIN);
            ((high + (x - high) * scale) as f32, (low + (x - low) * scale) as f32)
        };
        let (x, y) = (interval(u), interval(v));
        let rectangle = Rectangle { low: [x.0, y.0], high: [x.1, y.1] };
        Some((rectangle, [(u * scale) as f32, (v * scale) as f32]))
    }

    /// Rectangle around the projections of a triangle, or `None` where it lies behind the light.
    pub(super) fn triangle(&self, corners: [Vec3; 3]) -> Option<Rectangle> {
        let corners = corners.map(|corner| self.local(corner));
        // Below this distance from the light's plane, projections are meaningless.
        let near = 64.0 * self.thickness;
        let highest = corners.iter().map(|corner| corner[2]).fold(f64::NEG_INFINITY, f64::max);
        if highest < -self.thickness {
            return None;
        }
        let mut rectangle = Rectangle::EMPTY;
        let mut beside = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        let mut touches = false;
        for (at, from) in corners.iter().enumerate() {
            let to = corners[(at + 1) % 3];
            if from[2] >= near {
                self.include(&mut rectangle, *from);
            } else if from[2] >= -self.thickness {
                touches = true;
                widen(&mut beside, *from);
            }
            for height in [near, -self.thickness] {
                if (from[2] < height) != (to[2] < height) {
                    let t = (height - from[2]) / (to[2] - from[2]);
                    let crossing = [from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t, height];
                    if height == near {
                        self.include(&mut rectangle, crossing);
                    }
                    touches = true;
                    widen(&mut beside, crossing);
                }
            }
        }
        if touches {
            // Part at the light's plane: unbounded on every side unless it lies beside the light.
            for (axis, (low, high)) in beside.into_iter().enumerate() {
                let scale = self.distance / near;
                let bound = |x: f64, q: f64| q + (x - q) * scale;
                let (left, right) = (-2.0 * MARGIN, 1.0 + 2.0 * MARGIN);
                let lowest = if low > right { bound(low, right) } else { f64::NEG_INFINITY };
                let highest = if high < left { bound(high, left) } else { f64::INFINITY };
                rectangle.low[axis] = rectangle.low[axis].min(lowest as f32);
                rectangle.high[axis] = rectangle.high[axis].max(highest as f32);
            }
        }
        // Rounded outwards by more than the rounding error of receivers.
        for axis in 0..2 {
            let (low, high) = (rectangle.low[axis], rectangle.high[axis]);
            let room = |x: f32| if x.is_finite() { x.abs() * 2f32.powi(-20) + 1e-6 } else { 0.0 };
            rectangle.low[axis] = low - room(low);
            rectangle.high[axis] = high + room(high);
        }
        Some(rectangle)
    }

    fn include(&self, rectangle: &mut Rectangle, [u, v, h]: [f64; 3]) {
        let scale = self.distance / h;
        for (axis, x) in [u, v].into_iter().enumerate() {
            for q in [-MARGIN, 1.0 + MARGIN] {
                let at = (q + (x - q) * scale) as f32;
                rectangle.low[axis] = rectangle.low[axis].min(at);
                rectangle.high[axis] = rectangle.high[axis].max(at);
            }
        }
    }
}

fn widen(beside: &mut [(f64, f64); 2], point: [f64; 3]) {
    for (axis, bounds) in beside.iter_mut().enumerate() {
        *bounds = (bounds.0.min(point[axis]), bounds.1.max(point[axis]));
    }
}
