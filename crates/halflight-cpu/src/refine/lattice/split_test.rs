//! Which cells are kept: what corners say about what lies between them, and finer neighbours about their cells.

use std::sync::atomic::{AtomicBool, Ordering};

use halflight_core::gbuffer::GBuffer;
use rayon::prelude::*;

use super::{Lattice, NONE, Square, Verdict, View};
use crate::corners::Corners;
use crate::refine::representative::{cell_rect, faces_away};
use crate::tangent_plane::Between;

impl Lattice {
    pub(super) fn keep(&mut self, gbuffer: &GBuffer, cell: Square, verdict: Verdict) {
        let rect = cell_rect(gbuffer, cell.level, cell.x, cell.y);
        let columns = gbuffer.width.div_ceil(2);
        for y in rect.y0 / 2..rect.y1.div_ceil(2) {
            let row = (y * columns + rect.x0 / 2) as usize..(y * columns + rect.x1.div_ceil(2)) as usize;
            self.owners[row].fill(self.kept.len() as u32);
        }
        // Until cells are first compared all masks are recent; later ones have neighbours that are not.
        self.suspected.push(AtomicBool::new(self.closing_cracks));
        self.kept.push(Some((cell, verdict)));
    }

    /// Whether a cell whose corners are known can be interpolated over.
    pub(super) fn passes_split_test(&self, view: &View, cell: Square) -> bool {
        let corners = cell.corners(view.gbuffer);
        let found = corners.pixels().map(|pixel| self.fraction(pixel));
        if self.discontinuities.inside(cell.level, cell.x, cell.y) == Between::Step {
            return self.passes_step_test(view, cell.level, &corners, &found);
        }
        match found.iter().filter(|fraction| fraction.is_nan()).count() {
            0 => {}
            // On the unlit side, if no bulge turns back to the light.
            4 => {
                let rect = cell_rect(view.gbuffer, cell.level, cell.x, cell.y);
                let light = view.frame.light(view.light);
                let unlit = |x, y| faces_away(view.gbuffer, light, view.gbuffer.index(x, y));
                return (rect.y0..rect.y1).all(|y| (rect.x0..rect.x1).all(|x| unlit(x, y)));
            }
            _ => return false,
        }
        let (low, high) = range(&found);
        let tolerance = self.tolerance(&corners);
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
        let known = parent.pixels().map(|pixel| self.fraction(pixel));
        corners.places().into_iter().zip(found).all(|((x, y), fraction)| {
            // Without a fraction at the parent's corners there is no prediction, and the comparison fails.
            (parent.interpolate(&view.planes, &known, x, y) - fraction).abs() <= tolerance
        })
    }

    /// Difference of the visible fraction that is interpolated over between corners: the less, the stronger the light there.
    fn tolerance(&self, corners: &Corners) -> f32 {
        if self.config.target <= 0.0 {
            return self.plan.error;
        }
        self.plan.tolerance(self.strongest(corners))
    }

    /// The most light that any of a cell's corners would get without shadows, as irradiance per radiance.
    pub(super) fn strongest(&self, corners: &Corners) -> f32 {
        let strength = |pixel: usize| match self.corners[pixel] {
            NONE => 0.0,
            sample => self.unshadowed[sample as usize],
        };
        corners.pixels().map(strength).into_iter().fold(0.0, f32::max)
    }

    /// Whether a cell across a step can be interpolated over: corners on one surface agree, and one that is alone on its own
    /// sees all of the light or nothing.
    fn passes_step_test(&self, view: &View, level: u8, corners: &Corners, found: &[f32; 4]) -> bool {
        let (pixels, places) = (corners.pixels(), corners.places());
        let tolerance = self.tolerance(corners);
        (0..4).filter(|&one| view.gbuffer.is_receiver(pixels[one])).all(|one| {
            let mut alone = true;
            for other in (0..4).filter(|&other| pixels[other] != pixels[one]) {
                let ((x0, y0), (x1, y1)) = (places[one], places[other]);
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

    /// Whether no corner of finer cells where they meet a kept one contradicts what it would have there.
    fn meets_neighbours(&self, view: &View, cell: Square) -> bool {
        let corners = cell.corners(view.gbuffer);
        let known = corners.pixels().map(|pixel| self.fraction(pixel));
        let ((low, high), error) = (range(&known), self.tolerance(&corners));
        let [(x0, y0), ..] = corners.places();
        corners.all_edges(|x, y| {
            let found = self.fraction(view.gbuffer.index(x, y));
            // Between corners that are all so near nothing is farther.
            if found.is_nan() || x >= x0 && y >= y0 && found - low <= error && high - found <= error {
                return true;
            }
            let expected = corners.interpolate(&view.planes, &known, x, y);
            // Without corners on the pixel's surface there is nothing to compare with.
            expected.is_nan() || (found - expected).abs() <= error
        })
    }

    /// Splits kept cells that their neighbours contradict; whether there were any.
    pub(super) fn close_cracks(&mut self, view: &View) -> bool {
        self.suspect(view.gbuffer);
        let (mut verdicts, suspects) =
            (std::mem::take(&mut self.verdicts), std::mem::take(&mut self.suspects));
        let meets = |&place: &u32| match self.kept[place as usize] {
            Some((cell, _)) if !self.meets_neighbours(view, cell) => Verdict::Split,
            _ => Verdict::Keep,
        };
        suspects.par_iter().with_min_len(64).map(meets).collect_into_vec(&mut verdicts);
        let mut any = false;
        for (&place, &verdict) in suspects.iter().zip(&verdicts) {
            if verdict == Verdict::Split
                && let Some((cell, _)) = self.kept[place as usize].take()
            {
                self.split(cell);
                any = true;
            }
        }
        (self.verdicts, self.suspects) = (verdicts, suspects);
        any
    }

    /// Finds the kept cells that recent pixels of finer ones lie on or just outside the edges of.
    fn suspect(&mut self, gbuffer: &GBuffer) {
        let (width, height, columns) = (gbuffer.width, gbuffer.height, gbuffer.width.div_ceil(2));
        let Self { recent, owners, kept, suspected, suspects, .. } = self;
        recent.par_iter().with_min_len(1024).for_each(|&(pixel, level)| {
            let (x, y) = (pixel % width, pixel / width);
            let (x0, y0) = (x.saturating_sub(1) / 2, y.saturating_sub(1) / 2);
            let (x1, y1) = ((x + 1).min(width - 1) / 2, (y + 1).min(height - 1) / 2);
            for (x, y) in [(x0, y0), (x1, y0), (x0, y1), (x1, y1)] {
                let place = owners[(y * columns + x) as usize];
                if place == NONE || suspected[place as usize].load(Ordering::Relaxed) {
                    continue;
                }
                if kept[place as usize].is_some_and(|(cell, _)| cell.level > level) {
                    // Nothing but the flags is handed on, and they after the threads have joined.
                    suspected[place as usize].store(true, Ordering::Relaxed);
                }
            }
        });
        suspects.clear();
        let marked =
            (0..).zip(suspected).filter_map(|(place, flag)| std::mem::take(flag.get_mut()).then_some(place));
        suspects.extend(marked);
        recent.clear();
        self.closing_cracks = true;
    }
}

/// The lowest and the highest fraction.
pub(super) fn range(fractions: &[f32; 4]) -> (f32, f32) {
    let empty = (f32::INFINITY, f32::NEG_INFINITY);
    fractions.iter().fold(empty, |(low, high), &fraction| (low.min(fraction), high.max(fraction)))
}
