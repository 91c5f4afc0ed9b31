//! Roofs: solid wedges and the tiles that lie on them.

use glam::Vec3;

use super::builder::Builder;
use super::random::Random;

/// A gabled roof along x, solid: its eaves at `low`, its ridge over the middle at `high`.
pub(super) fn gable(builder: &mut Builder, [left, right]: [f32; 2], half: f32, [low, high]: [f32; 2]) {
    // Both upper edges are the ridge.
    builder.hexahedron(|i| {
        let z = if i >> 2 & 1 == 1 { half } else { -half };
        let x = if i & 1 == 1 { right } else { left };
        if i >> 1 & 1 == 1 { Vec3::new(x, high, 0.0) } else { Vec3::new(x, low, z) }
    });
}

/// Tiles on a sloping field, each a thin box that overlaps the one below; they are painted `shades` at
/// random.
///
/// `eave` and `ridge` go from left to right as seen from outside. `size` is a tile's width and the visible
/// part of its length.
pub(super) fn tiles(builder: &mut Builder, eave: [Vec3; 2], ridge: [Vec3; 2], size: f32, shades: [u32; 3]) {
    let slope = (ridge[0] + ridge[1] - eave[0] - eave[1]) / 2.0;
    let normal = (eave[1] - eave[0]).cross(slope).normalize_or(Vec3::Y);
    let rows = (slope.length() / size).round().max(1.0) as usize;
    let edge = |end: usize, row: f32| eave[end].lerp(ridge[end], row / rows as f32);
    for row in 0..rows {
        // Seeded by the slope's direction, so that fields differ.
        let mut random = Random::new(row as u32, (slope.x * 64.0 + slope.z * 8.0) as i32 as u32);
        let at = row as f32;
        let columns = (edge(0, at).distance(edge(1, at)) / size).round().max(1.0) as usize;
        // Every other row is shifted by half a tile.
        let shift = if row.is_multiple_of(2) { 0.0 } else { 0.5 };
        for column in 0..columns + row % 2 {
            let from = ((column as f32 - shift) / columns as f32).max(0.0);
            let to = ((column as f32 - shift + 0.95) / columns as f32).min(1.0);
            let upper = (at + 1.3).min(rows as f32);
            let lift = random.between(0.16, 0.22) * size;
            let material = shades[(random.unit() * 3.0) as usize % 3];
            let old = builder.paint(material);
            builder.hexahedron(|i| {
                let (row, lift) = if i >> 1 & 1 == 1 { (upper, 0.06 * size) } else { (at - 0.1, lift) };
                let across = if i & 1 == 1 { to } else { from };
                let out = lift - if i >> 2 & 1 == 1 { 0.0 } else { 0.12 * size };
                edge(0, row).lerp(edge(1, row), across) + normal * out
            });
            builder.paint(old);
        }
    }
}
