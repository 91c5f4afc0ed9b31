//! Empty-space skipping for all rays of a receiver at once: the fan from the receiver to the light, and the
//! parts of it where the grid is empty.

use glam::Vec3;
use halflight_core::light::AreaLight;

use super::grid::Grid;
use super::march::{Measures, NUMBER, floor, whole};
use super::run::Run;
use crate::simd::Lanes;

/// Number of cross-sections of a fan or a part of it; they delimit one piece less.
const SECTIONS: usize = 16;

/// Most runs of a fan.
const RUNS: usize = 16;

/// Margin of a piece's bounding box, in voxels: several times the error of single precision in a grid of
/// 1,024 texels.
const SLACK: f32 = 0.01;

/// Runs of a fan that may contain set voxels, ordered from the receiver on.
pub(super) struct Runs {
    runs: [Run; RUNS],
    count: usize,
}

impl Runs {
    const NONE: Self = Self { runs: [Run::NONE; RUNS], count: 0 };

    pub(super) fn as_slice(&self) -> &[Run] {
        &self.runs[..self.count]
    }

    /// Appends a run. It extends the last run if it touches it or if there is no room.
    #[inline(always)]
    fn add(&mut self, run: Run) {
        if self.count > 0 && (self.runs[self.count - 1].to == run.from || self.count == RUNS) {
            let last = &mut self.runs[self.count - 1];
            last.inside &= run.inside && last.to == run.from;
            last.to = run.to;
        } else {
            self.runs[self.count] = run;
            self.count += 1;
        }
    }
}

/// Runs of a receiver: those of the whole fan, each subdivided once more. Slices up to `thickness` farther
/// and nearer than the rays count.
#[inline(always)]
pub(super) fn runs<L: Lanes>(
    grid: &Grid,
    measures: &Measures,
    thickness: u32,
    origin: Vec3,
    light: &AreaLight,
) -> Runs {
    let mut coarse = Runs::NONE;
    Fan::new::<L>(measures, thickness, origin, light, Run::WHOLE).add_runs(grid, &mut coarse);
    let mut fine = Runs::NONE;
    for &run in coarse.as_slice() {
        Fan::new::<L>(measures, thickness, origin, light, run).add_runs(grid, &mut fine);
    }
    fine
}

/// Cross-sections of a part of a fan, which cut it into equally long pieces, and the pieces' bounding boxes.
struct Fan {
    /// Ray parameters of the cross-sections.
    at: [f32; SECTIONS],
    /// First and last texels and slices of the pieces, with [`NUMBER`] added.
    low: [[f32; SECTIONS]; 3],
    high: [[f32; SECTIONS]; 3],
    /// Mask of pieces that are entirely outside the grid.
    outside: u32,
    /// Mask of pieces that are entirely inside the grid.
    inside: u32,
}

impl Fan {
    /// Cuts a part of a fan into pieces. Origin and light are in homogeneous coordinates.
    ///
    /// A piece is the convex hull of the cross-sections at its ends, and in front of the eye a projection
    /// maps convex hulls to convex hulls: the box around both boxes contains the piece. A cross-section that
    /// reaches behind the nearest slice may lie anywhere in the image.
    #[inline(always)]
    fn new<L: Lanes>(
        measures: &Measures,
        thickness: u32,
        origin: Vec3,
        light: &AreaLight,
        part: Run,
    ) -> Self {
        let mut at = [0.0f32; SECTIONS];
        for (section, at) in at.iter_mut().enumerate() {
            let t = section as f32 * (1.0 / (SECTIONS - 1) as f32);
            *at = part.from + (part.to - part.from) * t;
        }
        // Adjacent runs must share an end, bit for bit.
        at[SECTIONS - 1] = part.to;

        let (zero, side, near) = (L::splat(0.0), L::splat(measures.side), L::splat(measures.near));
        // One entry more than vectors hold, so that every section's successor can be loaded.
        let (mut lows, mut highs) = ([[0.0f32; 2 * SECTIONS]; 3], [[0.0f32; 2 * SECTIONS]; 3]);
        let corners = light.corners();
        for first in (0..SECTIONS).step_by(L::WIDTH) {
            let t = L::load(&at[first..]);
            let (mut low, mut high) = ([L::splat(f32::INFINITY); 3], [L::splat(f32::NEG_INFINITY); 3]);
            for corner in corners {
                let d = corner - origin;
                let place = |axis: usize| L::splat(origin[axis]).add(L::splat(d[axis]).mul(t));
                let depth = place(2);
                let behind = depth.lt(near);
                let inverse = L::splat(1.0).div(depth.max(near));
                let slice = depth.sub(near).mul(L::splat(measures.density));
                (low[2], high[2]) = (low[2].min(slice), high[2].max(slice));
                for axis in 0..2 {
                    let along = place(axis).mul(inverse);
                    low[axis] = low[axis].min(along.select(behind, zero));
                    high[axis] = high[axis].max(along.select(behind, side));
                }
            }
            for axis in 0..3 {
                low[axis].store(&mut lows[axis][first..]);
                high[axis].store(&mut highs[axis][first..]);
            }
        }

        let mut fan = Self {
            at,
            low: [[0.0; SECTIONS]; 3],
            high: [[0.0; SECTIONS]; 3],
            outside: 0,
            inside: (1 << SECTIONS) - 1,
        };
        for first in (0..SECTIONS).step_by(L::WIDTH) {
            for axis in 0..3 {
                let (size, slack) = match axis {
                    2 => (measures.slices, SLACK + thickness as f32),
                    _ => (measures.side, SLACK),
                };
                let (last, size, slack) = (L::splat(size - 1.0), L::splat(size), L::splat(slack));
                let ends = |all: &[f32]| (L::load(&all[first..]), L::load(&all[first + 1..]));
                let (low, high) = (ends(&lows[axis]), ends(&highs[axis]));
                let (low, high) = (low.0.min(low.1).sub(slack), high.0.max(high.1).add(slack));
                fan.outside |= (high.lt(zero) | size.lt(low)) << first;
                fan.inside &= !((low.lt(zero) | size.lt(high)) << first);
                let texel = |at: L| floor(at.max(zero).min(last)).add(L::splat(NUMBER));
                texel(low).store(&mut fan.low[axis][first..]);
                texel(high).store(&mut fan.high[axis][first..]);
            }
        }
        fan
    }

    /// Adds the runs between the pieces where the grid is empty.
    #[inline(always)]
    fn add_runs(&self, grid: &Grid, runs: &mut Runs) {
        for piece in 0..SECTIONS - 1 {
            let corner = |all: &[[f32; SECTIONS]; 3]| [0, 1, 2].map(|axis| whole(all[axis][piece]));
            if self.outside >> piece & 1 == 1 || grid.is_empty(corner(&self.low), corner(&self.high)) {
                continue;
            }
            let inside = self.inside >> piece & 1 == 1;
            runs.add(Run { from: self.at[piece], to: self.at[piece + 1], inside });
        }
    }
}
