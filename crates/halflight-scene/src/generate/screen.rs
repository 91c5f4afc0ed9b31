//! Generated textures of lights: what a screen shows, as a still or as a film that repeats without a seam.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

/// Names of the patterns.
pub(crate) const PATTERNS: [&str; 2] = ["checkerboard", "meadow"];

/// Patterns in the order of their names: linear colour at a point, in heights of the screen from its lower left, and at a time in periods.
const COLOURS: [fn(Vec2, f32) -> Vec3; PATTERNS.len()] = [checkerboard, meadow];

/// Width and height of the textures, texels.
pub(crate) const SIZE: [u32; 2] = [160, 90];

/// Side of a square of the checkerboard, heights of the screen.
const SQUARE: f32 = 1.0 / 9.0;

/// Sub-samples along each side of a texel.
const SUBSAMPLES: u32 = 2;

/// Linear texels of frame `frame` of `frames` of a pattern, row by row from the top; `None` for a name that is not known.
pub(crate) fn texels(pattern: &str, frame: u32, frames: u32) -> Option<Vec<Vec3>> {
    let colour = COLOURS[PATTERNS.iter().position(|known| *known == pattern)?];
    let [width, height] = SIZE;
    let time = frame as f32 / frames.max(1) as f32;
    let count = SUBSAMPLES * SUBSAMPLES;
    let texel = |index: u32| {
        let (x, y) = (index % width, index / width);
        let sum = (0..count).map(|sample| {
            let inside = |number: u32| (number as f32 + 0.5) / SUBSAMPLES as f32;
            let (right, down) =
                (x as f32 + inside(sample % SUBSAMPLES), y as f32 + inside(sample / SUBSAMPLES));
            colour(Vec2::new(right, height as f32 - down) / height as f32, time)
        });
        sum.sum::<Vec3>() / count as f32
    };
    Some((0..width * height).map(texel).collect())
}

/// Black and white squares that move to the right, by two in a period.
fn checkerboard(at: Vec2, time: f32) -> Vec3 {
    let (column, row) = ((at.x / SQUARE - 2.0 * time).floor(), (at.y / SQUARE).floor());
    if (column + row).rem_euclid(2.0) == 0.0 { Vec3::ONE } else { Vec3::ZERO }
}

/// 0 below `low`, 1 above `high` and smooth between them.
fn step(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Hills that pass by below a low sun and clouds, and a balloon that crosses the picture.
fn meadow(at: Vec2, time: f32) -> Vec3 {
    let wave = |cycles: f32, turns: f32| (TAU * (at.x * cycles + turns * time)).sin();
    let mut colour = Vec3::new(0.52, 0.70, 0.95).lerp(Vec3::new(0.07, 0.22, 0.70), at.y);
    let sun = at.distance(Vec2::new(1.36, 0.74));
    colour += Vec3::new(0.75, 0.50, 0.20) * (-sun * sun / 0.04).exp();
    colour = colour.lerp(Vec3::new(1.0, 0.92, 0.70), 1.0 - step(0.065, 0.08, sun));
    // Clouds leave on the right and come back on the left, 2.4 heights further.
    for (x, y, size) in [(0.1, 0.86, 1.0), (0.9, 0.70, 0.7), (1.7, 0.90, 1.2)] {
        let middle = (x + 2.4 * time).rem_euclid(2.4) - 0.3;
        let puff = |shift: f32, size: f32| {
            let from = (at - Vec2::new(middle + shift * size, y)) / (size * Vec2::new(0.13, 0.045));
            (-from.length_squared()).exp()
        };
        let cover = puff(0.0, size) + puff(0.11, 0.8 * size) + puff(-0.12, 0.7 * size);
        colour = colour.lerp(Vec3::new(0.95, 0.95, 0.97), 0.9 * step(0.25, 0.75, cover));
    }
    let balloon =
        (at - Vec2::new(2.3 * time - 0.2, 0.58 + 0.06 * (TAU * time).sin())) / Vec2::new(0.085, 0.1);
    if balloon.length_squared() < 1.0 {
        let stripe = ((balloon.x * 2.5).floor() as i32).rem_euclid(2);
        colour = [Vec3::new(0.85, 0.07, 0.03), Vec3::new(0.95, 0.60, 0.05)][stripe as usize];
    }
    let far = 0.40 + 0.05 * wave(0.5, 1.0) + 0.02 * wave(1.3, 2.0);
    colour = colour.lerp(Vec3::new(0.10, 0.24, 0.22), 1.0 - step(far - 0.005, far + 0.005, at.y));
    let near = 0.25 + 0.06 * wave(0.7, 2.0) + 0.015 * wave(2.1, 5.0);
    let meadow = Vec3::new(0.16, 0.40, 0.05).lerp(Vec3::new(0.30, 0.42, 0.06), step(0.0, 0.3, at.y));
    colour.lerp(meadow, 1.0 - step(near - 0.005, near + 0.005, at.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_repeat_and_move() {
        for pattern in PATTERNS {
            let frame = |number, frames| texels(pattern, number, frames).unwrap();
            let still = frame(0, 1);
            assert_eq!(still.len(), (SIZE[0] * SIZE[1]) as usize);
            assert!(still.iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0), "{pattern}");
            assert_eq!(frame(0, 24), still);
            let change = |a: &[Vec3], b: &[Vec3]| {
                a.iter().zip(b).map(|(a, b)| (*a - *b).abs().element_sum()).sum::<f32>() / a.len() as f32
            };
            // The last frame is to the first as the first to the second.
            let (next, last) = (change(&still, &frame(1, 24)), change(&frame(23, 24), &still));
            assert!(next > 0.01 && (next / last - 1.0).abs() < 0.3, "{pattern}: {next}, {last}");
        }
        assert_eq!(texels("static", 0, 1), None);
    }

    #[test]
    fn half_of_the_checkerboard_is_white() {
        let texels = texels("checkerboard", 0, 1).unwrap();
        let mean = texels.iter().map(|texel| texel.x).sum::<f32>() / texels.len() as f32;
        assert_eq!(mean, 0.5);
        // Squares of 10 × 10 texels; the lower left one is white.
        let at = |x: usize, y: usize| texels[y * 160 + x].x;
        assert_eq!([at(0, 89), at(9, 80), at(10, 89), at(0, 79)], [1.0, 1.0, 0.0, 0.0]);
    }
}
