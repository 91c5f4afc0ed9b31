//! A garden bed: shrubs of quads with a compound leaf as alpha mask, before a wall.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use halflight_core::alpha::{AlphaMask, DEFAULT_CUTOFF};
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::parameters::Parameters;
use super::random::Random;
use super::shapes::tube;

const GROUND: u32 = 0;
const WALL: u32 = 1;
const BARK: u32 = 2;
const LEAVES: [u32; 2] = [3, 4];
const PALETTE: [[f32; 3]; 5] =
    [[0.50, 0.44, 0.36], [0.62, 0.58, 0.52], [0.30, 0.22, 0.16], [0.24, 0.45, 0.14], [0.34, 0.50, 0.18]];

/// Shrubs: foot, height and radius of the crown, metres.
const SHRUBS: [(Vec2, f32, f32); 4] = [
    (Vec2::new(-1.5, -0.7), 1.7, 0.75),
    (Vec2::new(-0.2, 0.1), 1.1, 0.55),
    (Vec2::new(0.8, -0.8), 1.9, 0.8),
    (Vec2::new(1.7, 0.2), 0.9, 0.5),
];

/// Texels along the side of the mask.
const SIDE: u32 = 64;

/// Pairs of leaflets of a leaf.
const PAIRS: u32 = 5;

/// A garden 4 m wide; `leaves` is the number of leaves of all shrubs, two triangles each.
pub(super) fn garden(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let leaves = parameters.count("leaves", 1200, 1..=1_000_000)?;
    let seed = parameters.count("seed", 1, 0..=u32::MAX)?;
    parameters.finish()?;
    let mut builder = Builder::new();
    builder.paint(GROUND);
    builder.floor(16.0, 8);
    builder.paint(WALL);
    // No face of the wall lies in the ground.
    builder.cuboid(Vec3::new(-2.8, -0.1, -1.9), Vec3::new(2.8, 1.9, -1.65));
    builder.paint(BARK);
    for (number, (foot, height, radius)) in (0..).zip(SHRUBS) {
        stems(&mut builder, &mut Random::new(seed, number), foot, height, radius);
    }
    let mut random = Random::new(seed, SHRUBS.len() as u32);
    for number in 0..leaves {
        leaf(&mut builder, &mut random, SHRUBS[number as usize % SHRUBS.len()]);
    }
    let mut mesh = builder.finish(&PALETTE);
    let first = mesh.uvs.len() - 4 * leaves as usize;
    let corners = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
    mesh.uvs[first..].iter_mut().zip(corners.into_iter().cycle()).for_each(|(uv, corner)| *uv = corner);
    mesh.alpha_masks = AlphaMask::new(SIDE, SIDE, texels().into_iter(), DEFAULT_CUTOFF).into_iter().collect();
    for material in LEAVES {
        mesh.materials[material as usize].alpha_mask = Some(0);
    }
    Ok(mesh)
}

/// Stems from the foot of a shrub into its crown.
fn stems(builder: &mut Builder, random: &mut Random, foot: Vec2, height: f32, radius: f32) {
    let start = Vec3::new(foot.x, -0.05, foot.y);
    for stem in 0..5 {
        let (sin, cos) = ((stem as f32 + random.unit()) / 5.0 * TAU).sin_cos();
        let out = Vec3::new(cos, 0.0, sin) * (0.5 * radius);
        let tip = start + out + Vec3::Y * (height * random.between(0.6, 0.85));
        let middle = start.lerp(tip, 0.5) - out * 0.25;
        tube(builder, &[(start, 0.02), (middle, 0.014), (tip, 0.0)], 6);
    }
}

/// A leaf in the crown of a shrub, denser towards its surface and turned outwards.
fn leaf(builder: &mut Builder, random: &mut Random, (foot, height, radius): (Vec2, f32, f32)) {
    let out = random.direction();
    let middle = Vec3::new(foot.x, 0.62 * height, foot.y);
    let reach = random.unit().sqrt();
    let base = middle + out * reach * Vec3::new(radius, 0.36 * height, radius);
    let along = (out + random.direction() * 0.8 - Vec3::Y * 0.2).normalize_or(Vec3::Y);
    let across = along.cross(random.direction()).normalize_or(along.any_orthonormal_vector());
    let length = random.between(0.16, 0.3);
    let (along, half) = (along * length, across * (0.35 * length));
    builder.paint(LEAVES[usize::from(random.unit() < 0.5)]);
    builder.quad([base - half, base + half, base + half + along, base - half + along]);
}

/// Alpha of a leaf whose stalk is the middle of the lower edge: pairs of leaflets along a rib and one at its end.
fn texels() -> Vec<u8> {
    let solid = |texel: u32| {
        let place = |number: u32| (number as f32 + 0.5) / SIDE as f32;
        let (x, y) = ((place(texel % SIDE) - 0.5).abs(), 1.0 - place(texel / SIDE));
        let leaflet = |root: f32, direction: Vec2, length: f32| {
            let from = Vec2::new(x, y - root);
            // A lens: wide at a third of its length.
            let (t, width) = (from.dot(direction) / length, from.perp_dot(direction).abs() / length);
            (0.0..=1.0).contains(&t) && width < 0.34 * t.sqrt() * (1.0 - t)
        };
        let pair = |number: u32| {
            let t = number as f32 / PAIRS as f32;
            leaflet(0.12 + 0.6 * t, Vec2::from_angle(0.5), 0.46 - 0.2 * t)
        };
        x < 0.012 && y < 0.8 || leaflet(0.7, Vec2::Y, 0.3) || (0..PAIRS).any(pair)
    };
    (0..SIDE * SIDE).map(|texel| if solid(texel) { 255 } else { 0 }).collect()
}
