//! Split test by the corners of a cell, and crack test against finer neighbours.

use std::sync::atomic::{AtomicBool, Ordering};

use halflight_core::gbuffer::GBuffer;
use rayon::prelude::*;

use super::{Lattice, NONE, Square, TOLERANCE_IN_VISIBLE_ERROR, Verdict, View};
use crate::corners::Corners;
use crate::refine::representative::{cell_rect, faces_away};
use crate::tangent_plane::Between;

/// Least interpolation tolerance, in standard deviations of the noise at the corners.
const DEVIATIONS: f32 = 2.5;

impl Lattice {
    pub(super) fn keep(&mut self, gbuffer: &GBuffer, cell: Square, verdict: Verdict) {
        let rect = cell_rect(gbuffer, cell.level, cell.x, cell.y);
        let columns = gbuffer.width.div_ceil(2);
        for y in rect.y0 / 2..rect.y1.div_ceil(2) {
            let row = (y * columns + rect.x0 / 2) as usize..(y * columns + rect.x1.div_ceil(2)) as usize;
            self.owners[row].fill(self.kept.len() as u32);
        }
        // Before the first crack test all masks are recent; cells kept later have older masks next to them.
        self.suspected.push(AtomicBool::new(self.closing_cracks));
        self.kept.push(Some((cell, verdict)));
    }

    /// True if a cell whose corners are known can be interpolated.
    pub(super) fn passes_split_test(&self, view: &View, cell: Square) -> bool {
        let corners = cell.corners(view.gbuffer);
        if self.discontinuities.inside(cell.level, cell.x, cell.y) == Between::Step {
            return (0..self.channels()).all(|channel| {
                let found = corners.pixels().map(|pixel| self.fraction_of(channel, pixel));
                self.passes_step_test(view, cell.level, &corners, &found)
            });
        }
        let found = corners.pixels().map(|pixel| self.fraction(pixel));
        match found.iter().filter(|fraction| fraction.is_nan()).count() {
            0 => {}
            // All corners on the unlit side: kept if no pixel in between faces the light.
            4 => {
                let rect = cell_rect(view.gbuffer, cell.level, cell.x, cell.y);
                let light = view.frame.light(view.light);
                let unlit = |x, y| faces_away(view.gbuffer, light, view.gbuffer.index(x, y));
                return (rect.y0..rect.y1).all(|y| (rect.x0..rect.x1).all(|x| unlit(x, y)));
            }
            _ => return false,
        }
        let tolerance = self.tolerance(&corners);
        (0..self.channels()).all(|channel| self.is_predictable(view, cell, &corners, channel, tolerance))
    }

    /// True if the corners of a cell agree in a channel, or the parent's corners predicted them.
    fn is_predictable(
        &self,
        view: &View,
        cell: Square,
        corners: &Corners,
        channel: usize,
        tolerance: f32,
    ) -> bool {
        let found = corners.pixels().map(|pixel| self.fraction_of(channel, pixel));
        let (low, high) = range(&found);
        if high - low <= tolerance {
            return true;
        }
        let parent = Square { level: cell.level + 1, x: cell.x / 2, y: cell.y / 2 };
        if cell.level >= self.top()
            || self.discontinuities.inside(parent.level, parent.x, parent.y) != Between::Nothing
        {
            return false;
        }
        let parent = parent.corners(view.gbuffer);
        let known = parent.pixels().map(|pixel| self.fraction_of(channel, pixel));
        corners.positions().into_iter().zip(found).all(|((x, y), fraction)| {
            // Without a fraction at the parent's corners there is no prediction, and the comparison fails.
            (parent.interpolate(&view.planes, &known, x, y) - fraction).abs() <= tolerance
        })
    }

    /// Interpolation tolerance between corners: the smaller, the stronger the light.
    fn tolerance(&self, corners: &Corners) -> f32 {
        if self.config.target <= 0.0 {
            return self.plan.error;
        }
        let strongest = self.strongest(corners);
        let tolerance = self.plan.tolerance(strongest);
        if self.bounds_visible_error() {
            tolerance.min(self.visible_tolerance(corners, strongest))
        } else {
            tolerance
        }
    }

    /// Interpolation tolerance for a bound on visible errors: relative to the brightness at the corners, but no less than what the noise of
    /// those that see part of the light explains.
    fn visible_tolerance(&self, corners: &Corners, strongest: f32) -> f32 {
        let (mut sum, mut noise, mut count) = (0.0, 0.0, 0.0);
        for sample in
            corners.pixels().map(|pixel| self.corners[pixel]).into_iter().filter(|&sample| sample != NONE)
        {
            let fraction = self.fractions[sample as usize];
            if !fraction.is_nan() {
                sum += fraction;
                count += 1.0;
            }
            if fraction > 0.0 && fraction < 1.0 {
                noise += self.variances[sample as usize];
            }
        }
        let count = f32::max(count, 1.0);
        let visible = self.config.visible_error
            * TOLERANCE_IN_VISIBLE_ERROR
            * self.plan.brightness(sum / count, strongest);
        visible.max(DEVIATIONS * (noise / count).sqrt())
    }

    /// Largest unshadowed irradiance per radiance at a cell's corners.
    pub(super) fn strongest(&self, corners: &Corners) -> f32 {
        let strength = |pixel: usize| match self.corners[pixel] {
            NONE => 0.0,
            sample => self.unshadowed[sample as usize],
        };
        corners.pixels().map(strength).into_iter().fold(0.0, f32::max)
    }

    /// True if a cell across a depth discontinuity can be interpolated: corners on one surface agree, and a
    /// corner that is alone on its surface is fully lit or in umbra.
    fn passes_step_test(&self, view: &View, level: u8, corners: &Corners, found: &[f32; 4]) -> bool {
        let (pixels, positions) = (corners.pixels(), corners.positions());
        let tolerance = self.tolerance(corners);
        (0..4).filter(|&one| view.gbuffer.is_receiver(pixels[one])).all(|one| {
            let mut alone = true;
            for other in (0..4).filter(|&other| pixels[other] != pixels[one]) {
                let ((x0, y0), (x1, y1)) = (positions[one], positions[other]);
                if view.planes.is_discontinuity(
                    pixels[one],
                    pixels[other],
                    x0.abs_diff(x1).max(y0.abs_diff(y1)),
                ) {
                    continue;
                }
                alone = false;
                let agree = (found[one] - found[other]).abs() <= tolerance
                    || found[one].is_nan() && found[other].is_nan();
                if !agree {
                    return false;
                }
            }
            let plain = found[one] == 0.0 || found[one] == 1.0 || found[one].is_nan();
            !alone || plain && level == 1
        })
    }

    /// True if no corner of finer cells on the border of a kept cell differs from the cell's interpolated
    /// value there by more than the tolerance.
    fn meets_neighbours(&self, view: &View, cell: Square) -> bool {
        let corners = cell.corners(view.gbuffer);
        let error = self.tolerance(&corners);
        (0..self.channels()).all(|channel| self.meets_in_channel(view, &corners, channel, error))
    }

    fn meets_in_channel(&self, view: &View, corners: &Corners, channel: usize, error: f32) -> bool {
        let known = corners.pixels().map(|pixel| self.fraction_of(channel, pixel));
        let (low, high) = range(&known);
        let [(x0, y0), ..] = corners.positions();
        corners.all_edges(|x, y| {
            let found = self.fraction_of(channel, view.gbuffer.index(x, y));
            // A value within the tolerance of all corners is within the tolerance of any value interpolated
            // between them.
            if found.is_nan() || x >= x0 && y >= y0 && found - low <= error && high - found <= error {
                return true;
            }
            let expected = corners.interpolate(&view.planes, &known, x, y);
            // Without corners on the pixel's surface, no comparison is possible.
            expected.is_nan() || (found - expected).abs() <= error
        })
    }

    /// Splits kept cells that disagree with finer neighbours; returns true if there were any.
    pub(super) fn close_cracks(&mut self, view: &View) -> bool {
        self.suspect(view.gbuffer);
        let (mut verdicts, suspects) =
            (std::mem::take(&mut self.verdicts), std::mem::take(&mut self.suspects));
        let meets = |&index: &u32| match self.kept[index as usize] {
            Some((cell, _)) if !self.meets_neighbours(view, cell) => Verdict::Split,
            _ => Verdict::Keep,
        };
        suspects.par_iter().with_min_len(64).map(meets).collect_into_vec(&mut verdicts);
        let mut any = false;
        for (&index, &verdict) in suspects.iter().zip(&verdicts) {
            if verdict == Verdict::Split
                && let Some((cell, _)) = self.kept[index as usize].take()
            {
                self.split(cell);
                any = true;
            }
        }
        (self.verdicts, self.suspects) = (verdicts, suspects);
        any
    }

    /// Finds the kept cells with recently traced pixels of finer cells on or just outside their edges.
    fn suspect(&mut self, gbuffer: &GBuffer) {
        let (width, height, columns) = (gbuffer.width, gbuffer.height, gbuffer.width.div_ceil(2));
        let Self { recent, owners, kept, suspected, suspects, .. } = self;
        recent.par_iter().with_min_len(1024).for_each(|&(pixel, level)| {
            let (x, y) = (pixel % width, pixel / width);
            let (x0, y0) = (x.saturating_sub(1) / 2, y.saturating_sub(1) / 2);
            let (x1, y1) = ((x + 1).min(width - 1) / 2, (y + 1).min(height - 1) / 2);
            for (x, y) in [(x0, y0), (x1, y0), (x0, y1), (x1, y1)] {
                let index = owners[(y * columns + x) as usize];
                if index == NONE || suspected[index as usize].load(Ordering::Relaxed) {
                    continue;
                }
                if kept[index as usize].is_some_and(|(cell, _)| cell.level > level) {
                    // Only the flags are shared, and they are read after the threads have joined.
                    suspected[index as usize].store(true, Ordering::Relaxed);
                }
            }
        });
        suspects.clear();
        let marked =
            (0..).zip(suspected).filter_map(|(index, flag)| std::mem::take(flag.get_mut()).then_some(index));
        suspects.extend(marked);
        recent.clear();
        self.closing_cracks = true;
    }
}

/// Lowest and highest fraction.
pub(super) fn range(fractions: &[f32; 4]) -> (f32, f32) {
    let empty = (f32::INFINITY, f32::NEG_INFINITY);
    fractions.iter().fold(empty, |(low, high), &fraction| (low.min(fraction), high.max(fraction)))
}
