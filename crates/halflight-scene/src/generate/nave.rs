//! A vaulted church: a nave between two aisles, compound piers, pointed arches, ribbed vaults and an apse.
//!
//! The nave runs along x with the apse at +x. Each side is built once, on the -z side and facing +z, and
//! copied with a half turn; the sides are symmetric in x.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::columns::{Detail, shaft};
use super::parameters::Parameters;
use super::shapes::{
    Behind, Opening, arch, groin_vault, hood, mullion, pierced_wall, rectangle, swept, turned, vault_section,
};

const STONE: u32 = 0;
const VAULT: u32 = 1;
const PAVING: u32 = 2;
const DARK_PAVING: u32 = 3;
const GLASS: u32 = 4;
const WOOD: u32 = 5;
const LINEN: u32 = 6;
const PALETTE: [[f32; 3]; 7] = [
    [0.66, 0.62, 0.55],
    [0.72, 0.69, 0.63],
    [0.62, 0.57, 0.50],
    [0.35, 0.32, 0.30],
    [0.22, 0.30, 0.45],
    [0.34, 0.21, 0.12],
    [0.80, 0.78, 0.74],
];

/// Length and number of the bays.
const BAY: f32 = 4.0;
const BAYS: usize = 7;
/// Half the length of the bays together.
const END: f32 = BAY * BAYS as f32 / 2.0;
/// From the nave's axis to the front and the back of the arcade, and to the aisle's outer wall.
const FRONT: f32 = 3.2;
const BACK: f32 = 4.0;
const WALL: f32 = 7.2;
/// Springing of the arcade and of the aisle's vaults; springing of the nave's vaults.
const SPRING: f32 = 4.2;
const HIGH_SPRING: f32 = 8.6;
/// Rises of the aisle's and of the nave's vaults.
const RISE: f32 = 2.3;
const HIGH_RISE: f32 = 4.4;
/// Height at which the arcade ends and the clerestory begins, and top of the walls (above the vaults).
const STRING: f32 = 7.1;
const TOP: f32 = 13.4;

pub(super) fn nave(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let detail = Detail(parameters.number("detail", 1.0, 0.25..=4.0)?);
    parameters.finish()?;
    let mut builder = Builder::new();
    let side = side(detail);
    builder.place(&side, |p| p);
    builder.place(&side, |p| Vec3::new(-p.x, p.y, -p.z));
    high_vaults(&mut builder, detail);
    apse(&mut builder, detail);
    ends(&mut builder, detail);
    floor(&mut builder);
    furniture(&mut builder);
    Ok(builder.finish(&PALETTE))
}

fn middles() -> impl Iterator<Item = f32> {
    (0..BAYS).map(|bay| (bay as f32 + 0.5) * BAY - END)
}

fn bounds() -> impl Iterator<Item = f32> {
    (0..=BAYS).map(|bay| bay as f32 * BAY - END)
}

/// Arcade, clerestory and aisle at -z.
fn side(detail: Detail) -> Builder {
    let mut builder = Builder::new();
    let steps = detail.steps(8.0);
    let mut bay = Builder::new();
    bay.paint(STONE);
    let opening = Opening { half: 1.45, sill: -0.05, spring: SPRING, rise: 2.1 };
    pierced_wall(&mut bay, BAY / 2.0, [-0.05, STRING], opening, (BACK - FRONT, Behind::Air), steps);
    let window = Opening { half: 0.7, sill: 8.2, spring: 10.2, rise: 1.3 };
    pierced_wall(&mut bay, BAY / 2.0, [STRING, TOP], window, (0.35, Behind::Material(GLASS)), steps);
    mullion(&mut bay, window, -0.3);
    // A second, narrower order under the arch.
    let order: Vec<Vec3> = arch(opening.half, opening.rise, steps)
        .into_iter()
        .map(|p| Vec3::new(p.x, SPRING + p.y, -(BACK - FRONT) / 2.0))
        .collect();
    let profile = [[0.2, 0.02], [0.2, -0.12], [0.12, -0.2], [-0.12, -0.2], [-0.2, -0.12], [-0.2, 0.02]];
    swept(&mut bay, &profile.map(Vec2::from_array), &order, Vec3::Z);
    hood(&mut bay, opening, steps);
    bay.place(&aisle_bay(detail), |p| p);
    for x in middles() {
        builder.place(&bay, |p| p + Vec3::new(x, 0.0, -FRONT));
    }
    let pier = pier(detail);
    for (index, x) in bounds().enumerate() {
        builder.place(&pier, |p| p + Vec3::X * x);
        aisle_rib(&mut builder, x, if index == 0 || index == BAYS { 0.5 } else { 0.36 }, steps);
    }
    builder.paint(STONE);
    // Mouldings under the clerestory, towards the nave, and along the foot of the outer wall.
    let string_course = [[-0.1, 7.0], [0.06, 7.06], [0.14, 7.16], [0.14, 7.26], [-0.1, 7.3]];
    along(&mut builder, &string_course, -FRONT);
    along(&mut builder, &[[-0.1, -0.05], [0.14, -0.05], [0.14, 0.4], [0.06, 0.5], [-0.1, 0.5]], -WALL);
    builder
}

/// The outer wall with a window, and the aisle's vault, in the frame of the arcade's bay.
fn aisle_bay(detail: Detail) -> Builder {
    let mut bay = Builder::new();
    bay.paint(STONE);
    let window = Opening { half: 0.65, sill: 2.0, spring: 4.2, rise: 1.2 };
    pierced_wall(
        &mut bay,
        BAY / 2.0,
        [-0.05, STRING],
        window,
        (0.35, Behind::Material(GLASS)),
        detail.steps(5.0),
    );
    mullion(&mut bay, window, -0.3);
    let mut builder = Builder::new();
    builder.place(&bay, |p| p - Vec3::Z * (WALL - FRONT));
    let mut vault = Builder::new();
    vault.paint(VAULT);
    let half = Vec2::new(BAY / 2.0, (WALL - BACK) / 2.0);
    groin_vault(&mut vault, half, RISE, detail.steps(7.0));
    diagonals(&mut vault, half, RISE, 0.14, detail);
    builder.place(&vault, |p| p + Vec3::new(0.0, SPRING, FRONT - (BACK + WALL) / 2.0));
    builder
}

/// Ribs under the groins of a vault and a boss where they cross.
fn diagonals(builder: &mut Builder, half: Vec2, rise: f32, width: f32, detail: Detail) {
    let old = builder.paint(STONE);
    let section = vault_section(half, rise, detail.steps(7.0));
    for sign in [-1.0, 1.0] {
        let along = Vec3::new(half.x, 0.0, sign * half.y);
        let path: Vec<Vec3> = section.iter().map(|p| along * p.x + Vec3::Y * p.y).collect();
        let w = width / 2.0;
        let profile =
            [[w, 0.03], [w, -0.5 * w], [0.4 * w, -1.6 * w], [-0.4 * w, -1.6 * w], [-w, -0.5 * w], [-w, 0.03]];
        swept(builder, &profile.map(Vec2::from_array), &path, along.normalize().cross(Vec3::Y));
    }
    let (r, low) = (1.4 * width, rise - 1.1 * width);
    let boss = [[0.0, low - 0.6 * r], [0.6 * r, low - 0.4 * r], [r, low], [r, rise]].map(Vec2::from_array);
    turned(builder, &boss, detail.sides(8.0));
    builder.paint(old);
}

/// The rib between two bays of the aisle, from the arcade to the outer wall.
fn aisle_rib(builder: &mut Builder, x: f32, width: f32, steps: usize) {
    let half = (WALL - BACK) / 2.0;
    let path: Vec<Vec3> = vault_section(Vec2::new(BAY / 2.0, half), RISE, steps)
        .into_iter()
        .map(|p| Vec3::new(x, SPRING + p.y, p.x * half - (BACK + WALL) / 2.0))
        .collect();
    builder.paint(STONE);
    swept(builder, &rectangle(width, -0.18, 0.05), &path, -Vec3::X);
}

/// Pier between two bays: shafts around it and at the outer wall, on plinths.
fn pier(detail: Detail) -> Builder {
    let mut pier = Builder::new();
    pier.paint(STONE);
    let middle = -(FRONT + BACK) / 2.0;
    let plinth = 0.3;
    for (x, z, radius, top, sides) in [
        (0.0, -FRONT + 0.05, 0.2, HIGH_SPRING, 14.0),
        (-0.32, -FRONT + 0.02, 0.1, HIGH_SPRING, 10.0),
        (0.32, -FRONT + 0.02, 0.1, HIGH_SPRING, 10.0),
        (-0.55, middle, 0.17, SPRING, 14.0),
        (0.55, middle, 0.17, SPRING, 14.0),
        (0.0, -BACK, 0.18, SPRING, 14.0),
        (0.0, -WALL, 0.18, SPRING, 14.0),
    ] {
        pier.place(&shaft(radius, top - plinth, sides, detail), |p| p + Vec3::new(x, plinth, z));
    }
    pier.block(Vec3::new(0.0, -0.05, middle), Vec3::new(1.72, 0.25, 1.72));
    pier.block(Vec3::new(0.0, -0.05, middle), Vec3::new(1.66, plinth + 0.05, 1.66));
    pier.block(Vec3::new(0.0, -0.05, -WALL), Vec3::new(0.8, plinth + 0.05, 0.8));
    pier.block(Vec3::new(0.0, SPRING - 0.16, middle), Vec3::new(1.2, 0.14, BACK - FRONT + 0.1));
    pier
}

/// Ribbed vaults over the nave, between transverse arches.
fn high_vaults(builder: &mut Builder, detail: Detail) {
    let steps = detail.steps(7.0);
    let half = Vec2::new(BAY / 2.0, FRONT);
    let mut vault = Builder::new();
    vault.paint(VAULT);
    groin_vault(&mut vault, half, HIGH_RISE, steps);
    diagonals(&mut vault, half, HIGH_RISE, 0.2, detail);
    for x in middles() {
        builder.place(&vault, |p| p + Vec3::new(x, HIGH_SPRING, 0.0));
    }
    builder.paint(STONE);
    let section = vault_section(half, HIGH_RISE, steps);
    for x in bounds() {
        let path: Vec<Vec3> = section.iter().map(|p| Vec3::new(x, HIGH_SPRING + p.y, p.x * FRONT)).collect();
        swept(builder, &rectangle(0.42, -0.25, 0.05), &path, -Vec3::X);
    }
}

/// The half-round end: a wall of five windows under a pointed half dome with ribs.
fn apse(builder: &mut Builder, detail: Detail) {
    const PANELS: usize = 5;
    let width = PI / PANELS as f32;
    let steps = detail.steps(6.0);
    let mut panel = Builder::new();
    panel.paint(STONE);
    let window = Opening { half: 0.55, sill: 3.0, spring: 6.4, rise: 1.1 };
    let bounds = [-0.05, HIGH_SPRING];
    pierced_wall(&mut panel, width * FRONT / 2.0, bounds, window, (0.35, Behind::Material(GLASS)), steps);
    hood(&mut panel, window, steps);
    mullion(&mut panel, window, -0.3);
    for index in 0..PANELS {
        let middle = (index as f32 + 0.5) * width - PI / 2.0;
        builder.place(&panel, |p| {
            let (sin, cos) = (middle + p.x / FRONT).sin_cos();
            let radius = FRONT - p.z;
            Vec3::new(END + radius * cos, p.y, radius * sin)
        });
    }

    let half_arch: Vec<Vec2> = arch(FRONT, HIGH_RISE, steps).split_off(steps).into_iter().rev().collect();
    let columns = PANELS * detail.steps(4.0);
    builder.paint(VAULT);
    builder.sheet(steps, columns, |row, column| {
        let (sin, cos) = (PI * (column as f32 / columns as f32 - 0.5)).sin_cos();
        let p = half_arch[row];
        Vec3::new(END + p.x * cos, HIGH_SPRING + p.y, p.x * sin)
    });
    builder.paint(STONE);
    for index in 1..PANELS {
        let (sin, cos) = (index as f32 * width - PI / 2.0).sin_cos();
        let out = Vec3::new(cos, 0.0, sin);
        let path: Vec<Vec3> =
            half_arch.iter().map(|p| Vec3::new(END, HIGH_SPRING + p.y, 0.0) + out * p.x).collect();
        swept(builder, &rectangle(0.18, -0.15, 0.05), &path, Vec3::Y.cross(out));
        let foot = Vec3::new(END, 0.0, 0.0) + out * (FRONT - 0.02);
        builder.place(&shaft(0.12, HIGH_SPRING, 8.0, detail), |p| p + foot);
    }
    // A moulding where wall and half dome meet.
    let ring: Vec<Vec3> = (0..=columns)
        .map(|column| {
            let (sin, cos) = (PI * (0.5 - column as f32 / columns as f32)).sin_cos();
            Vec3::new(END + FRONT * cos, HIGH_SPRING, FRONT * sin)
        })
        .collect();
    let profile = [[-0.16, -0.05], [-0.1, 0.1], [0.06, 0.1], [0.12, -0.05]];
    swept(builder, &profile.map(Vec2::from_array), &ring, Vec3::Y);
}

/// The west front with a portal and a window, and the ends of the aisles.
fn ends(builder: &mut Builder, detail: Detail) {
    let steps = detail.steps(6.0);
    let mut west = Builder::new();
    west.paint(STONE);
    let portal = Opening { half: 1.3, sill: -0.05, spring: 2.6, rise: 1.8 };
    pierced_wall(&mut west, FRONT, [-0.05, STRING], portal, (0.6, Behind::Material(WOOD)), steps);
    hood(&mut west, portal, steps);
    let window = Opening { half: 1.2, sill: 7.8, spring: 9.6, rise: 2.0 };
    pierced_wall(&mut west, FRONT, [STRING, TOP], window, (0.4, Behind::Material(GLASS)), steps);
    mullion(&mut west, window, -0.35);
    builder.place(&west, |p| Vec3::new(p.z - END, p.y, -p.x));

    let mut aisle = Builder::new();
    aisle.paint(STONE);
    let window = Opening { half: 0.65, sill: 2.0, spring: 4.2, rise: 1.2 };
    let half = (WALL - FRONT) / 2.0;
    pierced_wall(&mut aisle, half, [-0.05, STRING], window, (0.35, Behind::Material(GLASS)), steps);
    mullion(&mut aisle, window, -0.3);
    for z in [-FRONT - half, FRONT + half] {
        builder.place(&aisle, |p| Vec3::new(p.z - END, p.y, z - p.x));
        builder.place(&aisle, |p| Vec3::new(END - p.z, p.y, z + p.x));
    }
}

/// Paving in a chequered pattern, and the steps up to the choir.
fn floor(builder: &mut Builder) {
    let (low, high) = (Vec2::new(-END - 0.65, -WALL - 0.1), Vec2::new(END + FRONT + 0.4, WALL + 0.1));
    let slabs = [40, 18];
    let slab = (high - low) / Vec2::new(slabs[0] as f32, slabs[1] as f32);
    for row in 0..slabs[1] {
        for column in 0..slabs[0] {
            builder.paint(if (row + column) % 2 == 0 { PAVING } else { DARK_PAVING });
            let corner = |right: i32, far: i32| {
                Vec3::new(low.x + (column + right) as f32 * slab.x, 0.0, high.y - (row + far) as f32 * slab.y)
            };
            builder.quad([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
        }
    }
    builder.paint(STONE);
    for step in 0..3 {
        let k = step as f32;
        let (x, y, z) = (CHOIR + 0.4 * k, 0.15 * (k + 1.0), 2.74 - 0.02 * k);
        builder.cuboid(Vec3::new(x, -0.1, -z), Vec3::new(END + FRONT + 0.2 + 0.02 * k, y, z));
    }
}

/// Start of the steps to the choir.
const CHOIR: f32 = 7.2;

/// Benches in the nave; in the choir an altar with candlesticks.
fn furniture(builder: &mut Builder) {
    let mut bench = Builder::new();
    bench.paint(WOOD);
    for z in [-0.86, 0.0, 0.86] {
        bench.block(Vec3::new(0.1, -0.02, z), Vec3::new(0.44, 0.45, 0.06));
    }
    for z in [-0.88, 0.88] {
        bench.block(Vec3::new(0.05, -0.02, z), Vec3::new(0.6, 0.97, 0.07));
    }
    bench.block(Vec3::new(0.1, 0.41, 0.0), Vec3::new(0.48, 0.05, 1.76));
    for y in [0.5, 0.72] {
        bench.block(Vec3::new(-0.16, y, 0.0), Vec3::new(0.04, 0.16, 1.76));
    }
    for row in 0..9 {
        for z in [-1.85, 1.85] {
            builder.place(&bench, |p| p + Vec3::new(row as f32 * 1.15 - 4.4, 0.0, z));
        }
    }
    let foot = Vec3::new(END - 0.4, 0.4, 0.0);
    builder.paint(STONE);
    builder.block(foot, Vec3::new(1.9, 0.2, 3.4));
    builder.block(foot + Vec3::Y * 0.15, Vec3::new(0.8, 0.95, 2.2));
    builder.paint(LINEN);
    builder.block(foot + Vec3::Y * 1.08, Vec3::new(0.95, 0.06, 2.4));
    builder.block(foot + Vec3::Y * 0.7, Vec3::new(0.97, 0.42, 0.7));
    builder.paint(WOOD);
    let stick =
        [[0.12, 0.0], [0.12, 0.03], [0.03, 0.08], [0.03, 0.5], [0.08, 0.55], [0.08, 0.58], [0.025, 0.58]];
    let candle = [[0.025, 0.58], [0.025, 0.85], [0.0, 0.87]];
    for z in [-0.9, 0.9] {
        let mut light = Builder::new();
        light.paint(WOOD);
        turned(&mut light, &stick.map(Vec2::from_array), 10);
        light.paint(LINEN);
        turned(&mut light, &candle.map(Vec2::from_array), 10);
        builder.place(&light, |p| p + foot + Vec3::new(0.0, 1.13, z));
    }
}

/// Sweeps a profile of (towards +z, height) points from one end of the bays to the other, from bottom to top.
fn along(builder: &mut Builder, profile: &[[f32; 2]], z: f32) {
    let profile: Vec<Vec2> = profile.iter().map(|[out, height]| Vec2::new(*height, *out)).collect();
    let path = [Vec3::new(END, 0.0, z), Vec3::new(-END, 0.0, z)];
    swept(builder, &profile, &path, Vec3::Y);
}
