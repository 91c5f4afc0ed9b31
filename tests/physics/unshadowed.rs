//! Unshadowed irradiance `U` against adaptive quadrature in double precision.

use halflight::glam::{DVec3, Vec3};
use halflight::light::{AreaLight, LightFrame};
use halflight::unshadowed::unshadowed;

/// Integral `∫ cosθx cosθy / r² dA` over the light by adaptive Gauss quadrature, with the integrand clipped
/// at the horizon.
///
/// Along each line of constant v the integrand is analytic between the points where the horizon cuts the
/// line, so each piece is integrated separately and converges fast.
fn quadrature(light: &AreaLight, origin: Vec3, normal: Vec3) -> f64 {
    let (o, n) = (origin.as_dvec3(), normal.as_dvec3());
    let LightFrame { origin, u, v } = light.frame();
    let [corner, eu, ev] = [origin, u, v].map(Vec3::as_dvec3);
    let facing = eu.cross(ev);
    let height = |p: DVec3| n.dot(p - o);
    let term = |p: DVec3| {
        let d = p - o;
        let emitter = -facing.dot(d);
        let emitter = if light.two_sided { emitter.abs() } else { emitter.max(0.0) };
        height(p).max(0.0) * emitter / d.length_squared().powi(2)
    };
    let line = |v: f64| {
        let start = corner + ev * v;
        let (h0, h1) = (height(start), height(start + eu));
        let (low, high) = if h0 <= 0.0 && h1 <= 0.0 {
            return 0.0;
        } else if h0 < 0.0 {
            (h0 / (h0 - h1), 1.0)
        } else if h1 < 0.0 {
            (0.0, h0 / (h0 - h1))
        } else {
            (0.0, 1.0)
        };
        adaptive(&|u| term(start + eu * u), low, high, 0)
    };
    // The horizon's ends on the edges v = const are kinks of the outer integrand.
    let mut discontinuities = vec![0.0, 1.0];
    for start in [corner, corner + eu] {
        let (h0, h1) = (height(start), height(start + ev));
        if (h0 < 0.0) != (h1 < 0.0) {
            discontinuities.push(h0 / (h0 - h1));
        }
    }
    discontinuities.sort_by(f64::total_cmp);
    discontinuities.windows(2).map(|pair| adaptive(&line, pair[0], pair[1], 0)).sum()
}

fn gauss(f: &dyn Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    half * NODES.iter().map(|&(x, w)| w * f(middle + half * x)).sum::<f64>()
}

fn adaptive(f: &dyn Fn(f64) -> f64, a: f64, b: f64, depth: u32) -> f64 {
    let middle = 0.5 * (a + b);
    let (whole, left, right) = (gauss(f, a, b), gauss(f, a, middle), gauss(f, middle, b));
    if depth >= 24 || (left + right - whole).abs() <= 1e-10 * (left + right).abs() + 1e-300 {
        left + right
    } else {
        adaptive(f, a, middle, depth + 1) + adaptive(f, middle, b, depth + 1)
    }
}

fn check(name: &str, light: &AreaLight, origin: Vec3, normal: Vec3) {
    let expected = quadrature(light, origin, normal);
    let found = f64::from(unshadowed(light, origin, normal));
    // The required accuracy; single-precision rounding of the result alone is 6e-8.
    assert!((found - expected).abs() <= 1e-5 * expected, "{name}: {found} instead of {expected}");
    assert!(expected > 0.0, "{name}: not a case worth testing");
}

fn light(corner: [f32; 3], edge_u: [f32; 3], edge_v: [f32; 3]) -> AreaLight {
    AreaLight::parallelogram(corner.into(), edge_u.into(), edge_v.into(), Vec3::ONE).two_sided()
}

#[test]
fn above_the_horizon() {
    let square = light([-1.0, 2.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    check("under a square", &square, Vec3::ZERO, Vec3::Y);
    check("beside it, tilted", &square, Vec3::new(2.0, 0.5, -1.0), Vec3::new(-0.3, 1.0, 0.2).normalize());
    let skew = light([0.3, 1.4, -0.7], [1.1, 0.3, 0.2], [-0.4, 0.2, 0.9]);
    check("a skew parallelogram", &skew, Vec3::new(-0.2, 0.0, 0.1), Vec3::Y);
}

#[test]
fn clipped_by_the_horizon() {
    let wall = light([2.0, -1.0, -1.5], [0.0, 0.0, 3.0], [0.0, 2.5, 0.0]);
    check("an edge below", &wall, Vec3::ZERO, Vec3::Y);
    check("one corner below", &wall, Vec3::ZERO, Vec3::new(0.3, 1.0, 0.45).normalize());
    check("one corner above", &wall, Vec3::ZERO, Vec3::new(-0.55, 1.0, 0.45).normalize());
    check("a sliver above", &wall, Vec3::new(0.0, 1.499, 0.0), Vec3::Y);
    let square = light([-1.0, 2.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    check("turned nearly away", &square, Vec3::new(3.0, 0.0, 0.0), Vec3::new(1.0, 1.1, 0.1).normalize());
}

#[test]
fn tiny_and_huge_solid_angles() {
    for scale in [1e-1f32, 1e-2, 1e-3, 1e-4, 1e-5] {
        let tiny = light([0.5, 3.0, 0.2], [scale, 0.0, 0.0], [0.0, 0.1 * scale, scale]);
        check(&format!("{scale} m at 3 m"), &tiny, Vec3::ZERO, Vec3::new(0.1, 1.0, 0.0).normalize());
    }
    for scale in [10.0f32, 1e3, 1e5] {
        let huge = light([-scale, 1.0, -scale], [2.0 * scale, 0.0, 0.0], [0.0, 0.0, 2.0 * scale]);
        check(&format!("{scale} m at 1 m"), &huge, Vec3::ZERO, Vec3::Y);
    }
    let near = light([-1.0, 1e-3, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    check("a millimetre away", &near, Vec3::ZERO, Vec3::Y);
}

#[test]
fn nearly_degenerate_lights() {
    let needle = light([-1.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1e-4]);
    check("a needle", &needle, Vec3::ZERO, Vec3::Y);
    let sheared = light([-1.0, 2.0, 0.0], [2.0, 0.0, 0.0], [1.9, 0.0, 1e-3]);
    check("nearly parallel edges", &sheared, Vec3::new(0.2, 0.0, 0.3), Vec3::Y);
    let edge_on = light([2.0, 0.0, -1.0], [0.0, 0.0, 2.0], [0.5, 2e-3, 0.0]);
    check("nearly edge-on", &edge_on, Vec3::ZERO, Vec3::Y);
}

#[test]
fn receivers_on_the_light_or_its_plane_get_finite_values() {
    let square = light([-1.0, 2.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    for origin in [[0.0, 2.0, 0.0], [-1.0, 2.0, -1.0], [-1.0, 2.0, 0.3], [5.0, 2.0, 0.0]] {
        for normal in [Vec3::Y, Vec3::X, -Vec3::Y] {
            let value = unshadowed(&square, origin.into(), normal);
            assert!((0.0..=4.0).contains(&value), "{origin:?} {normal}: {value}");
        }
    }
}

#[test]
fn the_quadrature_itself_rejects_a_wrong_answer() {
    let square = light([-1.0, 2.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let wrong = f64::from(unshadowed(&square, Vec3::new(0.0, 1e-4, 0.0), Vec3::Y));
    let expected = quadrature(&square, Vec3::ZERO, Vec3::Y);
    assert!((wrong - expected).abs() > 1e-5 * expected, "a receiver 0.1 mm off must be told apart");
}
