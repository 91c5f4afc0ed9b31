//! Shadow rays: all rays of one receiver, or to one light sample, at once.
//!
//! The bundle goes through the hierarchy as a whole: a node is entered when any ray between the bounds of its directions
//! might enter it. For an axis-aligned light that is the exact pyramid from the receiver to the light. At a block the
//! planes of eight triangles are set up once for all rays, triangles out of the bundle's reach are dropped, and those
//! that stay meet the rays a vector at a time. In dense geometry, where a bundle as a whole meets far too much, its rays
//! get box tests of their own.

use super::Bvh;
use super::bundle::Bundle;
use super::layout::Child;
use super::slab::{Shaft, enters};
use super::stack::{Stacks, push_near_last};
use crate::occluder::{Block, Planes, Vector, exact};
use crate::simd::{Kernel, Lanes, Simd};

/// Rays for each node or block that a bundle visits as a whole before its rays have box tests of their own.
const RAYS_A_VISIT: usize = 2;

/// Nodes and blocks that a bundle visits as a whole at least.
const VISITS: usize = 16;

/// Rays so few that they are quicker by themselves: alone, each tests eight boxes at once.
pub(super) const ALONE: u32 = 4;

/// The bits of the first `count` rays.
#[inline(always)]
fn first(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

impl Bvh {
    /// Which rays of a finished bundle meet a triangle at 0 < t < 1.
    #[inline(always)]
    pub(super) fn occluded<S: Simd>(&self, bundle: &Bundle, stacks: &mut Stacks) -> u64 {
        S::call(Occluded { bvh: self, bundle, stacks })
    }

    #[inline(always)]
    fn whole<S: Simd>(&self, bundle: &Bundle, stacks: &mut Stacks) -> u64 {
        if self.nodes.is_empty() || bundle.count == 0 {
            return 0;
        }
        let shaft = Shaft::new(bundle.origin, bundle.low, bundle.high);
        let all = first(bundle.count);
        let mut alive = all;
        let mut budget = (bundle.count / RAYS_A_VISIT).max(VISITS);
        stacks.dense = false;
        stacks.whole[0] = 0;
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let child = stacks.whole[waiting];
            if budget == 0 {
                stacks.dense = true;
                alive = self.split::<S>(child, bundle, &shaft, alive, stacks);
            } else {
                budget -= 1;
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

    /// The same, one ray after another.
    #[inline(always)]
    pub(super) fn occluded_singly<S: Simd>(&self, bundle: &Bundle, stacks: &mut Stacks) -> u64 {
        let mut occluded = 0;
        for ray in 0..bundle.count {
            let hit = self.occludes::<S>(0, bundle.origin, bundle.end(ray), &mut stacks.single);
            occluded |= u64::from(hit) << ray;
        }
        occluded
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
        let mut within = shaft.within::<S>(block, &mut planes);
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
}

/// A bundle on its way through the hierarchy.
struct Occluded<'a> {
    bvh: &'a Bvh,
    bundle: &'a Bundle,
    stacks: &'a mut Stacks,
}

impl Kernel for Occluded<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self) -> u64 {
        self.bvh.whole::<S>(self.bundle, self.stacks)
    }
}
