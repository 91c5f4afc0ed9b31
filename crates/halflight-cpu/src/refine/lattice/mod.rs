//! The lattice refiner: masks at the corners of quadtree cells, refined where the visible fraction cannot be
//! predicted.

mod config;
mod denoise;
mod error_estimate;
mod split_test;
mod trace;
mod validate;
mod view;

use std::sync::atomic::AtomicBool;

use halflight_core::certificate::{Certificate, Region};
use halflight_core::fragment::Fragments;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::mask::Purpose;
use halflight_core::pattern::Pattern;
use halflight_core::pyramid::MAX_LEVEL;
use halflight_core::stages::{RefineOutput, Refiner, Visibility};
use halflight_core::stats::CertificateCounts;
use halflight_core::values::NO_VALUE;
use rayon::prelude::*;

use super::discontinuities::Discontinuities;
use super::pixel_set::PixelSet;
use super::target::{Neighbours, PilotSample, SamplingPlan, Steps};
use crate::corners::Corners;
use crate::tangent_plane::{Between, TangentPlanes};
use crate::textured::StrataTable;
pub use config::LatticeConfig;
use denoise::Estimate;
use error_estimate::{Measured, Measurement};
use validate::{Probe, Risk, Weighed};
use view::View;

/// Noise of a sample before smoothing, relative to the bound on visible errors.
const NOISE_IN_VISIBLE_ERROR: f32 = 1.5;

/// Interpolation tolerance relative to the bound on visible errors: between corners on a smooth surface, errors are a fraction of it.
const TOLERANCE_IN_VISIBLE_ERROR: f32 = 2.0;

/// Pixel without a mask.
const NONE: u32 = u32::MAX;

/// Finest level at which certificates are requested: one costs as much as the masks of three receivers.
const PROVE_LEVEL: u8 = 2;

/// Largest bound on the variation of the hidden fraction of the light inside a certified cell. With the noise
/// of 64 samples at the corners, and geometry terms that weight one end of the light more than the other, no
/// pixel is wrong by more than a quarter.
const MOST_UNSEEN: f32 = 0.125;

/// A cell.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Square {
    level: u8,
    x: u32,
    y: u32,
}

impl Square {
    fn corners(self, gbuffer: &GBuffer) -> Corners {
        Corners::new(gbuffer.width, gbuffer.height, self.level, self.x, self.y)
    }
}

/// Result of classifying a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    /// Cell without any geometry.
    Drop,
    Split,
    /// Kept if its corners' masks allow it, or a single pixel.
    Keep,
    /// Kept, with a certificate that all of it is fully lit.
    Lit,
    /// Kept, with a certificate that all of it is in umbra.
    Umbra,
}

/// Refiner of quadtree cells with full masks at pixel-centred corners, each traced once and shared by all
/// cells and levels.
///
/// The visible fraction `F` is smooth over most of a penumbra and independent of normals. A cell is kept, to
/// be interpolated, if its corners' `F` differ by no more than [`LatticeConfig::error`], or if the parent's
/// corners predicted them to within this tolerance.
///
/// A cell is split if its corners lie partly on the lit and partly on the unlit side of the light. It is
/// split at concave creases and low depth discontinuities where one side may shadow the other, since contact
/// shadows occur there (see [`DiscontinuityLimits`](crate::tangent_plane::DiscontinuityLimits)). Along other depth discontinuities, silhouettes and
/// creases, cells of up to 4 × 4 pixels are kept if each of their pixels has a corner on its own surface.
/// Error targets of 3e-5 and below treat sharp convex edges as such discontinuities too, since grooves finer
/// than a pixel run along them.
///
/// Finally cracks between levels are closed. Corners of finer cells on or beside the edges of a kept cell are
/// compared with its interpolated values there, and a cell whose difference exceeds the tolerance is split.
/// No crack between levels is therefore wider than the tolerance, and a thin shadow that one cell has found
/// is followed through its neighbours. A shadow that passes between all corners is missed.
///
/// The samples of a cell are its corners: top left, top right, bottom left, bottom right. Corners that
/// coincide at the image's border occur once, and those without geometry never. A single-pixel cell has its
/// own sample. All samples have level 0: they are single pixels.
#[derive(Debug, Default)]
pub struct Lattice {
    config: LatticeConfig,
    plan: SamplingPlan,
    steps: Steps,
    discontinuities: Discontinuities,
    /// Sample of every pixel, or [`NONE`].
    corners: Vec<u32>,
    /// Visible fraction of every sample, of a textured light that of all channels together; NaN where the light lies below its horizon.
    fractions: Vec<f32>,
    /// Visible fractions of red, green and blue of every sample, for a textured light.
    colours: Vec<[f32; 3]>,
    /// Strata of a textured light.
    strata: StrataTable,
    /// Expected squared error of every sample's fraction, for a bound on visible errors; after smoothing if `smoothed`.
    variances: Vec<f32>,
    smoothed: bool,
    /// Smoothed fractions of all samples.
    estimates: Vec<Estimate>,
    /// Flag of every sample: true if it is in umbra beside the penumbra.
    beside: Vec<bool>,
    /// Numbers of samples along a side of the light that pilot samples would need.
    sides: Vec<f32>,
    /// Unshadowed irradiance per radiance of every sample, for an error target.
    unshadowed: Vec<f32>,
    /// Number of pixels that see geometry, for an error target.
    receivers: usize,
    /// Results of validation, and the pixels that it traces.
    risk: Risk,
    probes: Vec<Probe>,
    weighed: Vec<Weighed>,
    /// Kept cells by their estimated squared error per pixel, and indices of those that are split by
    /// validation.
    ranked: Vec<(f64, u32)>,
    off: Vec<u32>,
    /// Receivers that see part of the light, and their samples.
    partly: Vec<u32>,
    partly_samples: Vec<u32>,
    /// Visible fractions computed with more samples.
    renewed: Vec<f32>,
    /// Pixels from which the noise of the frame is estimated.
    measurements: Vec<Measurement>,
    neighbours: Vec<Neighbours>,
    /// Last measured noise of traced pixels, and the number of cells at that time.
    measured: Option<(usize, Measured)>,
    expected: Option<f64>,
    /// Cells to classify, by level.
    pending: Vec<Vec<Square>>,
    /// Verdicts on `pending` or on `kept`.
    verdicts: Vec<Verdict>,
    /// Pixels whose masks the current level requests.
    wanted: PixelSet,
    fresh: Vec<u32>,
    /// Cells above one pixel that have been kept, and their verdicts; none where they were split later.
    kept: Vec<Option<(Square, Verdict)>>,
    /// Index in `kept` of the cell that contains each block of 2 × 2 pixels, or [`NONE`].
    owners: Vec<u32>,
    /// Pixels that have got a mask since the last crack test, and the level of the cells that requested them.
    recent: Vec<(u32, u8)>,
    /// Flag of every kept cell: true if such pixels lie on or beside its edges. Indices of the flagged cells.
    suspected: Vec<AtomicBool>,
    suspects: Vec<u32>,
    closing_cracks: bool,
    /// Cells for which certificates are requested, their receivers' bounds, and the certificates.
    certified: Vec<Square>,
    regions: Vec<Region>,
    certificates: Vec<Certificate>,
    pilot: Vec<PilotSample>,
    certificate_counts: CertificateCounts,
}

impl Lattice {
    /// Creates a refiner with these options.
    pub fn new(config: LatticeConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// True if visible errors are bounded.
    fn bounds_visible_error(&self) -> bool {
        self.config.visible_error > 0.0 && self.config.target > 0.0
    }

    /// Level of the coarsest cells.
    fn top(&self) -> u8 {
        self.config.coarsest_level.min(MAX_LEVEL)
    }

    /// Processes all pending cells of a level: traces the new corners, then keeps or splits the cells.
    fn descend(
        &mut self,
        level: u8,
        view: &View,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        if self.pending[usize::from(level)].is_empty() {
            return;
        }
        let mut cells = std::mem::take(&mut self.pending[usize::from(level)]);
        let mut verdicts = std::mem::take(&mut self.verdicts);
        cells
            .par_iter()
            .with_min_len(256)
            .map(|&cell| self.classify(view, cell))
            .collect_into_vec(&mut verdicts);
        self.request(view, level, visibility, fragments);
        if level == self.top() && self.config.target > 0.0 {
            let pilot = self.plan.full;
            self.plan(view, fragments);
            // The coarsest cells have corners with the pilot samples only.
            if self.plan.full.len() > pilot.len() {
                self.top_up(view, 0, Purpose::Refine, visibility, fragments);
            }
            self.refine_noise(view, 0, Purpose::Refine, visibility, fragments);
        }
        if level > 0 {
            let measurements = cells.par_iter().zip(&mut verdicts).with_min_len(256);
            measurements.filter(|(_, verdict)| **verdict == Verdict::Keep).for_each(|(&cell, verdict)| {
                if !self.passes_split_test(view, cell) || !self.fits_target(view, cell) {
                    *verdict = Verdict::Split;
                }
            });
        }
        if self.config.certify && level > 0 {
            self.certify(view, &cells, &mut verdicts, visibility);
        }
        for (&cell, verdict) in cells.iter().zip(&verdicts) {
            match verdict {
                Verdict::Drop => {}
                Verdict::Split => self.split(cell),
                Verdict::Keep | Verdict::Lit | Verdict::Umbra if level > 0 => {
                    self.keep(view.gbuffer, cell, *verdict);
                }
                Verdict::Keep | Verdict::Lit | Verdict::Umbra => {
                    self.certificate_counts.traced += u64::from(self.config.certify);
                    let sample = self.corners[view.gbuffer.index(cell.x, cell.y)];
                    fragments.push_cell(0, cell.x, cell.y, &[sample]);
                }
            }
        }
        self.verdicts = verdicts;
        // Returned to keep its memory.
        cells.clear();
        self.pending[usize::from(level)] = cells;
    }

    /// Processes the cells that were split after being kept, from the coarsest level on.
    fn descend_all(&mut self, view: &View, visibility: &mut dyn Visibility, fragments: &mut Fragments) {
        for level in (0..self.top()).rev() {
            self.descend(level, view, visibility, fragments);
        }
    }

    /// Classifies a cell by geometry alone; requests the masks of its corners if that does not suffice.
    fn classify(&self, view: &View, cell: Square) -> Verdict {
        let gbuffer = view.gbuffer;
        if cell.x << cell.level >= gbuffer.width || cell.y << cell.level >= gbuffer.height {
            return Verdict::Drop;
        }
        let corners = cell.corners(gbuffer);
        match self.discontinuities.inside(cell.level, cell.x, cell.y) {
            // Without a discontinuity all of the cell's pixels see geometry if one of them does.
            Between::Nothing if !gbuffer.is_receiver(corners.pixels()[0]) => return Verdict::Drop,
            Between::Nothing => {}
            Between::Step if cell.level <= self.steps.level && view.serves(&corners, cell) => {}
            Between::Step | Between::Shade => return Verdict::Split,
        }
        for ((x, y), pixel) in corners.positions().into_iter().zip(corners.pixels()) {
            if self.corners[pixel] == NONE && gbuffer.is_receiver(pixel) {
                self.wanted.insert(x, y);
            }
        }
        Verdict::Keep
    }

    /// Splits cells without a sufficient certificate.
    fn certify(
        &mut self,
        view: &View,
        cells: &[Square],
        verdicts: &mut [Verdict],
        visibility: &mut dyn Visibility,
    ) {
        let Self { regions, certificates, .. } = self;
        if cells.first().is_some_and(|cell| cell.level < PROVE_LEVEL) {
            let kept = verdicts.iter_mut().filter(|verdict| **verdict == Verdict::Keep);
            kept.for_each(|verdict| *verdict = Verdict::Split);
            return;
        }
        let kept = || cells.iter().zip(&*verdicts).filter(|(_, verdict)| **verdict == Verdict::Keep);
        regions.clear();
        regions.extend(kept().map(|_| Region::EMPTY));
        self.certified.clear();
        self.certified.extend(kept().map(|(&cell, _)| cell));
        regions.par_iter_mut().zip(&self.certified).with_min_len(64).for_each(|(region, &cell)| {
            *region = view.region(cell);
        });
        visibility.certify(view.frame, view.light, regions, certificates);
        let kept = verdicts.iter_mut().filter(|verdict| **verdict == Verdict::Keep);
        for (verdict, (certificate, region)) in kept.zip(certificates.iter().zip(&*regions)) {
            *verdict = match certificate {
                _ if *region == Region::EMPTY => Verdict::Umbra,
                Certificate::Lit => Verdict::Lit,
                Certificate::Umbra => Verdict::Umbra,
                Certificate::Bounded(share) if *share <= MOST_UNSEEN => Verdict::Keep,
                Certificate::Bounded(_) | Certificate::Open => Verdict::Split,
            };
        }
    }

    fn split(&mut self, cell: Square) {
        let level = cell.level - 1;
        self.pending[usize::from(level)].extend((0..4).map(|child| Square {
            level,
            x: 2 * cell.x + (child & 1),
            y: 2 * cell.y + (child >> 1),
        }));
    }

    /// Visible fraction at a pixel; NaN where it is undefined or not traced.
    fn fraction(&self, pixel: usize) -> f32 {
        match self.corners[pixel] {
            NONE => NO_VALUE,
            sample => self.fractions[sample as usize],
        }
    }

    /// Number of channels in which samples may differ.
    fn channels(&self) -> usize {
        if self.colours.is_empty() { 1 } else { 3 }
    }

    /// Visible fraction of a channel at a pixel; NaN where it is undefined or not traced.
    fn fraction_of(&self, channel: usize, pixel: usize) -> f32 {
        match self.corners[pixel] {
            NONE => NO_VALUE,
            sample => match self.colours.get(sample as usize) {
                Some(colours) => colours[channel],
                None => self.fractions[sample as usize],
            },
        }
    }
}

impl Refiner for Lattice {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        let gbuffer = frame.gbuffer;
        let top = self.top();
        self.plan = if self.config.target > 0.0 {
            SamplingPlan::pilot(frame.pattern.kind, self.config.error)
        } else {
            SamplingPlan::fixed(frame.pattern, self.config.error)
        };
        self.steps = Steps::new(self.config.target);
        self.discontinuities.find(frame, light, &self.config.discontinuity, self.steps.edge, top);
        self.corners.clear();
        self.corners.resize(gbuffer.pixels(), NONE);
        self.wanted.reset(gbuffer.width, gbuffer.height);
        self.fractions.clear();
        self.colours.clear();
        self.strata.clear();
        self.unshadowed.clear();
        self.variances.clear();
        self.smoothed = false;
        self.risk = Risk::default();
        self.measured = None;
        self.receivers = if self.config.target > 0.0 {
            gbuffer
                .primitive
                .par_iter()
                .with_min_len(4096)
                .filter(|&&triangle| triangle != NO_PRIMITIVE)
                .count()
        } else {
            0
        };
        self.kept.clear();
        self.suspected.clear();
        self.recent.clear();
        self.closing_cracks = false;
        self.certificate_counts = CertificateCounts::default();
        self.owners.clear();
        self.owners.resize(gbuffer.width.div_ceil(2) as usize * gbuffer.height.div_ceil(2) as usize, NONE);
        let (columns, rows) = (gbuffer.width.div_ceil(1 << top), gbuffer.height.div_ceil(1 << top));
        self.pending.resize_with(usize::from(top) + 1, Vec::new);
        let all = (0..rows).flat_map(|y| (0..columns).map(move |x| Square { level: top, x, y }));
        self.pending[usize::from(top)].extend(all);
        let view =
            View { frame, gbuffer, light, planes: TangentPlanes::new(frame, &self.config.discontinuity) };
        // The coarse levels decide if refinement is cheaper than tracing every pixel.
        let mut dense = false;
        for level in (0..=top).rev() {
            self.descend(level, &view, visibility, fragments);
            dense = self.config.target > 0.0 && level > 0 && self.is_dense(gbuffer, level - 1);
            if dense {
                self.trace_all(&view, visibility, fragments);
                if self.config.validate {
                    self.raise(1.0, 0.0, &view, visibility, fragments);
                }
                break;
            }
        }
        let validates = self.config.target > 0.0 && self.config.validate && !dense;
        let (mut round, mut rounds) = (0, if validates { validate::ROUNDS } else { 0 });
        loop {
            while !dense && self.close_cracks(&view) {
                self.descend_all(&view, visibility, fragments);
            }
            if round == rounds {
                break;
            }
            if !self.validate(round, &view, visibility, fragments) {
                rounds = round + 1;
            }
            self.descend_all(&view, visibility, fragments);
            round += 1;
        }
        if self.bounds_visible_error() {
            self.refine_umbra(&view, visibility, fragments);
            self.denoise(&view, fragments);
        }
        self.expected = (self.config.target > 0.0).then(|| self.predict_error(&view, fragments));
        for &(cell, verdict) in self.kept.iter().flatten() {
            if self.config.certify {
                let pixels = view.receivers(cell);
                match verdict {
                    Verdict::Lit => self.certificate_counts.lit += pixels,
                    Verdict::Umbra => self.certificate_counts.umbra += pixels,
                    _ => self.certificate_counts.bounded += pixels,
                }
            }
            let mut own = [NONE; 4];
            let mut count = 0;
            for sample in cell.corners(gbuffer).pixels().map(|pixel| self.corners[pixel]) {
                if sample != NONE && !own[..count].contains(&sample) {
                    own[count] = sample;
                    count += 1;
                }
            }
            fragments.push_cell(cell.level, cell.x, cell.y, &own[..count]);
        }
        RefineOutput {
            expected_error: self.expected,
            fractions: &self.fractions,
            colours: &self.colours,
            certified: self.certificate_counts,
            levels: &[],
        }
    }

    fn patterns(&self, full: Pattern) -> Vec<Pattern> {
        if self.config.target > 0.0 { SamplingPlan::patterns(full.kind) } else { vec![full] }
    }

    /// Returns 0: discontinuities are found by the tangent-plane test, not in the pyramid.
    fn coarsest_level(&self) -> u8 {
        0
    }

    fn bytes(&self) -> usize {
        let pending: usize = self.pending.iter().map(Vec::capacity).sum();
        self.discontinuities.bytes()
            + (self.corners.capacity() + self.fractions.capacity() + self.fresh.capacity()) * 4
            + self.colours.capacity() * size_of::<[f32; 3]>()
            + self.strata.bytes()
            + pending * size_of::<Square>()
            + self.kept.capacity() * size_of::<Option<(Square, Verdict)>>()
            + (self.owners.capacity() + self.suspects.capacity()) * 4
            + self.recent.capacity() * size_of::<(u32, u8)>()
            + self.verdicts.capacity()
            + self.suspected.capacity()
            + (self.unshadowed.capacity() + self.variances.capacity() + self.sides.capacity()) * 4
            + self.estimates.capacity() * size_of::<Estimate>()
            + self.beside.capacity()
            + self.probes.capacity() * size_of::<Probe>()
            + self.weighed.capacity() * size_of::<Weighed>()
            + self.ranked.capacity() * size_of::<(f64, u32)>()
            + self.off.capacity() * 4
            + (self.partly.capacity() + self.partly_samples.capacity() + self.renewed.capacity()) * 4
            + self.pilot.capacity() * size_of::<PilotSample>()
            + self.measurements.capacity() * size_of::<Measurement>()
            + self.neighbours.capacity() * size_of::<Neighbours>()
            + self.certified.capacity() * size_of::<Square>()
            + self.regions.capacity() * size_of::<Region>()
            + self.certificates.capacity() * size_of::<Certificate>()
            + self.wanted.bytes()
    }
}
