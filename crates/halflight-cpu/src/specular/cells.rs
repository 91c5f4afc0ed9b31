//! A light as triangles that are small beside a lobe, and what the lobe reflects of each.
//!
//! Polygons are fans of triangles, an ellipse is a polygon of equal area; what lies below the surface's horizon is clipped. Triangles are halved
//! until they are small beside their distance and beside their angle to the middle of the lobe or the lobe's width, whichever is larger: their number grows with
//! the logarithm of the lobe's narrowness. The integrand is smooth inside each, and a rule of 16 points gives its integral.

use std::sync::LazyLock;

use glam::{Vec2, Vec3};
use halflight_core::light::{AreaLight, Extent, LightFrame, Shape, Sphere};
use halflight_core::light_texture::PlacedTexture;

use super::lobe::{Lobe, Shares};
use crate::multiversion::multiversion;

/// Corners of the polygons that stand for an ellipse: for wide lobes, and for narrow ones, which show its edge.
const WIDE_ELLIPSE: usize = 12;
const NARROW_ELLIPSE: usize = 32;

/// Width of a narrow lobe in angles that the light subtends.
const NARROW: f32 = 0.25;

/// Longest side of a triangle in distances from the receiver.
const BY_DISTANCE: f32 = 1.2;

/// Longest angle of a triangle in angles to the middle of the lobe, or in widths of the lobe.
const BY_ANGLE: f32 = 1.5;

/// Most times that a triangle is halved: far more than any width needs at distances within the range of scenes.
const MOST_HALVINGS: u8 = 40;

/// Most triangles, from which on they are not halved.
const MOST_CELLS: usize = 4096;

/// Number of points of the rule.
const POINTS: usize = 16;

/// Gauss's rule of four points on 0 … 1, and that for the weight 1 − x there (Gauss–Jacobi): points and weights, which sum to 1.
const GAUSS: [(f32, f32); 4] = [
    (0.069_431_84, 0.173_927_42),
    (0.330_009_5, 0.326_072_58),
    (0.669_990_5, 0.326_072_58),
    (0.930_568_16, 0.173_927_42),
];
const JACOBI: [(f32, f32); 4] = [
    (0.057_104_196, 0.271_013_83),
    (0.276_843, 0.406_929_14),
    (0.583_590_45, 0.259_695_08),
    (0.860_240_16, 0.062_361_94),
];

/// Rule of degree 7 on a triangle, by the product of both (Stroud's conical product): weights of the second and third corner, and of the point.
static RULE: LazyLock<[[f32; POINTS]; 3]> = LazyLock::new(|| {
    let mut rule = [[0.0; POINTS]; 3];
    for (row, (x, by_x)) in JACOBI.into_iter().enumerate() {
        for (column, (y, by_y)) in GAUSS.into_iter().enumerate() {
            let point = 4 * row + column;
            (rule[0][point], rule[1][point], rule[2][point]) = (x, y * (1.0 - x), by_x * by_y);
        }
    }
    rule
});

/// Triangle of the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Corners in the coordinates of the light's frame.
    pub(super) corners: [Vec2; 3],
    /// Light that the lobe reflects of it per unit radiance, without the Fresnel term, by luminance of the texture.
    pub(super) share: f32,
}

/// Cells of a light, in buffers that are kept.
#[derive(Default)]
pub(super) struct Cells {
    pub(super) all: Vec<Cell>,
    waiting: Vec<([Vec2; 3], u8)>,
    clipped: Vec<Vec2>,
    /// Sum of the shares of all cells.
    pub(super) share: f32,
}

/// Corners of a light in the coordinates of its frame.
pub(super) struct Outline {
    fine: Vec<Vec2>,
    coarse: Vec<Vec2>,
}

/// A light as a receiver sees it.
#[derive(Clone, Copy)]
pub(super) struct Emitter<'a> {
    pub(super) light: &'a AreaLight,
    outline: &'a Outline,
    pub(super) texture: Option<&'a PlacedTexture<'a>>,
    /// Corner of the frame from the receiver, and edges.
    corner: Vec3,
    u: Vec3,
    v: Vec3,
    /// Normal on the receiver's side, with the length of the frame's area.
    facing: Vec3,
    /// Sphere that the light covers, and the receiver.
    sphere: Option<(&'a Sphere, Vec3)>,
}

impl<'a> Emitter<'a> {
    /// The light seen from `origin`; none where it emits nothing towards it.
    pub(super) fn new(
        light: &'a AreaLight,
        outline: &'a Outline,
        texture: Option<&'a PlacedTexture<'a>>,
        origin: Vec3,
    ) -> Option<Self> {
        if !light.emits_towards(origin) {
            return None;
        }
        let LightFrame { origin: corner, u, v } = light.frame();
        let area = light.vector_area();
        let facing = if light.side(origin) < 0.0 { -area } else { area };
        Some(Self { light, outline, texture, corner: corner - origin, u, v, facing, sphere: None })
    }

    /// Emitter of a disk that covers a sphere as seen from `origin`.
    pub(super) fn of_sphere(self, sphere: Option<&'a Sphere>, origin: Vec3) -> Self {
        Self { sphere: sphere.map(|sphere| (sphere, origin)), ..self }
    }

    /// End of the shadow ray to a point of the light, world space: on the surface of a sphere.
    pub(super) fn end(&self, uv: Vec2) -> Vec3 {
        let point = self.light.point(uv);
        let entered = self.sphere.and_then(|(sphere, origin)| sphere.before_surface(origin, point));
        entered.unwrap_or(point)
    }

    /// Point of the light from the receiver.
    #[inline(always)]
    pub(super) fn point(&self, uv: Vec2) -> Vec3 {
        self.corner + self.u * uv.x + self.v * uv.y
    }

    /// Light that the lobe reflects around a point, per area of the frame's unit square and unit radiance: that of normal incidence and
    /// Schlick's weight.
    #[inline(always)]
    pub(super) fn reflected(&self, lobe: &Lobe, to: Vec3) -> (f32, f32) {
        let squared = to.length_squared().max(f32::MIN_POSITIVE);
        let inverse = 1.0 / squared.sqrt();
        let (value, grazing) = lobe.reflected(to * inverse);
        let solid = (-to.dot(self.facing)).max(0.0) * inverse / squared;
        (value * solid, grazing)
    }

    /// Factors of the radiance at a point, or their mean over a square of the frame around it with these sides.
    pub(super) fn factors(&self, uv: Vec2, side: f32) -> Vec3 {
        let Some(texture) = self.texture else { return Vec3::ONE };
        if side <= 0.0 {
            return texture.at(uv);
        }
        texture.mean_around(uv, side)
    }
}

impl Outline {
    /// Outline of a light.
    pub(super) fn new(light: &AreaLight) -> Self {
        let square = || vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        match light.extent() {
            Extent::Whole => Self { fine: square(), coarse: square() },
            Extent::Ellipse => Self { fine: circle(NARROW_ELLIPSE), coarse: circle(WIDE_ELLIPSE) },
            Extent::Polygon(_) => {
                let LightFrame { origin, u, v } = light.frame();
                let corners = match &light.shape {
                    Shape::Polygon(polygon) => {
                        polygon.corners().iter().map(|&corner| place(corner - origin, u, v)).collect()
                    }
                    Shape::Parallelogram(_) | Shape::Ellipse(_) | Shape::Sphere(_) => square(),
                };
                Self { fine: Vec::clone(&corners), coarse: corners }
            }
        }
    }
}

/// Polygon of the area of the circle that touches the sides of the unit square.
fn circle(corners: usize) -> Vec<Vec2> {
    let step = std::f32::consts::TAU / corners as f32;
    // With corners at distance r its area is ½ N r² sin(2π/N).
    let radius = 0.5 * (step / step.sin()).sqrt();
    (0..corners).map(|index| Vec2::from_angle(index as f32 * step) * radius + 0.5).collect()
}

/// Coordinates by the edges `u` and `v` of a point of their plane.
fn place(at: Vec3, u: Vec3, v: Vec3) -> Vec2 {
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let (au, av) = (at.dot(u), at.dot(v));
    Vec2::new(au * vv - av * uv, av * uu - au * uv) / (uu * vv - uv * uv)
}

impl Cells {
    /// Parts the light into cells. Returns what the lobe reflects of all of it, per unit radiance and by channel, as shares.
    pub(super) fn part(&mut self, emitter: &Emitter, lobe: &Lobe) -> Shares<Vec3> {
        self.all.clear();
        self.share = 0.0;
        let mut sum = Shares::default();
        self.clip(emitter, lobe);
        self.waiting.clear();
        for index in (2..self.clipped.len()).rev() {
            self.waiting.push(([self.clipped[0], self.clipped[index - 1], self.clipped[index]], 0));
        }
        while let Some((corners, halvings)) = self.waiting.pop() {
            let [a, b, c] = corners;
            let points = [emitter.point(a), emitter.point(b), emitter.point(c)];
            let [p, q, r] = points;
            let lengths = [p.distance_squared(q), q.distance_squared(r), r.distance_squared(p)];
            let longest = if lengths[0] >= lengths[1] && lengths[0] >= lengths[2] {
                0
            } else if lengths[1] >= lengths[2] {
                1
            } else {
                2
            };
            let more = halvings < MOST_HALVINGS && self.all.len() + self.waiting.len() < MOST_CELLS;
            if more && is_large(points, lengths[longest].sqrt(), lobe) {
                let [a, b, c] = [corners[longest], corners[(longest + 1) % 3], corners[(longest + 2) % 3]];
                let middle = (a + b) * 0.5;
                self.waiting.push(([a, middle, c], halvings + 1));
                self.waiting.push(([middle, b, c], halvings + 1));
                continue;
            }
            let (shares, share) = evaluate(emitter, lobe, corners);
            if share > 0.0 {
                sum.normal += shares.normal;
                sum.grazing += shares.grazing;
                self.share += share;
                self.all.push(Cell { corners, share });
            }
        }
        sum
    }

    /// Takes the outline, without what lies below the horizon, in the coordinates of the frame (Sutherland and Hodgman 1974).
    fn clip(&mut self, emitter: &Emitter, lobe: &Lobe) {
        let Emitter { outline: Outline { fine, coarse }, corner, u, v, .. } = emitter;
        let wide = (*corner + (*u + *v) * 0.5).length() * lobe.width > NARROW * (u.length() + v.length());
        let polygon = if wide { coarse } else { fine };
        let clipped = &mut self.clipped;
        clipped.clear();
        let height = |uv: Vec2| emitter.point(uv).dot(lobe.normal);
        // The outline lies in the frame, but for the corners of a circle, by a hundredth.
        if [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].iter().all(|&uv| height(uv * 1.02 - 0.01) > 0.0) {
            clipped.extend_from_slice(polygon);
            return;
        }
        for (index, &corner) in polygon.iter().enumerate() {
            let next = polygon[(index + 1) % polygon.len()];
            let (here, there) = (height(corner), height(next));
            if here > 0.0 {
                clipped.push(corner);
            }
            if (here > 0.0) != (there > 0.0) {
                clipped.push(corner.lerp(next, here / (here - there)));
            }
        }
    }
}

/// True if a triangle is too large for the rule.
fn is_large([a, b, c]: [Vec3; 3], longest: f32, lobe: &Lobe) -> bool {
    let centre = (a + b + c) * (1.0 / 3.0);
    let distance = centre.length();
    // No corner is farther from the centre.
    let reach = longest * (2.0 / 3.0);
    if longest > BY_DISTANCE * (distance - reach).max(0.25 * distance) {
        return true;
    }
    let angle = (centre / distance).distance(lobe.mirrored) - reach / distance;
    longest > BY_ANGLE * distance * (angle.max(0.0) + lobe.width)
}

multiversion! {
    /// Writes what the lobe reflects around the points of the rule in the triangle with a corner `a` and edges from it, and Schlick's weights.
    fn reflected_at_points(
        rule: &[[f32; POINTS]; 3],
        emitter: &Emitter,
        lobe: &Lobe,
        a: Vec3,
        edges: [Vec3; 2],
        area: f32,
        values: &mut [f32; POINTS],
        weights: &mut [f32; POINTS],
    ) {
        for point in 0..POINTS {
            let to = a + edges[0] * rule[0][point] + edges[1] * rule[1][point];
            let (value, grazing) = emitter.reflected(lobe, to);
            (values[point], weights[point]) = (value * rule[2][point] * area, grazing);
        }
    }
}

/// Integrates what the lobe reflects of a triangle of the light.
fn evaluate(emitter: &Emitter, lobe: &Lobe, [a, b, c]: [Vec2; 3]) -> (Shares<Vec3>, f32) {
    let (ab, ac) = (b - a, c - a);
    let area = 0.5 * ab.perp_dot(ac).abs();
    let rule = &*RULE;
    let edges = [emitter.u * ab.x + emitter.v * ab.y, emitter.u * ac.x + emitter.v * ac.y];
    let (mut values, mut weights) = ([0.0f32; POINTS], [0.0f32; POINTS]);
    reflected_at_points(rule, emitter, lobe, emitter.point(a), edges, area, &mut values, &mut weights);
    let mut shares = Shares::<Vec3>::default();
    let mut share = 0.0;
    if emitter.texture.is_none() {
        let (mut all, mut grazing) = (0.0, 0.0);
        for point in 0..POINTS {
            all += values[point];
            grazing += values[point] * weights[point];
        }
        let add = |value| Vec3::splat(value);
        return (Shares { normal: add(all - grazing), grazing: add(grazing) }, all);
    }
    for point in 0..POINTS {
        let uv = a + ab * rule[0][point] + ac * rule[1][point];
        let rgb = emitter.factors(uv, (area * rule[2][point]).sqrt()) * values[point];
        shares.normal += rgb * (1.0 - weights[point]);
        shares.grazing += rgb * weights[point];
        share += crate::compose::luminance(rgb * emitter.light.radiance);
    }
    (shares, share)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrals of powers of the two coordinates over the triangle, whose area counts as 1: 2 m! n! / (m + n + 2)!.
    #[test]
    fn the_rule_is_exact_up_to_degree_7() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for m in 0..=7 {
            for n in 0..=7 - m {
                let power = |point: usize| {
                    let [x, y, weight] = RULE.map(|row| f64::from(row[point]));
                    weight * x.powi(m) * y.powi(n)
                };
                let sum: f64 = (0..POINTS).map(power).sum();
                let expected = 2.0 * factorial(m) * factorial(n) / factorial(m + n + 2);
                // Points and weights are single precision.
                assert!((sum - expected).abs() < 2e-7, "{m} {n}: {sum} {expected}");
            }
        }
    }
}
