//! Furniture: tables, chairs, bookcases, stairs, cups and plants. Each stands on y = 0 around the origin.

use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3};

use super::bars::rod;
use super::builder::Builder;
use super::random::Random;
use super::shapes::{tube, turned};

/// A table on four legs with an apron below its top.
pub(super) fn table(builder: &mut Builder, size: Vec2, height: f32) {
    let (top, leg) = (0.03, 0.06);
    let half = size * 0.5;
    builder.block(Vec3::Y * (height - top), Vec3::new(size.x, top, size.y));
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let foot = Vec3::new(x * (half.x - leg), 0.0, z * (half.y - leg));
        builder.block(foot, Vec3::new(leg, height - top, leg));
    }
    let (low, inset) = (height - top - 0.08, leg * 1.2);
    for side in [-1.0, 1.0] {
        let along = Vec3::new(0.0, low, side * (half.y - inset));
        builder.block(along, Vec3::new(size.x - 3.5 * leg, 0.08, 0.02));
        let across = Vec3::new(side * (half.x - inset), low, 0.0);
        builder.block(across, Vec3::new(0.02, 0.08, size.y - 3.5 * leg));
    }
}

/// A chair whose back, of three to six slats, is at negative z.
pub(super) fn chair(builder: &mut Builder, height: f32, random: &mut Random) {
    let (half, leg) = (0.2, 0.035);
    builder.block(Vec3::Y * (height - 0.025), Vec3::new(0.42, 0.025, 0.42));
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0f32)] {
        let top = if z < 0.0 { height + 0.45 } else { height - 0.025 };
        let place = Vec3::new(
            x * (half - leg * 0.5),
            0.0,
            z * (half - leg * 0.5) - if z < 0.0 { 0.026 } else { 0.0 },
        );
        builder.block(place, Vec3::new(leg, top, leg));
    }
    let slats = 3 + (random.unit() * 4.0) as u32;
    for slat in 0..slats {
        let y = height + 0.06 + 0.36 * slat as f32 / slats as f32;
        builder.block(Vec3::new(0.0, y, -half - 0.008), Vec3::new(0.33, 0.03, 0.012));
    }
}

/// A bookcase with its back at negative z and books on its boards.
pub(super) fn bookcase(builder: &mut Builder, size: Vec3, boards: u32, random: &mut Random) {
    let thick = 0.022;
    for side in [-1.0, 1.0] {
        builder.block(Vec3::new(side * (size.x - thick) * 0.5, 0.0, 0.0), Vec3::new(thick, size.y, size.z));
    }
    builder
        .block(Vec3::new(0.0, 0.0, (0.006 - size.z) * 0.5), Vec3::new(size.x - 2.0 * thick, size.y, 0.006));
    let clear = size.y / boards as f32;
    for board in 0..=boards {
        let y = (board as f32 * clear).min(size.y - thick);
        builder.block(Vec3::new(0.0, y, 0.003), Vec3::new(size.x - 2.0 * thick, thick, size.z - 0.006));
        if board == boards {
            break;
        }
        let mut x = thick - size.x * 0.5 + 0.004;
        while x < size.x * 0.5 - 0.1 {
            let book = Vec3::new(
                random.between(0.012, 0.05),
                clear * random.between(0.5, 0.85),
                random.between(0.14, 0.26),
            );
            if random.unit() < 0.12 {
                x += random.between(0.03, 0.25);
                continue;
            }
            builder.paint(2 + (random.unit() * 4.0) as u32);
            let foot = Vec3::new(x + book.x * 0.5, y + thick, 0.01 - size.z * 0.5 + book.z * 0.5);
            builder.block(foot, book);
            x += book.x + random.between(0.0005, 0.004);
        }
    }
}

/// Stairs that go up towards negative z, open or closed below their treads, with balusters and a rail on the
/// right.
pub(super) fn flight(builder: &mut Builder, steps: u32, [rise, going, width]: [f32; 3], closed: bool) {
    for step in 0..steps {
        let (y, z) = (step as f32 * rise, -(step as f32) * going);
        if closed {
            builder.block(Vec3::new(0.0, 0.0, z - going * 0.5), Vec3::new(width, y + rise - 0.03, going));
        }
        builder.block(
            Vec3::new(0.0, y + rise - 0.03, z - going * 0.5 + 0.01),
            Vec3::new(width + 0.04, 0.03, going + 0.02),
        );
        let foot = Vec3::new(width * 0.5 - 0.05, y + rise, z - going * 0.5);
        rod(builder, [foot, foot + Vec3::Y * 0.85], 0.012, 8);
    }
    let rail = |step: f32| Vec3::new(width * 0.5 - 0.05, (step + 1.0) * rise + 0.86, -(step + 0.5) * going);
    rod(builder, [rail(0.0), rail(steps as f32 - 1.0)], 0.025, 10);
}

/// A cup, bowl or plate.
pub(super) fn cup(builder: &mut Builder, radius: f32, height: f32) {
    let wall = (height * 0.1).min(radius * 0.1);
    let profile = [
        (0.0, 0.0),
        (radius * 0.7, 0.0),
        (radius, height),
        (radius - wall, height),
        (radius * 0.65, wall),
        (0.0, wall),
    ];
    let profile: Vec<Vec2> = profile.iter().map(|&(r, y)| Vec2::new(r, y)).collect();
    turned(builder, &profile, 28);
}

/// Stems with bent leaves.
pub(super) fn plant(builder: &mut Builder, height: f32, leaves: usize, random: &mut Random) {
    let stems = 3 + (random.unit() * 4.0) as usize;
    for stem in 0..stems {
        let lean = Quat::from_rotation_y(stem as f32 / stems as f32 * TAU)
            * Vec3::new(random.between(0.1, 0.5), 0.0, 0.0);
        let at = |t: f32| Vec3::Y * (height * t) + lean * (t * t * height);
        let path: Vec<(Vec3, f32)> = (0..=6).map(|step| (at(step as f32 / 6.0), 0.006)).collect();
        tube(builder, &path, 6);
        for _ in 0..leaves / stems {
            let root = at(random.between(0.25, 1.0));
            let out = Quat::from_rotation_y(random.unit() * TAU) * Vec3::X;
            let (length, wide) = (height * random.between(0.1, 0.25), height * random.between(0.02, 0.06));
            let side = out.cross(Vec3::Y) * wide;
            let droop = random.between(-0.2, 0.6);
            builder.sheet(4, 2, |row, column| {
                let t = row as f32 / 4.0;
                let belly = 4.0 * t * (1.0 - t) + 0.05;
                root + out * (length * t)
                    + side * (belly * (column as f32 - 1.0))
                    + Vec3::Y * (length * (0.5 * t - droop * t * t))
            });
        }
    }
}
