//! A village church from outside: nave, chancel and porch under tiled roofs, a tower with a spire, graves and
//! a fence.
//!
//! The church stands along x with its tower at -x and its porch at +z.

use std::f32::consts::{FRAC_PI_8, TAU};

use glam::{Vec2, Vec3};
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::churchyard::{IRON, PAVING, STONE, WOOD, churchyard};
use super::columns::{Detail, column};
use super::parameters::Parameters;
use super::roofs::{gable, tiles};
use super::shapes::{Behind, Opening, hood, mullion, pierced_wall, quarter, rectangle, swept, turned};

pub(super) const GRASS: u32 = 0;
const GLASS: u32 = 5;
const DRESSED: u32 = 6;
const TILES: [u32; 3] = [7, 8, 9];
const SLATES: [u32; 3] = [10, 11, 11];
const PALETTE: [[f32; 3]; 12] = [
    [0.44, 0.50, 0.30],
    [0.62, 0.57, 0.48],
    [0.10, 0.10, 0.11],
    [0.30, 0.19, 0.11],
    [0.58, 0.55, 0.50],
    [0.13, 0.18, 0.26],
    [0.74, 0.70, 0.62],
    [0.56, 0.25, 0.16],
    [0.48, 0.20, 0.13],
    [0.62, 0.31, 0.20],
    [0.30, 0.33, 0.37],
    [0.24, 0.27, 0.31],
];

/// Depth of walls below the ground.
const BELOW: f32 = -0.1;
/// Nave: ends, half width, eaves, ridge, and the bays between its buttresses.
const NAVE: [f32; 2] = [-8.0, 8.0];
const NAVE_HALF: f32 = 4.6;
const NAVE_EAVES: f32 = 6.2;
const NAVE_RIDGE: f32 = 11.2;
const BAYS: usize = 5;
/// Chancel, likewise.
const CHANCEL: [f32; 2] = [8.0, 13.4];
const CHANCEL_HALF: f32 = 3.3;
const CHANCEL_EAVES: f32 = 4.8;
const CHANCEL_RIDGE: f32 = 8.4;
/// Tower: its middle, half width, and the heights of its storeys.
const TOWER: f32 = -10.6;
const TOWER_HALF: f32 = 2.7;
const STOREYS: [f32; 4] = [BELOW, 6.0, 10.6, 15.6];
const SPIRE: f32 = 28.0;
/// Porch: its middle and half width, how far it comes out, eaves and ridge.
const PORCH: f32 = -3.2;
const PORCH_HALF: f32 = 1.7;
const PORCH_FRONT: f32 = 8.0;
const PORCH_EAVES: f32 = 3.0;
const PORCH_RIDGE: f32 = 5.0;

pub(super) fn church(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let detail = Detail(parameters.number("detail", 1.0, 0.25..=4.0)?);
    parameters.finish()?;
    let mut builder = Builder::new();
    builder.paint(GRASS);
    builder.floor(100.0, 16);
    nave(&mut builder, detail);
    chancel(&mut builder, detail);
    tower(&mut builder, detail);
    spire(&mut builder, detail);
    porch(&mut builder, detail);
    churchyard(&mut builder, detail, PORCH);
    Ok(builder.finish(&PALETTE))
}

/// Side of a tile.
fn tile(detail: Detail) -> f32 {
    0.1667 / detail.0
}

/// Bay of wall with a filled opening; its front is at z = 0.
fn bay(half: f32, bounds: [f32; 2], opening: Opening, fill: u32, detail: Detail) -> Builder {
    let steps = detail.steps(8.0);
    let mut bay = Builder::new();
    bay.paint(STONE);
    pierced_wall(&mut bay, half, bounds, opening, (0.35, Behind::Material(fill)), steps);
    bay.paint(DRESSED);
    hood(&mut bay, opening, steps);
    if fill == GLASS {
        mullion(&mut bay, opening, -0.28);
        let sill = Vec3::new(0.0, opening.sill - 0.16, 0.0);
        bay.block(sill, Vec3::new(2.0 * opening.half + 0.4, 0.16, 0.24));
    }
    bay
}

/// A stepped buttress with two weatherings, against a wall at z = 0.
fn buttress(height: f32) -> Builder {
    let mut buttress = Builder::new();
    for (material, low, high, out) in [
        (STONE, BELOW, 0.5, 1.25),
        (STONE, BELOW, 0.52 * height, 1.1),
        (DRESSED, 0.52 * height, 0.52 * height + 0.5, 1.1),
        (STONE, BELOW, 0.86 * height, 0.65),
        (DRESSED, 0.86 * height, 0.86 * height + 0.5, 0.65),
    ] {
        buttress.paint(material);
        let half = if high < 1.0 { 0.42 } else { 0.33 };
        let slope = if material == DRESSED { out - 0.06 } else { 0.0 };
        let over = if material == DRESSED { 0.05 } else { 0.0 };
        buttress.hexahedron(|i| {
            let x = if i & 1 == 1 { half + over } else { -half - over };
            let top = i >> 1 & 1 == 1;
            let z = if i >> 2 & 1 == 0 {
                -0.1
            } else if top {
                out + over - slope
            } else {
                out + over
            };
            Vec3::new(x, if top { high } else { low }, z)
        });
    }
    buttress
}

/// Walls with windows along both sides between `ends`, buttresses, a base course and a tiled gable roof.
fn hall(
    builder: &mut Builder,
    ends: [f32; 2],
    half: f32,
    [eaves, ridge]: [f32; 2],
    bays: usize,
    window: Opening,
    detail: Detail,
) {
    let length = (ends[1] - ends[0]) / bays as f32;
    let part = bay(length / 2.0, [BELOW, eaves], window, GLASS, detail);
    let support = buttress(eaves);
    for turn in [0, 2] {
        for index in 0..bays {
            let x = ends[0] + (index as f32 + 0.5) * length;
            builder.place(&part, |p| quarter(turn, p + Vec3::Z * half) + Vec3::X * x);
        }
        for index in 0..=bays {
            let x = (ends[0] + index as f32 * length).clamp(ends[0] + 0.35, ends[1] - 0.35);
            builder.place(&support, |p| quarter(turn, p + Vec3::Z * half) + Vec3::X * x);
        }
        let line = |y: f32| [ends[0], ends[1]].map(|x| quarter(turn, Vec3::Z * half) + Vec3::new(x, y, 0.0));
        builder.paint(DRESSED);
        for (y, profile) in [(0.2, rectangle(0.6, -0.1, 0.1)), (eaves - 0.14, rectangle(0.28, -0.1, 0.16))] {
            // `side × direction` is outward where the path goes to -x on the side of +z.
            let [from, to] = line(y);
            let path = if turn == 0 { [to, from] } else { [from, to] };
            swept(builder, &profile, &path, -Vec3::Y);
        }
    }
    roof(builder, ends, half, [eaves, ridge], detail);
}

/// A solid gable with tiles on both slopes, which reach a little over the wall.
fn roof(builder: &mut Builder, ends: [f32; 2], half: f32, [eaves, ridge]: [f32; 2], detail: Detail) {
    builder.paint(STONE);
    gable(builder, ends, half, [eaves, ridge]);
    let over = 1.0 + 0.45 / half;
    let low = ridge - (ridge - eaves) * over;
    for side in [-1.0, 1.0] {
        let corner = |x: f32, y: f32, out: f32| Vec3::new(x, y, side * out);
        let (left, right) = if side > 0.0 { (ends[0], ends[1]) } else { (ends[1], ends[0]) };
        let eave = [corner(left, low, half * over), corner(right, low, half * over)];
        tiles(builder, eave, [left, right].map(|x| corner(x, ridge, 0.0)), tile(detail), TILES);
    }
    builder.paint(DRESSED);
    // Ridge tiles.
    let count = detail.steps((ends[1] - ends[0]) / 0.5);
    let each = (ends[1] - ends[0]) / count as f32;
    for index in 0..count {
        let x = ends[0] + (index as f32 + 0.5) * each;
        builder.block(Vec3::new(x, ridge - 0.1, 0.0), Vec3::new(0.95 * each, 0.2, 0.26));
    }
}

fn nave(builder: &mut Builder, detail: Detail) {
    let window = Opening { half: 0.62, sill: 1.9, spring: 3.9, rise: 1.2 };
    hall(builder, NAVE, NAVE_HALF, [NAVE_EAVES, NAVE_RIDGE], BAYS, window, detail);
    // Both ends, behind the tower and above the chancel.
    builder.paint(STONE);
    for x in [NAVE[0] + 0.1, NAVE[1] - 0.1] {
        let half = NAVE_HALF - 0.02;
        builder.cuboid(Vec3::new(x - 0.1, BELOW, -half), Vec3::new(x + 0.1, NAVE_EAVES, half));
    }
}

fn chancel(builder: &mut Builder, detail: Detail) {
    let window = Opening { half: 0.5, sill: 1.7, spring: 3.0, rise: 0.9 };
    hall(builder, CHANCEL, CHANCEL_HALF, [CHANCEL_EAVES, CHANCEL_RIDGE], 2, window, detail);
    let window = Opening { half: 1.2, sill: 1.7, spring: 3.2, rise: 1.3 };
    let east = bay(CHANCEL_HALF, [BELOW, CHANCEL_EAVES], window, GLASS, detail);
    builder.place(&east, |p| quarter(1, p + Vec3::Z * CHANCEL[1]));
}

/// Three storeys, the lowest with a portal, the highest with belfry openings, and a parapet.
fn tower(builder: &mut Builder, detail: Detail) {
    for turn in 0..4 {
        let openings = [
            Opening { half: 0.9, sill: BELOW, spring: 2.2, rise: 1.3 },
            Opening { half: 0.4, sill: 7.3, spring: 8.8, rise: 0.6 },
            Opening { half: 0.95, sill: 11.6, spring: 13.6, rise: 1.3 },
        ];
        for (storey, opening) in openings.into_iter().enumerate() {
            let fill = [WOOD, GLASS, IRON][storey];
            let bounds = [STOREYS[storey], STOREYS[storey + 1]];
            let mut face = bay(TOWER_HALF, bounds, opening, fill, detail);
            if storey == 2 {
                louvres(&mut face, opening, detail);
            }
            builder.place(&face, |p| quarter(turn, p + Vec3::Z * TOWER_HALF) + Vec3::X * TOWER);
        }
        let mut corner = Builder::new();
        corner.paint(DRESSED);
        // Quoins, alternately long to either side.
        let count = 36;
        let each = (STOREYS[3] - STOREYS[0]) / count as f32;
        for index in 0..count {
            let (x, z) = if index % 2 == 0 { (0.7, 0.4) } else { (0.4, 0.7) };
            let out = TOWER_HALF + 0.04;
            let low = Vec3::new(out - x, STOREYS[0] + index as f32 * each, out - z);
            corner.cuboid(low, Vec3::new(out, low.y + 0.94 * each, out));
        }
        // Merlons, and a pinnacle at the corner.
        for index in 0..6 {
            let x = (index as f32 + 0.5) * 0.9 - TOWER_HALF;
            corner.block(Vec3::new(x, STOREYS[3] + 0.5, TOWER_HALF - 0.1), Vec3::new(0.5, 0.8, 0.3));
        }
        let foot = Vec3::new(TOWER_HALF - 0.1, STOREYS[3], TOWER_HALF - 0.1);
        corner.block(foot, Vec3::new(0.6, 1.8, 0.6));
        let mut pinnacle = Builder::new();
        pinnacle.paint(DRESSED);
        turned(&mut pinnacle, &[[0.0, 0.0], [0.4, 0.0], [0.36, 0.2], [0.0, 2.0]].map(Vec2::from_array), 8);
        corner.place(&pinnacle, |p| p + foot + Vec3::Y * 1.75);
        builder.place(&corner, |p| quarter(turn, p) + Vec3::X * TOWER);
    }
    builder.paint(DRESSED);
    let square = |y: f32| {
        let h = TOWER_HALF;
        [[-h, -h], [-h, h], [h, h], [h, -h], [-h, -h]].map(|[x, z]| Vec3::new(TOWER + x, y, z))
    };
    for (y, width, out) in
        [(0.3, 0.8, 0.14), (STOREYS[1], 0.24, 0.12), (STOREYS[2], 0.24, 0.12), (15.5, 0.3, 0.2)]
    {
        swept(builder, &rectangle(width, -0.1, out), &square(y), Vec3::Y);
    }
    builder.paint(STONE);
    swept(builder, &rectangle(0.6, -0.28, 0.03), &square(STOREYS[3] + 0.3), Vec3::Y);
    let half = TOWER_HALF - 0.05;
    builder.block(Vec3::new(TOWER, STOREYS[3] - 0.2, 0.0), Vec3::new(2.0 * half, 0.2, 2.0 * half));
}

/// Slanting boards in a belfry opening.
fn louvres(face: &mut Builder, opening: Opening, detail: Detail) {
    let count = detail.steps(11.0);
    let old = face.paint(WOOD);
    let height = opening.spring + 0.5 * opening.rise - opening.sill;
    for index in 0..count {
        let y = opening.sill + 0.05 + (index as f32 + 0.4) * height / count as f32;
        face.hexahedron(|i| {
            let x = if i & 1 == 1 { opening.half + 0.02 } else { -opening.half - 0.02 };
            let thick = if i >> 1 & 1 == 1 { 0.05 } else { 0.0 };
            let (drop, z) = if i >> 2 & 1 == 1 { (0.0, -0.06) } else { (0.2, -0.3) };
            Vec3::new(x, y + drop + thick, z)
        });
    }
    face.paint(old);
}

/// An eight-sided spire under slates, with a ball and a cross.
fn spire(builder: &mut Builder, detail: Detail) {
    let low = STOREYS[3] - 0.02;
    let radius = 2.35 / FRAC_PI_8.cos();
    let at = |side: usize, radius: f32, y: f32| {
        let (sin, cos) = ((side as f32 - 0.5) / 8.0 * TAU).sin_cos();
        Vec3::new(TOWER + radius * sin, y, radius * cos)
    };
    let mut core = Builder::new();
    core.paint(STONE);
    turned(&mut core, &[[0.0, low], [0.97 * radius, low], [0.0, SPIRE - 0.1]].map(Vec2::from_array), 8);
    builder.place(&core, |p| {
        let (sin, cos) = FRAC_PI_8.sin_cos();
        Vec3::new(TOWER + cos * p.x - sin * p.z, p.y, sin * p.x + cos * p.z)
    });
    for side in 0..8 {
        let ends = |radius: f32, y: f32| [at(side, radius, y), at(side + 1, radius, y)];
        tiles(builder, ends(radius, low), ends(0.1, SPIRE), tile(detail), SLATES);
    }
    let mut top = Builder::new();
    top.paint(IRON);
    let sides = detail.sides(16.0);
    let rows = detail.steps(8.0);
    let ball: Vec<Vec2> = (0..=rows)
        .map(|row| {
            let (sin, cos) = (TAU / 2.0 * row as f32 / rows as f32).sin_cos();
            Vec2::new(if row == 0 || row == rows { 0.0 } else { 0.24 * sin }, -0.24 * cos)
        })
        .collect();
    turned(&mut top, &ball, sides);
    top.block(Vec3::ZERO, Vec3::new(0.09, 1.7, 0.09));
    top.block(Vec3::Y * 1.1, Vec3::new(0.08, 0.1, 0.8));
    builder.place(&top, |p| p + Vec3::new(TOWER, SPIRE + 0.1, 0.0));
}

/// A porch on four columns before the door, with steps and a gabled, tiled roof.
fn porch(builder: &mut Builder, detail: Detail) {
    let middle = (NAVE_HALF + PORCH_FRONT) / 2.0;
    builder.paint(PAVING);
    for step in 0..2 {
        let k = step as f32;
        let foot = Vec3::new(PORCH, BELOW, middle + 0.35 - 0.2 * k);
        let size = Vec3::new(
            2.0 * PORCH_HALF + 1.1 - 0.5 * k,
            0.22 + 0.14 * k,
            PORCH_FRONT - NAVE_HALF + 0.7 - 0.4 * k,
        );
        builder.block(foot, size);
    }
    // Columns come in the palette's material 0.
    let mut support = column(0.2, PORCH_EAVES - 0.5, 20.0, detail);
    support.repaint(DRESSED);
    for (x, z) in
        [(-1.0, PORCH_FRONT - 0.3), (1.0, PORCH_FRONT - 0.3), (-1.0, NAVE_HALF + 1.5), (1.0, NAVE_HALF + 1.5)]
    {
        builder.place(&support, |p| p + Vec3::new(PORCH + x * (PORCH_HALF - 0.3), 0.25, z));
    }
    builder.paint(WOOD);
    for x in [-1.0, 1.0] {
        let foot = Vec3::new(PORCH + x * (PORCH_HALF - 0.3), PORCH_EAVES - 0.27, middle);
        builder.block(foot, Vec3::new(0.3, 0.3, PORCH_FRONT - NAVE_HALF));
    }
    builder.block(
        Vec3::new(PORCH, PORCH_EAVES - 0.25, PORCH_FRONT - 0.3),
        Vec3::new(2.0 * PORCH_HALF, 0.29, 0.24),
    );
    // The door, in front of the wall's window.
    builder.block(Vec3::new(PORCH, BELOW, NAVE_HALF + 0.02), Vec3::new(1.7, 2.6, 0.2));
    for plank in 0..6 {
        let x = PORCH - 0.625 + 0.25 * plank as f32;
        builder.block(Vec3::new(x, 0.1, NAVE_HALF + 0.12), Vec3::new(0.22, 2.2, 0.06));
    }
    let mut top = Builder::new();
    roof(&mut top, [NAVE_HALF - 0.3, PORCH_FRONT], PORCH_HALF, [PORCH_EAVES, PORCH_RIDGE], detail);
    // Its ridge, built along x, points to +z.
    builder.place(&top, |p| Vec3::new(PORCH - p.z, p.y, p.x));
}
