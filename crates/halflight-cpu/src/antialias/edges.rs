//! Edge pixels: pixels that see another surface than one of their four neighbours.
//!
//! Every straight edge that crosses a pixel passes between its centre and that of such a neighbour, so that no other pixels need be looked at. Things
//! thinner than a pixel may pass between all centres; pixels that miss them are not found.

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use rayon::prelude::*;

use super::surfaces::{Seen, Surfaces};

/// Pixels along the side of a tile: edge pixels are listed tile by tile, since those of one tile are traced together.
const TILE: usize = 8;

/// Edge between a pixel and its right neighbour.
pub(super) const RIGHT: u8 = 1;
/// Edge between a pixel and the one below.
pub(super) const BELOW: u8 = 2;
/// Edge between a pixel and its left neighbour.
pub(super) const LEFT: u8 = 4;
/// Edge between a pixel and the one above.
pub(super) const ABOVE: u8 = 8;

/// Number of sets of these sides.
pub(super) const SIDES: usize = 16;

/// Edge pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Edge {
    pub(super) pixel: u32,
    /// Sides on which a neighbour sees another surface.
    pub(super) sides: u8,
}

/// Edge pixels of a frame.
#[derive(Default)]
pub(super) struct Edges {
    flags: Vec<u8>,
    /// Edge pixels of each row of tiles.
    bands: Vec<Vec<Edge>>,
    all: Vec<Edge>,
}

impl Edges {
    /// Finds the edge pixels of a frame; with the `irradiance` of all pixels, those amid pixels of which one at least is
    /// lit.
    pub(super) fn find(&mut self, gbuffer: &GBuffer, surfaces: &Surfaces, irradiance: Option<&[Vec3]>) {
        let (width, pixels) = (gbuffer.width.max(1) as usize, gbuffer.pixels());
        self.flags.resize(pixels, 0);
        let rows = self.flags.par_chunks_mut(width).enumerate();
        rows.for_each(|(y, flags)| flag_row(gbuffer, surfaces, y * width, flags));
        let flags = &self.flags[..];
        self.bands.resize_with(pixels.div_ceil(width * TILE), Vec::new);
        let bands = self.bands.par_iter_mut().enumerate();
        bands.for_each(|(band, found)| {
            list_band(flags, width, band * TILE, found);
            if let Some(irradiance) = irradiance {
                found.retain(|edge| is_lit(irradiance, width, edge.pixel as usize));
            }
        });
        self.all.clear();
        self.bands.iter().for_each(|found| self.all.extend_from_slice(found));
    }

    /// Edge pixels, tile by tile.
    pub(super) fn all(&self) -> &[Edge] {
        &self.all
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        let bands: usize = self.bands.iter().map(Vec::capacity).sum();
        self.flags.capacity() + (bands + self.all.capacity()) * size_of::<Edge>()
    }
}

/// Writes the right and lower sides of the row that begins with pixel `first`.
fn flag_row(gbuffer: &GBuffer, surfaces: &Surfaces, first: usize, flags: &mut [u8]) {
    let (width, primitive) = (flags.len(), &gbuffer.primitive[..]);
    let seen = |entry: usize| Seen { gbuffer, entry };
    for (x, flag) in flags.iter_mut().enumerate() {
        let pixel = first + x;
        let right = x + 1 < width && !surfaces.look_alike(seen(pixel), seen(pixel + 1));
        let below = pixel + width < primitive.len() && !surfaces.look_alike(seen(pixel), seen(pixel + width));
        *flag = (u8::from(right) * RIGHT) | (u8::from(below) * BELOW);
    }
}

/// Returns whether one of the 3 × 3 pixels around a pixel receives light.
fn is_lit(irradiance: &[Vec3], width: usize, pixel: usize) -> bool {
    // Neighbours of pixels at the left and right border are some of other rows: these can only add edges.
    let rows = [pixel.wrapping_sub(width), pixel, pixel.wrapping_add(width)];
    let mut near = rows.into_iter().flat_map(|row| [row.wrapping_sub(1), row, row.wrapping_add(1)]);
    near.any(|near| irradiance.get(near).is_some_and(|&irradiance| irradiance != Vec3::ZERO))
}

/// Lists the edge pixels of the tiles whose first row is `top`, those of each quarter, and of its quarters, together.
fn list_band(flags: &[u8], width: usize, top: usize, found: &mut Vec<Edge>) {
    found.clear();
    let height = flags.len() / width;
    for left in (0..width).step_by(TILE) {
        for place in 0..TILE * TILE {
            let bit = |bit: usize| place >> bit & 1;
            let (x, y) =
                (left + (bit(0) | bit(2) << 1 | bit(4) << 2), top + (bit(1) | bit(3) << 1 | bit(5) << 2));
            if x >= width || y >= height {
                continue;
            }
            let pixel = y * width + x;
            let mut sides = flags[pixel];
            if x > 0 && flags[pixel - 1] & RIGHT != 0 {
                sides |= LEFT;
            }
            if y > 0 && flags[pixel - width] & BELOW != 0 {
                sides |= ABOVE;
            }
            if sides != 0 {
                found.push(Edge { pixel: pixel as u32, sides });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_listed_on_both_sides_and_tile_by_tile() {
        let (width, height) = (11, 10);
        let mut flags = vec![0; width * height];
        // A wall between columns 8 and 9, a floor below row 8, and a corner at the left.
        (0..height).for_each(|y| flags[y * width + 8] |= RIGHT);
        (0..width).for_each(|x| flags[8 * width + x] |= BELOW);
        let mut found = [Vec::new(), Vec::new()];
        list_band(&flags, width, 0, &mut found[0]);
        list_band(&flags, width, TILE, &mut found[1]);
        let at = |x: usize, y: usize, sides| Edge { pixel: (y * width + x) as u32, sides };
        assert_eq!(found[0].len(), 2 * 8);
        assert_eq!(&found[0][..3], [at(8, 0, RIGHT), at(9, 0, LEFT), at(8, 1, RIGHT)]);
        assert_eq!(&found[1][..3], [at(0, 8, BELOW), at(1, 8, BELOW), at(0, 9, ABOVE)]);
        assert_eq!(found[1].len(), 2 * width);
        assert!(found[1].contains(&at(8, 8, RIGHT | BELOW)) && found[1].contains(&at(9, 9, LEFT | ABOVE)));
    }
}
