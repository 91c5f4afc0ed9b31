//! A living room before a screen on its left wall: sofa, armchair, low table, bookcase, plant and lamp; open towards the camera.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Quat, Vec2, Vec3};
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::bars::rod;
use super::builder::Builder;
use super::columns::{Detail, pot};
use super::furniture::{bookcase, cup, plant, table};
use super::parameters::Parameters;
use super::random::Random;
use super::shapes::turned;

const WALL: u32 = 0;
const WOOD: u32 = 1;
/// Colours 2 to 5 are those of the books.
const RED: u32 = 2;
const BLUE: u32 = 3;
const LEAF: u32 = 4;
const CREAM: u32 = 5;
const OAK: u32 = 6;
const PLANK: u32 = 7;
const BLACK: u32 = 8;
const CLOTH: u32 = 9;
const RUG: u32 = 10;
const CLAY: u32 = 11;
const PALETTE: [[f32; 3]; 12] = [
    [0.74, 0.71, 0.66],
    [0.34, 0.21, 0.12],
    [0.58, 0.15, 0.11],
    [0.16, 0.27, 0.47],
    [0.20, 0.42, 0.15],
    [0.80, 0.75, 0.64],
    [0.50, 0.34, 0.20],
    [0.44, 0.29, 0.17],
    [0.05, 0.05, 0.06],
    [0.42, 0.46, 0.48],
    [0.56, 0.44, 0.36],
    [0.62, 0.36, 0.24],
];

/// Half the room's length along x and along z, and its height, metres.
const HALF: Vec2 = Vec2::new(3.0, 2.5);
const HIGH: f32 = 2.6;

/// The room, 6 × 5 × 2.6 m around the origin; the screen's place is 1.6 × 0.9 m on the wall at negative x.
pub(super) fn living_room(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let seed = parameters.count("seed", 1, 0..=u32::MAX)?;
    parameters.finish()?;
    let mut builder = Builder::new();
    shell(&mut builder);
    screen(&mut builder);
    seats(&mut builder);
    low_table(&mut builder);
    along_the_walls(&mut builder, &mut Random::new(seed, 0));
    Ok(builder.finish(&PALETTE))
}

/// Adds a part, turned about the vertical and moved.
fn put(builder: &mut Builder, part: &Builder, turn: f32, foot: Vec3) {
    let turn = Quat::from_rotation_y(turn);
    builder.place(part, |p| turn * p + foot);
}

/// A part of one colour, made by a function that may change the colour.
fn made(colour: u32, make: impl FnOnce(&mut Builder)) -> Builder {
    let mut part = Builder::new();
    part.paint(colour);
    make(&mut part);
    part
}

/// Floor of planks, three walls with skirting boards, a ceiling with a cornice, and a rug.
fn shell(builder: &mut Builder) {
    let planks = 25;
    let width = 2.0 * HALF.y / planks as f32;
    for plank in 0..planks {
        builder.paint(if plank % 3 == 1 { OAK } else { PLANK });
        let near = HALF.y - plank as f32 * width;
        let corner = |x: f32, z: f32| Vec3::new(x * HALF.x, 0.0, z);
        builder.quad([
            corner(-1.0, near),
            corner(1.0, near),
            corner(1.0, near - width),
            corner(-1.0, near - width),
        ]);
    }
    builder.paint(WALL);
    let at = |x: f32, y: f32, z: f32| Vec3::new(x * HALF.x, y * HIGH, z * HALF.y);
    builder.quad([at(-1.0, 0.0, -1.0), at(1.0, 0.0, -1.0), at(1.0, 1.0, -1.0), at(-1.0, 1.0, -1.0)]);
    builder.quad([at(-1.0, 0.0, 1.0), at(-1.0, 0.0, -1.0), at(-1.0, 1.0, -1.0), at(-1.0, 1.0, 1.0)]);
    builder.quad([at(1.0, 0.0, -1.0), at(1.0, 0.0, 1.0), at(1.0, 1.0, 1.0), at(1.0, 1.0, -1.0)]);
    builder.quad([at(-1.0, 1.0, -1.0), at(1.0, 1.0, -1.0), at(1.0, 1.0, 1.0), at(-1.0, 1.0, 1.0)]);
    builder.paint(CREAM);
    for (low, high, depth) in [(-0.01, 0.11, 0.02), (HIGH - 0.07, HIGH + 0.01, 0.05)] {
        let (x, z) = (HALF.x + 0.01, HALF.y + 0.01);
        builder.cuboid(Vec3::new(-x, low, -z), Vec3::new(x, high, depth - HALF.y));
        builder.cuboid(Vec3::new(-x, low, depth - HALF.y), Vec3::new(depth - HALF.x, high, HALF.y));
        builder.cuboid(Vec3::new(HALF.x - depth, low, depth - HALF.y), Vec3::new(x, high, HALF.y));
    }
    builder.paint(RUG);
    builder.cuboid(Vec3::new(-1.35, -0.01, -1.25), Vec3::new(0.75, 0.012, 1.25));
    builder.paint(RED);
    for z in [-1.05, 0.95] {
        builder.cuboid(Vec3::new(-1.3, -0.01, z), Vec3::new(0.7, 0.014, z + 0.1));
    }
}

/// Frame of the screen, the sideboard below it with things on it, and a loudspeaker on either side.
fn screen(builder: &mut Builder) {
    let wall = -HALF.x;
    builder.paint(BLACK);
    builder.cuboid(Vec3::new(wall + 0.005, 0.80, -0.84), Vec3::new(wall + 0.055, 1.78, 0.84));
    builder.paint(WOOD);
    builder.cuboid(Vec3::new(wall + 0.02, 0.10, -1.0), Vec3::new(wall + 0.44, 0.50, 1.0));
    for (x, z) in [(0.06, -0.95), (0.06, 0.95), (0.40, -0.95), (0.40, 0.95)] {
        builder.block(Vec3::new(wall + x, -0.01, z), Vec3::new(0.05, 0.12, 0.05));
    }
    builder.paint(OAK);
    for z in [-0.66, 0.0, 0.66] {
        builder.cuboid(Vec3::new(wall + 0.43, 0.13, z - 0.31), Vec3::new(wall + 0.455, 0.47, z + 0.31));
        rod(builder, [Vec3::new(wall + 0.45, 0.36, z), Vec3::new(wall + 0.49, 0.36, z)], 0.015, 12);
    }
    for z in [-1.3, 1.3] {
        builder.paint(BLACK);
        builder.block(Vec3::new(wall + 0.24, -0.01, z), Vec3::new(0.28, 0.96, 0.22));
        builder.paint(CLOTH);
        for (height, radius) in [(0.72, 0.08), (0.5, 0.08), (0.86, 0.03)] {
            let face = Vec3::new(wall + 0.37, height, z);
            rod(builder, [face, face + Vec3::X * 0.03], radius, 24);
        }
    }
    let vase = made(BLUE, |part| part.place(&pot(0.22, 22.0, Detail(1.0)), |p| p));
    let mut vase = vase;
    vase.repaint(BLUE);
    put(builder, &vase, 0.0, Vec3::new(wall + 0.25, 0.499, -0.78));
    let bowl = made(CLAY, |part| cup(part, 0.11, 0.07));
    put(builder, &bowl, 0.0, Vec3::new(wall + 0.27, 0.499, 0.72));
}

/// A box of this size with rounded sides, standing on y = 0: a superellipsoid.
fn cushion(builder: &mut Builder, size: Vec3) {
    let (rows, columns) = (12, 28);
    let power = |value: f32| value.signum() * value.abs().powf(0.35);
    builder.ring(rows, columns, |row, column| {
        let up = (row as f32 / rows as f32 - 0.5) * PI;
        let around = column as f32 / columns as f32 * TAU;
        // The poles are points.
        let wide = if row == 0 || row == rows { 0.0 } else { power(up.cos()) };
        let unit = Vec3::new(wide * power(around.cos()), 1.0 + power(up.sin()), -wide * power(around.sin()));
        unit * size * 0.5
    });
}

/// A seat for `places` people that looks along z.
fn sofa(builder: &mut Builder, places: usize, colour: u32) {
    let (place, deep) = (0.68, 0.92);
    let width = places as f32 * place;
    let soft = |builder: &mut Builder, foot: Vec3, size: Vec3| {
        put(builder, &made(colour, |part| cushion(part, size)), 0.0, foot);
    };
    builder.paint(colour);
    builder.block(Vec3::new(0.0, 0.1, 0.0), Vec3::new(width + 0.02, 0.16, deep - 0.06));
    for side in [-1.0, 1.0] {
        let arm = Vec3::new(side * (width * 0.5 + 0.1), 0.09, 0.0);
        soft(builder, arm, Vec3::new(0.22, 0.52, deep));
        builder.paint(WOOD);
        for z in [-0.36, 0.36] {
            builder.block(Vec3::new(side * (width * 0.5 + 0.08), -0.01, z), Vec3::new(0.06, 0.13, 0.06));
        }
    }
    soft(builder, Vec3::new(0.0, 0.09, -0.37), Vec3::new(width + 0.06, 0.76, 0.22));
    for seat in 0..places {
        let x = (seat as f32 + 0.5) * place - width * 0.5;
        soft(builder, Vec3::new(x, 0.24, 0.08), Vec3::new(place - 0.01, 0.2, 0.74));
        let back = made(colour, |part| cushion(part, Vec3::new(place - 0.03, 0.44, 0.17)));
        builder.place(&back, |p| Quat::from_rotation_x(-0.2) * p + Vec3::new(x, 0.40, -0.17));
    }
}

/// The sofa opposite the screen with pillows, and an armchair.
fn seats(builder: &mut Builder) {
    put(builder, &made(CLOTH, |part| sofa(part, 3, CLOTH)), -FRAC_PI_2, Vec3::new(1.75, 0.0, 0.0));
    for (colour, z, turn, lean) in [(RED, -0.78, 0.35, -0.5), (CREAM, 0.8, -0.3, -0.45)] {
        let pillow = made(colour, |part| cushion(part, Vec3::new(0.44, 0.42, 0.15)));
        let rotation = Quat::from_rotation_y(turn - FRAC_PI_2) * Quat::from_rotation_x(lean);
        builder.place(&pillow, |p| rotation * p + Vec3::new(1.6, 0.43, z));
    }
    put(builder, &made(RED, |part| sofa(part, 1, RED)), -0.55, Vec3::new(0.55, 0.0, -1.72));
}

/// The low table before the sofa, laid.
fn low_table(builder: &mut Builder) {
    let (foot, height) = (Vec3::new(-0.15, 0.0, 0.05), 0.42);
    put(builder, &made(OAK, |part| table(part, Vec2::new(0.72, 1.2), height)), 0.0, foot);
    let top = foot + Vec3::Y * (height - 0.001);
    for (x, z, colour) in [(0.2, -0.35, CREAM), (0.22, 0.3, BLUE)] {
        put(builder, &made(colour, |part| cup(part, 0.07, 0.015)), 0.0, top + Vec3::new(x, 0.0, z));
        put(builder, &made(colour, |part| cup(part, 0.042, 0.085)), 0.0, top + Vec3::new(x, 0.004, z));
    }
    put(builder, &made(CLAY, |part| cup(part, 0.15, 0.09)), 0.0, top + Vec3::new(-0.05, 0.0, 0.02));
    for (number, (x, z)) in [(-0.12, -0.09), (0.0, 0.1), (0.07, -0.03), (-0.08, 0.08)].into_iter().enumerate()
    {
        let fruit = made(if number % 2 == 0 { RED } else { LEAF }, |part| {
            let profile: Vec<Vec2> = (0..=12)
                .map(|step| {
                    let angle = PI * step as f32 / 12.0;
                    Vec2::new(0.04 * angle.sin(), 0.04 - 0.04 * angle.cos())
                })
                .collect();
            turned(part, &profile, 20);
        });
        put(builder, &fruit, 0.0, top + Vec3::new(x * 0.7 - 0.05, 0.035, z * 0.7 + 0.02));
    }
    for (number, colour) in [BLUE, CREAM, RED].into_iter().enumerate() {
        let book = made(colour, |part| part.block(Vec3::ZERO, Vec3::new(0.17, 0.024, 0.24)));
        let y = number as f32 * 0.0245;
        put(builder, &book, 0.25 - 0.3 * number as f32, top + Vec3::new(-0.17, y, 0.42));
    }
    let remote = made(BLACK, |part| part.block(Vec3::ZERO, Vec3::new(0.045, 0.018, 0.17)));
    put(builder, &remote, 0.5, top + Vec3::new(0.05, 0.0, -0.42));
}

/// Bookcase, pictures, plant, standing lamp and curtain.
fn along_the_walls(builder: &mut Builder, random: &mut Random) {
    let case = made(WOOD, |part| bookcase(part, Vec3::new(1.5, 2.0, 0.32), 5, random));
    put(builder, &case, 0.0, Vec3::new(-1.45, 0.004, -HALF.y + 0.185));
    for (x, y, size, colour) in [
        (0.45, 1.62, Vec2::new(0.9, 0.62), BLUE),
        (1.35, 1.74, Vec2::new(0.42, 0.52), RED),
        (1.35, 1.2, Vec2::new(0.42, 0.3), LEAF),
    ] {
        let wall = Vec3::new(x, y, -HALF.y);
        let half = (size * 0.5).extend(0.0);
        builder.paint(WOOD);
        builder.cuboid(wall - half + Vec3::Z * -0.005, wall + half + Vec3::Z * 0.03);
        builder.paint(CREAM);
        let mat = half - Vec3::new(0.03, 0.03, 0.0);
        builder.cuboid(wall - mat, wall + mat + Vec3::Z * 0.034);
        builder.paint(colour);
        let canvas = half - Vec3::new(0.09, 0.09, 0.0);
        builder.cuboid(wall - canvas, wall + canvas + Vec3::Z * 0.036);
    }
    let place = Vec3::new(2.45, 0.0, -1.95);
    let mut vessel = pot(0.42, 24.0, Detail(1.0));
    vessel.repaint(CLAY);
    put(builder, &vessel, 0.0, place + Vec3::Y * 0.002);
    put(builder, &made(LEAF, |part| plant(part, 1.25, 150, random)), 0.7, place + Vec3::Y * 0.36);

    let foot = Vec3::new(-2.5, 0.0, -1.95);
    let lamp = made(BLACK, |part| {
        let base = [(0.0, 0.002), (0.15, 0.002), (0.15, 0.02), (0.012, 0.035)];
        turned(part, &base.map(|(r, y)| Vec2::new(r, y)), 28);
        rod(part, [Vec3::Y * 0.03, Vec3::Y * 1.6], 0.011, 12);
        part.paint(CREAM);
        // Down inside and up outside again: a shell.
        let shade = [(0.155, 1.66), (0.225, 1.32), (0.23, 1.32), (0.16, 1.66), (0.155, 1.66)];
        turned(part, &shade.map(|(r, y)| Vec2::new(r, y)), 32);
    });
    put(builder, &lamp, 0.0, foot);

    builder.paint(BLUE);
    for (near, far) in [(2.3, 1.25), (-0.35, -1.2)] {
        let folds = 9.0;
        let fold = |column: usize| (column as f32 / 72.0 * folds * TAU).sin();
        // A cloth 1 cm thick, whose front faces the room.
        builder.sheet(1, 72, |row, column| {
            let z = near + (far - near) * (1.0 - column as f32 / 72.0);
            Vec3::new(HALF.x - 0.09 + 0.035 * fold(column), [0.03, 2.35][row], z)
        });
        rod(
            builder,
            [Vec3::new(HALF.x - 0.09, 2.37, near + 0.08), Vec3::new(HALF.x - 0.09, 2.37, far - 0.08)],
            0.014,
            12,
        );
    }
    builder.paint(CREAM);
    builder.cuboid(Vec3::new(HALF.x - 0.02, 0.85, -0.3), Vec3::new(HALF.x + 0.01, 2.2, 1.2));
    builder.paint(BLACK);
    builder.cuboid(Vec3::new(HALF.x - 0.022, 0.92, -0.23), Vec3::new(HALF.x, 2.13, 1.13));
    builder.paint(CREAM);
    builder.cuboid(Vec3::new(HALF.x - 0.03, 0.9, 0.42), Vec3::new(HALF.x, 2.15, 0.48));
}
