//! Analytic unshadowed irradiance of a parallelogram: Lambert's formula, clipped to the receiver's horizon.
//!
//! `U = ½ Σ_edges Θ_i (n · (r_i × r_{i+1})) / |r_i × r_{i+1}|` over the polygon's corners `r` seen from the receiver, with
//! `Θ` the angle an edge subtends. It is exact for a uniform light. Terms of size Θ cancel to a sum of size Θ², so it is
//! evaluated in single precision only near the light. Far from it nine points of a product Gauss rule, whose terms do not
//! cancel, are as good as exact, and the rest is in double precision.

use glam::{DVec3, Vec3};
use halflight_core::light::{AreaLight, Parallelogram};

use super::LANES;
use super::arctangent::{angle_over_sine, quick_angle_over_sine};
use crate::multiversion::multiversion;

/// Receivers that are evaluated together in double precision.
const DOUBLES: usize = LANES / 2;

/// Distance from the light's centre, in lengths of its longer edge, from which on three Gauss points a side are good to 1e-7:
/// their error goes with the sixth power of its inverse.
const DISTANT: f32 = 8.0;

/// Nodes on −½ … ½ and weights of the rule with three points.
const NODES: [(f32, f32); 3] = [(-0.387_298_33, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.387_298_33, 5.0 / 18.0)];

/// Irradiance per unit radiance of a `light` with this shape: `out[i]` for `origins[i]` and `normals[i]`.
pub(super) fn irradiance(
    light: &AreaLight,
    shape: &Parallelogram,
    origins: &[Vec3],
    normals: &[Vec3],
    out: &mut [f32],
) {
    // Coordinates must be fine enough for the light's edges: then corners are wrong by a 2⁻¹⁶th of these at most.
    let (corners, centre, two_sided) = (light.corners(), light.centre(), light.two_sided);
    let edge = shape.edge_u.length().min(shape.edge_v.length());
    let coarse = |point: Vec3| point.abs().max_element() > edge * 256.0;
    let fine = !corners.into_iter().any(coarse);
    let widest = shape.edge_u.length_squared().max(shape.edge_v.length_squared());
    for (out, (origins, normals)) in
        out.chunks_mut(LANES).zip(origins.chunks(LANES).zip(normals.chunks(LANES)))
    {
        // Nor may the light be so small in the sky that too little is left of the sum.
        let far =
            |&origin: &Vec3| (corners[0] - origin).length_squared() > edge * edge * 64.0 || coarse(origin);
        let distant = |&origin: &Vec3| (centre - origin).length_squared() >= widest * (DISTANT * DISTANT);
        if fine && out.len() == LANES && origins.len() == LANES && !origins.iter().any(far) {
            quick(shape, two_sided, &corners, origins, normals, out);
        } else if origins.iter().all(distant) {
            gauss(shape, two_sided, origins, normals, out);
        } else {
            precise(shape, two_sided, origins, normals, out);
        }
    }
}

multiversion! {
    /// In single precision, wrong by less than 1e-4 of itself or 1e-7 where a light's edges are no shorter than an eighth of its distance.
    /// For [`LANES`] receivers.
    fn quick(
        light: &Parallelogram,
        two_sided: bool,
        corners: &[Vec3; 4],
        origins: &[Vec3],
        normals: &[Vec3],
        out: &mut [f32],
    ) {
        let facing = light.edge_u.cross(light.edge_v);
        let mut r = [[[0.0f32; LANES]; 3]; 4];
        let mut n = [[0.0f32; LANES]; 3];
        for (lane, (o, m)) in origins.iter().zip(normals).enumerate().take(LANES) {
            for axis in 0..3 {
                n[axis][lane] = m[axis];
                for corner in 0..4 {
                    r[corner][axis][lane] = corners[corner][axis] - o[axis];
                }
            }
        }
        let mut side = [0.0f32; LANES];
        let mut lowest = [f32::INFINITY; LANES];
        let mut highest = [f32::NEG_INFINITY; LANES];
        for lane in 0..LANES {
            side[lane] = -(facing.x * r[0][0][lane] + facing.y * r[0][1][lane] + facing.z * r[0][2][lane]);
            for corner in &r {
                let height = n[0][lane] * corner[0][lane] + n[1][lane] * corner[1][lane] + n[2][lane] * corner[2][lane];
                lowest[lane] = lowest[lane].min(height);
                highest[lane] = highest[lane].max(height);
            }
        }
        let mut sum = [0.0f32; LANES];
        for edge in 0..4 {
            let (a, b) = (&r[edge], &r[(edge + 1) % 4]);
            for lane in 0..LANES {
                let (ax, ay, az) = (a[0][lane], a[1][lane], a[2][lane]);
                let (bx, by, bz) = (b[0][lane], b[1][lane], b[2][lane]);
                let (cx, cy, cz) = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx);
                let sine = (cx * cx + cy * cy + cz * cz).sqrt();
                let cosine = ax * bx + ay * by + az * bz;
                sum[lane] += (n[0][lane] * cx + n[1][lane] * cy + n[2][lane] * cz) * quick_angle_over_sine(sine, cosine);
            }
        }
        for (lane, out) in out.iter_mut().enumerate().take(LANES) {
            let lit = if two_sided { side[lane] != 0.0 } else { side[lane] > 0.0 };
            *out = if !lit || highest[lane] <= 0.0 {
                0.0
            } else if lowest[lane] >= 0.0 {
                (0.5 * sum[lane] * -side[lane].signum()).max(0.0)
            } else {
                let corners = corners.map(Vec3::as_dvec3);
                let value = clipped(&corners, origins[lane].as_dvec3(), normals[lane].as_dvec3());
                (value as f32 * -side[lane].signum()).max(0.0)
            };
        }
    }
}

multiversion! {
    /// By quadrature over a light that is [`DISTANT`] from all receivers. For up to [`LANES`] of them.
    fn gauss(light: &Parallelogram, two_sided: bool, origins: &[Vec3], normals: &[Vec3], out: &mut [f32]) {
        let (corner, u, v) = (light.corner.as_dvec3(), light.edge_u.as_dvec3(), light.edge_v.as_dvec3());
        let corners = [corner, corner + u, corner + u + v, corner + v];
        let (centre, facing) = (corner + 0.5 * (u + v), u.cross(v));
        let count = out.len().min(origins.len()).min(normals.len());
        // Heights above both planes cancel, and points far from the origin lie close together: in double precision.
        let mut heights = [[0.0f32; LANES]; 3];
        let mut r = [[0.0f32; LANES]; 3];
        let mut side = [0.0f32; LANES];
        for lane in 0..count {
            let (n, to) = (normals[lane].as_dvec3(), centre - origins[lane].as_dvec3());
            heights[0][lane] = n.dot(to) as f32;
            heights[1][lane] = n.dot(u) as f32;
            heights[2][lane] = n.dot(v) as f32;
            side[lane] = -facing.dot(to) as f32;
            for axis in 0..3 {
                r[axis][lane] = to[axis] as f32;
            }
        }
        let (u, v) = (light.edge_u, light.edge_v);
        let (uu, vv, uv) = (u.length_squared(), v.length_squared(), u.dot(v));
        let mut sum = [0.0f32; LANES];
        for lane in 0..LANES {
            let (x, y, z) = (r[0][lane], r[1][lane], r[2][lane]);
            let (rr, ru, rv) = (x * x + y * y + z * z, x * u.x + y * u.y + z * u.z, x * v.x + y * v.y + z * v.z);
            for (s, ws) in NODES {
                for (t, wt) in NODES {
                    let square = rr + 2.0 * (s * ru + t * rv) + (s * s * uu + t * t * vv + 2.0 * s * t * uv);
                    let height = heights[0][lane] + s * heights[1][lane] + t * heights[2][lane];
                    sum[lane] += ws * wt * height / (square * square);
                }
            }
        }
        for (lane, out) in out.iter_mut().enumerate().take(count) {
            let lit = if two_sided { side[lane] != 0.0 } else { side[lane] > 0.0 };
            let reach = 0.5 * (heights[1][lane].abs() + heights[2][lane].abs());
            *out = if !lit || heights[0][lane] + reach <= 0.0 {
                0.0
            } else if heights[0][lane] >= reach {
                sum[lane] * side[lane].abs()
            } else {
                let value = clipped(&corners, origins[lane].as_dvec3(), normals[lane].as_dvec3());
                (value * -f64::from(side[lane].signum())).max(0.0) as f32
            };
        }
    }
}

multiversion! {
    /// In double precision.
    fn precise(light: &Parallelogram, two_sided: bool, origins: &[Vec3], normals: &[Vec3], out: &mut [f32]) {
        // In double precision from the start: the corners of a small light far from the origin round to one point.
        let (corner, u, v) = (light.corner.as_dvec3(), light.edge_u.as_dvec3(), light.edge_v.as_dvec3());
        let corners = [corner, corner + u, corner + u + v, corner + v];
        let facing = u.cross(v);
        let chunks = out.chunks_mut(DOUBLES).zip(origins.chunks(DOUBLES).zip(normals.chunks(DOUBLES)));
        for (out, (origins, normals)) in chunks {
            let count = out.len().min(origins.len()).min(normals.len());
            // The corners relative to each receiver, as lanes of doubles.
            let mut r = [[[0.0f64; DOUBLES]; 3]; 4];
            let mut n = [[0.0f64; DOUBLES]; 3];
            for lane in 0..count {
                let (o, m) = (origins[lane], normals[lane]);
                for axis in 0..3 {
                    n[axis][lane] = f64::from(m[axis]);
                    for corner in 0..4 {
                        r[corner][axis][lane] = corners[corner][axis] - f64::from(o[axis]);
                    }
                }
            }
            let mut side = [0.0f64; DOUBLES];
            let mut lowest = [f64::INFINITY; DOUBLES];
            let mut highest = [f64::NEG_INFINITY; DOUBLES];
            for lane in 0..DOUBLES {
                side[lane] = -(facing.x * r[0][0][lane] + facing.y * r[0][1][lane] + facing.z * r[0][2][lane]);
                for corner in &r {
                    let height = n[0][lane] * corner[0][lane] + n[1][lane] * corner[1][lane] + n[2][lane] * corner[2][lane];
                    lowest[lane] = lowest[lane].min(height);
                    highest[lane] = highest[lane].max(height);
                }
            }
            let mut sum = [0.0f64; DOUBLES];
            for edge in 0..4 {
                let (a, b) = (&r[edge], &r[(edge + 1) % 4]);
                for lane in 0..DOUBLES {
                    let (ax, ay, az) = (a[0][lane], a[1][lane], a[2][lane]);
                    let (bx, by, bz) = (b[0][lane], b[1][lane], b[2][lane]);
                    let (cx, cy, cz) = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx);
                    let sine = (cx * cx + cy * cy + cz * cz).sqrt();
                    let cosine = ax * bx + ay * by + az * bz;
                    sum[lane] += (n[0][lane] * cx + n[1][lane] * cy + n[2][lane] * cz) * angle_over_sine(sine, cosine);
                }
            }
            for lane in 0..count {
                let lit = if two_sided { side[lane] != 0.0 } else { side[lane] > 0.0 };
                // Seen from in front, the corners run clockwise: the sum is negative there.
                let value = if !lit || highest[lane] <= 0.0 {
                    0.0
                } else if lowest[lane] >= 0.0 {
                    0.5 * sum[lane] * -side[lane].signum()
                } else {
                    clipped(&corners, origins[lane].as_dvec3(), normals[lane].as_dvec3()) * -side[lane].signum()
                };
                out[lane] = value.max(0.0) as f32;
            }
        }
    }
}

/// Half the signed sum over the part of the polygon above the receiver's horizon.
fn clipped(corners: &[DVec3; 4], origin: DVec3, normal: DVec3) -> f64 {
    // A plane cuts a convex quadrilateral to at most five corners.
    let mut polygon = [DVec3::ZERO; 6];
    let mut count = 0;
    for index in 0..4 {
        let (a, b) = (corners[index] - origin, corners[(index + 1) % 4] - origin);
        let (ha, hb) = (normal.dot(a), normal.dot(b));
        if ha >= 0.0 {
            polygon[count] = a;
            count += 1;
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            polygon[count] = a + (b - a) * (ha / (ha - hb));
            count += 1;
        }
    }
    let mut sum = 0.0;
    for index in 0..count {
        let (a, b) = (polygon[index], polygon[(index + 1) % count]);
        let cross = a.cross(b);
        sum += normal.dot(cross) * angle_over_sine(cross.length(), a.dot(b));
    }
    0.5 * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_is_close_wherever_it_is_used() {
        let light = Parallelogram {
            corner: Vec3::new(3.0, 4.0, -5.0),
            edge_u: Vec3::new(1.5, 0.2, 0.1),
            edge_v: Vec3::new(-0.1, 0.3, 1.2),
        };
        let mut numbers =
            (1u32..).map(|n| halflight_core::hash::unit_pair(halflight_core::hash::sample_bits(7, n)));
        let mut some = || {
            let (a, b, c) = (numbers.next().unwrap().0, numbers.next().unwrap().0, numbers.next().unwrap().1);
            Vec3::new(a, b, c) * 2.0 - 1.0
        };
        let corners = AreaLight::parallelogram(light.corner, light.edge_u, light.edge_v, Vec3::ONE).corners();
        let mut worst = 0.0f32;
        for _ in 0..2000 {
            let origins: Vec<Vec3> = (0..LANES).map(|_| light.corner + some() * 10.0).collect();
            let normals: Vec<Vec3> = (0..LANES).map(|_| some().normalize()).collect();
            let (mut single, mut double) = ([0.0; LANES], [0.0; LANES]);
            quick(&light, true, &corners, &origins, &normals, &mut single);
            precise(&light, true, &origins, &normals, &mut double);
            for (single, double) in single.into_iter().zip(double) {
                worst = worst.max((single - double).abs() / (double + 1e-3));
            }
        }
        // Single precision, 6e-8, some ten roundings, and angles of a sixteenth that nearly cancel beside the light.
        assert!(worst > 0.0 && worst < 1e-4, "{worst}");
    }

    #[test]
    fn quadrature_is_close_from_its_distance_on() {
        let light = Parallelogram {
            corner: Vec3::new(3.0, 4.0, -5.0),
            edge_u: Vec3::new(1.5, 0.2, 0.1),
            edge_v: Vec3::new(-0.1, 0.03, 0.12),
        };
        let centre = light.corner + 0.5 * (light.edge_u + light.edge_v);
        let mut numbers =
            (1u32..).map(|n| halflight_core::hash::unit_pair(halflight_core::hash::sample_bits(9, n)));
        let mut some = || {
            let (a, b, c) = (numbers.next().unwrap().0, numbers.next().unwrap().0, numbers.next().unwrap().1);
            (Vec3::new(a, b, c) * 2.0 - 1.0).normalize()
        };
        let least = DISTANT * light.edge_u.length();
        let mut worst = 0.0f64;
        let mut lit = 0;
        for round in 0..2000 {
            let away = least * 1.0001 * 1.01f32.powi(round % 300);
            let origins: Vec<Vec3> = (0..LANES).map(|_| centre + some() * away).collect();
            let normals: Vec<Vec3> = (0..LANES).map(|_| some()).collect();
            let (mut points, mut edges) = ([0.0; LANES], [0.0; LANES]);
            gauss(&light, true, &origins, &normals, &mut points);
            precise(&light, true, &origins, &normals, &mut edges);
            // Relative, but for what lies so near a horizon that the light's own coordinates are too coarse for it.
            let small = 1e-6 * f64::from(light.edge_u.cross(light.edge_v).length() / (away * away));
            for (points, edges) in points.into_iter().zip(edges).map(|(p, e)| (f64::from(p), f64::from(e))) {
                lit += i32::from(points > 0.0);
                assert_eq!(points > 0.0, edges > 0.0);
                worst = worst.max((points - edges).abs() / (edges + small));
            }
        }
        assert!(lit > 10_000, "{lit}");
        // The rule's own error, 1e-7 here, and some ten roundings of single precision.
        assert!(worst > 0.0 && worst < 2e-6, "{worst}");
    }
}
