//! A gallery with a polished floor: sculptures on pedestals, niches, pictures and a bench below pendant lamps.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec2, Vec3};
use halflight_core::scene::Mesh;
use halflight_core::specular::Specular;

use super::GenerateError;
use super::bars::rod;
use super::builder::Builder;
use super::columns::{Detail, column, pot};
use super::parameters::Parameters;
use super::shapes::{Behind, Opening, hood, pierced_wall, tube, turned};

const PLASTER: u32 = 0;
const STONE: u32 = 1;
const LIGHT_TILE: u32 = 2;
const DARK_TILE: u32 = 3;
const WOOD: u32 = 4;
const BRONZE: u32 = 5;
const MARBLE: u32 = 6;
const RED: u32 = 7;
const BLUE: u32 = 8;
const GOLD: u32 = 9;
const BLACK: u32 = 10;
const NICHE: u32 = 11;
const PALETTE: [[f32; 3]; 12] = [
    [0.72, 0.69, 0.63],
    [0.58, 0.54, 0.48],
    [0.58, 0.55, 0.50],
    [0.13, 0.12, 0.12],
    [0.34, 0.20, 0.11],
    [0.72, 0.49, 0.30],
    [0.78, 0.77, 0.74],
    [0.58, 0.12, 0.09],
    [0.12, 0.22, 0.46],
    [0.83, 0.66, 0.33],
    [0.04, 0.04, 0.04],
    [0.46, 0.30, 0.24],
];

/// Half the hall's length along x and along z, and its height, metres.
const HALF: Vec2 = Vec2::new(7.0, 3.0);
const HIGH: f32 = 4.4;

/// Places of the pendant lamps along x, and the height of their disks.
const LAMPS: [f32; 4] = [-4.5, -1.5, 1.5, 4.5];
const LAMP: f32 = 3.2;

/// Niches of the long wall, and its bays.
const BAY: f32 = 2.8;

/// The gallery, 14 × 6 × 4.4 m around the origin. Lamps of 0.35 m radius belong at a height of 3.2 m on z = 0, at x = ±1.5 and ±4.5.
pub(super) fn gallery(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    parameters.finish()?;
    let mut builder = Builder::new();
    floor(&mut builder);
    walls(&mut builder);
    ceiling(&mut builder);
    sculptures(&mut builder);
    furniture(&mut builder);
    let mut mesh = builder.finish(&PALETTE);
    let polished = |roughness: f32, metallic: f32, reflectance: f32| {
        Some(Specular { roughness, metallic, reflectance: Vec3::splat(reflectance) })
    };
    for (material, specular) in [
        (LIGHT_TILE, polished(0.25, 0.0, 0.06)),
        (DARK_TILE, polished(0.25, 0.0, 0.06)),
        (BRONZE, polished(0.35, 1.0, 0.04)),
        (GOLD, polished(0.45, 1.0, 0.04)),
        (MARBLE, polished(0.3, 0.0, 0.05)),
    ] {
        mesh.materials[material as usize].specular = specular;
    }
    Ok(mesh)
}

/// Chequered tiles of half a metre.
fn floor(builder: &mut Builder) {
    let tile = 0.5;
    let [columns, rows] = [(2.0 * HALF.x / tile) as i32, (2.0 * HALF.y / tile) as i32];
    for row in 0..rows {
        for column in 0..columns {
            builder.paint(if (row + column) % 2 == 0 { LIGHT_TILE } else { DARK_TILE });
            let corner = |right: i32, far: i32| {
                Vec3::new((column + right) as f32 * tile - HALF.x, 0.0, HALF.y - (row + far) as f32 * tile)
            };
            builder.quad([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
        }
    }
}

/// Long walls, one with arched niches between half columns, and the ends of the hall.
fn walls(builder: &mut Builder) {
    let detail = Detail(1.0);
    let niche = Opening { half: 0.62, sill: 0.75, spring: 2.1, rise: 0.62 };
    for bay in -2..=2 {
        let mut field = Builder::new();
        field.paint(PLASTER);
        pierced_wall(&mut field, BAY / 2.0, [0.0, HIGH], niche, (0.55, Behind::Material(NICHE)), 10);
        field.paint(STONE);
        hood(&mut field, niche, 10);
        field.block(Vec3::new(0.0, niche.sill - 0.08, 0.0), Vec3::new(2.0 * niche.half + 0.2, 0.08, 0.16));
        builder.place(&field, |p| p + Vec3::new(bay as f32 * BAY, 0.0, -HALF.y));
    }
    let mut pillar = column(0.16, 3.9, 20.0, detail);
    pillar.repaint(STONE);
    for bay in 0..6 {
        let x = (bay as f32 - 2.5) * BAY;
        builder.place(&pillar, |p| p + Vec3::new(x, -0.002, -HALF.y + 0.12));
    }
    builder.paint(PLASTER);
    let at = |x: f32, y: f32, z: f32| Vec3::new(x * HALF.x, y * HIGH, z * HALF.y);
    builder.quad([at(-1.0, 0.0, 1.0), at(-1.0, 0.0, -1.0), at(-1.0, 1.0, -1.0), at(-1.0, 1.0, 1.0)]);
    builder.quad([at(1.0, 0.0, -1.0), at(1.0, 0.0, 1.0), at(1.0, 1.0, 1.0), at(1.0, 1.0, -1.0)]);
    builder.quad([at(1.0, 0.0, 1.0), at(-1.0, 0.0, 1.0), at(-1.0, 1.0, 1.0), at(1.0, 1.0, 1.0)]);
    // Skirting boards and an entablature; the columns carry it.
    for (low, high, depth, colour) in [(-0.01, 0.16, 0.03, WOOD), (3.88, 4.12, 0.42, STONE)] {
        builder.paint(colour);
        let back = Vec3::new(-HALF.x, low, -HALF.y - 0.01);
        builder.cuboid(back, Vec3::new(HALF.x, high, depth - HALF.y));
        let right = Vec3::new(HALF.x - depth, low, depth - HALF.y);
        builder.cuboid(right, Vec3::new(HALF.x + 0.01, high, HALF.y));
    }
    pictures(builder);
}

/// Framed pictures at the far end and on the wall of the camera.
fn pictures(builder: &mut Builder) {
    let turns = [Quat::from_rotation_y(-PI / 2.0), Quat::from_rotation_y(PI)];
    for (turn, middle, size, colours) in [
        (turns[0], Vec3::new(HALF.x, 1.9, -1.2), Vec2::new(1.5, 1.1), [BLUE, RED]),
        (turns[0], Vec3::new(HALF.x, 1.9, 1.0), Vec2::new(1.1, 1.5), [RED, GOLD]),
        (turns[1], Vec3::new(3.5, 1.9, HALF.y), Vec2::new(1.9, 1.2), [BLUE, NICHE]),
        (turns[1], Vec3::new(0.0, 1.9, HALF.y), Vec2::new(1.3, 1.3), [NICHE, BLUE]),
    ] {
        let half = (size * 0.5).extend(0.0);
        let mut part = Builder::new();
        part.paint(GOLD);
        for (low, high) in [
            (Vec3::new(-half.x, half.y - 0.07, -0.01), Vec3::new(half.x, half.y, 0.06)),
            (Vec3::new(-half.x, -half.y, -0.01), Vec3::new(half.x, 0.07 - half.y, 0.06)),
            (Vec3::new(-half.x, 0.07 - half.y, -0.01), Vec3::new(0.07 - half.x, half.y - 0.07, 0.06)),
            (Vec3::new(half.x - 0.07, 0.07 - half.y, -0.01), Vec3::new(half.x, half.y - 0.07, 0.06)),
        ] {
            part.cuboid(low, high);
        }
        part.paint(MARBLE);
        let canvas = half - Vec3::new(0.06, 0.06, 0.0);
        part.cuboid(-canvas - Vec3::Z * 0.01, canvas + Vec3::Z * 0.02);
        for (number, colour) in colours.into_iter().enumerate() {
            part.paint(colour);
            let shift = (number as f32 - 0.5) * 0.42;
            let block = Vec3::new(canvas.x * 0.42, canvas.y * (0.75 - 0.3 * number as f32), 0.0);
            let place = Vec3::new(shift * size.x, shift * size.y * 0.35, 0.0);
            part.cuboid(place - block, place + block + Vec3::Z * 0.022);
        }
        builder.place(&part, |p| turn * p + middle);
    }
}

/// Ceiling with beams, and the pendant lamps' shades.
fn ceiling(builder: &mut Builder) {
    builder.paint(PLASTER);
    let at = |x: f32, z: f32| Vec3::new(x * HALF.x, HIGH, z * HALF.y);
    builder.quad([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]);
    builder.paint(WOOD);
    for beam in -4..=4 {
        let x = beam as f32 * 1.5 + 0.75;
        if x < HALF.x {
            builder.cuboid(Vec3::new(x - 0.09, 4.12, -HALF.y), Vec3::new(x + 0.09, HIGH + 0.01, HALF.y));
        }
    }
    let mut lamp = Builder::new();
    lamp.paint(BLACK);
    // A shell that is open below; its rim lies beside the square around the disk.
    let shade = [(0.515, 0.0), (0.50, 0.08), (0.36, 0.22), (0.10, 0.30), (0.05, 0.42), (0.0, 0.42)];
    turned(&mut lamp, &shade.map(|(r, y)| Vec2::new(r, y)), 40);
    let inside = [(0.0, 0.27), (0.09, 0.27), (0.34, 0.2), (0.495, 0.07), (0.51, 0.0)];
    turned(&mut lamp, &inside.map(|(r, y)| Vec2::new(r, y)), 40);
    rod(&mut lamp, [Vec3::Y * 0.4, Vec3::Y * (HIGH - LAMP + 0.01)], 0.012, 10);
    for x in LAMPS {
        builder.place(&lamp, |p| p + Vec3::new(x, LAMP, 0.0));
    }
}

/// A knot of a round bar, `size` metres across, around the origin.
fn knot(builder: &mut Builder, size: f32) {
    let (rows, sides) = (132, 18);
    let scale = size / 6.0;
    let path = |row: usize| {
        let t = (row % rows) as f32 / rows as f32 * TAU;
        let out = 2.0 + (3.0 * t).cos();
        Vec3::new(out * (2.0 * t).cos(), out * (2.0 * t).sin(), (3.0 * t).sin()) * scale
    };
    builder.ring(rows, sides, |row, column| {
        let along = (path(row + 1) - path(row + rows - 1)).normalize_or(Vec3::X);
        let across = along.cross(Vec3::Z).normalize_or(Vec3::Y);
        let (sin, cos) = (column as f32 / sides as f32 * TAU).sin_cos();
        path(row) + (across * cos + along.cross(across) * sin) * (0.52 * scale)
    });
}

/// A square bar that turns about itself on its way up and tapers.
fn twist(builder: &mut Builder, width: f32, height: f32) {
    let rows = 48;
    for side in 0..4 {
        builder.sheet(rows, 4, |row, column| {
            let t = row as f32 / rows as f32;
            let turn = Quat::from_rotation_y(t * PI + side as f32 * PI / 2.0);
            let half = width * 0.5 * (1.0 - 0.45 * t);
            turn * Vec3::new((column as f32 / 2.0 - 1.0) * half, t * height, half)
        });
    }
    let half = width * 0.5 * 0.55;
    builder.quad(
        [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
            .map(|(x, z)| Vec3::new(x * half, height, z * half)),
    );
}

/// A ball that stands on y = 0.
fn ball(builder: &mut Builder, radius: f32) {
    let profile: Vec<Vec2> = (0..=24)
        .map(|step| {
            let angle = PI * step as f32 / 24.0;
            Vec2::new(angle.sin(), 1.0 - angle.cos()) * radius
        })
        .collect();
    turned(builder, &profile, 40);
}

/// Pedestals with sculptures in the hall, vessels and balls in the niches.
fn sculptures(builder: &mut Builder) {
    let detail = Detail(1.3);
    let stand = |builder: &mut Builder, foot: Vec3, width: f32, height: f32| {
        builder.paint(STONE);
        builder.block(foot - Vec3::Y * 0.01, Vec3::new(width + 0.14, 0.11, width + 0.14));
        builder.block(foot + Vec3::Y * 0.09, Vec3::new(width, height - 0.15, width));
        builder.block(foot + Vec3::Y * (height - 0.07), Vec3::new(width + 0.1, 0.07, width + 0.1));
    };
    let put = |builder: &mut Builder, colour: u32, part: &Builder, turn: Quat, foot: Vec3| {
        let mut part = part.clone();
        part.repaint(colour);
        builder.place(&part, |p| turn * p + foot);
    };
    let part = |make: &dyn Fn(&mut Builder)| {
        let mut part = Builder::new();
        make(&mut part);
        part
    };
    let (knot, twist) = (part(&|part| knot(part, 1.0)), part(&|part| twist(part, 0.42, 1.35)));
    let ball = |radius: f32| part(&move |part| ball(part, radius));
    stand(builder, Vec3::new(-2.6, 0.0, -0.9), 0.6, 0.9);
    put(builder, BRONZE, &knot, Quat::from_rotation_y(0.7), Vec3::new(-2.6, 1.44, -0.9));
    stand(builder, Vec3::new(0.6, 0.0, 0.9), 0.56, 0.55);
    put(builder, MARBLE, &twist, Quat::IDENTITY, Vec3::new(0.6, 0.545, 0.9));
    stand(builder, Vec3::new(2.6, 0.0, -1.0), 0.7, 0.7);
    for (radius, x, y, z, colour) in
        [(0.27, 0.0, 0.699, 0.0, BRONZE), (0.18, 0.02, 1.232, 0.02, MARBLE), (0.1, 0.0, 1.588, 0.01, GOLD)]
    {
        put(builder, colour, &ball(radius), Quat::IDENTITY, Vec3::new(2.6 + x, y, z - 1.0));
    }
    let vessel = pot(0.7, 26.0, detail);
    for bay in -2..=2 {
        let foot = Vec3::new(bay as f32 * BAY, 0.745, -HALF.y - 0.27);
        match bay {
            -2 | 1 => put(builder, [RED, BLUE][usize::from(bay > 0)], &vessel, Quat::IDENTITY, foot),
            -1 | 2 => put(builder, MARBLE, &ball(0.24), Quat::IDENTITY, foot),
            _ => {
                let small = Quat::from_rotation_y(0.6);
                put(builder, GOLD, &twist, small, foot);
            }
        }
    }
}

/// A bench, and ropes between posts before the knot.
fn furniture(builder: &mut Builder) {
    builder.paint(WOOD);
    for slat in 0..5 {
        let z = 0.35 + slat as f32 * 0.11;
        builder.block(Vec3::new(-1.9, 0.42, z), Vec3::new(1.5, 0.035, 0.09));
    }
    builder.paint(BLACK);
    for x in [-2.5, -1.3] {
        builder.block(Vec3::new(x, 0.385, 0.57), Vec3::new(0.06, 0.036, 0.5));
        for z in [0.36, 0.78] {
            builder.block(Vec3::new(x, -0.01, z), Vec3::new(0.05, 0.4, 0.05));
        }
    }
    let posts = [(-3.4, -1.7), (-3.4, -0.1), (-1.8, -0.1), (-1.8, -1.7)].map(|(x, z)| Vec3::new(x, 0.0, z));
    builder.paint(GOLD);
    for post in posts {
        let profile = [
            (0.0, 0.001),
            (0.13, 0.001),
            (0.13, 0.02),
            (0.025, 0.05),
            (0.02, 0.86),
            (0.045, 0.9),
            (0.03, 0.95),
            (0.0, 0.96),
        ];
        let mut part = Builder::new();
        part.paint(GOLD);
        turned(&mut part, &profile.map(|(r, y)| Vec2::new(r, y)), 24);
        builder.place(&part, |p| p + post);
    }
    builder.paint(RED);
    for pair in posts.windows(2) {
        let point = |step: u32| {
            let t = step as f32 / 20.0;
            (pair[0].lerp(pair[1], t) + Vec3::Y * (0.84 - 1.1 * t * (1.0 - t)), 0.018)
        };
        tube(builder, &(0..=20).map(point).collect::<Vec<_>>(), 10);
    }
}
