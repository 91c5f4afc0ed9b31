//! A roller-coaster: a closed track of two rails on sleepers, carried by braced bents, with a train and a
//! station.

use glam::Vec3;
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::bars::{bar, rod};
use super::builder::Builder;
use super::parameters::Parameters;
use super::track::{Place, Track};

const FLOOR: u32 = 0;
const RAIL: u32 = 1;
const TIMBER: u32 = 2;
const SLEEPER: u32 = 3;
const CAR: u32 = 4;
const SEAT: u32 = 5;
const CONCRETE: u32 = 6;
const PALETTE: [[f32; 3]; 7] = [
    [0.62, 0.62, 0.56],
    [0.66, 0.14, 0.10],
    [0.76, 0.72, 0.66],
    [0.36, 0.26, 0.18],
    [0.14, 0.30, 0.58],
    [0.12, 0.11, 0.10],
    [0.50, 0.49, 0.47],
];

/// Triangles by default.
const TRIANGLES: u32 = 1_096_000;
/// Half the distance between the rails, and between the posts of a bent.
const GAUGE: f32 = 0.5;
const POSTS: f32 = 0.75;
/// Distance from the midpoint between the rails down to the top of a bent.
const UNDER: f32 = 0.34;
/// Clearance that the track needs above it.
const CLEAR: f32 = 2.2;
/// Sides of struts and of rails.
const SIDES: usize = 12;
const RAIL_SIDES: usize = 12;

/// Coaster 56 m long and 15 m high with very nearly `triangles` triangles. A larger number makes more bents
/// with more, thinner struts; the remainder subdivides the rails.
pub(super) fn coaster(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let triangles = parameters.count("triangles", TRIANGLES, 100_000..=3_000_000)? as usize;
    parameters.finish()?;
    let fineness = (triangles as f32 / TRIANGLES as f32).sqrt();
    let mut builder = Builder::new();
    builder.paint(FLOOR);
    builder.floor(120.0, 16);
    let track = Track::new();
    trestle(&mut builder, &track, fineness);
    sleepers(&mut builder, &track, fineness);
    train(&mut builder, &track);
    station(&mut builder);
    // A ring of both rails is `4 × RAIL_SIDES` triangles; struts leave thousands of rings at every count.
    let rings = triangles.saturating_sub(builder.triangle_count()) / (4 * RAIL_SIDES);
    rails(&mut builder, &track, rings.max(3));
    Ok(builder.finish(&PALETTE))
}

/// Support of the track at one position: two posts from `foot` up to `tops`, left and right.
struct Bent {
    middle: Vec3,
    side: Vec3,
    foot: f32,
    tops: [f32; 2],
}

impl Bent {
    fn new(track: &Track, place: &Place, length: f32) -> Self {
        let side = place.level_side();
        let lean = place.side.y / place.side.dot(side) * POSTS;
        let y = place.middle.y - UNDER;
        // Bents above another stretch of the track are suspended from their neighbours.
        let below = track.highest_below(place, length, POSTS + GAUGE + 0.6, CLEAR);
        let foot = below.map_or(-0.1, |height| height + CLEAR);
        Self {
            middle: Vec3::new(place.middle.x, 0.0, place.middle.z),
            side,
            foot,
            tops: [y - lean, y + lean],
        }
    }

    fn at(&self, post: usize, y: f32) -> Vec3 {
        self.middle + self.side * [-POSTS, POSTS][post] + Vec3::Y * y
    }

    /// True if there is room for a strut at this height.
    fn reaches(&self, y: f32) -> bool {
        y >= self.foot.max(0.0) && self.tops.iter().all(|&top| y < top)
    }
}

/// Bents along the track, braced across and along, storey by storey.
fn trestle(builder: &mut Builder, track: &Track, fineness: f32) {
    let count = (track.length() * fineness / 0.68).round() as usize;
    let storey = 0.85 / fineness;
    let radius = 0.05 * fineness.powf(-0.5);
    let thin = 0.6 * radius;
    let bents: Vec<Bent> = (0..count)
        .map(|i| {
            let length = track.length() * i as f32 / count as f32;
            Bent::new(track, &track.at(length), length)
        })
        .collect();
    for (i, bent) in bents.iter().enumerate() {
        let next = &bents[(i + 1) % count];
        for post in 0..2 {
            builder.paint(TIMBER);
            if bent.tops[post] - bent.foot > 0.2 {
                rod(builder, [bent.at(post, bent.foot), bent.at(post, bent.tops[post])], radius, SIDES);
            }
            if bent.foot < 0.0 {
                builder.paint(CONCRETE);
                builder.block(bent.at(post, -0.1), Vec3::new(5.0 * radius, 0.25, 5.0 * radius));
            }
        }
        builder.paint(TIMBER);
        // Under the sleepers: a beam across, and one along on each side.
        let top = |bent: &Bent, post: usize| bent.at(post, bent.tops[post]);
        rod(builder, [top(bent, 0), top(bent, 1)], radius, SIDES);
        for post in 0..2 {
            between(builder, [top(bent, post), top(next, post)], radius);
        }
        let mut level = 1;
        while level as f32 * storey < bent.tops[0].max(bent.tops[1]) {
            let y = level as f32 * storey;
            let low = y - storey;
            level += 1;
            if !bent.reaches(y) || (low > 0.0 && !bent.reaches(low)) {
                continue;
            }
            // The braces cross in two planes, before and behind the posts.
            let off = bent.side.cross(Vec3::Y) * (radius + thin);
            rod(builder, [bent.at(0, y), bent.at(1, y)], thin, SIDES);
            rod(builder, [bent.at(0, low) + off, bent.at(1, y) + off], thin, SIDES);
            rod(builder, [bent.at(1, low) - off, bent.at(0, y) - off], thin, SIDES);
            if !next.reaches(y) || (low > 0.0 && !next.reaches(low)) {
                continue;
            }
            for post in 0..2 {
                between(builder, [bent.at(post, y), next.at(post, y)], thin);
                let [from, to] = if (i + level).is_multiple_of(2) { [low, y] } else { [y, low] };
                between(builder, [bent.at(post, from), next.at(post, to)], thin);
            }
        }
    }
}

/// A strut between two posts. It ends inside them, so that no end meets that of the next strut.
fn between(builder: &mut Builder, ends: [Vec3; 2], radius: f32) {
    let short = (ends[1] - ends[0]).normalize_or_zero() * (0.5 * radius);
    rod(builder, [ends[0] + short, ends[1] - short], radius, SIDES);
}

fn sleepers(builder: &mut Builder, track: &Track, fineness: f32) {
    let count = (track.length() * fineness / 0.35).round() as usize;
    builder.paint(SLEEPER);
    for i in 0..count {
        let place = track.at(track.length() * i as f32 / count as f32);
        let middle = place.middle - place.up * 0.16;
        let half = place.side * (POSTS + 0.15);
        bar(builder, [middle - half, middle + half], place.ahead, [0.14, 0.12]);
    }
}

/// Two closed tubes of `rings` rings each.
fn rails(builder: &mut Builder, track: &Track, rings: usize) {
    const RADIUS: f32 = 0.07;
    builder.paint(RAIL);
    for side in [-1.0, 1.0] {
        builder.ring(rings, RAIL_SIDES, |row, column| {
            let place = track.at(track.length() * (row % rings) as f32 / rings as f32);
            let (sin, cos) = (column as f32 / RAIL_SIDES as f32 * std::f32::consts::TAU).sin_cos();
            place.middle + place.side * (side * GAUGE + RADIUS * cos) + place.up * (RADIUS * sin)
        });
    }
}

/// Five cars on the way down from the second hill.
fn train(builder: &mut Builder, track: &Track) {
    for car in 0..5 {
        let place = track.at(track.length() * 0.475 - 2.3 * car as f32);
        let at = |x: f32, y: f32, z: f32| place.middle + place.ahead * x + place.up * y + place.side * z;
        let mut beam = |material: u32, [from, to]: [f32; 2], y: f32, z: f32, size: [f32; 2]| {
            builder.paint(material);
            bar(builder, [at(from, y, z), at(to, y, z)], place.side, size);
        };
        beam(CAR, [-1.0, 1.0], 0.28, 0.0, [1.1, 0.22]);
        beam(CAR, [0.7, 1.05], 0.55, 0.0, [1.0, 0.6]);
        for z in [-0.5, 0.5] {
            beam(CAR, [-0.95, 0.8], 0.52, z, [0.08, 0.4]);
        }
        for x in [-0.85, 0.05] {
            beam(SEAT, [x, x + 0.16], 0.8, 0.0, [0.9, 0.95]);
            beam(SEAT, [x + 0.1, x + 0.55], 0.45, 0.0, [0.9, 0.16]);
        }
        for (x, z) in [(-0.7, -GAUGE), (0.7, -GAUGE), (-0.7, GAUGE), (0.7, GAUGE)] {
            builder.paint(SEAT);
            let half = place.side * 0.06;
            rod(builder, [at(x, 0.19, z) - half, at(x, 0.19, z) + half], 0.13, 16);
        }
    }
}

/// A platform beside the level track under a flat roof.
fn station(builder: &mut Builder) {
    let middle = Vec3::new(-12.0, 0.0, 17.6);
    builder.paint(CONCRETE);
    builder.block(middle - Vec3::Y * 0.1, Vec3::new(12.0, 1.8, 3.0));
    for step in 0..6 {
        let k = step as f32;
        let foot = middle + Vec3::new(-6.0 - 0.15 - 0.3 * k, -0.1, 0.3);
        builder.block(foot, Vec3::new(0.3, 1.55 - 0.26 * k, 1.6));
    }
    builder.paint(SLEEPER);
    builder.block(middle + Vec3::new(0.0, 4.4, 0.0), Vec3::new(12.0, 0.14, 2.9));
    for post in 0..5 {
        let foot = middle + Vec3::new(-5.6 + 2.8 * post as f32, 1.6, 1.1);
        rod(builder, [foot, foot + Vec3::Y * 2.9], 0.09, 16);
    }
}
