//! Tracing of masks: those of new samples, and those of samples that need more light samples.

use halflight_core::fragment::{Fragments, Sample};
use halflight_core::gbuffer::GBuffer;
use halflight_core::mask::Purpose;
use halflight_core::pattern::Pattern;
use halflight_core::stages::Visibility;
use rayon::prelude::*;

use super::view::View;
use super::{Lattice, NOISE_IN_VISIBLE_ERROR, NONE, PROVE_LEVEL, Square};
use crate::refine::target::Budget;
use crate::refine::trace_pixels;

impl Lattice {
    /// Traces the requested masks, each of a new sample, and computes their visible fractions.
    pub(super) fn request(
        &mut self,
        view: &View,
        level: u8,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        let purpose = if level == 0 { Purpose::Final } else { Purpose::Refine };
        let known = fragments.samples().len();
        self.wanted.drain(&mut self.fresh);
        if self.fresh.is_empty() {
            return;
        }
        let batch = fragments.open_batch(self.plan.first, purpose);
        for (query, &pixel) in (0..).zip(&self.fresh) {
            let sample = Sample::of_pixel(pixel, view.gbuffer.width, 0, batch, query);
            self.corners[pixel as usize] = fragments.push_sample(sample);
        }
        trace_pixels(view.frame, view.light, &self.fresh, visibility, fragments.batch_mut(batch));
        self.evaluate(view, known, fragments);
        if self.plan.full != self.plan.first {
            self.top_up(view, known, purpose, visibility, fragments);
        }
        self.refine_noise(view, known, purpose, visibility, fragments);
        self.recent.extend(self.fresh.iter().map(|&pixel| (pixel, level)));
    }

    /// Traces additional light samples for the receivers that see part of the light, among samples from
    /// `known` on.
    pub(super) fn top_up(
        &mut self,
        view: &View,
        known: usize,
        purpose: Purpose,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        self.partly.clear();
        self.partly_samples.clear();
        let samples = fragments.samples()[known..].iter().zip(&self.fractions[known..]);
        for (index, (sample, &fraction)) in (known as u32..).zip(samples) {
            if fraction > 0.0 && fraction < 1.0 {
                self.partly.push(sample.pixel);
                self.partly_samples.push(index);
            }
        }
        self.trace_again(view, self.plan.full, purpose, visibility, fragments);
    }

    /// Traces more light samples for the receivers whose noise would be visible, among samples from `known` on.
    pub(super) fn refine_noise(
        &mut self,
        view: &View,
        known: usize,
        purpose: Purpose,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        if !self.bounds_visible_error() || self.plan.fine.len() <= self.plan.full.len() {
            return;
        }
        let most = self.config.visible_error * NOISE_IN_VISIBLE_ERROR;
        self.partly.clear();
        self.partly_samples.clear();
        for index in known..self.fractions.len() {
            let (fraction, variance) = (self.fractions[index], self.variances[index]);
            let bright = self.plan.brightness(fraction, self.unshadowed[index]);
            if fraction > 0.0 && fraction < 1.0 && variance > (most * bright).powi(2) {
                self.partly.push(fragments.samples()[index].pixel);
                self.partly_samples.push(index as u32);
            }
        }
        self.trace_again(view, self.plan.fine, purpose, visibility, fragments);
    }

    /// Traces more light samples for receivers that seem to be in umbra beside others that are not.
    pub(super) fn refine_umbra(
        &mut self,
        view: &View,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        // The coarsest corners have pilot samples, whatever the plan.
        let fine = self.plan.fine.len();
        if fine <= usize::from(Budget::PILOT * Budget::PILOT) {
            return;
        }
        let mut beside = std::mem::take(&mut self.beside);
        let is_beside = |(index, &fraction): (usize, &f32)| {
            let sample = &fragments.samples()[index];
            fraction == 0.0
                && fragments.batch(sample.batch).pattern().len() < fine
                && self.is_beside_penumbra(view, sample.pixel)
        };
        self.fractions.par_iter().enumerate().with_min_len(256).map(is_beside).collect_into_vec(&mut beside);
        self.partly.clear();
        self.partly_samples.clear();
        for index in (0..beside.len()).filter(|&index| beside[index]) {
            self.partly.push(fragments.samples()[index].pixel);
            self.partly_samples.push(index as u32);
        }
        self.beside = beside;
        self.trace_again(view, self.plan.fine, Purpose::Final, visibility, fragments);
    }

    /// Traces the receivers in `partly` again with another pattern.
    pub(super) fn trace_again(
        &mut self,
        view: &View,
        pattern: Pattern,
        purpose: Purpose,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        if self.partly.is_empty() {
            return;
        }
        let batch = fragments.open_batch(pattern, purpose);
        trace_pixels(view.frame, view.light, &self.partly, visibility, fragments.batch_mut(batch));
        for (query, &sample) in (0..).zip(&self.partly_samples) {
            let sample = fragments.sample_mut(sample);
            (sample.batch, sample.first) = (batch, query);
        }
        let samples = std::mem::take(&mut self.partly_samples);
        self.evaluate_batch(view, fragments.batch(batch), &samples);
        self.partly_samples = samples;
    }

    /// True if the pending cells of this level contain so many pixels that tracing every pixel is cheaper.
    pub(super) fn is_dense(&self, gbuffer: &GBuffer, level: u8) -> bool {
        // Cells for which certificates can still be requested are not left to pixels.
        if self.config.certify && level >= PROVE_LEVEL {
            return false;
        }
        let Some(share) = self.plan.dense_share(level) else {
            return false;
        };
        let inside = |cell: &&Square| cell.x << level < gbuffer.width && cell.y << level < gbuffer.height;
        let left = self.pending[usize::from(level)].iter().filter(inside).count() << (2 * level);
        left as f32 > share * self.receivers as f32
    }

    /// Traces the masks of all receivers that have none, each a cell of its own.
    pub(super) fn trace_all(
        &mut self,
        view: &View,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        let gbuffer = view.gbuffer;
        self.plan = self.plan.every_pixel();
        self.kept.clear();
        self.pending.iter_mut().for_each(Vec::clear);
        for sample in 0..fragments.samples().len() {
            let pixel = fragments.samples()[sample].pixel;
            fragments.push_cell(0, pixel % gbuffer.width, pixel / gbuffer.width, &[sample as u32]);
        }
        let corners = &self.corners;
        self.wanted.insert_where(|pixel| corners[pixel] == NONE && gbuffer.is_receiver(pixel));
        self.wanted.drain(&mut self.fresh);
        let batch = fragments.open_batch(self.plan.full, Purpose::Final);
        trace_pixels(view.frame, view.light, &self.fresh, visibility, fragments.batch_mut(batch));
        let known = fragments.samples().len();
        fragments.push_pixels(batch, &self.fresh);
        if self.bounds_visible_error() {
            for (index, &pixel) in (known as u32..).zip(&self.fresh) {
                self.corners[pixel as usize] = index;
            }
            self.evaluate(view, known, fragments);
            self.refine_noise(view, 0, Purpose::Final, visibility, fragments);
        }
        self.certificate_counts.traced = if self.config.certify { fragments.cells().len() as u64 } else { 0 };
    }
}
