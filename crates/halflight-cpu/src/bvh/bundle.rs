//! All rays of one receiver at once.
//!
//! The bundle goes through the hierarchy as a whole: a node is entered when any ray between the bounds of its directions
//! might enter it. For an axis-aligned light that is the exact pyramid from the receiver to the light. At a block the
//! planes of eight triangles are set up once for all rays, triangles out of the bundle's reach are dropped, and those
//! that stay meet the rays a vector at a time.

use glam::Vec3;

use super::facet::Facets;
use super::layout::{Block, Child};
use super::slab::{Shaft, enters, inverse};
use super::vector::Vector;
use super::{Bvh, STACK, exact, push_near_last, push_sorted};
use crate::simd::{Lanes, Simd};

/// Rays of a bundle.
pub(crate) const RAYS: usize = 64;

/// Nodes and blocks that a bundle visits as a whole before its rays have box tests of their own.
const BUDGET: u32 = 32;

/// Rays so few that they are quicker by themselves.
const ALONE: u32 = 2;

/// Room for what is still to be visited.
pub(super) struct Stacks {
    whole: [u32; STACK],
    split: [(u32, u64); STACK],
    pub(super) single: [u32; STACK],
}

impl Stacks {
    pub(super) fn new() -> Self {
        Self { whole: [0; STACK], split: [(0, 0); STACK], single: [0; STACK] }
    }
}

/// Up to 64 rays from one origin.
#[derive(Clone)]
pub(crate) struct Bundle {
    origin: Vec3,
    count: usize,
    /// Where shadow rays end.
    ends: [[f32; RAYS]; 3],
    d: [[f32; RAYS]; 3],
    inverse: [[f32; RAYS]; 3],
    low: Vec3,
    high: Vec3,
}

/// The nearest hit of every ray of a bundle.
pub(crate) struct Hits {
    /// Ray parameter; infinite for a miss.
    pub(crate) t: [f32; RAYS],
    /// Triangle; `u32::MAX` for a miss.
    pub(crate) triangle: [u32; RAYS],
}

/// [`Facets`] in memory, to pick one triangle at a time.
struct Planes {
    edges: [[[f32; 8]; 3]; 3],
    face: [[f32; 8]; 3],
    distance: [f32; 8],
    edge_error: [f32; 8],
    face_error: [f32; 8],
}

impl Planes {
    fn new() -> Self {
        Self {
            edges: [[[0.0; 8]; 3]; 3],
            face: [[0.0; 8]; 3],
            distance: [0.0; 8],
            edge_error: [0.0; 8],
            face_error: [0.0; 8],
        }
    }

    #[inline(always)]
    fn set<L: Lanes>(&mut self, facets: &Facets<L>) {
        facets.edges[0].store(&mut self.edges[0], 0);
        facets.edges[1].store(&mut self.edges[1], 0);
        facets.edges[2].store(&mut self.edges[2], 0);
        facets.face.store(&mut self.face, 0);
        facets.distance.store(&mut self.distance);
        facets.edge_error.store(&mut self.edge_error);
        facets.face_error.store(&mut self.face_error);
    }

    /// Sets up a block and returns the triangles in it that the bundle may meet, at t < 1 where `near`.
    #[inline(always)]
    fn within<S: Simd>(&mut self, block: &Block, bundle: &Bundle, shaft: &Shaft, near: bool) -> u32 {
        let facets =
            Facets::<S::Eight>::new(block, Vector::splat(bundle.origin), Vector::splat(shaft.reach()));
        let within = shaft.meets(&facets, near) & block.occupied();
        if within != 0 {
            self.set(&facets);
        }
        within
    }

    /// One triangle in all lanes.
    #[inline(always)]
    fn facet<L: Lanes>(&self, lane: usize) -> Facets<L> {
        Facets {
            edges: [
                Vector::broadcast(&self.edges[0], lane),
                Vector::broadcast(&self.edges[1], lane),
                Vector::broadcast(&self.edges[2], lane),
            ],
            face: Vector::broadcast(&self.face, lane),
            distance: L::splat(self.distance[lane]),
            edge_error: L::splat(self.edge_error[lane]),
            face_error: L::splat(self.face_error[lane]),
        }
    }
}

impl Bundle {
    pub(crate) fn new() -> Self {
        Self {
            origin: Vec3::ZERO,
            count: 0,
            ends: [[0.0; RAYS]; 3],
            d: [[0.0; RAYS]; 3],
            inverse: [[0.0; RAYS]; 3],
            low: Vec3::ZERO,
            high: Vec3::ZERO,
        }
    }

    /// Starts anew with an origin and no rays.
    #[inline(always)]
    pub(crate) fn clear(&mut self, origin: Vec3) {
        (self.origin, self.count) = (origin, 0);
    }

    /// Number of rays.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Adds a ray along `d` unless there are 64.
    #[inline(always)]
    pub(crate) fn push(&mut self, d: Vec3) {
        if self.count < RAYS {
            for axis in 0..3 {
                self.d[axis][self.count] = d[axis];
            }
            self.count += 1;
        }
    }

    /// Adds a shadow ray that stops at `end` unless there are 64.
    #[inline(always)]
    pub(super) fn push_end(&mut self, end: Vec3) {
        if self.count < RAYS {
            for axis in 0..3 {
                self.ends[axis][self.count] = end[axis];
            }
        }
        self.push(end - self.origin);
    }

    /// The direction of a ray.
    #[inline(always)]
    pub(crate) fn direction(&self, ray: usize) -> Vec3 {
        Vec3::new(self.d[0][ray], self.d[1][ray], self.d[2][ray])
    }

    /// The end of a shadow ray.
    #[inline(always)]
    pub(super) fn end(&self, ray: usize) -> Vec3 {
        Vec3::new(self.ends[0][ray], self.ends[1][ray], self.ends[2][ray])
    }

    #[inline(always)]
    pub(super) fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Reciprocals and bounds, once all rays are there. Unused lanes repeat the first ray.
    #[inline(always)]
    pub(crate) fn finish<S: Simd>(&mut self) {
        let width = S::Wide::WIDTH;
        let filled = self.count.next_multiple_of(width);
        for axis in 0..3 {
            for ray in self.count..filled {
                self.d[axis][ray] = self.d[axis][0];
            }
            let first = S::Wide::splat(self.d[axis][0]);
            let (mut low, mut high) = (first, first);
            for at in (0..filled).step_by(width) {
                let d = S::Wide::load(&self.d[axis][at..]);
                (low, high) = (low.min(d), high.max(d));
                inverse(d).store(&mut self.inverse[axis][at..]);
            }
            let (mut lows, mut highs) = ([0.0f32; 16], [0.0f32; 16]);
            low.store(&mut lows);
            high.store(&mut highs);
            self.low[axis] = lows[..width].iter().fold(f32::INFINITY, |a, &b| a.min(b));
            self.high[axis] = highs[..width].iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
        }
    }
}

impl Hits {
    pub(crate) fn new() -> Self {
        Self { t: [f32::INFINITY; RAYS], triangle: [u32::MAX; RAYS] }
    }
}

/// The bits of the first `count` rays.
#[inline(always)]
fn first(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

impl Bvh {
    /// Which rays of a finished bundle meet a triangle at 0 < t < 1.
    #[inline(always)]
    pub(super) fn occluded<S: Simd>(&self, bundle: &Bundle, stacks: &mut Stacks) -> u64 {
        if self.nodes.is_empty() || bundle.count == 0 {
            return 0;
        }
        let shaft = Shaft::new(bundle.origin, bundle.low, bundle.high);
        let all = first(bundle.count);
        let mut alive = all;
        let mut visits = 0;
        stacks.whole[0] = 0;
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let child = stacks.whole[waiting];
            if visits == BUDGET {
                alive = self.split::<S>(child, bundle, &shaft, alive, stacks);
            } else {
                visits += 1;
                match Child::decode(child) {
                    Child::Node(index) => {
                        let node = &self.nodes[index as usize];
                        let (low, high) = node.bounds::<S::Eight>();
                        let (mask, enter) = shaft.enters(low, high, 1.0);
                        waiting =
                            push_near_last(node, mask & node.occupied(), enter, &mut stacks.whole, waiting);
                    }
                    Child::Block(index) => {
                        alive = self.shadow_block::<S>(
                            &self.blocks[index as usize],
                            bundle,
                            &shaft,
                            alive,
                            alive,
                        );
                    }
                }
            }
            if alive == 0 {
                break;
            }
        }
        all & !alive
    }

    /// The rays out of `alive` that everything under `root` leaves, when it is too dense for the bundle as a whole: every
    /// ray has its own box tests, and rays that are left nearly alone go on by themselves.
    #[inline(always)]
    fn split<S: Simd>(
        &self,
        root: u32,
        bundle: &Bundle,
        shaft: &Shaft,
        mut alive: u64,
        stacks: &mut Stacks,
    ) -> u64 {
        let width = S::Wide::WIDTH;
        let origin = Vector::<S::Wide>::splat(bundle.origin);
        let end = S::Wide::splat(1.0);
        stacks.split[0] = (root, alive);
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (child, mut rays) = stacks.split[waiting];
            rays &= alive;
            if rays == 0 {
                continue;
            }
            if rays.count_ones() <= ALONE {
                while rays != 0 {
                    let ray = rays.trailing_zeros() as usize;
                    rays &= rays - 1;
                    if self.occludes::<S>(child, bundle.origin, bundle.end(ray), &mut stacks.single) {
                        alive &= !(1 << ray);
                    }
                }
                continue;
            }
            match Child::decode(child) {
                Child::Node(index) => {
                    let node = &self.nodes[index as usize];
                    let (low, high) = node.bounds::<S::Eight>();
                    let (mask, enter) = shaft.enters(low, high, 1.0);
                    let mut left = mask & node.occupied();
                    let mut distances = [0.0f32; 8];
                    enter.store(&mut distances);
                    let (bottom, mut nearest, mut least) = (waiting, waiting, f32::INFINITY);
                    while left != 0 {
                        let slot = left.trailing_zeros() as usize;
                        left &= left - 1;
                        let (low, high) = node.child_bounds::<S::Wide>(slot);
                        let mut inside = 0;
                        for at in (0..bundle.count).step_by(width) {
                            let some = (rays >> at) as u32 & S::Wide::ALL;
                            if some != 0 {
                                let inverse = Vector::load(&bundle.inverse, at);
                                inside |= u64::from(some & enters(low, high, origin, inverse, end).0) << at;
                            }
                        }
                        if inside != 0 {
                            stacks.split[waiting] = (node.child(slot), inside);
                            if distances[slot] < least {
                                (nearest, least) = (waiting, distances[slot]);
                            }
                            waiting += 1;
                        }
                    }
                    if waiting > bottom {
                        stacks.split.swap(nearest, waiting - 1);
                    }
                }
                Child::Block(index) => {
                    alive = self.shadow_block::<S>(&self.blocks[index as usize], bundle, shaft, alive, rays);
                }
            }
        }
        alive
    }

    /// The rays out of `alive` that a block leaves when those in `rays` are tested.
    #[inline(always)]
    fn shadow_block<S: Simd>(
        &self,
        block: &Block,
        bundle: &Bundle,
        shaft: &Shaft,
        alive: u64,
        rays: u64,
    ) -> u64 {
        let mut planes = Planes::new();
        let mut within = planes.within::<S>(block, bundle, shaft, true);
        let width = S::Wide::WIDTH;
        let mut left = rays;
        while within != 0 && left != 0 {
            let lane = within.trailing_zeros() as usize;
            within &= within - 1;
            let facet = planes.facet::<S::Wide>(lane);
            for at in (0..bundle.count).step_by(width) {
                let some = (left >> at) as u32 & S::Wide::ALL;
                if some == 0 {
                    continue;
                }
                let (may, surely) = facet.shadow(Vector::load(&bundle.d, at));
                if some & may != 0 {
                    left &= !(u64::from(some & surely) << at);
                    let mut open = some & may & !surely;
                    while open != 0 {
                        let ray = at + open.trailing_zeros() as usize;
                        open &= open - 1;
                        if exact::meets(bundle.origin, bundle.end(ray), block.triangle_corners(lane)) {
                            left &= !(1 << ray);
                        }
                    }
                }
            }
        }
        alive & !(rays & !left)
    }

    /// The nearest triangle that each ray of a finished bundle meets at t > 0; of several at the same t the one with
    /// the lowest index.
    #[inline(always)]
    pub(crate) fn nearest<S: Simd>(&self, bundle: &Bundle, stack: &mut [(u32, f32); STACK], hits: &mut Hits) {
        *hits = Hits::new();
        if self.nodes.is_empty() || bundle.count == 0 {
            return;
        }
        let shaft = Shaft::new(bundle.origin, bundle.low, bundle.high);
        let mut end = f32::INFINITY;
        stack[0] = (0, 0.0);
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (child, enter) = stack[waiting];
            if enter > end {
                continue;
            }
            match Child::decode(child) {
                Child::Node(index) => {
                    let node = &self.nodes[index as usize];
                    let (low, high) = node.bounds::<S::Eight>();
                    let (mask, enter) = shaft.enters(low, high, end);
                    waiting = push_sorted(node, mask & node.occupied(), enter, stack, waiting);
                }
                Child::Block(index) => {
                    if self.nearest_in_block::<S>(&self.blocks[index as usize], bundle, &shaft, hits) {
                        end = hits.t[..bundle.count].iter().fold(0.0, |a: f32, &t| a.max(t));
                    }
                }
            }
        }
    }

    /// Whether any ray found a nearer hit in a block. Rays within rounding of an edge hit both its triangles, so that
    /// none passes between them.
    #[inline(always)]
    fn nearest_in_block<S: Simd>(
        &self,
        block: &Block,
        bundle: &Bundle,
        shaft: &Shaft,
        nearest: &mut Hits,
    ) -> bool {
        let mut planes = Planes::new();
        let mut within = planes.within::<S>(block, bundle, shaft, false);
        let width = S::Wide::WIDTH;
        let mut found = false;
        while within != 0 {
            let lane = within.trailing_zeros() as usize;
            within &= within - 1;
            let facet = planes.facet::<S::Wide>(lane);
            for at in (0..bundle.count).step_by(width) {
                let best = S::Wide::load(&nearest.t[at..]);
                let (mut hits, t) = facet.nearest(Vector::load(&bundle.d, at), best);
                if hits != 0 {
                    found = true;
                    let mut slots = [0.0f32; 16];
                    t.store(&mut slots);
                    while hits != 0 {
                        let slot = hits.trailing_zeros() as usize;
                        hits &= hits - 1;
                        let (ray, triangle) = (at + slot, block.triangle(lane));
                        if slots[slot] < nearest.t[ray] || triangle < nearest.triangle[ray] {
                            (nearest.t[ray], nearest.triangle[ray]) = (slots[slot], triangle);
                        }
                    }
                }
            }
        }
        found
    }
}
