//! Unshadowed irradiance of a light, by its shape.

mod arctangent;
mod ellipse;
mod parallelogram;
mod polygon;
mod sphere;

use glam::{DVec3, Vec2, Vec3};
use halflight_core::light::{AreaLight, Shape};

use crate::multiversion::multiversion;

/// Receivers that are evaluated together.
const LANES: usize = 16;

/// Irradiance per unit radiance (the projected solid angle, 0 … π) at one receiver with unit normal `normal`.
pub fn unshadowed(light: &AreaLight, origin: Vec3, normal: Vec3) -> f32 {
    let mut out = [0.0];
    unshadowed_many(light, &[origin], &[normal], &mut out);
    out[0]
}

/// Computes [`unshadowed`] of many receivers: `out[i]` for `origins[i]` and `normals[i]`, as many as the shortest slice has.
/// A zero normal gives 0.
pub fn unshadowed_many(light: &AreaLight, origins: &[Vec3], normals: &[Vec3], out: &mut [f32]) {
    match &light.shape {
        Shape::Parallelogram(shape) => parallelogram::irradiance(light, shape, origins, normals, out),
        Shape::Ellipse(shape) => each(light, origins, normals, out, |o, n| ellipse::flux(shape, o, n)),
        Shape::Polygon(shape) => {
            each(light, origins, normals, out, |o, n| polygon::flux(shape.corners(), o, n));
        }
        Shape::Sphere(shape) => {
            for (out, (origin, normal)) in out.iter_mut().zip(origins.iter().zip(normals)) {
                *out = sphere::irradiance(shape, origin.as_dvec3(), normal.as_dvec3()) as f32;
            }
        }
    }
}

/// Irradiance per unit radiance of receivers one by one. `flux` is ½ ∮ n · (r × dr) / r² around the light for a receiver, double precision: positive
/// behind the light.
fn each(
    light: &AreaLight,
    origins: &[Vec3],
    normals: &[Vec3],
    out: &mut [f32],
    flux: impl Fn(DVec3, DVec3) -> f64,
) {
    let (corner, facing) = (light.frame().origin.as_dvec3(), light.vector_area().as_dvec3());
    for (out, (origin, normal)) in out.iter_mut().zip(origins.iter().zip(normals)) {
        let (origin, normal) = (origin.as_dvec3(), normal.as_dvec3());
        let side = facing.dot(origin - corner);
        let lit = normal != DVec3::ZERO && if light.two_sided { side != 0.0 } else { side > 0.0 };
        *out = if lit { (-flux(origin, normal) * side.signum()).max(0.0) as f32 } else { 0.0 };
    }
}

/// Computes [`unshadowed_many`] to within a few percent where the light is no larger than its distance: by the middles of its four quarters, without
/// horizons inside them. It is for weights, and takes a fifth of the time. Spheres are computed exactly, which takes no longer.
pub(crate) fn roughly_unshadowed(light: &AreaLight, origins: &[Vec3], normals: &[Vec3], out: &mut [f32]) {
    if light.as_sphere().is_some() {
        return unshadowed_many(light, origins, normals, out);
    }
    let filled = light.filled();
    for (out, (origins, normals)) in
        out.chunks_mut(LANES).zip(origins.chunks(LANES).zip(normals.chunks(LANES)))
    {
        rough(light, filled, origins, normals, out);
    }
}

multiversion! {
    /// For up to [`LANES`] receivers.
    fn rough(light: &AreaLight, filled: f32, origins: &[Vec3], normals: &[Vec3], out: &mut [f32]) {
        let facing = light.vector_area();
        let (mut o, mut n) = ([[0.0f32; LANES]; 3], [[0.0f32; LANES]; 3]);
        for (lane, (origin, normal)) in origins.iter().zip(normals).enumerate().take(LANES) {
            for axis in 0..3 {
                (o[axis][lane], n[axis][lane]) = (origin[axis], normal[axis]);
            }
        }
        let mut sum = [0.0f32; LANES];
        for (s, t) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let point = light.point(Vec2::new(s, t));
            for lane in 0..LANES {
                let (x, y, z) = (point.x - o[0][lane], point.y - o[1][lane], point.z - o[2][lane]);
                let square = x * x + y * y + z * z;
                let above = (n[0][lane] * x + n[1][lane] * y + n[2][lane] * z).max(0.0);
                let side = -(facing.x * x + facing.y * y + facing.z * z);
                let side = if light.two_sided { side.abs() } else { side.max(0.0) };
                sum[lane] += above * side / (square * square).max(f32::MIN_POSITIVE);
            }
        }
        for (out, sum) in out.iter_mut().zip(sum) {
            // No irradiance is above that of a whole sky.
            *out = (0.25 * filled * sum).min(std::f32::consts::PI);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_straight_above_has_its_closed_form() {
        // Form factor of a square of side 2 at distance 1, centred: 4 × (2/π) × (1/√2) × atan(1/√2) / 4 × π.
        let corner = Vec3::new(-1.0, 1.0, -1.0);
        let light = AreaLight::parallelogram(corner, Vec3::X * 2.0, Vec3::Z * 2.0, Vec3::ONE).two_sided();
        let quarter = 2.0 * (0.5f64.sqrt()) * (0.5f64.sqrt()).atan() / 2.0;
        let expected = (4.0 * quarter) as f32;
        let value = unshadowed(&light, Vec3::ZERO, Vec3::Y);
        assert!((value / expected - 1.0).abs() < 1e-6, "{value} {expected}");
        // One-sided, it emits along X × Z = −Y, towards the receiver; turned over it does not.
        let one_sided = AreaLight { two_sided: false, ..light };
        assert_eq!(unshadowed(&one_sided, Vec3::ZERO, Vec3::Y), value);
        assert_eq!(unshadowed(&one_sided.reversed(), Vec3::ZERO, Vec3::Y), 0.0);
        assert_eq!(unshadowed(&light, Vec3::ZERO, -Vec3::Y), 0.0);
        assert_eq!(unshadowed(&light, Vec3::ZERO, Vec3::ZERO), 0.0);
    }

    #[test]
    fn half_below_the_horizon_is_half_the_light() {
        // A vertical light through the receiver's horizon, seen edge-symmetric: the lower half adds nothing.
        let light = |low: f32| {
            let (corner, up) = (Vec3::new(2.0, low, -1.0), Vec3::Y * (1.0 - low));
            AreaLight::parallelogram(corner, Vec3::Z * 2.0, up, Vec3::ONE).two_sided()
        };
        let (whole, upper) = (light(-1.0), light(0.0));
        let a = unshadowed(&whole, Vec3::ZERO, Vec3::Y);
        let b = unshadowed(&upper, Vec3::ZERO, Vec3::Y);
        assert!(a > 0.0 && (a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
}
