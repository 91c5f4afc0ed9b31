//! Meshes for tests, and batches of queries in them.

use glam::Vec3;
use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::hash;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::{Material, Mesh, Scene};
use halflight_core::stages::Visibility;
use std::sync::Arc;

/// Pseudo-random numbers in 0 … 1 from a counter.
pub(crate) struct Numbers(pub(crate) u32);

impl Numbers {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        hash::unit_pair(hash::sample_bits(0x5eed, self.0)).0
    }

    /// A point in the cube −1 … 1.
    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

/// A mesh of triangles given by their corners, one material.
pub(crate) fn mesh(corners: &[[Vec3; 3]]) -> Mesh {
    Mesh {
        positions: corners.iter().flatten().copied().collect(),
        normals: Vec::new(),
        uvs: vec![glam::Vec2::ZERO; corners.len() * 3],
        triangles: (0..corners.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        material_ids: vec![0; corners.len()],
        materials: vec![Material::default()],
        ..Mesh::default()
    }
}

/// Triangles of edge length `size` at random in the cube −1 … 1.
pub(crate) fn soup(count: usize, size: f32) -> Vec<[Vec3; 3]> {
    let mut numbers = Numbers(1);
    (0..count)
        .map(|_| {
            let at = numbers.point();
            [at, at + numbers.point() * size, at + numbers.point() * size]
        })
        .collect()
}

/// Two triangles that span a parallelogram.
fn quad(corner: Vec3, u: Vec3, v: Vec3) -> [[Vec3; 3]; 2] {
    [[corner, corner + u, corner + u + v], [corner, corner + u + v, corner + v]]
}

/// A closed box, twelve triangles that share their corners bit for bit.
pub(crate) fn cuboid(low: Vec3, high: Vec3) -> Vec<[Vec3; 3]> {
    let corner = |bits: usize| {
        let side = |axis: usize| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] };
        Vec3::new(side(0), side(1), side(2))
    };
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        .into_iter()
        .map(|face| face.map(corner))
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect()
}

/// A closed sphere of unit radius about the origin, whose triangles share their corners bit for bit.
pub(crate) fn sphere(rings: usize) -> Vec<[Vec3; 3]> {
    let point = |ring: usize, segment: usize| {
        if ring == 0 || ring == rings {
            return if ring == 0 { Vec3::Y } else { Vec3::NEG_Y };
        }
        let polar = std::f32::consts::PI * ring as f32 / rings as f32;
        let around = std::f32::consts::TAU * (segment % (2 * rings)) as f32 / (2 * rings) as f32;
        Vec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin())
    };
    let mut out = Vec::new();
    for ring in 0..rings {
        for segment in 0..2 * rings {
            let (a, b) = (point(ring, segment), point(ring, segment + 1));
            let (c, d) = (point(ring + 1, segment), point(ring + 1, segment + 1));
            if ring > 0 {
                out.push([a, b, c]);
            }
            if ring + 1 < rings {
                out.push([b, d, c]);
            }
        }
    }
    out
}

/// A floor, walls and two rows of columns with beams across them, in the box 0 … (8, 4, 16).
pub(crate) fn hall() -> Vec<[Vec3; 3]> {
    let mut out = cuboid(Vec3::ZERO, Vec3::new(8.0, 4.0, 16.0));
    for row in 0..8 {
        let z = 1.0 + 2.0 * row as f32;
        for x in [2.0, 6.0] {
            let sides = 24;
            for side in 0..sides {
                let rim = |side: usize| {
                    let angle = std::f32::consts::TAU * (side % sides) as f32 / sides as f32;
                    Vec3::new(x + 0.2 * angle.cos(), 0.0, z + 0.2 * angle.sin())
                };
                out.extend(quad(rim(side), rim(side + 1) - rim(side), Vec3::Y * 3.0));
            }
        }
        out.extend(cuboid(Vec3::new(1.5, 3.0, z - 0.25), Vec3::new(6.5, 3.3, z + 0.25)));
    }
    out
}

/// A scene around a mesh.
pub(crate) fn scene(corners: &[[Vec3; 3]], light: AreaLight) -> Scene {
    Scene { mesh: Arc::new(mesh(corners)), lights: vec![light], ..Scene::default() }
}

/// Horizontal square light that faces down, centred at `middle`.
pub(crate) fn lamp(middle: Vec3, size: f32) -> AreaLight {
    let corner = middle - Vec3::new(size, 0.0, size) * 0.5;
    AreaLight::parallelogram(corner, Vec3::X * size, Vec3::Z * size, Vec3::ONE).two_sided()
}

/// Batch of queries at `origins`. Where `sparse`, 16 at a time share a key; every other 16 of them want few
/// samples, all the same few, and the others half of theirs. Otherwise each query has a key of its own and
/// wants all samples.
pub(crate) fn ask(origins: &[Vec3], pattern: Pattern, sparse: bool) -> MaskBatch {
    let mut batch = MaskBatch::default();
    batch.reset(0, pattern, Purpose::Refine);
    for (index, &origin) in origins.iter().enumerate() {
        let group = index as u32 / 16;
        let (bits, shared) = (hash::mix(index as u32), hash::mix(group ^ 0x5eed));
        let few = if group.is_multiple_of(2) {
            u64::MAX
        } else {
            1 << (shared % 64) | 1 << ((shared >> 8) % 64) | 0xf
        };
        let subset: Vec<u64> = (0..pattern.words() as u32)
            .map(|word| u64::from(hash::fold(bits, word)) << 32 | u64::from(hash::fold(bits, !word)))
            .map(|half| half & few)
            .collect();
        let key = if sparse { shared } else { bits };
        batch.push(origin, Vec3::Y, index as u32, key, sparse.then_some(&subset));
    }
    batch
}

/// Answers a batch by a backend and returns all visible bits that were wanted.
pub(crate) fn answer(visibility: &mut dyn Visibility, scene: &Scene, batch: &mut MaskBatch) -> Vec<u64> {
    let (gbuffer, pyramid) = (GBuffer::default(), Pyramid::default());
    let frame = Frame {
        scene,
        gbuffer: &gbuffer,
        pyramid: &pyramid,
        pattern: batch.pattern(),
        sharing: Sharing::Receiver,
        index: 0,
        seed: 0,
    };
    visibility.masks(&frame, batch);
    (0..batch.len())
        .flat_map(|query| {
            let masks = batch.visible(query).iter().zip(batch.wanted(query));
            masks.map(|(visible, wanted)| visible & wanted).collect::<Vec<_>>()
        })
        .collect()
}

/// Patterns of all sizes and kinds.
pub(crate) fn patterns() -> impl Iterator<Item = Pattern> {
    [
        (PatternKind::Jittered, 64),
        (PatternKind::Grid, 16),
        (PatternKind::ShiftedRows, 7),
        (PatternKind::Jittered, 256),
    ]
    .into_iter()
    .map(|(kind, count)| Pattern::with_count(kind, count).unwrap())
}

/// Origins inside a box in clusters of 64, similar to the pixels of a tile; the clusters' sizes differ
/// widely.
pub(crate) fn clusters(count: usize, low: Vec3, high: Vec3) -> Vec<Vec3> {
    let mut numbers = Numbers(5);
    let (mut middle, mut size) = (low, 0.0);
    (0..count)
        .map(|index| {
            if index % 64 == 0 {
                middle = low + (numbers.point() * 0.5 + 0.5) * (high - low);
                size = 10f32.powf(-4.0 * numbers.next());
            }
            (middle + numbers.point() * (high - low) * size * 0.2).clamp(low, high)
        })
        .collect()
}
