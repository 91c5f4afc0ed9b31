//! Closed form for spheres with the receiver's horizon, in double precision (Lagarde and de Rousiers 2014, "Moving Frostbite to physically based
//! rendering", section 4.7.2; Snyder 1996, "Area light sources for real-time graphics").

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use halflight_core::light::Sphere;

/// Irradiance per unit radiance at a receiver with unit normal `normal`: the projected solid angle of the part of the sphere above its horizon,
/// or π inside the sphere, where there is light from all directions.
pub(super) fn irradiance(light: &Sphere, origin: DVec3, normal: DVec3) -> f64 {
    let (to, radius) = (light.centre.as_dvec3() - origin, f64::from(light.radius));
    let (squared, height) = (to.length_squared(), normal.dot(to));
    let outside = squared - radius * radius;
    if normal == DVec3::ZERO {
        return 0.0;
    }
    if outside <= 0.0 {
        return PI;
    }
    // Sine of half the angle that the sphere subtends, squared.
    let sine = radius * radius / squared;
    let cosine = height / squared.sqrt();
    if height >= radius {
        return PI * sine * cosine;
    }
    if height <= -radius {
        return 0.0;
    }
    cut(sine, outside / squared, cosine)
}

/// Projected solid angle above the horizon of a cone that the horizon cuts; `sine` and `rest` are the squares of the sine and the cosine of half its
/// angle, `cosine` that of the angle between its axis and the normal.
///
/// With x = √(1/s² − 1) and y = −x cos θ / sin θ this is s² (cos θ acos y − x g) + atan(g / x), where g = sin θ √(1 − y²) =
/// √(1 − cos² θ / s²). For small cones the last two terms cancel up to their third order, which is taken out.
fn cut(sine: f64, rest: f64, cosine: f64) -> f64 {
    let turned = (1.0 - cosine * cosine).max(0.0).sqrt();
    let x = (rest / sine).sqrt();
    // NaN, of a cone that fills half of space around the normal, is 0.
    let y = (-x * cosine / turned).clamp(-1.0, 1.0);
    let arc = if turned > 0.0 { y.acos() } else { FRAC_PI_2 };
    let g = (1.0 - cosine * cosine / sine).max(0.0).sqrt();
    let z = g / x;
    let rim = if z < 0.05 {
        // atan z = z − z³/3 + …; z − x g s² = z s².
        let square = z * z;
        z * sine
            - z * square
                * (1.0 / 3.0
                    - square * (1.0 / 5.0 - square * (1.0 / 7.0 - square * (1.0 / 9.0 - square / 11.0))))
    } else {
        z.atan() - x * g * sine
    };
    (sine * cosine * arc + rim).max(0.0)
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;

    fn unit(angle: f64) -> DVec3 {
        DVec3::new(angle.sin(), angle.cos(), 0.0)
    }

    /// Irradiance by integration over the cone: rings around its axis, of each the part above the horizon in closed form.
    fn by_rings(light: &Sphere, origin: DVec3, normal: DVec3) -> f64 {
        let to = light.centre.as_dvec3() - origin;
        let half = (f64::from(light.radius) / to.length()).asin();
        let cosine = normal.dot(to.normalize());
        let turned = (1.0 - cosine * cosine).sqrt();
        let count = 40_000;
        let step = half / f64::from(count);
        let ring = |index: i32| {
            let angle = (f64::from(index) + 0.5) * step;
            // Height above the horizon along the ring: a + b cos φ.
            let (a, b) = (cosine * angle.cos(), turned * angle.sin());
            let end = if a >= b {
                PI
            } else if a <= -b {
                0.0
            } else {
                (-a / b).acos()
            };
            2.0 * (a * end + b * end.sin()) * angle.sin() * step
        };
        (0..count).map(ring).sum()
    }

    #[test]
    fn the_closed_form_is_the_integral_over_the_cone() {
        for (radius, far) in [(0.5f32, 0.5001), (0.5, 0.6), (0.5, 2.0), (0.01, 3.0), (1e-3, 40.0)] {
            let light = Sphere { centre: Vec3::new(0.0, far, 0.0), radius };
            let half = (f64::from(radius) / f64::from(far)).asin();
            let angles = [0.0, 0.3, 1.2, 1.5, 2.0, 3.1];
            let grazing = [-0.99, -0.7, -0.1, 0.0, 0.1, 0.5, 0.9, 0.999].map(|part| FRAC_PI_2 + part * half);
            for angle in angles.into_iter().chain(grazing) {
                let (value, expected) = (
                    irradiance(&light, DVec3::ZERO, unit(angle)),
                    by_rings(&light, DVec3::ZERO, unit(angle)),
                );
                // The sum over rings is good to 1e-8 of the whole sphere's solid angle times the sine of its half angle.
                let slack = 1e-6 * expected + 1e-8 * PI * half.sin().powi(3);
                assert!((value - expected).abs() <= slack, "{radius} {far} {angle}: {value} {expected}");
            }
        }
    }

    #[test]
    fn both_branches_of_the_cut_meet() {
        for part in [0.2, 0.9, -0.5] {
            // z is 0.05 where the branches change.
            let at = |sine: f64| cut(sine * sine, 1.0 - sine * sine, part * sine);
            let g = (1.0f64 - part * part).sqrt();
            let sine = 0.05 / (g * g + 0.05 * 0.05).sqrt();
            let (below, above) = (at(sine * (1.0 - 1e-12)), at(sine * (1.0 + 1e-12)));
            assert!((above / below - 1.0).abs() < 1e-9, "{part}: {below} {above}");
        }
    }

    #[test]
    fn inside_there_is_light_from_everywhere() {
        let light = Sphere { centre: Vec3::Y, radius: 2.0 };
        for angle in [0.0, 1.0, 3.0] {
            assert_eq!(irradiance(&light, DVec3::ZERO, unit(angle)), PI);
        }
        assert_eq!(irradiance(&light, DVec3::ZERO, DVec3::ZERO), 0.0);
    }
}
