//! The lobe of a surface point: how much of the light from each direction it reflects towards the viewer.
//!
//! GGX with the separable shadowing and masking term of Smith (Walter and others 2007; glTF 2.0, Appendix B.3) and Schlick's Fresnel term.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::specular::SurfaceSpecular;

/// Least α: rougher than a mirror by half a thousandth. Smoother surfaces count as this smooth.
const LEAST_ALPHA: f32 = 5e-4;

/// Least cosine between normal and view: shading normals may turn away from the viewer.
const LEAST_COSINE: f32 = 1e-4;

/// Lobe of a surface point as seen by the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// Unit shading normal.
    pub(super) normal: Vec3,
    /// Unit direction to the viewer.
    view: Vec3,
    /// Unit direction of which a mirror would show the light.
    pub(super) mirrored: Vec3,
    /// α².
    alpha_squared: f32,
    /// Angle that the lobe subtends around the mirrored direction, across the plane of incidence, where it is narrowest, radians.
    pub(super) width: f32,
    /// Cosine of the angle between normal and view.
    cosine: f32,
}

/// Shares of a lobe: what is reflected is f₀ times the first plus the second, by Schlick's Fresnel term.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shares<T> {
    pub(super) normal: T,
    pub(super) grazing: T,
}

impl Lobe {
    pub(super) fn new(normal: Vec3, view: Vec3, surface: &SurfaceSpecular) -> Self {
        let alpha = (surface.roughness * surface.roughness).max(LEAST_ALPHA);
        let facing = normal.dot(view);
        let cosine = facing.max(LEAST_COSINE);
        Self {
            normal,
            view,
            mirrored: normal * (2.0 * facing) - view,
            alpha_squared: alpha * alpha,
            width: 2.0 * alpha * cosine.max(0.1),
            cosine,
        }
    }

    /// The lobe times the cosine of incidence, without the Fresnel term, and Schlick's weight (1 − v·h)⁵, for unit radiance along the unit
    /// direction `to`, 1/sr.
    #[inline(always)]
    pub(super) fn reflected(&self, to: Vec3) -> (f32, f32) {
        let incidence = self.normal.dot(to).max(0.0);
        let half = self.view + to;
        // At grazing incidence from behind, half may vanish.
        let squared = half.length_squared().max(f32::MIN_POSITIVE);
        let along = self.normal.dot(half);
        // Sines instead of 1 − cos², which cancels in narrow lobes.
        let spread =
            (self.normal.cross(half).length_squared() + self.alpha_squared * along * along) / squared;
        let distribution = self.alpha_squared * FRAC_1_PI / (spread * spread).max(f32::MIN_POSITIVE);
        let smith =
            |cosine: f32| cosine + (self.alpha_squared + (1.0 - self.alpha_squared) * cosine * cosine).sqrt();
        let masking = 1.0 / (smith(incidence) * smith(self.cosine));
        let left = (1.0 - self.view.dot(half) / squared.sqrt()).clamp(0.0, 1.0);
        let fourth = (left * left) * (left * left);
        (distribution * masking * incidence, fourth * left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobe(roughness: f32, angle: f32) -> Lobe {
        let view = Vec3::new(angle.sin(), angle.cos(), 0.0);
        Lobe::new(Vec3::Y, view, &SurfaceSpecular { f0: Vec3::ONE, roughness })
    }

    /// Integral of the lobe over all directions, by the midpoint rule in half vectors, whose density is that of GGX.
    fn albedo(lobe: &Lobe, alpha: f32) -> f32 {
        let (rings, spokes) = (2000, 256);
        let mut sum = 0.0f64;
        for ring in 0..rings {
            let u = (ring as f32 + 0.5) / rings as f32;
            let tangent = alpha * (u / (1.0 - u)).sqrt();
            let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
            for spoke in 0..spokes {
                let (s, c) = ((spoke as f32 + 0.5) / spokes as f32 * std::f32::consts::TAU).sin_cos();
                let half = Vec3::new(tangent * cosine * c, cosine, tangent * cosine * s);
                let to = half * (2.0 * lobe.view.dot(half)) - lobe.view;
                if to.y > 0.0 && lobe.view.dot(half) > 0.0 {
                    // Density of directions: D cos θ / (4 v·h).
                    let spread = 1.0 - cosine * cosine + alpha * alpha * cosine * cosine;
                    let density =
                        alpha * alpha * FRAC_1_PI / (spread * spread) * cosine / (4.0 * lobe.view.dot(half));
                    sum += f64::from(lobe.reflected(to).0 / density);
                }
            }
        }
        (sum / f64::from(rings * spokes)) as f32
    }

    /// Directional albedo of GGX without Fresnel term at normal incidence: all is reflected by smooth surfaces, and rough ones lose what their
    /// microfacets shadow.
    #[test]
    fn smooth_surfaces_reflect_all_and_rough_ones_lose_some() {
        for roughness in [0.05f32, 0.1, 0.2] {
            let all = albedo(&lobe(roughness, 0.5), roughness * roughness);
            // Losses by masking grow with α²: under 1 % at 0.04.
            assert!((all - 1.0).abs() < 0.01, "{roughness} {all}");
        }
        let rough = albedo(&lobe(1.0, 0.0), 1.0);
        // At α = 1 and normal incidence the integral is that of 1 / (1 + c) over cosines c from 0 to 1, in closed form 1 − ln 2.
        assert!((rough - (1.0 - std::f32::consts::LN_2)).abs() < 1e-3, "{rough}");
    }

    #[test]
    fn lobes_are_reciprocal() {
        for roughness in [0.02, 0.2, 0.7, 1.0] {
            let (a, b) = (Vec3::new(0.3, 0.5, -0.2).normalize(), Vec3::new(-0.5, 0.4, 0.3).normalize());
            let surface = SurfaceSpecular { f0: Vec3::ONE, roughness };
            let there = Lobe::new(Vec3::Y, a, &surface).reflected(b);
            let back = Lobe::new(Vec3::Y, b, &surface).reflected(a);
            // Each is the product with the cosine of incidence.
            assert!((there.0 / b.y / (back.0 / a.y) - 1.0).abs() < 1e-4, "{roughness}");
            assert!((there.1 - back.1).abs() < 1e-6);
        }
    }
}
