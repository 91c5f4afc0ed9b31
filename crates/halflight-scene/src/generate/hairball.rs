//! A ball of thin curved tubes over a floor: much fine geometry in a small space.

use glam::Vec3;
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::parameters::Parameters;
use super::random::Random;
use super::shapes::tube;

const FLOOR: u32 = 0;
const HAIR: u32 = 1;
const CORE: u32 = 2;
const PALETTE: [[f32; 3]; 3] = [[0.72, 0.72, 0.70], [0.62, 0.42, 0.24], [0.30, 0.20, 0.12]];

/// The ball's radius and the height of its middle; hairs reach a little further.
const RADIUS: f32 = 1.0;
const HEIGHT: f32 = 1.35;
/// Points along a full hair, and sides of its tube: `2 · SIDES · (POINTS - 2)` triangles with its tips.
const POINTS: usize = 40;
const SIDES: usize = 3;
/// Triangles that are not hair: the floor's.
const REST: usize = 2;

/// A hairball of very nearly `triangles` triangles; a count that hairs cannot reach exactly is missed by less
/// than six.
///
/// Unless `thickness` (radius in metres) is given, hairs get thinner as their number grows, so that all of
/// them together keep their volume.
pub(super) fn hairball(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let triangles = parameters.count("triangles", 100_000, 1_000..=2_850_000)? as usize;
    let usual = (0.0075 * (100_000.0 / triangles as f32).sqrt()).min(0.03);
    let thickness = parameters.number("thickness", usual, 1e-4..=0.1)?;
    let seed = parameters.count("seed", 1, 0..=u32::MAX)?;
    parameters.finish()?;

    let mut builder = Builder::new();
    builder.paint(FLOOR);
    let corner = |x, z| Vec3::new(x, 0.0, z);
    builder.quad([corner(-8.0, 8.0), corner(8.0, 8.0), corner(8.0, -8.0), corner(-8.0, -8.0)]);
    // A tube of n points whose first and last are tips has 2 · SIDES · (n - 2) triangles.
    let mut rings = (triangles - REST) / (2 * SIDES);
    let mut hair = 0;
    while rings > 0 {
        let points = (rings + 2).min(POINTS);
        let mut random = Random::new(seed, hair);
        builder.paint(if random.unit() < 0.25 { CORE } else { HAIR });
        tube(&mut builder, &strand(&mut random, points, thickness), SIDES);
        rings -= points - 2;
        hair += 1;
    }
    Ok(builder.finish(&PALETTE))
}

/// A hair that leaves the ball's inside, wanders along its surface and ends a little above it.
fn strand(random: &mut Random, points: usize, thickness: f32) -> Vec<(Vec3, f32)> {
    let mut out = random.direction();
    let mut along = out.cross(random.direction()).normalize_or(out.any_orthonormal_vector());
    let level = random.between(0.45, 1.0) * RADIUS;
    let wave = random.between(3.0, 9.0);
    let turn = random.between(-0.06, 0.06);
    let phase = random.unit();
    (0..points)
        .map(|point| {
            let t = point as f32 / (POINTS - 1) as f32;
            // One step along the surface, then a little to the side.
            let step = (out + along * 0.075).normalize();
            along = (along - step * step.dot(along)).normalize_or(step.any_orthonormal_vector());
            along = (along + step.cross(along) * (turn + 0.08 * (wave * (t + phase)).sin())).normalize();
            out = step;
            let radius = level * (1.0 + 0.06 * (2.0 * wave * (t - phase)).sin()) + 0.12 * t * t * RADIUS;
            let end = point == 0 || point + 1 == points;
            (Vec3::Y * HEIGHT + out * radius, if end { 0.0 } else { thickness * (1.0 - 0.5 * t) })
        })
        .collect()
}
