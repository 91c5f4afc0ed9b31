//! Surroundings of the church: graves, a path, benches and an iron fence with a gate.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::bars::{bar, rod};
use super::builder::Builder;
use super::columns::Detail;
use super::random::Random;
use super::shapes::turned;

pub(super) const STONE: u32 = 1;
pub(super) const IRON: u32 = 2;
pub(super) const WOOD: u32 = 3;
pub(super) const PAVING: u32 = 4;

/// The fence's corners, x and z.
const LOW: Vec2 = Vec2::new(-19.0, -13.0);
const HIGH: Vec2 = Vec2::new(19.0, 19.0);
const GATE: f32 = 1.3;

/// Builds all of it, with the path from the gate to a porch at `porch` along x.
pub(super) fn churchyard(builder: &mut Builder, detail: Detail, porch: f32) {
    path(builder, porch);
    graves(builder, detail, porch);
    fence(builder, detail, porch);
    for (x, z) in [(porch + 3.2, 10.2), (porch - 3.2, 10.2)] {
        bench(builder, Vec3::new(x, 0.0, z));
    }
}

fn path(builder: &mut Builder, porch: f32) {
    let mut random = Random::new(7, 0);
    builder.paint(PAVING);
    for row in 0..17 {
        for column in 0..3 {
            let middle = Vec3::new(porch + (column as f32 - 1.0) * 0.72, -0.05, 9.0 + 0.62 * row as f32);
            let size = Vec3::new(0.66, 0.05 + random.between(0.03, 0.06), 0.56);
            builder.block(middle, size);
        }
    }
}

/// A slab with a round or pointed top, 2 · `half` wide, facing +z on y = 0.
fn headstone(half: f32, height: f32, pointed: bool, detail: Detail) -> Builder {
    let steps = detail.steps(if pointed { 3.0 } else { 6.0 });
    let mut outline = vec![Vec2::new(half, -0.1)];
    outline.extend((0..=2 * steps).map(|i| {
        let (sin, cos) = (PI * i as f32 / (2 * steps) as f32).sin_cos();
        let rise = if pointed { 1.0 - cos.abs() } else { 0.7 * sin };
        Vec2::new(half * cos, height - half + half * rise)
    }));
    outline.push(Vec2::new(-half, -0.1));
    let mut stone = Builder::new();
    stone.paint(STONE);
    let depth = 0.08;
    let last = outline.len() - 1;
    for z in [depth, -depth] {
        // A fan of strips from the middle line of the foot.
        stone.sheet(last, 1, |row, column| {
            let p = outline[if z > 0.0 { row } else { last - row }];
            let p = if column == 0 { Vec2::new(0.0, -0.1) } else { p };
            p.extend(z)
        });
    }
    stone.sheet(outline.len() - 1, 1, |row, column| outline[row].extend([depth, -depth][column]));
    stone.quad([
        Vec3::new(-half, -0.1, depth),
        Vec3::new(-half, -0.1, -depth),
        Vec3::new(half, -0.1, -depth),
        Vec3::new(half, -0.1, depth),
    ]);
    stone
}

/// Rows of headstones and crosses on either side of the path, some of them leaning.
fn graves(builder: &mut Builder, detail: Detail, porch: f32) {
    let mut random = Random::new(3, 1);
    for row in 0..3 {
        for column in 0..17 {
            let x = 2.05 * column as f32 - 16.6 + random.between(-0.3, 0.3);
            let z = 11.4 + 2.3 * row as f32 + random.between(-0.25, 0.25);
            let kind = random.unit();
            let (half, height) = (random.between(0.28, 0.42), random.between(0.8, 1.25));
            let lean = [random.between(-0.09, 0.09), random.between(-0.12, 0.12)];
            let empty = random.unit() < 0.15;
            if empty || (x - porch).abs() < 1.9 || ((x - porch).abs() < 4.4 && row == 0) {
                continue;
            }
            let mut grave = headstone(half, height, kind < 0.3, detail);
            if kind > 0.75 {
                grave = Builder::new();
                grave.paint(STONE);
                grave.block(Vec3::Y * -0.1, Vec3::new(0.6, 0.35, 0.4));
                grave.block(Vec3::Y * 0.2, Vec3::new(0.16, height + 0.2, 0.15));
                grave.block(Vec3::Y * (height - 0.1), Vec3::new(0.62, 0.16, 0.14));
            }
            builder.place(&grave, |p| Vec3::new(x + p.x + lean[0] * p.y, p.y, z + p.z + lean[1] * p.y));
            builder.paint(STONE);
            builder.block(Vec3::new(x, -0.05, z + 1.0), Vec3::new(0.9, 0.09, 1.5));
        }
    }
}

/// Iron bars with tips between posts, all around but for the gate at `gate` on the side of +z.
fn fence(builder: &mut Builder, detail: Detail, gate: f32) {
    let spacing = 0.16 / detail.0.min(1.5);
    let sides = detail.sides(6.0);
    let mut picket = Builder::new();
    picket.paint(IRON);
    rod(&mut picket, [Vec3::Y * -0.05, Vec3::Y * 1.25], 0.016, sides);
    let tip = [[0.0, 1.2], [0.04, 1.25], [0.0, 1.42]].map(Vec2::from_array);
    turned(&mut picket, &tip, sides);
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let lines = [
        [corner(LOW.x, HIGH.y), corner(gate - GATE, HIGH.y)],
        [corner(gate + GATE, HIGH.y), corner(HIGH.x, HIGH.y)],
        [corner(HIGH.x, HIGH.y), corner(HIGH.x, LOW.y)],
        [corner(HIGH.x, LOW.y), corner(LOW.x, LOW.y)],
        [corner(LOW.x, LOW.y), corner(LOW.x, HIGH.y)],
    ];
    for [from, to] in lines {
        let length = from.distance(to);
        builder.paint(IRON);
        for y in [0.2, 1.1] {
            bar(builder, [from, to].map(|end| end + Vec3::Y * y), Vec3::Y, [0.05, 0.03]);
        }
        let spans = (length / 2.6).round().max(1.0) as usize;
        for span in 0..spans {
            let at = |t: f32| from.lerp(to, (span as f32 + t) / spans as f32);
            let count = (length / spans as f32 / spacing).round() as usize;
            for index in 1..count {
                let foot = at(index as f32 / count as f32);
                builder.place(&picket, |p| p + foot);
            }
            post(builder, at(0.0), 0.24, 1.3);
        }
    }
    for x in [gate - GATE, gate + GATE] {
        post(builder, corner(x, HIGH.y), 0.5, 1.9);
    }
}

/// A square stone post under a pyramid.
fn post(builder: &mut Builder, foot: Vec3, width: f32, height: f32) {
    builder.paint(STONE);
    builder.block(foot - Vec3::Y * 0.1, Vec3::new(width, height, width));
    let top = foot + Vec3::Y * (height - 0.1);
    builder.hexahedron(|i| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
        let half = if i >> 1 & 1 == 1 { 0.0 } else { 1.2 * width };
        top + Vec3::new(sign(0) * half, if half > 0.0 { 0.0 } else { 0.5 * width }, sign(2) * half)
    });
}

fn bench(builder: &mut Builder, foot: Vec3) {
    builder.paint(WOOD);
    for x in [-0.8, 0.8] {
        builder.block(foot + Vec3::new(x, -0.05, 0.0), Vec3::new(0.08, 0.48, 0.44));
        builder.block(foot + Vec3::new(x, 0.3, -0.2), Vec3::new(0.08, 0.6, 0.06));
    }
    for slat in 0..4 {
        let z = -0.165 + 0.11 * slat as f32;
        builder.block(foot + Vec3::new(0.0, 0.42, z), Vec3::new(1.8, 0.04, 0.09));
    }
    for y in [0.6, 0.76] {
        builder.block(foot + Vec3::new(0.0, y, -0.15), Vec3::new(1.8, 0.1, 0.03));
    }
}
