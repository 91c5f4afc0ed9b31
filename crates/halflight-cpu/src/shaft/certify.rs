//! Certificates for regions: facts about all receivers of a region, from a shaft and the triangles in it.

use glam::{DVec3, Vec3};
use halflight_core::certificate::{Certificate, Region};
use halflight_core::light::{AreaLight, Extent, LightFrame};
use rayon::prelude::*;

use super::{Gather, Hull, List};
use crate::bvh::Bvh;
use crate::pool::Pool;
use crate::simd::{Isa, Kernel, Simd};

/// Most triangles in a shaft for which certification is attempted: with more, the region is too large for its
/// occluders.
const MOST: usize = 64;

/// Most triangles of a shaft for which each is tested as an occluder of the whole shaft: among more, a single
/// one seldom covers it.
const COVERS: usize = 16;

/// Computes certificates of regions.
#[derive(Debug, Default)]
pub(crate) struct Certifier {
    pool: Pool<Work>,
}

/// Working memory that is reused from region to region.
#[derive(Default)]
struct Work {
    list: List,
    waiting: Vec<u32>,
    edges: Vec<Edge>,
}

impl Certifier {
    /// Writes one certificate per region, which says nothing of a sphere light.
    pub(crate) fn certify(
        &self,
        bvh: &Bvh,
        light: &AreaLight,
        regions: &[Region],
        certificates: &mut Vec<Certificate>,
    ) {
        if light.as_sphere().is_some() {
            // Shafts are to one frame.
            certificates.clear();
            return certificates.resize(regions.len(), Certificate::Open);
        }
        let isa = Isa::best();
        let certify = |region: &Region| {
            self.pool.lend(Work::default, |work| isa.run(Attempt { work, bvh, light, region: *region }))
        };
        regions.par_iter().with_min_len(16).map(certify).collect_into_vec(certificates);
    }
}

/// Certification of one region.
struct Attempt<'a> {
    work: &'a mut Work,
    bvh: &'a Bvh,
    light: &'a AreaLight,
    region: Region,
}

impl Kernel for Attempt<'_> {
    type Output = Certificate;

    #[inline(always)]
    fn run<S: Simd>(self) -> Certificate {
        let Self { work: Work { list, waiting, edges }, bvh, light, region } = self;
        // NaN and infinite bounds give no certificate.
        if !(region.low.cmple(region.high).all() && region.low.is_finite() && region.high.is_finite()) {
            return Certificate::Open;
        }
        let hull = Hull::new(region.low, region.high, light, bvh.largest());
        if !S::call(Gather { list, waiting, bvh, hull: &hull, most: MOST }) {
            return Certificate::Open;
        }
        if list.len() == 0 {
            return Certificate::Lit;
        }
        let places = || (0..list.len()).map(|place| (&list.blocks()[place / 8], place % 8));
        if list.len() <= COVERS && places().any(|(block, lane)| hull.is_covered::<S>(block, lane)) {
            return Certificate::Umbra;
        }
        let Some(sweep) = Sweep::new(light, &region) else { return Certificate::Open };
        edges.clear();
        for (block, lane) in places() {
            let corners = block.triangle_corners(lane);
            for first in 0..3 {
                let (p, q, other) = (corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]);
                if let Some((from, to)) = hull.clip(p.as_dvec3(), q.as_dvec3()) {
                    edges.push(Edge::new(p, q, other, sweep.area(from, to)));
                }
            }
        }
        match bound(edges, &region) {
            area if area < 1.0 => Certificate::Bounded(area as f32),
            _ => Certificate::Open,
        }
    }
}

/// Bounds on how far shadows move on the light when a receiver moves through a region.
struct Sweep {
    corner: DVec3,
    normal: DVec3,
    /// Vectors whose products with a point of the light's plane are its coordinates 0 … 1 on the light.
    dual: [DVec3; 2],
    middle: DVec3,
    /// Height of the lowest receiver above the light's plane.
    lowest: f64,
    /// Diameter of the region, over the cosine of the flattest direction to the light.
    apart: f64,
}

impl Sweep {
    /// Sweep of a region; `None` where the light's plane crosses the region, or where fractions of the frame's
    /// area are not fractions of the light's.
    fn new(light: &AreaLight, region: &Region) -> Option<Self> {
        if light.extent() != Extent::Whole {
            return None;
        }
        let (low, high) = (region.low.as_dvec3(), region.high.as_dvec3());
        let LightFrame { origin: corner, u, v } = light.frame();
        let [corner, u, v] = [corner, u, v].map(Vec3::as_dvec3);
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let cross = u.cross(v);
        let mut normal = cross.try_normalize()?;
        if normal.dot(middle - corner) < 0.0 {
            normal = -normal;
        }
        let lowest = normal.dot(middle - corner) - normal.abs().dot(half);
        let farthest = light.corners().into_iter().map(|c| (c.as_dvec3() - middle).length());
        let farthest = farthest.fold(0.0, f64::max) + half.length();
        (lowest > 0.0).then(|| Self {
            corner,
            normal,
            dual: [v.cross(cross) / cross.length_squared(), cross.cross(u) / cross.length_squared()],
            middle,
            lowest,
            apart: 2.0 * half.length() * farthest / lowest,
        })
    }

    /// Fraction of the light's area that the shadow of an edge can sweep over. Infinite where the edge is as
    /// near to the light's plane as receivers are, or lies on both sides of it.
    fn area(&self, from: DVec3, to: DVec3) -> f64 {
        let height = |point: DVec3| self.normal.dot(point - self.corner).max(0.0);
        let farther = height(from).max(height(to));
        if farther >= self.lowest * 0.999 {
            return f64::INFINITY;
        }
        // The shadow of a point moves against the receiver's motion, scaled by the ratio of the distances
        // occluder–light and receiver–occluder.
        let moved = self.apart * farther / (self.lowest - farther);
        let shadow = |point: DVec3| {
            let (there, here) = (height(point), self.normal.dot(self.middle - self.corner));
            let place = self.middle + (point - self.middle) * (here / (here - there)) - self.corner;
            self.dual.map(|axis| axis.dot(place))
        };
        let ([a, b], [c, d]) = (shadow(from), shadow(to));
        let [along, across] = self.dual.map(|axis| axis.length() * moved);
        (c - a).abs() * across + (d - b).abs() * along + 4.0 * along * across
    }
}

/// Edge of a triangle in the shaft.
struct Edge {
    /// End points as bits, in an order that does not depend on the edge's direction.
    ends: [[u32; 3]; 2],
    points: [DVec3; 2],
    /// Third corner of the triangle.
    other: DVec3,
    area: f64,
}

impl Edge {
    fn new(p: Vec3, q: Vec3, other: Vec3, area: f64) -> Self {
        let bits = |point: Vec3| point.to_array().map(f32::to_bits);
        let (p, q) = if bits(p) <= bits(q) { (p, q) } else { (q, p) };
        Self { ends: [bits(p), bits(q)], points: [p.as_dvec3(), q.as_dvec3()], other: other.as_dvec3(), area }
    }

    /// Six times the signed volume of the tetrahedron of a point and the triangle: its sign is the side of
    /// the edge on which the triangle appears from the point.
    fn volume(&self, ends: &[DVec3; 2], from: DVec3) -> f64 {
        (ends[0] - from).cross(ends[1] - from).dot(self.other - from)
    }
}

/// Bound on the difference of the hidden fraction of the light between receivers: the area that the edges of
/// the triangles' union sweep over. An edge shared by two triangles does not count if all receivers see the
/// triangles on both sides of it.
fn bound(edges: &mut [Edge], region: &Region) -> f64 {
    edges.sort_unstable_by(|a, b| a.ends.cmp(&b.ends).then(a.area.total_cmp(&b.area)));
    let corners: [DVec3; 8] = std::array::from_fn(|corner| {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { region.low[axis] } else { region.high[axis] };
        Vec3::new(pick(0), pick(1), pick(2)).as_dvec3()
    });
    let size = corners[0].abs().max(corners[7].abs()).max_element();
    let parts = |a: &Edge, b: &Edge| {
        let scale = a.points[0].abs().max(a.points[1].abs()).max(a.other.abs()).max(b.other.abs());
        // Volumes are linear in the receiver's position, so their extremes are at the box's corners.
        let least = (scale.max_element() + size).powi(3) * 1e-14;
        let sign = a.volume(&a.points, corners[0]).signum();
        corners.iter().all(|&corner| {
            sign * a.volume(&a.points, corner) > least && sign * b.volume(&a.points, corner) < -least
        })
    };
    let mut area = 0.0;
    for group in edges.chunk_by(|a, b| a.ends == b.ends) {
        let inner = group.iter().enumerate().any(|(at, a)| group[at + 1..].iter().any(|b| parts(a, b)));
        if !inner {
            area += group.iter().map(|edge| edge.area).sum::<f64>();
        }
    }
    area
}

#[cfg(test)]
mod tests {
    use halflight_core::mask::{MaskBatch, Purpose};
    use halflight_core::pattern::{Pattern, PatternKind};
    use halflight_core::scene::Scene;

    use super::*;
    use crate::brute_force::BruteForce;
    use crate::bvh::tests::meshes::{answer, clusters, cuboid, hall, lamp, scene, soup, sphere};

    /// Visible fraction at each receiver, by 16 × 16 samples.
    fn shares(scene: &Scene, receivers: &[Vec3]) -> Vec<f32> {
        let pattern = Pattern { kind: PatternKind::Grid, columns: 16, rows: 16 };
        let mut batch = MaskBatch::default();
        batch.reset(0, pattern, Purpose::Final);
        for &receiver in receivers {
            batch.push(receiver, Vec3::Y, 0, 0, None);
        }
        let bits = answer(&mut BruteForce, scene, &mut batch);
        bits.chunks(4).map(|mask| mask.iter().map(|w| w.count_ones()).sum::<u32>() as f32 / 256.0).collect()
    }

    #[test]
    fn certificates_hold_at_every_receiver() {
        let lamp = lamp(Vec3::new(4.0, 3.8, 8.0), 1.5);
        let mut boxes = soup(40, 0.6);
        boxes.iter_mut().flatten().for_each(|corner| *corner += Vec3::new(4.0, 1.8, 8.0));
        let mut ball = sphere(8);
        ball.iter_mut().flatten().for_each(|corner| *corner = *corner * 0.5 + Vec3::new(4.0, 2.0, 8.0));
        let table = cuboid(Vec3::new(2.0, 2.0, 6.0), Vec3::new(6.0, 2.1, 10.0));
        let slab = cuboid(Vec3::new(0.0, 2.0, 0.0), Vec3::new(20.0, 2.1, 20.0));
        let (mut lit, mut umbra, mut bounded, mut tight) = (0, 0, 0, 0);
        for mesh in [hall(), boxes, ball, table, slab] {
            let scene = scene(&mesh, lamp);
            let bvh = Bvh::build(&scene.mesh).unwrap();
            let origins = clusters(40, Vec3::new(1.0, 0.02, 4.0), Vec3::new(7.0, 0.6, 12.0));
            for size in [0.002, 0.02, 0.2] {
                let middle = |&low: &Vec3| Region { low, high: low + Vec3::new(size, size * 0.1, size) };
                let regions: Vec<Region> = origins.iter().map(middle).collect();
                let mut certificates = Vec::new();
                Certifier::default().certify(&bvh, &scene.lights[0], &regions, &mut certificates);
                for (region, certificate) in regions.iter().zip(certificates) {
                    let at =
                        |x: f32, y: f32, z: f32| region.low + (region.high - region.low) * Vec3::new(x, y, z);
                    let receivers = [
                        at(0.0, 0.0, 0.0),
                        at(1.0, 0.0, 0.0),
                        at(0.0, 1.0, 1.0),
                        at(1.0, 0.5, 1.0),
                        at(0.4, 0.3, 0.6),
                    ];
                    let shares = shares(&scene, &receivers);
                    let low = shares.iter().copied().fold(1.0, f32::min);
                    let high = shares.iter().copied().fold(0.0, f32::max);
                    match certificate {
                        Certificate::Lit => assert_eq!((low, high), (1.0, 1.0)),
                        Certificate::Umbra => assert_eq!((low, high), (0.0, 0.0)),
                        // Samples resolve an edge across the light to within a row of 16, and a shape has two
                        // edges.
                        Certificate::Bounded(share) => {
                            assert!(high - low <= share + 2.0 / 16.0, "{share}: {shares:?}");
                        }
                        Certificate::Open => {}
                    }
                    lit += u32::from(certificate == Certificate::Lit);
                    umbra += u32::from(certificate == Certificate::Umbra);
                    bounded += u32::from(matches!(certificate, Certificate::Bounded(share) if share < 0.5));
                    tight += u32::from(
                        matches!(certificate, Certificate::Bounded(share) if share < 0.5 && high > low),
                    );
                }
            }
        }
        // All kinds occur, and bounded regions whose fraction does vary.
        assert!(lit > 20 && umbra > 5 && bounded > 20 && tight > 5, "{lit} {umbra} {bounded} {tight}");
    }

    #[test]
    fn regions_without_sense_are_open() {
        let scene = scene(&hall(), lamp(Vec3::new(4.0, 3.8, 8.0), 1.5));
        let bvh = Bvh::build(&scene.mesh).unwrap();
        let mut certificates = Vec::new();
        let everywhere = Region { low: Vec3::NEG_INFINITY, high: Vec3::INFINITY };
        let nan = Region { low: Vec3::NAN, high: Vec3::ONE };
        // A region across the light's plane.
        let across = Region { low: Vec3::new(3.9, 3.0, 7.9), high: Vec3::new(4.1, 4.0, 8.1) };
        Certifier::default().certify(
            &bvh,
            &scene.lights[0],
            &[Region::EMPTY, everywhere, nan, across],
            &mut certificates,
        );
        assert_eq!(certificates[..3], [Certificate::Open; 3]);
        assert_ne!(certificates[3], Certificate::Lit);
    }
}
