//! What a frame will take and how wrong it will be, by what its masks show.

use glam::Vec3;
use halflight_core::fragment::{Cell, Fragments, Sample};
use halflight_core::hash;
use rayon::prelude::*;

use super::Lattice;
use super::view::View;
use crate::compose::luminance;
use crate::irradiance;
use crate::refine::target::{self, Neighbours, Plan, Trial};
use crate::unshadowed::unshadowed_many;

/// Samples whose unshadowed irradiance is computed together.
const SHINE: usize = 64;

/// Cells that the error of all is foretold by: within 7 % of what all foretell on seven scenes at two targets, a quarter as many
/// within 14 %.
const JUDGED: usize = 16_384;

impl Lattice {
    /// Computes the fractions of all samples from `known` on.
    pub(super) fn evaluate(&mut self, view: &View, known: usize, fragments: &Fragments) {
        let (samples, light) = (&fragments.samples()[known..], view.frame.light(view.light));
        self.fractions.resize(fragments.samples().len(), f32::NAN);
        self.fractions[known..].par_iter_mut().zip(samples).with_min_len(256).for_each(
            |(fraction, sample)| {
                let batch = fragments.batch(sample.batch);
                *fraction = irradiance::fraction(light, batch, sample.first as usize).unwrap_or(f32::NAN);
            },
        );
    }

    /// Chooses samples and cells by what the corners so far have shown.
    pub(super) fn plan(&mut self, view: &View, fragments: &Fragments) {
        self.shining.clear();
        self.shining.extend(fragments.samples().iter().map(|sample| sample.pixel));
        self.shine(view);
        let neighbours = Neighbours::new(self.plan.full);
        let trial = |(sample, (&fraction, &unshadowed)): (&Sample, (&f32, &f32))| {
            let (variance, torn) = neighbours.variance(fragments.batch(sample.batch), sample.first as usize);
            Trial { unshadowed, fraction, variance, torn }
        };
        let known = self.fractions.par_iter().zip(&self.unshadowed);
        fragments.samples().par_iter().zip(known).map(trial).collect_into_vec(&mut self.trial);
        self.plan = Plan::reach(self.config.target, view.frame.pattern.kind, &self.trial);
    }

    /// Computes the unshadowed irradiance of pixels.
    fn shine(&mut self, view: &View) {
        let light = view.frame.light(view.light);
        self.unshadowed.clear();
        self.unshadowed.resize(self.shining.len(), 0.0);
        let blocks = self.unshadowed.par_chunks_mut(SHINE).zip(self.shining.par_chunks(SHINE));
        blocks.with_min_len(16).for_each(|(out, pixels)| {
            let (mut origins, mut normals) = ([Vec3::ZERO; SHINE], [Vec3::ZERO; SHINE]);
            for (lane, &pixel) in pixels.iter().enumerate() {
                if let Some(receiver) = view.gbuffer.receiver(pixel as usize) {
                    (origins[lane], normals[lane]) = (receiver.origin, receiver.normal);
                }
            }
            unshadowed_many(light, &origins[..pixels.len()], &normals[..pixels.len()], out);
        });
    }

    /// Expected squared error of the irradiance by luminance, summed over all pixels; by some of the cells where there are many.
    pub(super) fn expect(&mut self, view: &View, fragments: &Fragments) -> f64 {
        let cells = fragments.cells();
        let stride = cells.len().div_ceil(JUDGED).max(1);
        let mut neighbours = std::mem::take(&mut self.neighbours);
        neighbours.clear();
        neighbours.extend(fragments.batches().iter().map(|batch| Neighbours::new(batch.pattern())));
        let noise = |sample: &u32| {
            let sample = &fragments.samples()[*sample as usize];
            let own = &neighbours[usize::from(sample.batch)];
            own.variance(fragments.batch(sample.batch), sample.first as usize).0
        };
        let judge = |(place, group): (usize, &[Cell])| {
            let cell = group[hash::mix(place as u32) as usize % group.len()];
            let samples = fragments.cell_samples(&cell);
            let variance = if cell.level == 0 {
                samples.iter().map(|sample| f64::from(noise(sample))).sum()
            } else {
                let known = samples.iter().map(|sample| (self.fractions[*sample as usize], noise(sample)));
                target::cell_variance(known, self.plan.error)
            };
            let (x0, y0, x1, y1) = cell.pixels(fragments.width(), fragments.height());
            let pixels = f64::from((x1 - x0) * (y1 - y0)) * group.len() as f64;
            (cell, variance * pixels)
        };
        let mut judged = std::mem::take(&mut self.judged);
        cells.par_chunks(stride).enumerate().with_min_len(256).map(judge).collect_into_vec(&mut judged);
        judged.retain(|(_, variance)| *variance > 0.0);
        self.shining.clear();
        let samples = judged.iter().flat_map(|(cell, _)| fragments.cell_samples(cell));
        self.shining.extend(samples.map(|&sample| fragments.samples()[sample as usize].pixel));
        self.shine(view);
        let (mut sum, mut first) = (0.0, 0);
        for (cell, variance) in &judged {
            let last = first + fragments.cell_samples(cell).len();
            let power = self.unshadowed[first..last].iter().map(|&one| f64::from(one).powi(2)).sum::<f64>();
            sum += variance * power / (last - first) as f64;
            first = last;
        }
        (self.judged, self.neighbours) = (judged, neighbours);
        sum * f64::from(luminance(view.frame.light(view.light).radiance)).powi(2)
    }
}
