//! Sub-samples of edge pixels: which of them are traced, and what they see.
//!
//! If a straight edge parts a pixel's centre from its right neighbour and from none of the others, only sub-samples to the right of the
//! centre can lie beyond it; where it parts the centre from the right and the lower neighbour, only those to the right or below. The others see
//! what the centre sees, and are not traced. Where opposite neighbours differ there are several edges, and all sub-samples are traced.

use glam::Vec2;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use rayon::prelude::*;

use super::edges::{ABOVE, BELOW, Edge, LEFT, RIGHT, SIDES};
use crate::bvh::Bvh;
use crate::gbuffer::{SubSample, trace_sub_samples};

/// Sub-samples that are traced, and their surfaces.
#[derive(Default)]
pub(super) struct SubSamples {
    /// Index of the first sub-sample of each edge pixel, and the last one's end.
    starts: Vec<usize>,
    all: Vec<SubSample>,
    /// One entry a sub-sample.
    pub(super) surfaces: GBuffer,
}

/// Returns whether a sub-sample at `offset` may lie beyond an edge on one of `sides`.
fn may_differ(offset: Vec2, sides: u8) -> bool {
    let has = |side: u8| sides & side != 0;
    has(LEFT) && has(RIGHT)
        || has(ABOVE) && has(BELOW)
        || has(RIGHT) && offset.x > 0.0
        || has(LEFT) && offset.x < 0.0
        || has(BELOW) && offset.y > 0.0
        || has(ABOVE) && offset.y < 0.0
}

impl SubSamples {
    /// Lists the sub-samples of edge pixels that may see another surface than the centre, and traces them.
    pub(super) fn trace(&mut self, bvh: &Bvh, frame: &Frame, offsets: &[Vec2], edges: &[Edge]) {
        let mut masks = [0u16; SIDES];
        for (sides, mask) in (0..).zip(&mut masks) {
            for (number, &offset) in offsets.iter().enumerate() {
                *mask |= u16::from(may_differ(offset, sides)) << number;
            }
        }
        let Self { starts, all, surfaces } = self;
        starts.clear();
        all.clear();
        starts.push(0);
        for edge in edges {
            let mut mask = masks[usize::from(edge.sides) % SIDES];
            while mask != 0 {
                all.push(SubSample { pixel: edge.pixel, offset: mask.trailing_zeros() as u8 });
                mask &= mask - 1;
            }
            starts.push(all.len());
        }
        let size = (frame.gbuffer.width, frame.gbuffer.height);
        trace_sub_samples(bvh, frame.scene, size, offsets, all, surfaces);
    }

    /// Sub-samples, those of each edge pixel one after another.
    pub(super) fn all(&self) -> &[SubSample] {
        &self.all
    }

    /// Index of the first sub-sample of each edge pixel, and the last one's end.
    pub(super) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// Parts values of all sub-samples into those of `count` edge pixels each, with the places where the pixels begin.
    pub(super) fn split<'a, T: Send>(
        &'a self,
        values: &'a mut [T],
        count: usize,
    ) -> impl IndexedParallelIterator<Item = (&'a [usize], &'a mut [T])> {
        let edges = self.starts.len().saturating_sub(1);
        let mut rest = values;
        let mut parts = Vec::with_capacity(edges.div_ceil(count));
        for first in (0..edges).step_by(count) {
            let starts = &self.starts[first..=(first + count).min(edges)];
            let part;
            (part, rest) = rest.split_at_mut(starts[starts.len() - 1] - starts[0]);
            parts.push((starts, part));
        }
        parts.into_par_iter()
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.starts.capacity() * size_of::<usize>()
            + self.all.capacity() * size_of::<SubSample>()
            + self.surfaces.bytes()
    }
}

#[cfg(test)]
mod tests {
    use halflight_core::subpixel;

    use super::*;

    #[test]
    fn sub_samples_beyond_a_straight_edge_are_traced() {
        let neighbours = [(RIGHT, Vec2::X), (BELOW, Vec2::Y), (LEFT, Vec2::NEG_X), (ABOVE, Vec2::NEG_Y)];
        let (mut beyond, mut traced, mut all) = (0, 0, 0);
        for turn in 0..360 {
            let normal = Vec2::from_angle((turn as f32).to_radians());
            for distance in 1..100 {
                let far = |point: Vec2| normal.dot(point) > distance as f32 * 0.01;
                let differ = neighbours.iter().filter(|(_, point)| far(*point));
                let sides: u8 = differ.map(|(side, _)| side).sum();
                for &offset in subpixel::offsets(16).unwrap() {
                    assert!(!far(offset) || may_differ(offset, sides), "{turn} {distance} {offset}");
                    beyond += u32::from(far(offset));
                    traced += u32::from(may_differ(offset, sides));
                    all += 1;
                }
            }
        }
        assert!(beyond < traced && traced * 5 < all * 3, "{beyond} {traced} {all}");
    }
}
