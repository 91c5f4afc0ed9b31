//! An arcaded court of two storeys: round arches on columns, vaulted aisles, a gallery with a balustrade.
//!
//! The court lies along x around the origin. Each side is built once in its own frame, x along the arcade, z
//! towards the court and z = 0 on the arcade's axis, and copied to the opposite side.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::columns::{Detail, baluster, column, pot};
use super::parameters::Parameters;
use super::shapes::{
    Behind, Opening, arch, groin_vault, pierced_wall, rectangle, swept, tube, vault_section,
};

const STONE: u32 = 0;
const PLASTER: u32 = 1;
const MARBLE: u32 = 2;
const SLATE: u32 = 3;
const WOOD: u32 = 4;
const TILE: u32 = 5;
const RED: u32 = 6;
const BLUE: u32 = 7;
const CLAY: u32 = 8;
const LEAF: u32 = 9;
const PALETTE: [[f32; 3]; 10] = [
    [0.68, 0.62, 0.52],
    [0.76, 0.70, 0.58],
    [0.72, 0.70, 0.66],
    [0.42, 0.40, 0.38],
    [0.32, 0.20, 0.12],
    [0.55, 0.28, 0.18],
    [0.60, 0.10, 0.08],
    [0.10, 0.18, 0.50],
    [0.60, 0.33, 0.20],
    [0.16, 0.36, 0.10],
];

/// Distance between columns.
const BAY: f32 = 2.4;
/// Bays of the two long and the two short sides.
const BAYS: [usize; 2] = [9, 3];
/// From the arcade's axis to the outer wall.
const AISLE: f32 = 2.8;
/// Half the thickness of the lower arcade.
const THICK: f32 = 0.25;
/// Floor of the aisles, springing of the lower arches, floor of the gallery, ceiling of the gallery.
const PODIUM: f32 = 0.3;
const SPRING: f32 = 3.5;
const GALLERY: f32 = 5.2;
const CEILING: f32 = 9.25;

/// A storey of arches.
struct Storey {
    column_radius: f32,
    foot: f32,
    spring: f32,
    half: f32,
    top: f32,
    thick: f32,
    sides: f32,
}

const LOWER: Storey = Storey {
    column_radius: 0.225,
    foot: PODIUM,
    spring: SPRING,
    half: 0.88,
    top: 5.05,
    thick: THICK,
    sides: 14.0,
};
const UPPER: Storey =
    Storey { column_radius: 0.17, foot: 6.15, spring: 7.9, half: 0.95, top: 9.4, thick: 0.2, sides: 10.0 };

pub(super) fn atrium(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let detail = Detail(parameters.number("detail", 1.0, 0.25..=4.0)?);
    parameters.finish()?;
    let mut builder = Builder::new();
    for (bays, distance, turn) in [(BAYS[0], half_width(1), 0.0), (BAYS[1], half_width(0), PI / 2.0)] {
        let side = side(bays, detail);
        for turn in [turn, turn + PI] {
            let (sin, cos) = quarter(turn);
            builder.place(&side, |p| {
                let z = p.z - distance;
                Vec3::new(cos * p.x + sin * z, p.y, cos * z - sin * p.x)
            });
        }
    }
    corners(&mut builder, detail);
    rings(&mut builder);
    floor(&mut builder);
    furniture(&mut builder, detail);
    Ok(builder.finish(&PALETTE))
}

/// Sine and cosine of a multiple of 90°, exact.
fn quarter(turn: f32) -> (f32, f32) {
    (turn.sin().round(), turn.cos().round())
}

/// Distance from the centre of the court to the arcade's axis, along the long (0) or the short (1) direction.
fn half_width(direction: usize) -> f32 {
    BAYS[direction] as f32 * BAY / 2.0
}

/// One side of the court, without its corners.
fn side(bays: usize, detail: Detail) -> Builder {
    let mut builder = Builder::new();
    let half = bays as f32 * BAY / 2.0;
    arcade(&mut builder, bays, &LOWER, detail);
    arcade(&mut builder, bays, &UPPER, detail);
    balustrade(&mut builder, bays, detail);
    aisle(&mut builder, bays, detail);
    outer_wall(&mut builder, bays, detail);
    // The long sides' beams run on over the corners.
    builder.paint(WOOD);
    let reach = if bays == BAYS[0] { half + AISLE - 0.3 } else { half - 0.4 };
    let beams = (reach / 0.4) as usize;
    for beam in 0..=beams {
        let x = (2.0 * beam as f32 / beams as f32 - 1.0) * reach;
        builder.cuboid(
            Vec3::new(x - 0.07, CEILING - 0.22, -AISLE - 0.05),
            Vec3::new(x + 0.07, CEILING + 0.05, -0.1),
        );
    }
    builder
}

/// Middles of the bays.
fn middles(bays: usize) -> impl Iterator<Item = f32> {
    (0..bays).map(move |bay| (bay as f32 + 0.5 - bays as f32 / 2.0) * BAY)
}

/// Bounds between the bays, ends included.
fn bounds(bays: usize) -> impl Iterator<Item = f32> {
    (0..=bays).map(move |bay| (bay as f32 - bays as f32 / 2.0) * BAY)
}

/// Positions of columns: between the bays; piers stand at the ends.
fn inner_bounds(bays: usize) -> impl Iterator<Item = f32> {
    bounds(bays).skip(1).take(bays - 1)
}

fn arcade(builder: &mut Builder, bays: usize, storey: &Storey, detail: Detail) {
    let steps = detail.steps(7.0);
    let Storey { spring, half, thick, top, .. } = *storey;
    let mut bay = Builder::new();
    bay.paint(PLASTER);
    let opening = Opening { half, sill: spring, spring, rise: half };
    pierced_wall(&mut bay, BAY / 2.0, [spring, top], opening, (2.0 * thick, Behind::Air), steps);
    bay.paint(STONE);
    // A stepped moulding around the arch; it stands out from the wall's face and from the arch's underside.
    let edge = |z: f32, n: f32| Vec2::new(z + thick, n);
    let moulding = [
        edge(-0.05, 0.16),
        edge(0.03, 0.16),
        edge(0.07, 0.1),
        edge(0.07, -0.02),
        edge(-0.05, -0.02),
        edge(-0.05, 0.01),
    ];
    // The wall's front is at z = 0 so far, and its axis half its thickness behind.
    let path: Vec<Vec3> =
        arch(half, half, steps).into_iter().map(|p| Vec3::new(p.x, spring + p.y, -thick)).collect();
    swept(&mut bay, &moulding, &path, Vec3::Z);
    for x in middles(bays) {
        builder.place(&bay, |p| p + Vec3::new(x, 0.0, thick));
    }

    let mut pillar = Builder::new();
    pillar.paint(STONE);
    pillar.place(&column(storey.column_radius, spring - storey.foot, storey.sides, detail), |p| p);
    for x in inner_bounds(bays) {
        builder.place(&pillar, |p| p + Vec3::new(x, storey.foot, 0.0));
    }
}

/// Pedestals under the upper columns and turned balusters between them.
fn balustrade(builder: &mut Builder, bays: usize, detail: Detail) {
    builder.paint(STONE);
    let (low, high) = (GALLERY + 0.1, UPPER.foot - 0.12);
    let gap = BAY / 2.0 - 0.2;
    let baluster = baluster(high - low, detail);
    for x in middles(bays) {
        for (y, size) in
            [(GALLERY - 0.05, Vec3::new(2.0 * gap, 0.15, 0.22)), (high, Vec3::new(2.0 * gap, 0.11, 0.26))]
        {
            builder.block(Vec3::new(x, y, 0.0), size);
        }
        for k in -2..=2 {
            builder.place(&baluster, |p| p + Vec3::new(x + k as f32 * 0.36, low, 0.0));
        }
    }
    for x in inner_bounds(bays) {
        let foot = Vec3::new(x, GALLERY - 0.05, 0.0);
        builder.block(foot, Vec3::new(0.5, UPPER.foot - foot.y - 0.08, 0.44));
        builder.block(foot, Vec3::new(0.56, 0.2, 0.5));
        builder.block(Vec3::new(x, UPPER.foot - 0.1, 0.0), Vec3::new(0.56, 0.1, 0.52));
    }
}

/// Rise of the aisles' vaults, and their middle and half depth across the aisle.
const VAULT_RISE: f32 = 1.25;
const VAULT_MIDDLE: f32 = -(THICK + AISLE) / 2.0;
const VAULT_HALF: f32 = (AISLE - THICK) / 2.0;

/// Groin vaults over the lower aisle, with ribs between them on corbels at the wall.
fn aisle(builder: &mut Builder, bays: usize, detail: Detail) {
    let steps = detail.steps(5.0);
    let mut vault = Builder::new();
    vault.paint(PLASTER);
    groin_vault(&mut vault, Vec2::new(BAY / 2.0, VAULT_HALF), VAULT_RISE, steps);
    for x in middles(bays) {
        builder.place(&vault, |p| p + Vec3::new(x, SPRING, VAULT_MIDDLE));
    }
    builder.paint(STONE);
    let section = vault_section(Vec2::new(BAY / 2.0, VAULT_HALF), VAULT_RISE, steps);
    for (index, x) in bounds(bays).enumerate() {
        // Ribs at the ends also span the thickness of the crossing arcade.
        let width = if index == 0 || index == bays { 2.0 * THICK + 0.02 } else { 0.3 };
        let path: Vec<Vec3> =
            section.iter().map(|p| Vec3::new(x, SPRING + p.y, VAULT_MIDDLE + p.x * VAULT_HALF)).collect();
        swept(builder, &rectangle(width, -0.1, 0.05), &path, -Vec3::X);
        let wall = Vec3::new(x, 0.0, -AISLE);
        builder.block(wall + Vec3::Y * (PODIUM - 0.05), Vec3::new(width + 0.1, 0.35, 0.3));
        builder.block(wall + Vec3::Y * PODIUM, Vec3::new(width, SPRING - PODIUM - 0.1, 0.2));
        builder.block(wall + Vec3::Y * (SPRING - 0.25), Vec3::new(width + 0.1, 0.25, 0.3));
    }
}

/// The outer wall with an arched doorway in every bay of both storeys, as a recess with a wooden door.
fn outer_wall(builder: &mut Builder, bays: usize, detail: Detail) {
    let steps = detail.steps(4.0);
    let recess = (0.25, Behind::Material(WOOD));
    // The fields at the corners are as wide as the aisle.
    let corner = bays as f32 * BAY / 2.0 + AISLE / 2.0;
    let fields = middles(bays).map(|x| (x, BAY / 2.0)).chain([(-corner, AISLE / 2.0), (corner, AISLE / 2.0)]);
    for (x, half) in fields {
        let mut field = Builder::new();
        field.paint(PLASTER);
        let door = Opening { half: 0.55, sill: PODIUM, spring: 2.0, rise: 0.55 };
        pierced_wall(&mut field, half, [PODIUM, GALLERY], door, recess, steps);
        let door = Opening { half: 0.5, sill: GALLERY, spring: 7.2, rise: 0.5 };
        pierced_wall(&mut field, half, [GALLERY, 11.8], door, recess, steps);
        builder.place(&field, |p| p + Vec3::new(x, 0.0, -AISLE));
    }
}

/// Piers and vaults where the sides of the court meet.
fn corners(builder: &mut Builder, detail: Detail) {
    for (sx, sz) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let axis = Vec3::new(sx * half_width(0), 0.0, sz * half_width(1));
        builder.paint(STONE);
        for (y, width, height) in [
            (PODIUM - 0.05, 0.78, 0.3),
            (PODIUM, 0.6, GALLERY - PODIUM - 0.02),
            (SPRING - 0.2, 0.76, 0.2),
            (GALLERY - 0.05, 0.62, UPPER.foot - GALLERY + 0.05),
            (UPPER.foot - 0.05, 0.5, CEILING - UPPER.foot + 0.1),
            (UPPER.spring - 0.15, 0.64, 0.15),
        ] {
            builder.block(axis + Vec3::Y * y, Vec3::new(width, height, width));
        }
        builder.paint(PLASTER);
        let mut vault = Builder::new();
        vault.paint(PLASTER);
        groin_vault(&mut vault, Vec2::splat(VAULT_HALF), VAULT_RISE, detail.steps(5.0));
        let centre = axis + Vec3::new(-sx * VAULT_MIDDLE, SPRING, -sz * VAULT_MIDDLE);
        builder.place(&vault, |p| p + centre);
    }
}

/// Sweeps a profile of (outwards from the arcade's axis, height) points around the court, clockwise around
/// solid.
fn around(builder: &mut Builder, profile: &[[f32; 2]]) {
    let (x, z) = (half_width(0), half_width(1));
    let path = [[-x, z], [x, z], [x, -z], [-x, -z], [-x, z]].map(|[x, z]| Vec3::new(x, 0.0, z));
    let profile: Vec<Vec2> = profile.iter().map(|[out, height]| Vec2::new(-height, *out)).collect();
    swept(builder, &profile, &path, -Vec3::Y);
}

/// Parts that run around the court unchanged: steps, cornices, the gallery's floor, ceiling, roof, outer
/// shell.
fn rings(builder: &mut Builder) {
    let wall = AISLE + 0.1;
    builder.paint(STONE);
    around(builder, &[[-1.1, -0.05], [-1.1, 0.15], [-0.75, 0.15], [-0.75, PODIUM], [wall, PODIUM]]);
    let string_course = [
        [-0.24, 4.8],
        [-0.31, 4.86],
        [-0.31, 4.96],
        [-0.4, 5.04],
        [-0.48, 5.08],
        [-0.48, GALLERY],
        [wall, GALLERY],
        [wall, 5.0],
        [-0.2, 5.0],
        [-0.24, 4.8],
    ];
    around(builder, &string_course);
    let cornice = [
        [-0.19, 9.1],
        [-0.26, 9.14],
        [-0.26, 9.3],
        [-0.38, 9.4],
        [-0.5, 9.46],
        [-0.5, 9.6],
        [-0.1, 9.6],
        [-0.1, 9.3],
        [-0.19, 9.1],
    ];
    around(builder, &cornice);
    builder.paint(WOOD);
    around(builder, &[[-0.05, CEILING], [-0.05, 9.5], [wall, 9.5], [wall, CEILING], [-0.05, CEILING]]);
    builder.paint(TILE);
    around(builder, &[[-0.75, 9.56], [-0.75, 9.64], [wall, 10.9], [wall, 10.8], [-0.75, 9.56]]);
    builder.paint(PLASTER);
    let (inner, outer) = (AISLE + 0.3, AISLE + 0.55);
    around(builder, &[[inner, -0.1], [inner, 11.9], [outer, 11.9], [outer, -0.1], [inner, -0.1]]);
    builder.paint(STONE);
    let (inner, outer) = (AISLE - 0.08, AISLE + 0.65);
    around(builder, &[[inner, 11.7], [inner, 12.0], [outer, 12.0], [outer, 11.7], [inner, 11.7]]);
}

/// The court's floor: marble and slate slabs in a chequered pattern.
fn floor(builder: &mut Builder) {
    let half = Vec2::new(half_width(0) - 1.1, half_width(1) - 1.1);
    let slabs = [28, 7];
    let slab = 2.0 * half / Vec2::new(slabs[0] as f32, slabs[1] as f32);
    for row in 0..slabs[1] {
        for column in 0..slabs[0] {
            builder.paint(if (row + column) % 2 == 0 { MARBLE } else { SLATE });
            let corner = |right: i32, far: i32| {
                Vec3::new(
                    (column + right) as f32 * slab.x - half.x,
                    0.0,
                    half.y - (row + far) as f32 * slab.y,
                )
            };
            builder.quad([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
        }
    }
}

/// A fountain's basin, potted shrubs on the steps, and banners in front of the lower arcade.
fn furniture(builder: &mut Builder, detail: Detail) {
    builder.paint(MARBLE);
    builder.place(&pot(0.8, 22.0, detail), |p| Vec3::new(3.6 + 2.2 * p.x, p.y, 2.2 * p.z));
    builder.place(&pot(1.5, 16.0, detail), |p| Vec3::new(3.6 + 0.7 * p.x, p.y, 0.7 * p.z));
    for (index, (x, z)) in
        [(-4.8, 3.1), (-4.8, -3.1), (0.0, -3.1), (2.4, 3.1), (7.2, 3.1), (7.2, -3.1)].into_iter().enumerate()
    {
        let foot = Vec3::new(x, PODIUM, z);
        builder.paint(CLAY);
        builder.place(&pot(0.5, 11.0, detail), |p| p + foot);
        builder.paint(LEAF);
        shrub(builder, foot + Vec3::Y * 0.45, index, detail);
    }
    for (index, (x, z)) in
        [(-6.0, -1.0), (-1.2, 1.0), (1.2, -1.0), (6.0, 1.0), (-6.0, 1.0), (6.0, -1.0)].into_iter().enumerate()
    {
        let near = z * (half_width(1) - 0.62);
        builder.paint(WOOD);
        let rod = [(-0.62, 0.0), (-0.6, 0.025), (0.6, 0.025), (0.62, 0.0)];
        let rod = rod.map(|(along, radius)| (Vec3::new(x + along, 5.02, near), radius));
        tube(builder, &rod, detail.sides(8.0));
        builder.paint(if index % 2 == 0 { RED } else { BLUE });
        banner(builder, Vec3::new(x, 5.0, near), index, detail);
    }
}

/// Long bent leaves out of one point.
fn shrub(builder: &mut Builder, foot: Vec3, index: usize, detail: Detail) {
    let rows = detail.steps(4.0);
    for leaf in 0..24 {
        // The golden angle spreads the leaves; inner ones stand, outer ones hang over.
        let (sin, cos) = (leaf as f32 * 2.399_963 + index as f32).sin_cos();
        let lean = 0.15 + 0.035 * leaf as f32;
        builder.sheet(rows, 2, |row, column| {
            let t = row as f32 / rows as f32;
            let out = lean * t * (0.4 + 0.6 * t);
            let up = 0.95 * t * (1.0 - 0.6 * lean * t);
            let across = (column as f32 - 1.0) * 0.07 * (1.0 - t * t) * (0.4 + 2.0 * t);
            let fold = if column == 1 { 0.0 } else { 0.02 * (1.0 - t) };
            foot + Vec3::new(cos * out + sin * across, up + fold, sin * out - cos * across)
        });
    }
}

/// A cloth that hangs from `top` in gentle folds and ends in a point.
fn banner(builder: &mut Builder, top: Vec3, index: usize, detail: Detail) {
    let (rows, columns) = (detail.steps(8.0), 2 * detail.steps(6.0));
    builder.sheet(rows, columns, |row, column| {
        let (t, s) = (1.0 - row as f32 / rows as f32, column as f32 / columns as f32 - 0.5);
        let length = 2.6 - 0.7 * s.abs();
        let fold = 0.06 * t.sqrt() * (3.0 * PI * s + index as f32 + 0.8 * t).sin();
        top + Vec3::new(1.0 * s * (1.0 - 0.06 * t), -length * t, fold)
    });
}
