//! Straight members that towers, trestles and toys are made of: bars, rods and laced girders, all of them
//! closed.

use std::f32::consts::TAU;

use glam::Vec3;

use super::builder::Builder;

/// Triangles of a [`bar`].
pub(super) const BAR: usize = 12;

/// Bar of rectangular section between two points: `width` along `side`, `depth` across it.
///
/// Only the component of `side` perpendicular to the bar is used.
pub(super) fn bar(builder: &mut Builder, ends: [Vec3; 2], side: Vec3, [width, depth]: [f32; 2]) {
    let axis = (ends[1] - ends[0]).normalize_or(Vec3::Y);
    let side = (side - axis * side.dot(axis)).normalize_or(axis.any_orthonormal_vector());
    let (across, deep) = (side * (width / 2.0), side.cross(axis) * (depth / 2.0));
    let sign = |i: usize, bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    builder.hexahedron(|i| ends[i >> 1 & 1] + across * sign(i, 0) + deep * sign(i, 2));
}

/// A round bar with flat ends: `4 × sides` triangles.
pub(super) fn rod(builder: &mut Builder, ends: [Vec3; 2], radius: f32, sides: usize) {
    let axis = (ends[1] - ends[0]).normalize_or(Vec3::Y);
    let across = axis.any_orthonormal_vector();
    let side = axis.cross(across);
    let rim = |end: usize, column: usize| {
        let (sin, cos) = (column as f32 / sides as f32 * TAU).sin_cos();
        ends[end] + (across * cos + side * sin) * radius
    };
    builder.ring(1, sides, rim);
    builder.ring(1, sides, |row, column| if row == 0 { ends[0] } else { rim(0, column) });
    builder.ring(1, sides, |row, column| if row == 1 { ends[1] } else { rim(1, column) });
}

/// A girder of two or four parallel bars with zigzag lacing between them.
#[derive(Clone, Copy)]
pub(super) struct Girder {
    pub(super) ends: [Vec3; 2],
    /// The direction in which a flat girder is wide.
    pub(super) side: Vec3,
    pub(super) width: f32,
    /// Two bars and one lacing instead of four and four.
    pub(super) flat: bool,
}

impl Girder {
    /// Number of triangles without lacing.
    fn least(&self) -> usize {
        if self.flat { 2 * BAR } else { 4 * BAR }
    }

    /// Weight of the girder when lacing is distributed.
    fn share(&self) -> f64 {
        let faces = if self.flat { 1.0 } else { 4.0 };
        f64::from(faces * self.ends[0].distance(self.ends[1]) / self.width)
    }

    fn build(&self, builder: &mut Builder, laces: usize) {
        let axis = (self.ends[1] - self.ends[0]).normalize_or(Vec3::Y);
        let side = (self.side - axis * self.side.dot(axis)).normalize_or(axis.any_orthonormal_vector());
        let (across, deep) = (side * (self.width / 2.0), side.cross(axis) * (self.width / 2.0));
        let line = |offset: Vec3| self.ends.map(|end| end + offset);
        let around: &[Vec3] = if self.flat {
            &[-across, across]
        } else {
            &[-across - deep, across - deep, across + deep, -across + deep]
        };
        let thick = 0.2 * self.width;
        for &offset in around {
            bar(builder, line(offset), side, [thick; 2]);
        }
        let faces = if self.flat { 1 } else { 4 };
        for face in 0..faces {
            let count = (laces + face) / faces;
            let (one, other) = (line(around[face]), line(around[(face + 1) % around.len()]));
            let out = (around[face] + around[(face + 1) % around.len()]).normalize_or(side.cross(axis));
            let node = |k: usize| {
                let [from, to] = if k.is_multiple_of(2) { one } else { other };
                from.lerp(to, k as f32 / count as f32)
            };
            for k in 0..count {
                bar(builder, [node(k), node(k + 1)], out, [0.08 * self.width, 0.1 * self.width]);
            }
        }
    }
}

/// Builds the girders with as much lacing as brings the builder to `triangles`, or none if it has as many
/// without.
///
/// The lacing is spread evenly over all girders, down to the single bar: the count is missed by less than one
/// bar.
pub(super) fn lace(builder: &mut Builder, girders: &[Girder], triangles: usize) {
    let least = builder.triangle_count() + girders.iter().map(Girder::least).sum::<usize>();
    let laces = (triangles.saturating_sub(least) / BAR) as f64;
    let whole: f64 = girders.iter().map(Girder::share).sum();
    let (mut share, mut done) = (0.0, 0);
    for (index, girder) in girders.iter().enumerate() {
        share += girder.share();
        // The last girder gets the remainder of rounding.
        let due = if index + 1 == girders.len() { laces } else { laces * share / whole } as usize;
        girder.build(builder, due - done);
        done = due;
    }
}
