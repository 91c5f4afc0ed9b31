//! Contour integral of ellipses, in double precision.
//!
//! `U = ½ ∮ n · (r × dr) / r²` around the ellipse `r(t) = c + a cos t + b sin t`, seen from the receiver. The integrand is periodic and analytic: equally
//! spaced points converge geometrically, the faster, the farther the receiver is from the edge. Where the horizon cuts the ellipse, the contour is
//! an arc, by Gauss–Legendre quadrature, and the chord along the horizon.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use glam::DVec3;
use halflight_core::light::Ellipse;

use super::polygon::edge;

/// Numbers of points around the ellipse, and the least distances of receivers from its edge in lengths of the longer axis from which they are good to
/// 1e-7.
const POINTS: [(usize, f64); 6] =
    [(16, 1.3), (32, 0.55), (64, 0.26), (256, 0.065), (1024, 0.016), (4096, 0.0)];

/// Most points.
const MOST: usize = 4096;

/// Cosines and sines of [`MOST`] equally spaced angles.
static CIRCLE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    (0..MOST)
        .map(|index| (TAU * index as f64 / MOST as f64).sin_cos())
        .map(|(sine, cosine)| (cosine, sine))
        .collect()
});

/// Nodes in −1 … 1 and weights of Gauss–Legendre quadrature with eight points, those above 0.
const NODES: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Half the contour integral around the part above the receiver's horizon.
pub(super) fn flux(light: &Ellipse, origin: DVec3, normal: DVec3) -> f64 {
    let (a, b) = (light.axis_u.as_dvec3(), light.axis_v.as_dvec3());
    let c = light.centre.as_dvec3() - origin;
    // Height above the horizon along the ellipse: middle + reach · cos(t − top).
    let (middle, along, across) = (normal.dot(c), normal.dot(a), normal.dot(b));
    let reach = along.hypot(across);
    if middle <= -reach {
        return 0.0;
    }
    let term = |cosine: f64, sine: f64| {
        let (r, turn) = (c + a * cosine + b * sine, b * cosine - a * sine);
        normal.dot(r.cross(turn)) / r.length_squared().max(f64::MIN_POSITIVE)
    };
    let near = distance(c, a, b);
    let points = POINTS.iter().find(|(_, least)| near >= *least).map_or(MOST, |&(points, _)| points);
    if middle >= reach {
        let sum: f64 = CIRCLE.iter().step_by(MOST / points).map(|&(cosine, sine)| term(cosine, sine)).sum();
        return 0.5 * sum * (TAU / points as f64);
    }
    let (top, half) = (across.atan2(along), (-middle / reach).acos());
    let panels = (points / 8).max(4);
    let width = half / panels as f64;
    let mut sum = 0.0;
    for panel in 0..panels {
        let centre = top - half + (2 * panel + 1) as f64 * width;
        for (node, weight) in NODES {
            for angle in [centre - node * width, centre + node * width] {
                let (sine, cosine) = angle.sin_cos();
                sum += weight * width * term(cosine, sine);
            }
        }
    }
    let point = |angle: f64| c + a * angle.cos() + b * angle.sin();
    0.5 * (sum + edge(point(top + half), point(top - half), normal))
}

/// About the distance of a receiver from the edge of the ellipse around `c`, as seen from it, in lengths of the longer axis.
fn distance(c: DVec3, a: DVec3, b: DVec3) -> f64 {
    let normal = a.cross(b).normalize_or_zero();
    let longer = a.length().max(b.length());
    let height = c.dot(normal);
    let dual = |axis: DVec3, other: DVec3| {
        let across = other.cross(normal);
        c.dot(across) / axis.dot(across)
    };
    // In coordinates along the axes the ellipse is the unit circle.
    let radial = (dual(a, b).hypot(dual(b, a)) - 1.0) * a.cross(b).length() / longer;
    height.hypot(radial) / longer
}
