//! Visible fraction of what a lobe reflects, by shadow rays to points that are distributed as the lobe reflects the light.

use glam::{Vec2, Vec3};
use halflight_core::hash;

use super::cells::{Cells, Emitter};
use super::lobe::Lobe;
use crate::bvh::RAYS;
use crate::segments::{Occluders, Segments};

/// Tracer of shadow rays and its working memory.
pub(super) struct Tracer {
    segments: Segments,
    points: Vec<Point>,
    /// Sums over the points that are visible, and over all.
    sums: [Vec3; 2],
}

/// Point of the light.
#[derive(Clone, Copy, Debug)]
struct Point {
    end: Vec3,
    /// Light that the lobe reflects around it, over its density, by channel.
    weight: Vec3,
}

impl Default for Tracer {
    fn default() -> Self {
        Self { segments: Segments::default(), points: Vec::new(), sums: [Vec3::ZERO; 2] }
    }
}

impl Tracer {
    /// Traces `count` rays. Returns the visible fraction by channel, and the number of rays.
    pub(super) fn visible(
        &mut self,
        occluders: Occluders,
        emitter: &Emitter,
        lobe: &Lobe,
        cells: &Cells,
        origin: Vec3,
        count: usize,
        key: u32,
    ) -> (Vec3, u64) {
        self.choose(emitter, lobe, cells, count, key);
        self.sums = [Vec3::ZERO; 2];
        let mut points = std::mem::take(&mut self.points);
        // All of them, even where the first ones agree: stopping there would be biased, and leave black pixels where a few percent are visible.
        let rays = self.trace(occluders, origin, points.iter());
        points.clear();
        self.points = points;
        let [seen, all] = self.sums;
        // Channels in which nothing is emitted have no fraction, and need none.
        let part = |seen: f32, all: f32| if all > 0.0 { seen / all } else { 0.0 };
        (Vec3::new(part(seen.x, all.x), part(seen.y, all.y), part(seen.z, all.z)), rays)
    }

    /// Traces rays, packet by packet, and adds them to the sums. Returns their number.
    fn trace<'a>(
        &mut self,
        occluders: Occluders,
        origin: Vec3,
        points: impl Iterator<Item = &'a Point>,
    ) -> u64 {
        let (mut weights, mut count, mut rays) = ([Vec3::ZERO; RAYS], 0, 0);
        let mut points = points.peekable();
        while let Some(point) = points.next() {
            self.segments.set_end(count, point.end);
            weights[count] = point.weight;
            count += 1;
            if count == RAYS || points.peek().is_none() {
                let hidden = self.segments.hidden(occluders, origin, count);
                for (ray, &weight) in weights[..count].iter().enumerate() {
                    self.sums[1] += weight;
                    if hidden >> ray & 1 == 0 {
                        self.sums[0] += weight;
                    }
                }
                rays += count as u64;
                count = 0;
            }
        }
        rays
    }

    /// Chooses points: cells by their shares, at equal steps through the sum of these, and in each cell uniformly.
    fn choose(&mut self, emitter: &Emitter, lobe: &Lobe, cells: &Cells, count: usize, key: u32) {
        self.points.clear();
        let (shift, _) = hash::unit_pair(hash::sample_bits(key, u32::MAX));
        let scramble = hash::sample_bits(key, u32::MAX - 1);
        let step = cells.share / count as f32;
        let (mut below, mut sample) = (0.0f32, 0usize);
        for cell in &cells.all {
            let above = below + cell.share;
            while sample < count {
                let at = (sample as f32 + shift) * step;
                if at >= above {
                    break;
                }
                // The rest of the number is uniform inside the cell's share. The other coordinate is van der Corput's sequence, scrambled, so
                // that samples near each other in one differ in the other (Hammersley's points).
                let along = ((at - below) / cell.share).clamp(0.0, 1.0);
                let reversed = (sample as u32).reverse_bits() ^ scramble;
                let across = (reversed >> 8) as f32 * (1.0 / 16_777_216.0);
                let root = along.sqrt();
                let [a, b, c] = cell.corners;
                let uv = a + (b - a) * (root * (1.0 - across)) + (c - a) * (root * across);
                self.push(emitter, lobe, uv, cell.share, 0.5 * (b - a).perp_dot(c - a).abs());
                sample += 1;
            }
            below = above;
        }
    }

    fn push(&mut self, emitter: &Emitter, lobe: &Lobe, uv: Vec2, share: f32, area: f32) {
        let (value, _) = emitter.reflected(lobe, emitter.point(uv));
        let weight = emitter.factors(uv, 0.0) * (value * area / share);
        // As light samples are placed, whose distance from surfaces behind the light is known.
        let end = emitter.end(uv);
        self.points.push(Point { end, weight });
    }
}
