//! Lights that are spheres.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::Ellipse;

/// Distance from a sphere within which a receiver counts as lying on it, relative to the largest coordinate: 32 units in the last place, as for
/// lights that are flush with a surface.
const ROUNDING: f64 = 32.0 / 16_777_216.0;

/// Sphere that emits from all of its surface, and towards receivers inside it from all directions.
///
/// Which part of it a receiver sees depends on the receiver: the cone that touches the sphere touches it along a circle, and the disk inside
/// that circle covers the sphere exactly ([`Sphere::disk_seen_from`]). Light samples are strata of the square around that disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, world space, metres.
    pub centre: Vec3,
    /// Radius, metres, above 0.
    pub radius: f32,
}

impl Sphere {
    /// Disk that covers the sphere as seen from a receiver outside it: the one whose edge is the circle along which the cone from the receiver
    /// touches the sphere. It emits towards the receiver.
    ///
    /// Its axes are the world's X and Z axes, turned by the smallest rotation that takes the Y axis to the direction from the receiver to the
    /// centre, so that they vary smoothly between receivers but for those straight above the sphere. From inside the sphere, and from
    /// where rounding cannot tell, it is [`Sphere::great_disk`]: such receivers are [surrounded](Sphere::surrounds).
    pub fn disk_seen_from(&self, origin: Vec3) -> Ellipse {
        let (centre, radius) = (self.centre.as_dvec3(), f64::from(self.radius));
        let to = centre - origin.as_dvec3();
        let squared = to.length_squared();
        let outside = squared - radius * radius;
        if self.surrounds(origin) || outside <= 0.0 {
            return self.great_disk();
        }
        let distance = squared.sqrt();
        let [along, across] = turned_axes(to / distance);
        // Height of the right-angled triangle of receiver, centre and a point of the circle.
        let rim = radius * outside.sqrt() / distance;
        Ellipse {
            centre: (centre - to * (radius * radius / squared)).as_vec3(),
            axis_u: (along * rim).as_vec3(),
            axis_v: (across * rim).as_vec3(),
        }
    }

    /// Disk through the centre that faces along −Y: a stand-in of the sphere's size, for no receiver in particular.
    pub fn great_disk(&self) -> Ellipse {
        Ellipse { centre: self.centre, axis_u: Vec3::X * self.radius, axis_v: Vec3::Z * self.radius }
    }

    /// True for receivers inside the sphere, or as near to it as rounding: to these all of the sphere that is above their horizon is visible.
    pub fn surrounds(&self, origin: Vec3) -> bool {
        let (centre, radius) = (self.centre.as_dvec3(), f64::from(self.radius));
        (origin.as_dvec3() - centre).length() <= radius + self.slack(origin)
    }

    /// Point just before that where the segment from a receiver to a point of its [disk](Sphere::disk_seen_from) enters the sphere: nearer to
    /// the receiver by as much as rounding. `None` if nothing is left of the segment.
    pub fn before_surface(&self, origin: Vec3, point: Vec3) -> Option<Vec3> {
        let from = origin.as_dvec3();
        let (to, d) = (self.centre.as_dvec3() - from, point.as_dvec3() - from);
        let length = d.length();
        let (along, outside) =
            (to.dot(d) / length, to.length_squared() - f64::from(self.radius) * f64::from(self.radius));
        // Points of the rim may miss the sphere by rounding.
        let enter = outside / (along + (along * along - outside).max(0.0).sqrt());
        let enter = enter.min(length) - self.slack(origin);
        // NaN, on the point itself, is none.
        (enter > 0.0).then(|| (from + d * (enter / length)).as_vec3())
    }

    /// Low and high corner of the box around the sphere, grown by as much as rounding at receivers no farther from the world's origin than
    /// `largest`.
    pub fn padded_bounds(&self, largest: f32) -> (Vec3, Vec3) {
        let around = Vec3::splat(self.radius + 2.0 * self.slack(Vec3::splat(largest)) as f32);
        (self.centre - around, self.centre + around)
    }

    /// Corners of a regular tetrahedron around the sphere.
    pub(super) fn corners(&self) -> [Vec3; 4] {
        // The sphere touches the middles of the faces; corners are three times as far away. A little is added for rounding.
        let far = self.radius * (3.0f32.sqrt() * 1.0001);
        [Vec3::ONE, Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(-1.0, -1.0, 1.0)]
            .map(|corner| self.centre + corner * far)
    }

    /// Surface area in m².
    pub(super) fn area(&self) -> f32 {
        (4.0 * PI * f64::from(self.radius) * f64::from(self.radius)) as f32
    }

    /// Bound on the rounding of distances between a receiver and the sphere, metres.
    fn slack(&self, origin: Vec3) -> f64 {
        let largest = origin.abs().max_element().max(self.centre.abs().max_element()).max(self.radius);
        f64::from(largest) * ROUNDING
    }
}

/// Images of the X and Z axes under the smallest rotation that takes the Y axis to a unit vector (Frisvad 2012).
fn turned_axes(to: DVec3) -> [DVec3; 2] {
    let DVec3 { x, y, z } = to;
    let level = x * x + z * z;
    // 1 / (1 + y), without cancellation where y is near −1.
    let factor = if y >= 0.0 {
        1.0 / (1.0 + y)
    } else if level > 0.0 {
        (1.0 - y) / level
    } else {
        return [-DVec3::X, DVec3::Z];
    };
    [
        DVec3::new(1.0 - x * x * factor, -x, -x * z * factor),
        DVec3::new(-x * z * factor, -z, 1.0 - z * z * factor),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPHERE: Sphere = Sphere { centre: Vec3::new(0.5, 2.0, -1.0), radius: 0.75 };

    /// Receivers all around, from beside the surface to far away, straight above and below.
    fn receivers() -> impl Iterator<Item = Vec3> {
        let directions = (0..400).map(|index| {
            let height = 1.0 - 2.0 * index as f32 / 399.0;
            let (sine, cosine) = (index as f32 * 2.399_963).sin_cos();
            let level = (1.0 - height * height).max(0.0).sqrt();
            Vec3::new(level * cosine, height, level * sine)
        });
        directions.flat_map(|direction| {
            [1.001, 1.5, 4.0, 300.0].map(|far| SPHERE.centre + direction * (SPHERE.radius * far))
        })
    }

    #[test]
    fn the_disk_touches_the_cone_and_emits_towards_the_receiver() {
        for origin in receivers() {
            let Ellipse { centre, axis_u, axis_v } = SPHERE.disk_seen_from(origin);
            let d = (origin - SPHERE.centre).length();
            // Rounding of points, relative to the disk.
            let slack = 1e-6 * origin.abs().max_element().max(2.0);
            for turn in 0..8 {
                let (sine, cosine) = (turn as f32 * 0.785).sin_cos();
                let rim = centre + axis_u * cosine + axis_v * sine;
                assert!(((rim - SPHERE.centre).length() - SPHERE.radius).abs() < slack, "{origin}");
                // Tangents are perpendicular to radii.
                assert!((rim - origin).dot(rim - SPHERE.centre).abs() < slack * d, "{origin}");
            }
            assert!(axis_u.cross(axis_v).dot(origin - centre) > 0.0, "{origin}");
            assert!((axis_u.length() - axis_v.length()).abs() < slack && axis_u.dot(axis_v).abs() < slack);
        }
    }

    #[test]
    fn axes_vary_smoothly_but_above_the_sphere() {
        for index in 0..360 {
            let (sine, cosine) = (index as f32).to_radians().sin_cos();
            for height in [-2.0f32, -0.5, 0.0, 0.5, 1.9] {
                let at = |by: Vec3| {
                    SPHERE.disk_seen_from(SPHERE.centre + Vec3::new(cosine, height, sine) * 3.0 + by)
                };
                let (here, there) = (at(Vec3::ZERO), at(Vec3::new(0.01, 0.0, -0.01)));
                // No faster than four times the direction to the centre turns.
                assert!((here.axis_u - there.axis_u).length() < 0.02, "{index} {height}");
            }
        }
        let pole = SPHERE.disk_seen_from(SPHERE.centre + Vec3::Y * 2.0);
        assert!(pole.axis_u.is_finite() && pole.axis_u.cross(pole.axis_v).y > 0.0);
    }

    #[test]
    fn receivers_inside_and_on_the_sphere_are_surrounded() {
        assert!(SPHERE.surrounds(SPHERE.centre) && SPHERE.surrounds(SPHERE.centre + Vec3::X * 0.75));
        assert!(!SPHERE.surrounds(SPHERE.centre + Vec3::X * 0.7501));
        assert_eq!(SPHERE.disk_seen_from(SPHERE.centre), SPHERE.great_disk());
    }

    #[test]
    fn segments_end_before_the_surface() {
        for origin in receivers() {
            let Ellipse { centre, axis_u, axis_v } = SPHERE.disk_seen_from(origin);
            for (u, v) in [(0.0, 0.0), (0.7, 0.0), (-0.3, 0.9), (0.0, -1.0)] {
                let point = centre + axis_u * u + axis_v * v;
                let Some(end) = SPHERE.before_surface(origin, point) else {
                    assert!((origin - SPHERE.centre).length() < 1.01 * SPHERE.radius);
                    continue;
                };
                let slack = 1e-5 * origin.abs().max_element().max(2.0);
                assert!((end - SPHERE.centre).length() > SPHERE.radius - 0.1 * slack, "{origin}");
                assert!((end - SPHERE.centre).length() < SPHERE.radius + slack, "{origin}");
                assert!((end - origin).length() <= (point - origin).length() * 1.000_001);
            }
            assert_eq!(SPHERE.before_surface(origin, origin), None);
        }
    }

    #[test]
    fn the_tetrahedron_contains_the_sphere() {
        let corners = SPHERE.corners();
        for face in 0..4 {
            let [a, b, c] = [1, 2, 3].map(|by| corners[(face + by) % 4]);
            let normal = (b - a).cross(c - a).normalize();
            let (inner, outer) = (normal.dot(SPHERE.centre - a), normal.dot(corners[face] - a));
            assert!(
                inner * outer > 0.0 && inner.abs() >= SPHERE.radius && inner.abs() < SPHERE.radius * 1.001
            );
        }
    }
}
