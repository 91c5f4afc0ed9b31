//! Shapes of toys, closed and one unit across, each tessellated to a number of triangles.

use std::f32::consts::{FRAC_PI_4, PI, TAU};

use glam::{Vec2, Vec3};

use super::builder::Builder;
use super::shapes::turned;

/// A cube around the origin with rounded edges.
pub(super) fn block(builder: &mut Builder, triangles: f32) {
    const HALF: f32 = 0.5;
    const ROUND: f32 = 0.07;
    // Six faces of (2 · steps + 1)² quads: a flat middle and steps round the edges.
    let steps = (((triangles / 12.0).sqrt() - 1.0) / 2.0).round().max(0.0) as usize;
    let cells = 2 * steps + 1;
    // Corners of cells on a cube with sharp edges, placed so that they have even angles once it is rounded.
    let line = |i: usize| {
        let far = if i <= steps { steps - i } else { i - steps - 1 };
        let out = if steps == 0 { 0.0 } else { (far as f32 / steps as f32 * FRAC_PI_4).tan() };
        let place = if steps == 0 || far == steps { HALF } else { HALF - ROUND + out * ROUND };
        if i <= steps { -place } else { place }
    };
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            builder.sheet(cells, cells, |row, column| {
                let cell = if side > 0.0 { [column, row] } else { [row, column] };
                let [across, up] = cell.map(line);
                let mut on_cube = Vec3::ZERO;
                on_cube[axis] = side * HALF;
                on_cube[(axis + 1) % 3] = across;
                on_cube[(axis + 2) % 3] = up;
                if steps == 0 {
                    return on_cube;
                }
                let core = on_cube.clamp(Vec3::splat(ROUND - HALF), Vec3::splat(HALF - ROUND));
                core + (on_cube - core).normalize_or_zero() * ROUND
            });
        }
    }
}

/// A ball around the origin.
pub(super) fn ball(builder: &mut Builder, triangles: f32) {
    // 2n sides and n rows, the first and the last of which are triangles: 4n (n - 1).
    let n = (0.5 + (0.25 + triangles / 4.0).sqrt()).round().max(3.0) as usize;
    let profile: Vec<Vec2> = (0..=n)
        .map(|row| {
            let (sin, cos) = (PI * row as f32 / n as f32).sin_cos();
            Vec2::new(if row == 0 || row == n { 0.0 } else { 0.5 * sin }, -0.5 * cos)
        })
        .collect();
    turned(builder, &profile, 2 * n);
}

/// Appends points from the profile's end, in `rows` even steps, to `end`.
fn line_to(profile: &mut Vec<Vec2>, end: Vec2, rows: usize) {
    let Some(&start) = profile.last() else { return };
    profile.extend((1..=rows).map(|row| start.lerp(end, row as f32 / rows as f32)));
}

/// A cone around the y axis with a wide brim, like those on roads.
pub(super) fn cone(builder: &mut Builder, triangles: f32) {
    // Rows of 2n triangles, up to n / 2 + 5.
    let n = ((triangles + 20.0).sqrt() - 3.0).round().max(6.0) as usize;
    let mut profile = vec![Vec2::new(0.0, -0.5)];
    for (x, y, rows) in [
        (0.5, -0.5, 1),
        (0.5, -0.44, 1),
        (0.36, -0.44, 1),
        (0.05, 0.48, n / 2),
        (0.03, 0.5, 1),
        (0.0, 0.5, 1),
    ] {
        line_to(&mut profile, Vec2::new(x, y), rows);
    }
    turned(builder, &profile, n);
}

/// A cylinder around the y axis with bevelled edges.
pub(super) fn drum(builder: &mut Builder, triangles: f32) {
    let n = ((triangles + 9.0).sqrt() - 3.0).round().max(6.0) as usize;
    let mut profile = vec![Vec2::new(0.0, -0.5)];
    for (x, y, rows) in [(0.44, -0.5, 1), (0.5, -0.45, 1), (0.5, 0.45, n / 2), (0.44, 0.5, 1), (0.0, 0.5, 1)]
    {
        line_to(&mut profile, Vec2::new(x, y), rows);
    }
    turned(builder, &profile, n);
}

/// A ring around the y axis, a sixth of its width thick.
pub(super) fn ring(builder: &mut Builder, triangles: f32) {
    let n = ((triangles / 4.0).sqrt()).round().max(4.0) as usize;
    let r = 1.0 / 12.0;
    // Begins and ends on the inside, at exactly one point.
    let profile: Vec<Vec2> = (0..=n)
        .map(|i| {
            let (sin, cos) = (TAU * (i % n) as f32 / n as f32).sin_cos();
            Vec2::new(0.5 - r - r * cos, -r * sin)
        })
        .collect();
    turned(builder, &profile, 2 * n);
}

/// A car along x on y = 0: a body, a cabin, four wheels and two lamps.
pub(super) fn car(builder: &mut Builder, triangles: f32, [body, rubber, glass]: [u32; 3]) {
    let share = triangles / 9.0;
    let part = |material: u32, shape: fn(&mut Builder, f32), triangles: f32| {
        let mut part = Builder::new();
        part.paint(material);
        shape(&mut part, triangles);
        part
    };
    // Lower at the front than behind.
    builder.place(&part(body, block, 1.5 * share), |p| {
        Vec3::new(p.x, 0.2 + p.y * (0.22 - 0.05 * p.x), p.z * (0.44 - 0.06 * p.x))
    });
    builder.place(&part(glass, block, 1.5 * share), |p| {
        let taper = 0.8 - 0.35 * p.y;
        Vec3::new(-0.06 + p.x * 0.58 * taper, 0.38 + 0.2 * p.y, p.z * 0.4 * taper)
    });
    let wheel = part(rubber, drum, share);
    for (x, z) in [(-0.3, 0.21), (0.3, 0.21), (-0.3, -0.21), (0.3, -0.21)] {
        builder.place(&wheel, |p| Vec3::new(x + 0.24 * p.x, 0.12 - 0.24 * p.z, z + 0.1 * p.y));
    }
    let lamp = part(glass, ball, share);
    for z in [-0.13, 0.13] {
        builder.place(&lamp, |p| Vec3::new(0.49, 0.22, z) + p * 0.08);
    }
}
