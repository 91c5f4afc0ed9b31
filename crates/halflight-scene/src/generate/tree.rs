//! A broad-leaved tree on a patch of ground: trunk, branches and twigs as tapered tubes, leaves as folded
//! quads.

use std::f32::consts::TAU;

use glam::Vec3;
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::parameters::Parameters;
use super::random::Random;
use super::shapes::tube;

const GROUND: u32 = 0;
const BARK: u32 = 1;
const LEAVES: [u32; 3] = [2, 3, 4];
const PALETTE: [[f32; 3]; 5] =
    [[0.55, 0.50, 0.42], [0.30, 0.22, 0.16], [0.22, 0.42, 0.12], [0.30, 0.48, 0.14], [0.16, 0.34, 0.10]];

/// Growth parameters of the branches of one order: the trunk first, twigs last.
struct Order {
    /// Points along a branch, and sides of its tube.
    points: usize,
    sides: usize,
    /// Number of branches of the next order that leave it, and the relative position of the first.
    children: u32,
    from: f32,
    /// Length and radius of a child relative to its parent's, and the angle between them in degrees.
    length: f32,
    radius: f32,
    angle_deg: f32,
    /// Crookedness, and upward (or, negative, downward) curvature.
    bend: f32,
    rise: f32,
}

const ORDERS: [Order; 5] = [
    Order {
        points: 12,
        sides: 16,
        children: 15,
        from: 0.3,
        length: 0.62,
        radius: 0.5,
        angle_deg: 58.0,
        bend: 0.05,
        rise: 0.1,
    },
    Order {
        points: 10,
        sides: 10,
        children: 12,
        from: 0.2,
        length: 0.48,
        radius: 0.5,
        angle_deg: 48.0,
        bend: 0.14,
        rise: 0.08,
    },
    Order {
        points: 8,
        sides: 6,
        children: 9,
        from: 0.15,
        length: 0.5,
        radius: 0.5,
        angle_deg: 45.0,
        bend: 0.16,
        rise: 0.05,
    },
    Order {
        points: 5,
        sides: 3,
        children: 5,
        from: 0.2,
        length: 0.6,
        radius: 0.55,
        angle_deg: 42.0,
        bend: 0.2,
        rise: 0.0,
    },
    Order {
        points: 4,
        sides: 3,
        children: 0,
        from: 0.0,
        length: 0.0,
        radius: 0.0,
        angle_deg: 0.0,
        bend: 0.2,
        rise: -0.1,
    },
];

/// A tree about 9 m high; `leaves` is the number of leaves on each of its about 8,000 twigs.
pub(super) fn tree(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let leaves = parameters.count("leaves", 12, 0..=64)?;
    let seed = parameters.count("seed", 4, 0..=u32::MAX)?;
    parameters.finish()?;
    let mut tree = Tree { builder: Builder::new(), leaves, seed, grown: 0 };
    tree.builder.paint(GROUND);
    tree.builder.floor(40.0, 16);
    // The trunk starts below the ground.
    tree.grow(0, Vec3::Y * -0.15, Vec3::Y, 6.6, 0.34);
    Ok(tree.builder.finish(&PALETTE))
}

struct Tree {
    builder: Builder,
    leaves: u32,
    seed: u32,
    /// Number of branches so far: each has its own random numbers.
    grown: u32,
}

impl Tree {
    fn grow(&mut self, index: usize, foot: Vec3, direction: Vec3, length: f32, radius: f32) {
        let Some(order) = ORDERS.get(index) else { return };
        let mut random = Random::new(self.seed, self.grown);
        self.grown += 1;
        let mut heading = direction;
        let mut point = foot;
        let path: Vec<(Vec3, f32)> = (0..order.points)
            .map(|i| {
                let t = i as f32 / (order.points - 1) as f32;
                if i > 0 {
                    heading = (heading + random.direction() * order.bend + Vec3::Y * order.rise)
                        .normalize_or(heading);
                    point += heading * (length / (order.points - 1) as f32);
                }
                // The trunk's foot is wider.
                let flare = if index == 0 { 1.0 + 0.8 * (-14.0 * t).exp() } else { 1.0 };
                let tip = i + 1 == order.points;
                (point, if tip { 0.0 } else { radius * flare * (1.0 - 0.8 * t) })
            })
            .collect();
        self.builder.paint(BARK);
        tube(&mut self.builder, &path, order.sides);
        if order.children == 0 {
            self.foliage(&mut random, &path);
        }
        let turn = random.unit() * TAU;
        for child in 0..order.children {
            let share = (child as f32 + random.unit()) / order.children as f32;
            let t = order.from + (0.97 - order.from) * share;
            let (base, along, here) = at(&path, t);
            // The golden angle keeps neighbouring branches apart.
            let around = turn + child as f32 * 2.399_963 + random.between(-0.4, 0.4);
            let side = along.any_orthonormal_vector();
            let away = side * around.cos() + along.cross(side) * around.sin();
            // Branches further up are shorter and steeper: this rounds the crown.
            let angle = (order.angle_deg * random.between(0.8, 1.2) * (1.15 - 0.4 * t)).to_radians();
            let reach = order.length * random.between(0.8, 1.15) * (1.25 - 0.65 * t);
            let child_radius = (radius * order.radius * (1.1 - 0.5 * t)).min(0.9 * here);
            self.grow(
                index + 1,
                base,
                along * angle.cos() + away * angle.sin(),
                length * reach,
                child_radius.max(0.003),
            );
        }
    }

    /// Leaves along a twig, each a quad folded along its middle (two triangles).
    fn foliage(&mut self, random: &mut Random, twig: &[(Vec3, f32)]) {
        for leaf in 0..self.leaves {
            let t = 0.15 + 0.85 * (leaf as f32 + random.unit()) / self.leaves as f32;
            let (base, along, _) = at(twig, t.min(1.0));
            let spread = random.direction();
            let out = (along * 0.6 + spread + Vec3::Y * -0.25).normalize_or(along);
            // Leaves face roughly upwards.
            let face = (Vec3::Y + random.direction() * 0.7).normalize_or(Vec3::Y);
            let across = out.cross(face).normalize_or(out.any_orthonormal_vector());
            let length = random.between(0.09, 0.15);
            let half = across * (0.3 * length);
            let up = across.cross(out) * (0.08 * length);
            let (middle, tip) = (base + out * (0.5 * length), base + out * length);
            self.builder.paint(LEAVES[(random.unit() * 3.0) as usize % 3]);
            // Folded along the line from base to tip.
            self.builder.quad([base, middle + half + up, tip, middle - half + up]);
        }
    }
}

/// Position, direction and radius at `t` of a path, 0 at its start and 1 at its end.
fn at(path: &[(Vec3, f32)], t: f32) -> (Vec3, Vec3, f32) {
    let last = path.len() - 1;
    let scaled = t * last as f32;
    let i = (scaled as usize).min(last - 1);
    let (a, b) = (path[i], path[i + 1]);
    let fraction = scaled - i as f32;
    (a.0.lerp(b.0, fraction), (b.0 - a.0).normalize_or(Vec3::Y), a.1 + (b.1 - a.1) * fraction)
}
