//! Many small toys strewn over a floor, some of them piled up: blocks, balls, cones, drums, rings and cars.
//!
//! [`strew`] places the toys, [`build`] tessellates each with the triangles that are left.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Quat, Vec2, Vec3};
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::parameters::Parameters;
use super::random::Random;
use super::toy_shapes::{ball, block, car, cone, drum, ring};

const FLOOR: u32 = 0;
const COLOURS: u32 = 7;
/// Tyres of cars, after the colours.
const RUBBER: u32 = 8;
const GLASS: u32 = 9;
const PALETTE: [[f32; 3]; 10] = [
    [0.72, 0.68, 0.60],
    [0.75, 0.16, 0.13],
    [0.85, 0.58, 0.10],
    [0.16, 0.32, 0.68],
    [0.20, 0.52, 0.22],
    [0.80, 0.76, 0.70],
    [0.55, 0.30, 0.60],
    [0.62, 0.44, 0.26],
    [0.08, 0.08, 0.08],
    [0.45, 0.60, 0.68],
];

/// Triangles by default, and how many toys they make.
const TRIANGLES: u32 = 263_000;
const TOYS: f32 = 420.0;
/// The radius in metres of the round patch that the toys cover.
const PATCH: f32 = 2.6;
/// Depth by which toys reach into their support, so that no two faces coincide.
const SUNK: f32 = 0.004;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Block,
    Ball,
    Cone,
    Drum,
    Ring,
    Car,
}

/// One toy: a shape around the origin, one unit across, that is stretched, turned and moved.
#[derive(Clone, Copy)]
struct Toy {
    kind: Kind,
    colour: u32,
    size: Vec3,
    turn: Quat,
    middle: Vec3,
}

/// Toys at one position and the radius of the circle that they need.
struct Group {
    toys: Vec<Toy>,
    radius: f32,
}

/// Toys with very nearly `triangles` triangles in total, in a round patch on a floor 14 m wide.
///
/// Four times the triangles make twice as many toys, smaller ones, of twice as many triangles each.
pub(super) fn toys(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let triangles = parameters.count("triangles", TRIANGLES, 10_000..=3_000_000)? as usize;
    let seed = parameters.count("seed", 1, 0..=u32::MAX)?;
    parameters.finish()?;
    let mut builder = Builder::new();
    builder.paint(FLOOR);
    builder.floor(14.0, 8);
    let count = TOYS * (triangles as f32 / TRIANGLES as f32).sqrt();
    build(&mut builder, &strew(seed, count as usize), triangles);
    Ok(builder.finish(&PALETTE))
}

/// At least `count` toys, spread over the patch.
fn strew(seed: u32, count: usize) -> Vec<Toy> {
    let mut random = Random::new(seed, 0);
    let mut groups = Vec::new();
    let mut found = 0;
    while found < count {
        let group = group(&mut random);
        found += group.toys.len();
        groups.push(group);
    }
    // Large ones first: small ones find room between them.
    groups.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let area: f32 = groups.iter().map(|group| group.radius * group.radius).sum();
    let mut patch = (area / 0.45).sqrt();
    let mut places: Vec<(Vec2, f32)> = Vec::with_capacity(groups.len());
    for group in &groups {
        loop {
            let place = Vec2::from_angle(random.unit() * TAU) * (patch * random.unit().sqrt());
            let free = places.iter().all(|(other, radius)| place.distance(*other) > radius + group.radius);
            if free {
                places.push((place, group.radius));
                break;
            }
            // The patch grows slowly, so that it is well filled.
            patch *= 1.0005;
        }
    }
    let scale = PATCH / patch;
    let mut toys = Vec::with_capacity(found);
    for (group, (place, _)) in groups.iter().zip(places) {
        let turn = Quat::from_rotation_y(random.unit() * TAU);
        toys.extend(group.toys.iter().map(|toy| Toy {
            size: toy.size * scale,
            turn: turn * toy.turn,
            middle: (turn * toy.middle + Vec3::new(place.x, -SUNK, place.y)) * scale,
            ..*toy
        }));
    }
    toys
}

/// A toy by itself or a pile, standing on y = 0 around the origin, about one unit across.
fn group(random: &mut Random) -> Group {
    let s = random.between(0.75, 1.25);
    let colour = 1 + (random.unit() * COLOURS as f32) as u32 % COLOURS;
    let mut toys = Vec::new();
    let mut add = |kind, size: [f32; 3], turn, middle: [f32; 3]| {
        let colour = 1 + (colour - 1 + 3 * toys.len() as u32) % COLOURS;
        let (size, middle) = (Vec3::from_array(size) * s, Vec3::from_array(middle) * s);
        toys.push(Toy { kind, colour, size, turn, middle });
    };
    let upright = Quat::IDENTITY;
    let lying = Quat::from_rotation_x(FRAC_PI_2);
    let radius = match (random.unit() * 24.0) as u32 {
        0..=2 => {
            add(Kind::Block, [1.0; 3], upright, [0.0, 0.5, 0.0]);
            0.75
        }
        3 => {
            add(Kind::Block, [1.5, 0.5, 0.75], upright, [0.0, 0.25, 0.0]);
            0.85
        }
        4..=7 => {
            add(Kind::Ball, [0.9; 3], upright, [0.0, 0.45, 0.0]);
            0.5
        }
        8..=9 => {
            add(Kind::Cone, [0.9, 1.3, 0.9], upright, [0.0, 0.65, 0.0]);
            0.55
        }
        10..=11 => {
            add(Kind::Drum, [0.8, 0.9, 0.8], upright, [0.0, 0.45, 0.0]);
            0.5
        }
        12 => {
            add(Kind::Drum, [0.6, 1.4, 0.6], lying, [0.0, 0.3, 0.0]);
            0.8
        }
        13..=14 => {
            // The ring's section is a sixth of its width.
            add(Kind::Ring, [1.2, 1.2, 1.2], upright, [0.0, 0.1, 0.0]);
            0.65
        }
        15..=16 => {
            add(Kind::Car, [1.8; 3], upright, [0.0; 3]);
            1.05
        }
        17..=18 => {
            // A tower of blocks, each turned a little against the one below.
            let floors = 3 + (random.unit() * 3.0) as usize;
            let mut low = 0.0;
            for floor in 0..floors {
                let side = 0.95 - 0.1 * floor as f32;
                let shift = [random.between(-0.07, 0.07), random.between(-0.07, 0.07)];
                let turn = Quat::from_rotation_y(random.between(-0.4, 0.4));
                add(Kind::Block, [side; 3], turn, [shift[0], low + side / 2.0, shift[1]]);
                low += side - SUNK;
            }
            0.8
        }
        19 => {
            // Three balls that touch, and a fourth on top.
            let r = 0.45;
            for ball in 0..3 {
                let (sin, cos) = (ball as f32 * TAU / 3.0).sin_cos();
                let out = 2.0 * r / 3.0_f32.sqrt();
                add(Kind::Ball, [2.0 * r; 3], upright, [out * cos, r, out * sin]);
            }
            add(Kind::Ball, [2.0 * r; 3], upright, [0.0, r + 2.0 * r * (2.0_f32 / 3.0).sqrt(), 0.0]);
            1.0
        }
        20 => {
            // Six logs, three, two and one.
            let r = 0.26;
            for row in 0..3 {
                for log in 0..3 - row {
                    let x = (2 * log + row) as f32 * r - 2.0 * r;
                    let y = r + row as f32 * r * 3.0_f32.sqrt();
                    add(Kind::Drum, [2.0 * r, 1.7, 2.0 * r], lying, [x, y, 0.0]);
                }
            }
            1.15
        }
        21 => {
            // A gate: two blocks, a beam across them and a cone on it.
            for x in [-0.75, 0.75] {
                add(Kind::Block, [0.55, 1.3, 0.55], upright, [x, 0.65, 0.0]);
            }
            add(Kind::Block, [2.1, 0.35, 0.6], upright, [0.0, 1.475 - SUNK, 0.0]);
            add(Kind::Cone, [0.6, 0.8, 0.6], upright, [0.0, 2.05 - 2.0 * SUNK, 0.0]);
            1.15
        }
        22 => {
            // A board that leans on a block's edge, half a right angle steep.
            add(Kind::Block, [1.0; 3], upright, [-0.6, 0.5, 0.0]);
            let (long, thick) = (1.7, 0.14);
            let (u, n) = (Vec2::new(-0.5, 0.5), Vec2::new(0.5, 0.5) * thick);
            let middle = Vec2::new(0.9, 0.0) + u * long + n / std::f32::consts::SQRT_2;
            let turn = Quat::from_rotation_z(-FRAC_PI_2 / 2.0);
            add(Kind::Block, [long * std::f32::consts::SQRT_2, thick, 0.8], turn, [middle.x, middle.y, 0.0]);
            1.35
        }
        _ => {
            // Rings on a post, a ball on top.
            add(Kind::Drum, [0.36, 1.35, 0.36], upright, [0.0, 0.675, 0.0]);
            let mut low = 0.0;
            for ring in 0..5 {
                let width = 1.3 - 0.14 * ring as f32;
                add(Kind::Ring, [width; 3], upright, [0.0, low + width / 12.0, 0.0]);
                low += width / 6.0 - SUNK;
            }
            add(Kind::Ball, [0.5; 3], upright, [0.0, 1.5, 0.0]);
            0.7
        }
    };
    Group { toys, radius: radius * s }
}

fn build(builder: &mut Builder, toys: &[Toy], triangles: usize) {
    // A car has many parts.
    let weight = |toy: &Toy| if toy.kind == Kind::Car { 4 } else { 1 };
    let mut weights: usize = toys.iter().map(weight).sum();
    for toy in toys {
        // Triangles that one toy's shape cannot use, or uses in excess, are shared by the following ones.
        let left = triangles.saturating_sub(builder.triangle_count());
        let budget = (left * weight(toy) / weights) as f32;
        weights -= weight(toy);
        let mut part = Builder::new();
        part.paint(toy.colour);
        match toy.kind {
            Kind::Block => block(&mut part, budget),
            Kind::Ball => ball(&mut part, budget),
            Kind::Cone => cone(&mut part, budget),
            Kind::Drum => drum(&mut part, budget),
            Kind::Ring => ring(&mut part, budget),
            Kind::Car => car(&mut part, budget, [toy.colour, RUBBER, GLASS]),
        }
        builder.place(&part, |p| toy.middle + toy.turn * (p * toy.size));
    }
}
