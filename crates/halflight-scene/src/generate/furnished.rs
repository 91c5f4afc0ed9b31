//! Small furnished scenes of many kinds, unlike the halls: things on a floor, a laid table, a bookcase,
//! chairs, stairs, potted plants, boxes in a corner, wires, and a long table below a low ceiling.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec2, Vec3};
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::bars::{bar, rod};
use super::builder::Builder;
use super::furniture::{bookcase, chair, cup, flight, plant, table};
use super::parameters::Parameters;
use super::random::Random;
use super::shapes::{tube, turned};

/// Kinds of scenes, in the order of the parameter `kind`.
pub(super) const KINDS: [&str; 9] =
    ["objects", "table", "bookcase", "chairs", "stairs", "plants", "corner", "wires", "conference"];

/// Albedos: floor and walls, then furniture.
const PALETTE: [[f32; 3]; 6] = [
    [0.70, 0.68, 0.64],
    [0.55, 0.36, 0.20],
    [0.75, 0.20, 0.16],
    [0.20, 0.36, 0.62],
    [0.24, 0.48, 0.22],
    [0.82, 0.80, 0.76],
];

/// The mesh of one kind and seed: 100 to 40,000 triangles on a floor, furniture within two metres and a half
/// of the middle.
pub(super) fn furnished(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let kind = parameters.choice("kind", &KINDS)?;
    let seed = parameters.count("seed", 1, 0..=u32::MAX)?;
    let walls = parameters.count("walls", 0, 0..=4)? as usize;
    parameters.finish()?;
    let mut builder = Builder::new();
    builder.floor(12.0, 4);
    room(&mut builder, walls);
    let mut random = Random::new(seed, kind as u32);
    let make = [objects, laid_table, shelves, chairs, stairs, plants, corner, wires, conference][kind];
    make(&mut builder, &mut random);
    Ok(builder.finish(&PALETTE))
}

/// Walls of 2.7 m at three metres from the middle: behind, left, right, and a ceiling.
fn room(builder: &mut Builder, walls: usize) {
    let (far, high) = (3.0, 2.7);
    let at = |x: f32, y: f32, z: f32| Vec3::new(x * far, y * high, z * far);
    let faces = [
        [at(-1.0, 0.0, -1.0), at(1.0, 0.0, -1.0), at(1.0, 1.0, -1.0), at(-1.0, 1.0, -1.0)],
        [at(-1.0, 0.0, 1.0), at(-1.0, 0.0, -1.0), at(-1.0, 1.0, -1.0), at(-1.0, 1.0, 1.0)],
        [at(1.0, 0.0, -1.0), at(1.0, 0.0, 1.0), at(1.0, 1.0, 1.0), at(1.0, 1.0, -1.0)],
        [at(-1.0, 1.0, -1.0), at(1.0, 1.0, -1.0), at(1.0, 1.0, 1.0), at(-1.0, 1.0, 1.0)],
    ];
    faces.into_iter().take(walls).for_each(|face| builder.quad(face));
}

/// Adds a part, turned about the vertical and moved, in a colour.
fn put(builder: &mut Builder, part: &Builder, colour: u32, turn: f32, foot: Vec3) {
    let (mut part, turn) = (part.clone(), Quat::from_rotation_y(turn));
    part.repaint(colour);
    builder.place(&part, |p| turn * p + foot);
}

/// A part made by a function.
fn made(make: impl FnOnce(&mut Builder)) -> Builder {
    let mut part = Builder::new();
    make(&mut part);
    part
}

/// A box, ball, drum, cone or bottle, some `size` metres across and high.
fn thing(random: &mut Random, size: f32) -> Builder {
    let (wide, high) = (size * random.between(0.6, 1.2), size * random.between(0.5, 1.6));
    let profile = |points: &[(f32, f32)]| {
        let points: Vec<Vec2> = points.iter().map(|&(r, y)| Vec2::new(r * wide * 0.5, y * high)).collect();
        made(|part| turned(part, &points, 24))
    };
    match (random.unit() * 5.0) as u32 {
        0 => made(|part| part.block(Vec3::ZERO, Vec3::new(wide, high, size * 0.8))),
        1 => {
            let ring = |step: u32| {
                let angle = PI * step as f32 / 16.0;
                (angle.sin(), 0.5 - 0.5 * angle.cos())
            };
            profile(&(0..=16).map(ring).collect::<Vec<_>>())
        }
        2 => profile(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]),
        3 => profile(&[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]),
        _ => profile(&[(0.0, 0.0), (0.7, 0.0), (0.7, 0.6), (0.2, 0.75), (0.2, 1.0), (0.0, 1.0)]),
    }
}

fn colour(random: &mut Random) -> u32 {
    1 + (random.unit() * 5.0) as u32
}

fn turn(random: &mut Random) -> f32 {
    random.unit() * TAU
}

/// Things of 5 to 60 cm, some of them on others.
fn objects(builder: &mut Builder, random: &mut Random) {
    for _ in 0..18 {
        let size = 0.05 + 0.55 * random.unit().powi(2);
        let foot = Vec3::new(random.between(-1.6, 1.6), 0.0, random.between(-1.6, 1.6));
        let (colour, angle) = (colour(random), turn(random));
        let raised = random.unit() < 0.25;
        if raised {
            let slab = made(|part| part.block(Vec3::ZERO, Vec3::new(size * 2.0, size * 0.3, size * 1.6)));
            put(builder, &slab, 5, angle, foot);
        }
        let foot = if raised { foot + Vec3::Y * size * 0.3 } else { foot };
        put(builder, &thing(random, size), colour, angle, foot);
    }
}

/// A table with plates, cups and other things on it, and four chairs that stand more or less below it.
fn laid_table(builder: &mut Builder, random: &mut Random) {
    let (size, height) = (Vec2::new(random.between(1.2, 1.8), random.between(0.7, 1.0)), 0.74);
    put(builder, &made(|part| table(part, size, height)), 1, 0.0, Vec3::ZERO);
    for side in 0..4 {
        let angle = side as f32 * TAU / 4.0 + random.between(-0.2, 0.2);
        let away = if side % 2 == 0 { size.y } else { size.x } * 0.5 + random.between(-0.2, 0.35);
        let foot = Quat::from_rotation_y(angle) * Vec3::new(0.0, 0.0, away);
        put(builder, &made(|part| chair(part, 0.45, random)), 1, angle + PI, foot);
    }
    for _ in 0..10 {
        let place =
            Vec3::new(random.between(-0.42, 0.42) * size.x, height, random.between(-0.4, 0.4) * size.y);
        let part = match (random.unit() * 3.0) as u32 {
            0 => made(|part| cup(part, 0.04, 0.09)),
            1 => made(|part| cup(part, 0.12, 0.025)),
            _ => thing(random, 0.14),
        };
        put(builder, &part, colour(random), turn(random), place);
    }
}

/// A bookcase against a wall, with boxes on and before it.
fn shelves(builder: &mut Builder, random: &mut Random) {
    builder.quad([(-3.0, 0.0), (3.0, 0.0), (3.0, 2.7), (-3.0, 2.7)].map(|(x, y)| Vec3::new(x, y, -0.6)));
    let width = random.between(1.2, 2.2);
    let part = made(|part| bookcase(part, Vec3::new(width, 2.0, 0.32), 5, random));
    put(builder, &part, 1, 0.0, Vec3::new(0.0, 0.0, -0.6 + 0.32));
    for step in 0..4 {
        let size = random.between(0.2, 0.4);
        let foot = Vec3::new(
            random.between(-0.8, 0.8),
            if step % 2 == 0 { 2.0 } else { 0.0 },
            random.between(0.3, 0.9),
        );
        let foot = if step % 2 == 0 { Vec3::new(foot.x * width * 0.4, foot.y, -0.4) } else { foot };
        put(
            builder,
            &thing(random, size),
            colour(random),
            if step % 2 == 0 { 0.0 } else { turn(random) },
            foot,
        );
    }
}

/// Rows of chairs.
fn chairs(builder: &mut Builder, random: &mut Random) {
    for row in 0..3 {
        for column in 0..4 {
            let foot = Vec3::new(column as f32 * 0.62 - 0.93, 0.0, row as f32 * 0.85 - 0.85);
            let angle = random.between(-0.15, 0.15);
            put(builder, &made(|part| chair(part, 0.45, random)), 1 + (row % 3), angle, foot);
        }
    }
}

/// A flight of stairs with balusters, and things on its steps.
fn stairs(builder: &mut Builder, random: &mut Random) {
    let (steps, rise, going) = (9, random.between(0.15, 0.2), random.between(0.24, 0.3));
    let closed = random.unit() < 0.5;
    put(
        builder,
        &made(|part| flight(part, steps, [rise, going, 1.2], closed)),
        1,
        0.0,
        Vec3::new(0.0, 0.0, 1.2),
    );
    for step in [1, 3, 6] {
        let foot =
            Vec3::new(random.between(-0.4, 0.4), rise * (step + 1) as f32, 1.2 - going * (step as f32 + 0.5));
        put(builder, &thing(random, 0.15), colour(random), 0.0, foot);
    }
}

/// Three plants in pots, one of them on a stool.
fn plants(builder: &mut Builder, random: &mut Random) {
    for (number, x) in [-0.9, 0.1, 0.95].into_iter().enumerate() {
        let mut foot = Vec3::new(x, 0.0, random.between(-0.5, 0.5));
        if number == 1 {
            put(builder, &made(|part| table(part, Vec2::splat(0.4), 0.45)), 1, 0.3, foot);
            foot.y = 0.45;
        }
        put(builder, &made(|part| cup(part, 0.16, 0.24)), 2, 0.0, foot);
        let leaves = 40 + (random.unit() * 120.0) as usize;
        let part = made(|part| plant(part, random.between(0.4, 1.1), leaves, random));
        put(builder, &part, 4, turn(random), foot + Vec3::Y * 0.2);
    }
}

/// Boxes piled up in the corner of two walls, with a skirting board and pipes.
fn corner(builder: &mut Builder, random: &mut Random) {
    let (far, high) = (1.2, 2.7);
    builder.quad([(-far, 0.0), (3.0, 0.0), (3.0, high), (-far, high)].map(|(x, y)| Vec3::new(x, y, -far)));
    builder.quad([(3.0, 0.0), (-far, 0.0), (-far, high), (3.0, high)].map(|(z, y)| Vec3::new(-far, y, z)));
    builder.cuboid(Vec3::new(-far, 0.0, -far), Vec3::new(3.0, 0.1, -far + 0.015));
    builder.cuboid(Vec3::new(-far, 0.0, -far + 0.015), Vec3::new(-far + 0.015, 0.1, 3.0));
    let mut top = 0.0;
    for _ in 0..4 {
        let size = Vec3::new(random.between(0.3, 0.8), random.between(0.15, 0.4), random.between(0.3, 0.7));
        let gap = if random.unit() < 0.5 { 0.0 } else { random.between(0.005, 0.08) };
        let foot = Vec3::new(-far + 0.015 + gap + size.x * 0.5, top, -far + 0.015 + gap + size.z * 0.5);
        put(builder, &made(|part| part.block(Vec3::ZERO, size)), colour(random), 0.0, foot);
        top += size.y;
    }
    for _ in 0..4 {
        let foot = Vec3::new(random.between(-0.4, 1.2), 0.0, random.between(-0.4, 1.0));
        let size = random.between(0.2, 0.5);
        put(builder, &thing(random, size), colour(random), turn(random), foot);
    }
    for height in [0.4, 0.5] {
        let line = [Vec3::new(-far, height, -far + 0.05), Vec3::new(3.0, height, -far + 0.05)];
        builder.paint(5);
        rod(builder, line, 0.018, 12);
    }
}

/// Posts with sagging cables, a fence of wire, and cords that hang down.
fn wires(builder: &mut Builder, random: &mut Random) {
    builder.paint(5);
    let posts: Vec<Vec3> =
        (0..3).map(|post| Vec3::new(post as f32 * 1.6 - 1.6, 0.0, random.between(-0.9, 0.1))).collect();
    for &post in &posts {
        rod(builder, [post, post + Vec3::Y * 1.9], 0.04, 12);
        bar(
            builder,
            [post + Vec3::new(-0.01, 1.8, -0.4), post + Vec3::new(-0.01, 1.8, 0.4)],
            Vec3::X,
            [0.05, 0.05],
        );
    }
    let thick = random.between(0.003, 0.012);
    for pair in posts.windows(2) {
        for across in [-0.35, -0.1, 0.1, 0.35] {
            let sag = random.between(0.05, 0.3);
            let point = |step: u32| {
                let t = step as f32 / 16.0;
                let line = pair[0].lerp(pair[1], t) + Vec3::new(0.0, 1.85, across);
                (line - Vec3::Y * (4.0 * sag * t * (1.0 - t)), thick)
            };
            tube(builder, &(0..=16).map(point).collect::<Vec<_>>(), 6);
        }
    }
    let (low, count) = (Vec3::new(-1.5, 0.0, 1.0), 24);
    for wire in 0..=count {
        let x = 3.0 * wire as f32 / count as f32;
        rod(builder, [low + Vec3::X * x, low + Vec3::new(x, 0.6, 0.0)], thick * 0.6, 6);
    }
    for height in [0.05, 0.3, 0.55] {
        rod(builder, [low + Vec3::Y * height, low + Vec3::new(3.0, height, 0.0)], thick * 0.6, 6);
    }
    for _ in 0..5 {
        let foot = Vec3::new(random.between(-1.4, 1.4), 0.0, random.between(-0.5, 0.8));
        let size = random.between(0.1, 0.3);
        put(builder, &thing(random, size), colour(random), turn(random), foot);
    }
}

/// Long table with screens and chairs pushed below it, cupboards, and a ceiling with a frame about the
/// light's position.
fn conference(builder: &mut Builder, random: &mut Random) {
    let size = Vec2::new(3.2, 1.1);
    put(builder, &made(|part| table(part, size, 0.74)), 1, 0.0, Vec3::ZERO);
    for side in [-1.0f32, 1.0] {
        for column in 0..4 {
            let foot =
                Vec3::new(column as f32 * 0.75 - 1.1, 0.0, side * (0.45 + random.between(-0.15, 0.25)));
            let angle = if side > 0.0 { PI } else { 0.0 } + random.between(-0.1, 0.1);
            put(builder, &made(|part| chair(part, 0.46, random)), 3, angle, foot);
        }
    }
    for column in 0..3 {
        let foot = Vec3::new(column as f32 * 1.0 - 1.0, 0.74, random.between(-0.2, 0.2));
        let screen = made(|part| {
            part.block(Vec3::ZERO, Vec3::new(0.24, 0.012, 0.18));
            part.block(Vec3::Y * 0.012, Vec3::new(0.03, 0.15, 0.03));
            part.block(Vec3::new(0.0, 0.13, 0.02), Vec3::new(0.56, 0.34, 0.025));
        });
        put(builder, &screen, 5, random.between(-0.4, 0.4), foot);
    }
    for column in 0..5 {
        let low = Vec3::new(column as f32 * 0.8 - 2.0, 0.0, -2.6);
        let part = made(|part| part.cuboid(Vec3::ZERO, Vec3::new(0.79, random.between(0.7, 2.1), 0.45)));
        put(builder, &part, 5, 0.0, low);
    }
    // A square opening in the ceiling's middle, a hand deep.
    let (inner, outer, high) = (0.62, 3.0, 2.7);
    for turn in 0..4 {
        let quarter = Quat::from_rotation_y(turn as f32 * TAU / 4.0);
        let face = |corners: [(f32, f32, f32); 4]| corners.map(|(x, y, z)| quarter * Vec3::new(x, y, z));
        builder.paint(0);
        builder.quad(face([
            (-outer, high, -outer),
            (outer, high, -outer),
            (inner, high, -inner),
            (-inner, high, -inner),
        ]));
        builder.quad(face([
            (-inner, high, -inner),
            (inner, high, -inner),
            (inner, high + 0.1, -inner),
            (-inner, high + 0.1, -inner),
        ]));
    }
}
