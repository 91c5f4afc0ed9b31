//! Triangles of every size and shape scattered in the air, without any regularity that an acceleration
//! structure could exploit.

use glam::Vec3;
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::parameters::Parameters;
use super::random::Random;

const FLOOR: u32 = 0;
const PAPER: u32 = 1;
const PALETTE: [[f32; 3]; 2] = [[0.72, 0.72, 0.70], [0.45, 0.52, 0.62]];

/// Radius and height of the ball that contains the triangles' centres.
const RADIUS: f32 = 1.5;
const HEIGHT: f32 = 1.8;
/// Range of longest sides at a thousand triangles, m; all sizes shrink with the count so that the transmitted
/// fraction of light stays about constant.
const SIZES: (f32, f32) = (0.015, 1.0);
/// Least ratio of width to length, as a power of ten: slivers down to the thinnest that count as triangles.
const SLIMMEST: f32 = -4.5;

/// Soup of `triangles` triangles, the floor's two among them. Lengths are distributed evenly over powers of
/// ten, and so are the widths of every second triangle; the others are no slivers.
pub(super) fn soup(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let triangles = parameters.count("triangles", 100_000, 100..=3_000_000)? as usize;
    let seed = parameters.count("seed", 1, 0..=u32::MAX)?;
    parameters.finish()?;

    let mut builder = Builder::new();
    builder.paint(FLOOR);
    let corner = |x, z| Vec3::new(x, 0.0, z);
    builder.quad([corner(-6.0, 6.0), corner(6.0, 6.0), corner(6.0, -6.0), corner(-6.0, -6.0)]);
    builder.paint(PAPER);
    let scale = (1000.0 / triangles as f32).sqrt().min(1.0);
    let mut index = 0;
    // Slivers that rounding leaves no area are not counted.
    while builder.triangle_count() < triangles {
        index += 1;
        let mut random = Random::new(seed, index);
        let middle = Vec3::Y * HEIGHT + random.direction() * RADIUS * random.unit().cbrt();
        let length = SIZES.0 * (SIZES.1 / SIZES.0).powf(random.unit()) * scale;
        let along = random.direction();
        let across = along.cross(random.direction()).normalize_or(along.any_orthonormal_vector());
        let slim =
            if index % 2 == 0 { 10f32.powf(SLIMMEST * random.unit()) } else { random.between(0.3, 1.0) };
        let (half, apex) = (along * (0.5 * length), across * (length * slim));
        let tip = middle + half * random.between(-1.0, 1.0) + apex;
        // A quad that collapses to a triangle.
        builder.quad([middle - half, middle + half, tip, middle - half]);
    }
    Ok(builder.finish(&PALETTE))
}
