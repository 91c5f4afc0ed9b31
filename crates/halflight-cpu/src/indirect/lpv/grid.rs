//! The grid, the intensities in its cells, and what blocks light between them.

use std::f32::consts::FRAC_1_PI;

use glam::{IVec3, Vec3};

use crate::indirect::points::Points;

/// Spherical harmonics of a channel: constant, x, y and z.
pub(super) const HARMONICS: usize = 4;

/// Values of a cell: the harmonics of three channels.
pub(super) const VALUES: usize = 3 * HARMONICS;

/// Harmonic of band 0, √(1/4π), and factor of those of band 1, √(3/4π).
pub(super) const CONSTANT: f32 = 0.282_094_8;
pub(super) const LINEAR: f32 = 0.488_602_5;

/// Coefficients of the cosine lobe max(0, n·ω): √π/2, and √(π/3) times n.
pub(super) const LOBE_CONSTANT: f32 = 0.886_226_9;
pub(super) const LOBE_LINEAR: f32 = 1.023_326_7;

/// Mean number of cells that light enters for each cell size it travels: the mean of |x| + |y| + |z| over all directions. Summed over steps, a cell holds
/// the radiance times the area of its side times that.
const ENTERED: f32 = 1.5;

/// Grid of cubes that is anchored in whole cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// Lower corner of the first cell that is used, world space.
    pub(super) low: Vec3,
    /// Side of a cell, metres.
    pub(super) size: f32,
    /// Cells along each axis, with an empty one at each end.
    pub(super) cells: [usize; 3],
}

impl Grid {
    /// Grid around a box, with about `count` cells along its longest side; none around a box without extent or that is too far from the origin to be
    /// divided so finely.
    pub(super) fn new(low: Vec3, high: Vec3, count: u32) -> Option<Self> {
        let longest = (high - low).max_element();
        if !(longest.is_finite() && longest > 0.0) {
            return None;
        }
        let size = ((longest / count as f32).log2() * 4.0).ceil() * 0.25;
        let size = size.exp2();
        // Light leaves the surfaces of the box by up to two cells.
        let (first, last) = ((low / size).floor() - 2.0, (high / size).floor() + 2.0);
        let cells = (last - first).as_ivec3() + IVec3::splat(3);
        let fits = cells.min_element() > 0 && cells.max_element() <= 2 * count as i32 + 16;
        let divided = low.abs().max(high.abs()).max_element() * f32::EPSILON * 64.0 < size;
        (fits && divided).then(|| Self {
            low: (first - 1.0) * size,
            size,
            cells: cells.as_uvec3().to_array().map(|cells| cells as usize + 1),
        })
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.cells.iter().product()
    }

    /// Steps from a cell to the next along each axis.
    pub(super) fn strides(&self) -> [usize; 3] {
        [1, self.cells[0], self.cells[0] * self.cells[1]]
    }

    /// Index of the cell around a place; none outside the cells that are used.
    pub(super) fn cell(&self, place: Vec3) -> Option<usize> {
        let at = ((place - self.low) / self.size).floor();
        let inside = |axis: usize| at[axis] >= 1.0 && at[axis] < (self.cells[axis] - 1) as f32;
        let [x, y, z] = self.strides();
        (inside(0) && inside(1) && inside(2))
            .then(|| at.x as usize * x + at.y as usize * y + at.z as usize * z)
    }

    /// The eight cells whose centres are around a place, the lowest as an index, and the place between them.
    fn around(&self, place: Vec3) -> (usize, Vec3) {
        let at = (place - self.low) / self.size - 0.5;
        let last = Vec3::from_array(self.cells.map(|cells| (cells - 2) as f32));
        let low = at.floor().clamp(Vec3::ZERO, last);
        let [x, y, z] = self.strides();
        let index = low.x as usize * x + low.y as usize * y + low.z as usize * z;
        (index, (at - low).clamp(Vec3::ZERO, Vec3::ONE))
    }
}

/// Intensity in every cell, W/sr, as harmonics: one value after another, each for all cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Volume {
    pub(super) values: Vec<f32>,
    cells: usize,
}

impl Volume {
    /// Empties the volume for a grid.
    pub(super) fn reset(&mut self, grid: &Grid) {
        self.cells = grid.len();
        self.values.clear();
        self.values.resize(VALUES * self.cells, 0.0);
    }

    /// One value of all cells.
    pub(super) fn plane(&self, value: usize) -> &[f32] {
        &self.values[value * self.cells..(value + 1) * self.cells]
    }

    /// Adds flux, W by channel, that leaves along a cosine lobe.
    pub(super) fn deposit(&mut self, cell: usize, flux: Vec3, normal: Vec3) {
        let lobe = [LOBE_CONSTANT, LOBE_LINEAR * normal.x, LOBE_LINEAR * normal.y, LOBE_LINEAR * normal.z];
        for channel in 0..3 {
            for (harmonic, lobe) in lobe.iter().enumerate() {
                self.values[(channel * HARMONICS + harmonic) * self.cells + cell] +=
                    flux[channel] * FRAC_1_PI * lobe;
            }
        }
    }

    /// Divides cells by the counts above 0.
    pub(super) fn divide(&mut self, counts: &[u32]) {
        for plane in self.values.chunks_mut(self.cells.max(1)) {
            for (value, &count) in plane.iter_mut().zip(counts) {
                *value /= count.max(1) as f32;
            }
        }
    }

    /// Adds another volume of the same grid.
    pub(super) fn add(&mut self, other: &Self) {
        for (sum, value) in self.values.iter_mut().zip(&other.values) {
            *sum += value;
        }
    }

    /// Irradiance by channel, W/m², of a receiver with this normal, from a sum over all steps.
    pub(super) fn irradiance(&self, grid: &Grid, place: Vec3, normal: Vec3) -> Vec3 {
        let (cell, inside) = grid.around(place);
        let [x, y, z] = grid.strides();
        // Light that travels against the normal.
        let lobe = [LOBE_CONSTANT, -LOBE_LINEAR * normal.x, -LOBE_LINEAR * normal.y, -LOBE_LINEAR * normal.z];
        let mut sum = [0.0f32; 3];
        for corner in 0..8 {
            let step = Vec3::new((corner & 1) as f32, (corner >> 1 & 1) as f32, (corner >> 2) as f32);
            let weight = (Vec3::ONE - step + (2.0 * step - 1.0) * inside).to_array().iter().product::<f32>();
            let index = cell + (corner & 1) * x + (corner >> 1 & 1) * y + (corner >> 2) * z;
            for (channel, sum) in sum.iter_mut().enumerate() {
                for (harmonic, lobe) in lobe.iter().enumerate() {
                    let value = self.values[(channel * HARMONICS + harmonic) * self.cells + index];
                    *sum += weight * value * lobe;
                }
            }
        }
        let side = ENTERED * grid.size * grid.size;
        Vec3::from_array(sum.map(|value| value.max(0.0) / side))
    }

    /// Flux in all cells by channel, W.
    #[cfg(test)]
    pub(super) fn flux(&self) -> [f64; 3] {
        [0, 1, 2].map(|channel| {
            let constant: f64 = self.plane(channel * HARMONICS).iter().map(|&value| f64::from(value)).sum();
            constant * f64::from(CONSTANT * 4.0 * std::f32::consts::PI)
        })
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.values.capacity() * 4
    }
}

/// Part of the light that surfaces block between cells. Kaplanyan and Dachsbacher keep it in harmonics of one-sided surfaces; here surfaces have two
/// sides, which harmonics of bands 0 and 1 cannot tell from blocking on all sides, and the blocked parts along the three axes stand for them.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocking {
    /// Blocked part of light along each axis at the corners of the cells, one axis after another; corner `i` is the lowest of cell `i`.
    corners: Vec<f32>,
    /// Blocked parts in the middle of the faces: `faces[axis]` of the lower side of each cell across that axis, three parts each.
    pub(super) faces: [[Vec<f32>; 3]; 3],
}

impl Blocking {
    /// Fills the volume: every point blocks the part area · |cos| / side² of the light.
    pub(super) fn fill(&mut self, grid: &Grid, points: &Points) {
        let (count, strides) = (grid.len(), grid.strides());
        self.corners.clear();
        self.corners.resize(3 * count, 0.0);
        let shifted = Vec3::splat(0.5 * grid.size);
        for point in &points.points {
            // Corners are the middles of the cells of a grid that is shifted by half a cell.
            let Some(corner) = grid.cell(point.position + shifted) else { continue };
            let part = point.normal.abs() * (point.area / (grid.size * grid.size));
            for axis in 0..3 {
                self.corners[axis * count + corner] += part[axis];
            }
        }
        for (across, faces) in self.faces.iter_mut().enumerate() {
            let (one, other) = (strides[(across + 1) % 3], strides[(across + 2) % 3]);
            for (axis, face) in faces.iter_mut().enumerate() {
                let corners = &self.corners[axis * count..(axis + 1) * count];
                let at = |index: usize| corners.get(index).copied().unwrap_or(0.0).min(1.0);
                face.clear();
                face.extend((0..count).map(|cell| {
                    0.25 * (at(cell) + at(cell + one) + at(cell + other) + at(cell + one + other))
                }));
            }
        }
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        let faces: usize = self.faces.iter().flatten().map(Vec::capacity).sum();
        (self.corners.capacity() + faces) * 4
    }
}
