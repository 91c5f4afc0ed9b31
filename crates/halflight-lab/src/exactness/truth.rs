//! Brute force over all triangles of a scene. Boxes leave out only what cannot be met.

use std::collections::HashSet;

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::hash;
use halflight_core::mask::MaskBatch;
use halflight_cpu::brute_force::hides;
use rayon::prelude::*;

use super::Agreement;

/// Compares masks (`found`, laid out like the batch's) with brute force, receiver by receiver in an arbitrary order until
/// `pairs` of a receiver and a wanted sample have been compared.
pub(super) fn compare(
    frame: &Frame,
    batch: &MaskBatch,
    found: &[u64],
    pairs: u64,
    agreement: &mut Agreement,
) {
    let count =
        |query: usize| batch.wanted(query).iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
    let (mut chosen, mut known, mut sum) = (Vec::new(), HashSet::new(), 0);
    for draw in 0..batch.len() as u32 {
        if sum >= pairs {
            break;
        }
        let query = hash::fold(hash::mix(frame.seed), draw) as usize % batch.len();
        if known.insert(query) {
            sum += count(query);
            chosen.push(query);
        }
    }
    let masks: Vec<Vec<u64>> = chosen.par_iter().map(|&query| truth(frame, batch, query)).collect();
    for (&query, mask) in chosen.iter().zip(&masks) {
        let found = &found[query * batch.words()..];
        for ((&wanted, &truth), &found) in batch.wanted(query).iter().zip(mask).zip(found) {
            agreement.add(wanted, truth, found);
        }
    }
}

/// Returns the mask of a receiver over the samples that it wants.
///
/// A segment and a triangle that meet have a point in common, and so have the boxes around them. Boxes are compared
/// coordinate by coordinate, without arithmetic and so without rounding: what is left out here cannot be met.
fn truth(frame: &Frame, batch: &MaskBatch, query: usize) -> Vec<u64> {
    let (receiver, mesh) = (batch.queries()[query], &frame.scene.mesh);
    let (light, wanted) = (frame.light(batch.light()).seen_from(receiver.origin), batch.wanted(query));
    let samples = (0..batch.pattern().len()).filter(|sample| wanted[sample / 64] >> (sample % 64) & 1 != 0);
    let place = |sample: usize| light.point(batch.pattern().position(sample, receiver.key));
    let ends: Vec<(usize, Vec3)> = samples.map(|sample| (sample, place(sample))).collect();

    let all = Bounds::around(ends.iter().map(|&(_, end)| end).chain([receiver.origin]));
    let near: Vec<(usize, Bounds)> = (0..mesh.triangle_count())
        .map(|triangle| (triangle, Bounds::around(mesh.corners(triangle))))
        .filter(|(_, bounds)| bounds.touches(&all))
        .collect();
    let mut visible = vec![0; wanted.len()];
    for (sample, end) in ends {
        let segment = Bounds::around([receiver.origin, end]);
        let mut triangles = near.iter().filter(|(_, bounds)| bounds.touches(&segment));
        let hidden = triangles.any(|&(triangle, _)| hides(mesh, triangle, receiver.origin, end));
        visible[sample / 64] |= u64::from(!hidden) << (sample % 64);
    }
    visible
}

/// Smallest closed box around points.
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        let empty = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };
        let grown = |b: Self, p| Self { low: b.low.min(p), high: b.high.max(p) };
        points.into_iter().fold(empty, grown)
    }

    fn touches(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}
