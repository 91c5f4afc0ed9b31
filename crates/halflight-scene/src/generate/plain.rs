//! Small scenes with a closed-form solution: an open floor, a half-plane, a resting box, a railing.

use glam::Vec3;
use halflight_core::scene::Mesh;

use super::GenerateError;
use super::builder::Builder;
use super::parameters::Parameters;

const FLOOR: u32 = 0;
const BLOCKER: u32 = 1;
const PALETTE: [[f32; 3]; 2] = [[0.75, 0.75, 0.75], [0.7, 0.45, 0.3]];

/// A square floor at y = 0 around the origin, `size` metres wide, in `cells × cells` quads.
fn floor(parameters: &mut Parameters) -> Result<Builder, GenerateError> {
    let size = parameters.number("size", 20.0, 0.01..=1e5)?;
    let cells = parameters.count("cells", 8, 1..=1024)? as usize;
    let mut builder = Builder::new();
    builder.paint(FLOOR);
    builder.floor(size, cells);
    builder.paint(BLOCKER);
    Ok(builder)
}

/// Floor alone.
pub(super) fn open_floor(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let builder = floor(parameters)?;
    parameters.finish()?;
    Ok(builder.finish(&PALETTE[..1]))
}

/// The floor and, `height` above it, a horizontal sheet over x < 0: it spans -extent ≤ x ≤ 0 and |z| ≤
/// extent.
pub(super) fn half_plane(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let mut builder = floor(parameters)?;
    let height = parameters.number("height", 2.0, 1e-3..=1e5)?;
    let extent = parameters.number("extent", 100.0, 1e-3..=1e6)?;
    parameters.finish()?;
    let corner = |x, z| Vec3::new(x, height, z);
    builder.quad([
        corner(-extent, extent),
        corner(0.0, extent),
        corner(0.0, -extent),
        corner(-extent, -extent),
    ]);
    Ok(builder.finish(&PALETTE))
}

/// The floor and a box on it around the y axis, `width × height × depth`.
///
/// Its bottom lies `0.01 × height` below the floor, so that no two faces coincide.
pub(super) fn contact(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let mut builder = floor(parameters)?;
    let width = parameters.number("width", 1.0, 1e-3..=1e4)?;
    let height = parameters.number("height", 1.0, 1e-3..=1e4)?;
    let depth = parameters.number("depth", 1.0, 1e-3..=1e4)?;
    parameters.finish()?;
    let sunk = 0.01 * height;
    builder.block(Vec3::Y * -sunk, Vec3::new(width, height + sunk, depth));
    Ok(builder.finish(&PALETTE))
}

/// The floor and a railing along x through the origin: `bars` upright square bars, evenly spread over
/// `length`, between a bottom and a top rail that are twice as thick.
///
/// Bars span 0.1 × `height` … `height`; end bars stand on the floor and are as thick as the rails.
pub(super) fn railing(parameters: &mut Parameters) -> Result<Mesh, GenerateError> {
    let mut builder = floor(parameters)?;
    let bars = parameters.count("bars", 25, 2..=100_000)?;
    let length = parameters.number("length", 4.0, 1e-2..=1e4)?;
    let height = parameters.number("height", 1.0, 1e-2..=1e3)?;
    // Thicker bars would leave no gap between the rails.
    let thickness = parameters.number("thickness", 0.02 * height, 1e-4..=0.2 * height)?;
    parameters.finish()?;
    let rail = 2.0 * thickness;
    for bar in 0..bars {
        let x = (bar as f32 / (bars - 1) as f32 - 0.5) * length;
        let end = bar == 0 || bar + 1 == bars;
        // Ends reach slightly into the floor and bars into the rails, so that no two faces coincide.
        let (width, foot, top) = if end {
            (1.5 * rail, -rail, height + rail)
        } else {
            (thickness, 0.1 * height, height - 0.5 * rail)
        };
        builder.block(Vec3::new(x, foot, 0.0), Vec3::new(width, top - foot, width));
    }
    for y in [0.1 * height - 0.5 * rail, height - rail] {
        builder.block(Vec3::Y * y, Vec3::new(length, rail, rail));
    }
    Ok(builder.finish(&PALETTE))
}
