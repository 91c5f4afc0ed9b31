//! Scenes and groups of receivers that are made to break certificates.

use glam::{Vec2, Vec3};
use halflight_core::hash;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::scene::{MIN_DIAGONAL, Material, Mesh, Scene};
use std::sync::Arc;

/// Receivers of a group: as many as beams take together.
const GROUP: usize = 64;

/// Patterns of the attacks. Those of one row or sample can have all of their samples next to the light's border.
const PATTERNS: [(PatternKind, u16, u16); 5] = [
    (PatternKind::Jittered, 1, 1),
    (PatternKind::ShiftedRows, 16, 1),
    (PatternKind::ShiftedRows, 1, 4),
    (PatternKind::Grid, 8, 8),
    (PatternKind::Jittered, 4, 4),
];

/// Attacks by number.
pub(super) struct Cases {
    seed: u32,
    /// Pattern keys whose first sample lies within a 256th of its stratum from the stratum's border, both ways.
    keys: Vec<u32>,
}

impl Cases {
    pub(super) fn new(seed: u32) -> Self {
        let close = |part: f32| !(1.0 / 256.0..=255.0 / 256.0).contains(&part);
        let keys = (0..1 << 20).filter(|&key| {
            let (u, v) = hash::unit_pair(hash::sample_bits(key, 0));
            close(u) && close(v)
        });
        Self { seed, keys: keys.collect() }
    }

    /// Returns the scene and the group of attack `index`.
    pub(super) fn case(&self, index: u32) -> (Scene, MaskBatch) {
        let mut numbers = Numbers { key: hash::fold(hash::mix(self.seed), index), index: 0 };
        let light = light(&mut numbers);
        let (kind, columns, rows) = PATTERNS[numbers.below(PATTERNS.len())];
        let pattern = Pattern { kind, columns, rows };
        let mut group = Group::new(&mut numbers, &light);
        group.keys = (0..GROUP).map(|_| self.keys[numbers.below(self.keys.len())]).collect();
        // One kind of triangle at a time, or all kinds.
        let kind = numbers.below(8);
        let count = if numbers.one_in(2) { 1 } else { 1 + numbers.below(12) };
        let mut corners = Vec::new();
        for _ in 0..count {
            let kind = if kind > 6 { numbers.below(7) } else { kind };
            corners.push(group.triangle(kind, &mut numbers, &light, pattern));
        }

        // A power of two moves no bit; a shift rounds everything alike.
        let scale = if numbers.one_in(2) { 1.0 } else { 2f32.powi(numbers.below(25) as i32 - 12) };
        let shift =
            if numbers.one_in(4) { numbers.point() * scale * numbers.power(-3.0, 4.0) } else { Vec3::ZERO };
        let place = |p: Vec3| p * scale + shift;
        let light = light.transformed(place, |direction| direction * scale);
        let mut positions: Vec<Vec3> = corners.into_iter().flatten().map(place).collect();
        // A speck is no mesh by itself: a triangle far beyond the light makes it one.
        let (low, high) = positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        if (high - low).length() < 2.0 * MIN_DIAGONAL {
            positions.extend([Vec3::X, Vec3::Y, Vec3::Z].map(|p| place(p + Vec3::Y * 100.0)));
        }
        let triangles: Vec<[u32; 3]> = (0..positions.len() as u32 / 3)
            .map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner))
            .collect();
        let mesh = Mesh {
            normals: vec![Vec3::Y; positions.len()],
            uvs: vec![Vec2::ZERO; positions.len()],
            material_ids: vec![0; triangles.len()],
            materials: vec![Material::default()],
            positions,
            triangles,
            ..Mesh::default()
        };
        let mut batch = MaskBatch::default();
        batch.reset(0, pattern, Purpose::Final);
        for (pixel, (&origin, &key)) in group.origins.iter().zip(&group.keys).enumerate() {
            batch.push(place(origin), Vec3::Y, pixel as u32, key, None);
        }
        (Scene { mesh: Arc::new(mesh), lights: vec![light], ..Scene::default() }, batch)
    }
}

/// Returns a light about a metre above the origin: level or tilted, of any size and shape.
fn light(numbers: &mut Numbers) -> AreaLight {
    let size = numbers.power(-2.0, 0.5);
    let (mut edge_u, mut edge_v) = (Vec3::X * size, Vec3::Z * size * numbers.power(-1.0, 0.0));
    if numbers.one_in(2) {
        edge_u = numbers.point() * size;
        edge_v = numbers.point() * size;
    }
    let middle = Vec3::Y + numbers.point() * 0.3;
    AreaLight::parallelogram(middle - (edge_u + edge_v) * 0.5, edge_u, edge_v, Vec3::ONE).two_sided()
}

/// Receivers in a box.
struct Group {
    low: Vec3,
    high: Vec3,
    origins: Vec<Vec3>,
    keys: Vec<u32>,
}

impl Group {
    /// Returns a box of any size, flat or not, below the light or reaching up to it; receivers in its corners and inside.
    fn new(numbers: &mut Numbers, light: &AreaLight) -> Self {
        let mut size = Vec3::splat(numbers.power(-7.0, 0.0));
        for axis in 0..3 {
            if numbers.one_in(3) {
                size[axis] *= if numbers.one_in(2) { 0.0 } else { numbers.power(-3.0, 0.0) };
            }
        }
        let middle = match numbers.below(6) {
            0 => light.point(Vec2::new(numbers.unit(), numbers.unit())) + numbers.point() * size * 2.0,
            _ => numbers.point() * Vec3::new(1.0, 0.5, 1.0) - Vec3::Y * 0.5,
        };
        let (low, high) = (middle - size * 0.5, middle + size * 0.5);
        let origins = (0..GROUP).map(|index| {
            let inside = Vec3::new(numbers.unit(), numbers.unit(), numbers.unit());
            let end = Vec3::new((index & 1) as f32, (index >> 1 & 1) as f32, (index >> 2) as f32);
            let part = if index < 8 { end } else { inside };
            (low + (high - low) * part).clamp(low, high)
        });
        let origins = origins.collect();
        Self { low, high, origins, keys: Vec::new() }
    }

    /// Returns a triangle of one of seven kinds, aimed at one of the samples of a receiver in a corner of the box.
    fn triangle(
        &mut self,
        kind: usize,
        numbers: &mut Numbers,
        light: &AreaLight,
        pattern: Pattern,
    ) -> [Vec3; 3] {
        let receiver = numbers.below(8);
        let place = pattern.position(numbers.below(pattern.len()), self.keys[receiver]);
        let (from, to) = (self.origins[receiver], light.point(place));
        let middle = ((self.low + self.high) * 0.5, light.point(Vec2::splat(0.5)));
        let t = numbers.unit();
        let at = from.lerp(to, t);
        let outwards = (at - middle.0.lerp(middle.1, t)).normalize_or(Vec3::X);
        match kind {
            // A wire or a speck near the segment.
            0 => {
                let at = at + numbers.point() * numbers.power(-8.0, 0.0);
                let long = numbers.point() * numbers.power(-4.0, 0.5);
                let thin = numbers.point() * numbers.power(-9.0, -1.0);
                [at, at + if numbers.one_in(2) { long } else { thin * 2.0 }, at + thin]
            }
            // Reaching in from outside with a corner on the segment, exactly so where the receiver can be moved to, or just
            // off it.
            1 => {
                let at = self.touch(receiver, to, numbers);
                let gap = if numbers.one_in(2) { numbers.power(-8.0, -3.0) } else { 0.0 };
                let at = at + outwards * gap;
                let long = (outwards + numbers.point() * 0.3) * numbers.power(-3.0, 0.5);
                let aside = numbers.point() * numbers.power(-9.0, 0.0);
                [at, at + long + aside, at + long - aside]
            }
            // In the plane through a receiver and an edge of the light: a face of the hull.
            2 => {
                let (first, second) = match numbers.below(4) {
                    edge @ 0..=2 => (light.corners()[edge], light.corners()[edge + 1]),
                    _ => (to, light.corners()[0]),
                };
                let lift = numbers.point() * numbers.power(-9.0, -5.0) * numbers.unit().round();
                [0, 1, 2].map(|_| {
                    let (a, b) = (numbers.unit() * 1.4 - 0.2, numbers.unit() * 1.4 - 0.2);
                    from + (first.lerp(second, b) - from) * a + lift
                })
            }
            // A level plate whose edges pass just outside or just inside of everything between the box and the light.
            3 => {
                let rays = light.corners().map(|end| [self.low.lerp(end, t), self.high.lerp(end, t)]);
                let (mut low, mut high) = (rays[0][0], rays[0][0]);
                for point in rays.into_iter().flatten() {
                    (low, high) = (low.min(point), high.max(point));
                }
                let sign = if numbers.one_in(4) { -1.0 } else { 1.0 };
                let over = (high - low) * sign * numbers.power(-8.0, 0.5) * numbers.unit().round();
                let (low, wide) = (low - over, (high - low + over * 2.0) * 2.0);
                let height = middle.0.lerp(middle.1, t).y;
                let low = Vec3::new(low.x, height, low.z);
                [low, low + Vec3::X * wide.x, low + Vec3::Z * wide.z]
            }
            // In the light's plane or the box's, or just off them.
            4 => {
                let off = numbers.point() * numbers.power(-9.0, -4.0) * numbers.unit().round();
                let level = if numbers.one_in(2) { self.low.y } else { self.high.y };
                if numbers.one_in(2) {
                    [0, 1, 2]
                        .map(|_| light.point(Vec2::new(numbers.unit(), numbers.unit()) * 3.0 - 1.0) + off)
                } else {
                    [0, 1, 2].map(|_| (from + numbers.point() * 2.0).with_y(level) + off)
                }
            }
            // A sliver as thin as rounding leaves it, with a corner on the segment and one near the world's origin, where
            // coordinates are finest; thinner than double precision resolves where the other two are in line with it.
            5 => {
                let at = self.touch(receiver, to, numbers);
                if numbers.one_in(2) {
                    return [at, at * 2.0, at * numbers.power(-9.0, -4.0)];
                }
                let fine = numbers.point() * numbers.power(-9.0, -4.0);
                [at, fine.lerp(at, numbers.unit() * 3.0 - 1.0), fine]
            }
            // A large triangle that has an edge through the segment and covers much of the light.
            _ => {
                let at = self.touch(receiver, to, numbers);
                let along = numbers.point().cross(to - from).normalize_or(Vec3::X) * numbers.power(-1.0, 1.0);
                let inwards = -outwards * numbers.power(-1.0, 1.0);
                [at + along, at - along * numbers.unit(), at + inwards + along * numbers.unit()]
            }
        }
    }

    /// Returns a point on the way from a receiver to `to`: halfway, with the receiver moved, if but a little, so that it is the
    /// middle exactly, or elsewhere within rounding.
    fn touch(&mut self, receiver: usize, to: Vec3, numbers: &mut Numbers) -> Vec3 {
        let from = self.origins[receiver];
        if numbers.one_in(4) {
            return from.lerp(to, numbers.unit());
        }
        let middle = (from + to) * 0.5;
        self.origins[receiver] = middle * 2.0 - to;
        middle
    }
}

/// Numbers from a counter.
struct Numbers {
    key: u32,
    index: u32,
}

impl Numbers {
    fn bits(&mut self) -> u32 {
        self.index += 1;
        hash::sample_bits(self.key, self.index)
    }

    /// Returns a uniform number in 0 ≤ x < 1.
    fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }

    /// Returns a uniform point in the cube −1 … 1.
    fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// Returns ten to a power between `low` and `high`.
    fn power(&mut self, low: f32, high: f32) -> f32 {
        10f32.powf(low + (high - low) * self.unit())
    }

    fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f32) as usize % count
    }

    fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }
}
