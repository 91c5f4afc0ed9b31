//! Columns, shafts, balusters and pots: solids turned around the y axis, standing at the origin.

use glam::{Vec2, Vec3};

use super::builder::Builder;
use super::shapes::{curve_to, turned};

/// Tessellation of round shapes, relative to the default.
#[derive(Clone, Copy)]
pub(super) struct Detail(pub(super) f32);

impl Detail {
    /// `count` divisions at detail 1, and never fewer than two.
    pub(super) fn steps(self, count: f32) -> usize {
        (count * self.0).round().max(2.0) as usize
    }

    /// `count` sides of something round at detail 1, and never fewer than five.
    pub(super) fn sides(self, count: f32) -> usize {
        (count * self.0).round().max(5.0) as usize
    }
}

/// A column with plinth, moulded base, tapered shaft, flared capital and square abacus (3.2 radii wide).
pub(super) fn column(radius: f32, height: f32, sides: f32, detail: Detail) -> Builder {
    let r = radius;
    let at = |x: f32, y: f32| Vec2::new(x * r, y * r);
    let top = |x: f32, below: f32| Vec2::new(x * r, height - below * r);
    let few = detail.steps(2.0);
    let mut profile = vec![at(1.3, 0.35)];
    curve_to(&mut profile, at(1.25, 0.75), 0.4, few);
    profile.push(at(1.12, 0.8));
    curve_to(&mut profile, at(1.1, 1.05), -0.25, few);
    curve_to(&mut profile, at(1.02, 1.4), 0.4, few);
    curve_to(&mut profile, top(0.85, 2.3), 0.006, detail.steps(3.0));
    curve_to(&mut profile, top(0.87, 2.05), 0.5, few);
    curve_to(&mut profile, top(1.1, 1.1), -0.1, detail.steps(2.0));
    curve_to(&mut profile, top(1.5, 0.7), -0.2, few);
    profile.push(top(1.5, 0.4));

    let mut builder = Builder::new();
    turned(&mut builder, &profile, detail.sides(sides));
    builder.block(Vec3::ZERO, Vec3::new(2.9 * r, 0.4 * r, 2.9 * r));
    // The slab overlaps the capital a little, and a thinner one under it makes a second step.
    builder.block(Vec3::Y * (height - 0.3 * r), Vec3::new(3.2 * r, 0.3 * r, 3.2 * r));
    builder.block(Vec3::Y * (height - 0.5 * r), Vec3::new(2.95 * r, 0.3 * r, 2.95 * r));
    leaves(&mut builder, r, height, detail);
    builder
}

/// Eight leaves that curl out of a capital under the corners and the middles of its slab.
fn leaves(builder: &mut Builder, r: f32, height: f32, detail: Detail) {
    let rows = detail.steps(2.0);
    for leaf in 0..8 {
        let (sin, cos) = (leaf as f32 / 8.0 * std::f32::consts::TAU).sin_cos();
        let reach = if leaf % 2 == 0 { 0.25 } else { 0.5 };
        builder.sheet(rows, 2, |row, column| {
            let t = row as f32 / rows as f32;
            // Up along the bell, then out and over.
            let out = (0.9 + reach * t * t + 0.12 * t) * r;
            let up = height + (-2.0 + 1.55 * t - 0.45 * t * t * t * t) * r;
            let across = (column as f32 - 1.0) * 0.26 * (1.0 - 0.6 * t * t) * r;
            let ridge = if column == 1 { 0.06 * r } else { 0.0 };
            let (x, z) = (out + ridge, -across);
            Vec3::new(cos * x - sin * z, up, sin * x + cos * z)
        });
    }
}

/// A slender shaft with a round base and a bell capital, to be set against a pier; no slab.
pub(super) fn shaft(radius: f32, height: f32, sides: f32, detail: Detail) -> Builder {
    let r = radius;
    let top = |x: f32, below: f32| Vec2::new(x * r, height - below * r);
    let few = detail.steps(2.0);
    let mut profile = vec![Vec2::new(1.6 * r, 0.0), Vec2::new(1.6 * r, 0.8 * r)];
    curve_to(&mut profile, Vec2::new(1.45 * r, 1.6 * r), 0.4, few);
    curve_to(&mut profile, Vec2::new(r, 2.2 * r), -0.2, few);
    profile.push(top(1.0, 3.6));
    curve_to(&mut profile, top(1.05, 3.2), 0.4, few);
    curve_to(&mut profile, top(1.6, 0.8), -0.15, detail.steps(3.0));
    profile.push(top(1.75, 0.6));
    profile.push(top(1.75, 0.0));
    profile.push(top(0.0, 0.0));
    let mut builder = Builder::new();
    turned(&mut builder, &profile, detail.sides(sides));
    builder
}

/// A vase-shaped baluster, a quarter as thick as it is high.
pub(super) fn baluster(height: f32, detail: Detail) -> Builder {
    let at = |x: f32, y: f32| Vec2::new(x, y) * height;
    let few = detail.steps(2.0);
    let mut profile = vec![at(0.085, 0.0), at(0.085, 0.08), at(0.05, 0.12)];
    curve_to(&mut profile, at(0.04, 0.62), 0.17, detail.steps(3.0));
    curve_to(&mut profile, at(0.07, 0.88), -0.08, few);
    profile.push(at(0.085, 0.92));
    profile.push(at(0.085, 1.0));
    let mut builder = Builder::new();
    turned(&mut builder, &profile, detail.sides(6.0));
    builder
}

/// A vessel of the given height: foot, belly, lip and a flat filling below the rim.
pub(super) fn pot(height: f32, sides: f32, detail: Detail) -> Builder {
    let at = |x: f32, y: f32| Vec2::new(x, y) * height;
    let few = detail.steps(2.0);
    let mut profile = vec![at(0.3, 0.0), at(0.3, 0.06)];
    curve_to(&mut profile, at(0.22, 0.14), -0.2, few);
    curve_to(&mut profile, at(0.4, 0.86), 0.16, detail.steps(6.0));
    profile.push(at(0.47, 0.9));
    profile.push(at(0.47, 1.0));
    profile.push(at(0.4, 1.0));
    profile.push(at(0.37, 0.9));
    profile.push(at(0.0, 0.9));
    let mut builder = Builder::new();
    turned(&mut builder, &profile, detail.sides(sides));
    builder
}
