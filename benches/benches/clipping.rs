//! Exact visible part of a light by clipping, against masks by `beam`: a table by the number of triangles before the light.
//!
//! Each triangle between a receiver and the light is projected from the receiver onto the light's plane and cut out of what is left of the light; the
//! pieces that remain are integrated by Lambert's formula, without noise. Finding the triangles is not timed, which favours clipping. One thread.
//! Writes rows of CSV to standard output: times in microseconds a receiver, and the root mean square error of the visible fraction that masks have.

#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use halflight::bvh::Bvh;
use halflight::frame::{Frame, Sharing};
use halflight::gbuffer::Receiver;
use halflight::glam::{DVec2, DVec3, Vec3};
use halflight::irradiance;
use halflight::light::{AreaLight, LightFrame};
use halflight::mask::{MaskBatch, Purpose};
use halflight::pattern::{Pattern, PatternKind};
use halflight::pyramid::Pyramid;
use halflight::scene::Scene;
use halflight::stages::Visibility;
use halflight_benches::{scene, warm};

/// Convex polygon in coordinates of the light's frame, counter-clockwise.
type Polygon = Vec<DVec2>;

/// Side of a tile in pixels, and spacing of tiles in tiles.
const TILE: u32 = 8;
const EVERY: u32 = 6;
/// Largest number of triangles of each row of the table. Receivers with more are counted only.
const BINS: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Side of masks.
const SIDES: [usize; 3] = [8, 16, 32];
/// Part of the height of the light over the receiver at which triangles are cut off.
const NEAR: f64 = 1e-7;

/// Length, in coordinates of the light's frame, from which on an edge has a direction.
const LEAST_EDGE: f64 = 1e-10;

/// A receiver and the light in double precision.
struct View {
    origin: DVec3,
    normal: DVec3,
    corner: DVec3,
    u: DVec3,
    v: DVec3,
    /// Normal of the light's plane over the height of the plane above the receiver.
    height: DVec3,
    /// Dual basis of `u` and `v`.
    dual: [DVec3; 2],
}

impl View {
    fn new(receiver: Receiver, frame: LightFrame) -> Self {
        let (u, v) = (frame.u.as_dvec3(), frame.v.as_dvec3());
        let (corner, origin) = (frame.origin.as_dvec3(), receiver.origin.as_dvec3());
        let n = u.cross(v);
        let dual = [v.cross(n) / u.dot(v.cross(n)), n.cross(u) / v.dot(n.cross(u))];
        let height = n / n.dot(corner - origin);
        Self { origin, normal: receiver.normal.as_dvec3(), corner, u, v, height, dual }
    }

    /// Shadow of a triangle on the light's plane, or nothing where it does not lie in between.
    fn project(&self, corners: [DVec3; 3]) -> Option<Polygon> {
        let points = corners.map(|corner| corner - self.origin);
        let heights = points.map(|point| self.height.dot(point));
        if heights.iter().all(|&height| height <= NEAR) || heights.iter().all(|&height| height >= 1.0) {
            return None;
        }
        let above = cut(points.to_vec(), |point| self.height.dot(point) - NEAR);
        let between = cut(above, |point| 1.0 - self.height.dot(point));
        if between.len() < 3 {
            return None;
        }
        let place = |point: &DVec3| {
            let on_plane = *point / self.height.dot(*point) + self.origin - self.corner;
            DVec2::new(self.dual[0].dot(on_plane), self.dual[1].dot(on_plane))
        };
        let mut shadow: Polygon = between.iter().map(place).collect();
        let outside = |axis: fn(&DVec2) -> f64| {
            shadow.iter().all(|at| axis(at) <= 0.0) || shadow.iter().all(|at| axis(at) >= 1.0)
        };
        if outside(|at| at.x) || outside(|at| at.y) {
            return None;
        }
        let twice_area: f64 = (1..shadow.len() - 1)
            .map(|at| (shadow[at] - shadow[0]).perp_dot(shadow[at + 1] - shadow[0]))
            .sum();
        if twice_area < 0.0 {
            shadow.reverse();
        }
        (twice_area.abs() > 1e-14 && overlap(&shadow, &unit_square())).then_some(shadow)
    }

    /// Lambert's formula over a piece of the light, clipped to the receiver's horizon.
    fn flux(&self, piece: &[DVec2]) -> f64 {
        let point = |at: &DVec2| self.corner + self.u * at.x + self.v * at.y - self.origin;
        let seen = cut(piece.iter().map(point).collect(), |point| self.normal.dot(point));
        let edge = |at: usize| {
            let (a, b) = (seen[at], seen[(at + 1) % seen.len()]);
            let cross = a.cross(b);
            let length = cross.length();
            if length > 0.0 { self.normal.dot(cross) / length * length.atan2(a.dot(b)) } else { 0.0 }
        };
        (0..seen.len()).map(edge).sum::<f64>().abs()
    }

    /// True if the whole light lies above the receiver's horizon: where it does not, few samples of a mask count.
    fn sees_all(&self) -> bool {
        let above =
            |at: &DVec2| self.normal.dot(self.corner + self.u * at.x + self.v * at.y - self.origin) > 0.0;
        unit_square().iter().all(above)
    }

    /// Visible fraction of the irradiance, exact but for rounding.
    fn visible(&self, shadows: &[Polygon]) -> f64 {
        let mut pieces = vec![unit_square()];
        for shadow in shadows {
            let mut left = Vec::with_capacity(pieces.len() + 4);
            for piece in pieces {
                subtract(piece, shadow, &mut left);
            }
            pieces = left;
            if pieces.is_empty() {
                return 0.0;
            }
        }
        pieces.iter().map(|piece| self.flux(piece)).sum::<f64>() / self.flux(&unit_square())
    }
}

fn unit_square() -> Polygon {
    vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]
}

/// Part of a convex polygon where `inside` is at least 0; `inside` is linear.
fn cut<P: Copy + std::ops::Add<Output = P> + std::ops::Sub<Output = P> + std::ops::Mul<f64, Output = P>>(
    polygon: Vec<P>,
    inside: impl Fn(P) -> f64,
) -> Vec<P> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (at, &a) in polygon.iter().enumerate() {
        let b = polygon[(at + 1) % polygon.len()];
        let (da, db) = (inside(a), inside(b));
        if da >= 0.0 {
            kept.push(a);
        }
        if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
            kept.push(a + (b - a) * (da / (da - db)));
        }
    }
    kept
}

/// Positive to the left of the edge from corner `at`.
fn left_of(polygon: &[DVec2], at: usize) -> impl Fn(DVec2) -> f64 + use<> {
    let (a, b) = (polygon[at], polygon[(at + 1) % polygon.len()]);
    move |point| (b - a).perp_dot(point - a)
}

/// False if an edge of one of two convex polygons has all of the other on its outer side.
fn overlap(one: &[DVec2], other: &[DVec2]) -> bool {
    let parts = |a: &[DVec2], b: &[DVec2]| {
        let is_edge =
            |edge: usize| a[edge].distance_squared(a[(edge + 1) % a.len()]) > LEAST_EDGE * LEAST_EDGE;
        let side = |edge| left_of(a, edge);
        (0..a.len()).any(|edge| is_edge(edge) && b.iter().all(|&point| side(edge)(point) <= 0.0))
    };
    !parts(one, other) && !parts(other, one)
}

/// Adds the convex pieces of `piece` outside `shadow` to `left`.
fn subtract(piece: Polygon, shadow: &[DVec2], left: &mut Vec<Polygon>) {
    if !overlap(&piece, shadow) {
        left.push(piece);
        return;
    }
    let mut rest = piece;
    for edge in 0..shadow.len() {
        let side = left_of(shadow, edge);
        if rest.iter().any(|&point| side(point) < 0.0) {
            let outside = cut(rest.clone(), |point| -side(point));
            if outside.len() > 2 {
                left.push(outside);
            }
            rest = cut(rest, &side);
            if rest.len() < 3 {
                return;
            }
        }
    }
}

/// Shadows on the light of all triangles between it and a receiver.
fn shadows(scene: &Scene, view: &View) -> Vec<Polygon> {
    let mesh = &scene.mesh;
    let corners = |at: usize| mesh.corners(at).map(Vec3::as_dvec3);
    (0..mesh.triangle_count()).filter_map(|at| view.project(corners(at))).collect()
}

struct Case {
    receiver: Receiver,
    pixel: u32,
    view: View,
    shadows: Vec<Polygon>,
}

/// Receivers in the penumbra of a light, in tiles, with what is before the light.
fn cases(scene: &Arc<Scene>, bvh: &Arc<Bvh>, light: &AreaLight) -> Vec<Case> {
    let pipeline = warm(scene, bvh, "per-pixel").unwrap();
    let gbuffer = pipeline.gbuffer();
    let step = (TILE * EVERY) as usize;
    let mut found = Vec::new();
    for top in (0..gbuffer.height).step_by(step) {
        for left in (0..gbuffer.width).step_by(step) {
            for (x, y) in (0..TILE * TILE).map(|at| (left + at % TILE, top + at / TILE)) {
                let pixel = y * gbuffer.width + x;
                let Some(receiver) = (x < gbuffer.width && y < gbuffer.height)
                    .then(|| gbuffer.receiver(pixel as usize))
                    .flatten()
                    .filter(|receiver| light.side(receiver.origin) > 0.0)
                else {
                    continue;
                };
                let view = View::new(receiver, light.frame());
                let shadows = shadows(scene, &view);
                // Long lists take long, and none of them is timed.
                let fraction = if shadows.len() > BINS[6] { 0.5 } else { view.visible(&shadows) };
                if view.sees_all() && fraction > 0.02 && fraction < 0.98 {
                    found.push(Case { receiver, pixel, view, shadows });
                }
            }
        }
    }
    found
}

fn main() {
    println!(
        "scene,triangles_up_to,receivers,share,clip_us,beam_64_us,beam_256_us,beam_1024_us,rms_64,rms_256,rms_1024"
    );
    let thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for name in ["contact", "railing", "atrium", "nave", "church", "toys", "tree"] {
        let (scene, bvh) = scene(name).unwrap();
        let light = scene.lights[0];
        let cases = cases(&scene, &bvh, &light);
        let (gbuffer, pyramid) = (halflight::gbuffer::GBuffer::default(), Pyramid::default());
        let mut from = 0;
        for upto in BINS {
            let bin: Vec<&Case> =
                cases.iter().filter(|case| (from + 1..=upto).contains(&case.shadows.len())).collect();
            from = upto;
            if bin.len() < 32 {
                continue;
            }
            let clip = || bin.iter().map(|case| case.view.visible(&case.shadows)).collect::<Vec<_>>();
            let exact = clip();
            let clip_us = thread.install(|| median(bin.len(), || drop(black_box(clip()))));
            let mut columns = [(0.0, 0.0); 3];
            for (side, column) in SIDES.into_iter().zip(&mut columns) {
                let pattern = Pattern::with_count(PatternKind::Jittered, side * side).unwrap();
                let frame = Frame {
                    scene: &scene,
                    gbuffer: &gbuffer,
                    pyramid: &pyramid,
                    pattern,
                    sharing: Sharing::Receiver,
                    index: 0,
                    seed: 0,
                };
                let mut batch = MaskBatch::default();
                batch.reset(0, pattern, Purpose::Final);
                for case in &bin {
                    batch.push(case.receiver.origin, case.receiver.normal, case.pixel, case.pixel, None);
                }
                let mut beam = halflight::beam::Beam::new(bvh.clone());
                beam.prepare(&frame);
                let us = thread.install(|| median(bin.len(), || beam.masks(&frame, &mut batch)));
                let squares = exact.iter().enumerate().map(|(at, exact)| {
                    let masked = irradiance::fraction(&light, &batch, at).unwrap_or(0.0);
                    (f64::from(masked) - exact).powi(2)
                });
                *column = (us, (squares.sum::<f64>() / bin.len() as f64).sqrt());
            }
            let [a, b, c] = columns;
            let share = bin.len() as f64 / cases.len() as f64;
            println!(
                "{name},{upto},{},{share:.3},{clip_us:.2},{:.2},{:.2},{:.2},{:.4},{:.4},{:.4}",
                bin.len(),
                a.0,
                b.0,
                c.0,
                a.1,
                b.1,
                c.1
            );
        }
    }
}

/// Median of five times, in microseconds a receiver.
fn median(receivers: usize, mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..5)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[2] * 1e6 / receivers as f64
}
