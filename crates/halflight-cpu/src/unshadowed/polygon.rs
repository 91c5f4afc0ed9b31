//! Contour integral of convex polygons: Lambert's formula, clipped to the receiver's horizon, in double precision.

use glam::{DVec3, Vec3};

use super::arctangent::angle_over_sine;

/// Half the sum of `n · (a × b) · angle / |a × b|` over the edges of the part above the receiver's horizon.
pub(super) fn flux(corners: &[Vec3], origin: DVec3, normal: DVec3) -> f64 {
    let seen = |index: usize| corners[index % corners.len()].as_dvec3() - origin;
    let (mut sum, mut first, mut last) = (0.0, None, None);
    let mut add = |point: DVec3| {
        if let Some(last) = last {
            sum += edge(last, point, normal);
        }
        first.get_or_insert(point);
        last = Some(point);
    };
    for index in 0..corners.len() {
        let (a, b) = (seen(index), seen(index + 1));
        let (ha, hb) = (normal.dot(a), normal.dot(b));
        if ha >= 0.0 {
            add(a);
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            add(a + (b - a) * (ha / (ha - hb)));
        }
    }
    if let (Some(first), Some(last)) = (first, last) {
        sum += edge(last, first, normal);
    }
    0.5 * sum
}

/// Integral of `n · (r × dr) / r²` along a straight edge.
pub(super) fn edge(a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let cross = a.cross(b);
    normal.dot(cross) * angle_over_sine(cross.length(), a.dot(b))
}
