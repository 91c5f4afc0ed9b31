//! Lights that are convex polygons.

use glam::{DVec3, Vec3};

use super::LightFrame;
use super::extent::{MOST_CORNERS, Sides};

/// Largest distance of a corner from the polygon's plane, relative to its size.
const FLAT: f64 = 1e-4;

/// Convex polygon that emits to the side from which its corners run counterclockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygon {
    corners: [Vec3; MOST_CORNERS],
    count: usize,
    frame: LightFrame,
}

/// Why corners are no polygon that can emit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PolygonError {
    /// Too few or too many corners.
    #[error("{0} corners, expected 3 to {MOST_CORNERS}")]
    Count(usize),
    /// A coordinate is NaN or infinite, or all corners lie on a line.
    #[error("corners span no area")]
    NoArea,
    /// A corner lies off the plane of the others.
    #[error("corner {0} lies off the plane of the others")]
    Plane(usize),
    /// The polygon is not convex, or it crosses itself.
    #[error("not convex at corner {0}; divide it into convex lights")]
    Concave(usize),
}

impl Polygon {
    /// Creates a polygon of 3 to 12 corners, world space, metres.
    ///
    /// # Errors
    /// The corners are too few or too many, span no area, do not lie in a plane or are not convex.
    pub fn new(corners: &[Vec3]) -> Result<Self, PolygonError> {
        let count = corners.len();
        if !(3..=MOST_CORNERS).contains(&count) {
            return Err(PolygonError::Count(count));
        }
        let points: Vec<DVec3> = corners.iter().map(|corner| corner.as_dvec3()).collect();
        let edge = |index: usize| points[(index + 1) % count] - points[index];
        let longest = (0..count).max_by(|&a, &b| edge(a).length().total_cmp(&edge(b).length())).unwrap_or(0);
        let from = |index: usize| points[index] - points[0];
        let area: DVec3 = (1..count - 1).map(|index| from(index).cross(from(index + 1))).sum();
        let size = points.iter().map(|point| (*point - points[0]).length()).fold(0.0, f64::max);
        // NaN must fail as well.
        if !(area.length() > 1e-6 * size * size && size.is_finite()) {
            return Err(PolygonError::NoArea);
        }
        let normal = area.normalize();
        if let Some(corner) = (0..count).find(|&index| from(index).dot(normal).abs() > FLAT * size) {
            return Err(PolygonError::Plane(corner));
        }
        // Each corner turns to the left, and all of them together once.
        let mut turned = 0.0;
        for index in 0..count {
            let (before, after) = (edge((index + count - 1) % count), edge(index));
            let (sine, cosine) = (before.cross(after).dot(normal), before.dot(after));
            if sine < -FLAT * before.length() * after.length() || after == DVec3::ZERO {
                return Err(PolygonError::Concave(index));
            }
            turned += sine.atan2(cosine);
        }
        if (turned / std::f64::consts::TAU - 1.0).abs() > 0.25 {
            return Err(PolygonError::Concave(0));
        }
        // The frame is the rectangle along the longest edge.
        let along = edge(longest).normalize();
        let across = normal.cross(along);
        let range = |axis: DVec3| {
            let places = points.iter().map(|point| (*point - points[0]).dot(axis));
            places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
        };
        let ((left, right), (low, high)) = (range(along), range(across));
        let frame = LightFrame {
            origin: (points[0] + along * left + across * low).as_vec3(),
            u: (along * (right - left)).as_vec3(),
            v: (across * (high - low)).as_vec3(),
        };
        let mut all = [Vec3::ZERO; MOST_CORNERS];
        all[..count].copy_from_slice(corners);
        Ok(Self { corners: all, count, frame })
    }

    /// The corners.
    pub fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// Rectangle around the polygon, along its longest edge.
    pub fn frame(&self) -> LightFrame {
        self.frame
    }

    /// Area in m².
    pub fn area(&self) -> f32 {
        let from = |index: usize| (self.corners[index] - self.corners[0]).as_dvec3();
        let area: DVec3 = (1..self.count - 1).map(|index| from(index).cross(from(index + 1))).sum();
        (0.5 * area.length()) as f32
    }

    /// Sides in the coordinates of the frame.
    pub(super) fn sides(&self) -> Sides {
        let LightFrame { origin, u, v } = self.frame;
        let (u, v) = (u.as_dvec3(), v.as_dvec3());
        let normal = u.cross(v);
        let place = |corner: Vec3| {
            let at = (corner - origin).as_dvec3();
            let dual =
                |edge: DVec3, other: DVec3| at.dot(other.cross(normal)) / edge.dot(other.cross(normal));
            (dual(u, v), dual(v, u))
        };
        let mut coefficients = [Vec3::ZERO; MOST_CORNERS];
        for (index, side) in coefficients.iter_mut().enumerate().take(self.count) {
            let ((x0, y0), (x1, y1)) =
                (place(self.corners[index]), place(self.corners[(index + 1) % self.count]));
            let (dx, dy) = (x1 - x0, y1 - y0);
            *side = DVec3::new(dy * x0 - dx * y0, -dy, dx).as_vec3();
        }
        Sides { coefficients, count: self.count }
    }

    /// Polygon after an affine map.
    pub(super) fn transformed(&self, point: impl Fn(Vec3) -> Vec3, direction: impl Fn(Vec3) -> Vec3) -> Self {
        let LightFrame { origin, u, v } = self.frame;
        let mut corners = self.corners;
        corners[..self.count].iter_mut().for_each(|corner| *corner = point(*corner));
        Self {
            corners,
            count: self.count,
            frame: LightFrame { origin: point(origin), u: direction(u), v: direction(v) },
        }
    }

    /// Polygon that emits to the other side.
    pub(super) fn reversed(&self) -> Self {
        let LightFrame { origin, u, v } = self.frame;
        let mut corners = self.corners;
        corners[..self.count].reverse();
        Self { corners, count: self.count, frame: LightFrame { origin, u: v, v: u } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(points: &[[f32; 2]]) -> Vec<Vec3> {
        points.iter().map(|&[x, z]| Vec3::new(x, 1.0, -z)).collect()
    }

    #[test]
    fn bad_corners_are_refused() {
        let square = at(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        let error = |corners: &[Vec3]| Polygon::new(corners).unwrap_err();
        assert_eq!(Polygon::new(&square).map(|polygon| polygon.area()), Ok(1.0));
        assert_eq!(error(&square[..2]), PolygonError::Count(2));
        assert_eq!(error(&[Vec3::ZERO; 13]), PolygonError::Count(13));
        assert_eq!(error(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0]), PolygonError::NoArea);
        assert_eq!(error(&[Vec3::ZERO, Vec3::X, Vec3::splat(f32::NAN)]), PolygonError::NoArea);
        let mut bent = square.clone();
        bent[2].y += 0.1;
        assert!(matches!(error(&bent), PolygonError::Plane(_)));
        let dented = at(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]]);
        assert_eq!(error(&dented), PolygonError::Concave(2));
        // A pentagram turns to the left everywhere, twice.
        let star: Vec<[f32; 2]> = (0..5)
            .map(|k| (k as f32 * 2.0 * 0.4 * std::f32::consts::PI).sin_cos())
            .map(|(a, b): (f32, f32)| [b, a])
            .collect();
        assert!(matches!(error(&at(&star)), PolygonError::Concave(_)));
    }

    #[test]
    fn sides_part_inside_from_outside() {
        let polygon = Polygon::new(&at(&[[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [1.0, 3.0]])).unwrap();
        let LightFrame { origin, u, v } = polygon.frame();
        let inside = |x: f32, z: f32| {
            let at = Vec3::new(x, 1.0, -z) - origin;
            let uv = glam::Vec2::new(at.dot(u) / u.length_squared(), at.dot(v) / v.length_squared());
            super::super::Extent::Polygon(polygon.sides()).contains(uv)
        };
        assert!(inside(1.0, 1.0) && inside(2.5, 0.9) && inside(1.0, 2.5));
        assert!(!inside(2.5, 0.4) && !inside(0.1, 0.5) && !inside(2.5, 2.0) && !inside(1.0, -0.01));
    }
}
