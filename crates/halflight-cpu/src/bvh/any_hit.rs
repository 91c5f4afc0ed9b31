//! Shadow rays: all rays of one receiver, or to one light sample, at once.
//!
//! The packet goes through the BVH as a whole: the first nodes are entered when any ray between the bounds of its
//! directions might enter them, later ones by the rays whose own box tests pass. At a block the planes of eight triangles
//! are set up once for all rays, triangles out of reach of each group of 16 rays are dropped, and those that stay meet the
//! rays a vector at a time. Where few rays are left, each is tested by itself against eight boxes or eight triangles at
//! once. Children are taken in the order of their slots: any hit will do, and order gains less than it costs.

use super::Bvh;
use super::layout::{Child, Node};
use super::packet::{GROUP, Packet, RAYS};
use super::slab::{Shaft, enters};
use super::stack::Stacks;
use crate::occluder::{Block, Facets, Planes, Spokes, Vector, exact};
use crate::simd::{Kernel, Lanes, Simd};

/// Rays so few that each is tested against a node's eight boxes at once, instead of each box against vectors of rays.
const FEW: u32 = 8;

/// Nodes that a packet enters as a whole before its rays have box tests of their own.
const COARSE: u32 = 3;

/// Rays so few that each is tested against a block's eight triangles at once, instead of each triangle against vectors of rays.
const DIRECT: u32 = 10;

/// The bits of the first `count` rays.
#[inline(always)]
fn first(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

impl Bvh {
    /// Which rays of a finished packet meet a triangle at 0 < t < 1.
    #[inline(always)]
    pub(super) fn occluded<S: Simd>(&self, packet: &Packet, stacks: &mut Stacks) -> u64 {
        S::call(Occluded { bvh: self, packet, stacks })
    }

    #[inline(always)]
    fn whole<S: Simd>(&self, packet: &Packet, stacks: &mut Stacks) -> u64 {
        if self.nodes.is_empty() || packet.count == 0 {
            return 0;
        }
        let shaft = Shaft::new(packet.origin, packet.low, packet.high);
        let all = first(packet.count);
        let mut alive = all;
        let mut budget = COARSE;
        stacks.split[0] = (0, alive);
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (index, rays) = stacks.split[waiting];
            let rays = rays & alive;
            if rays == 0 {
                continue;
            }
            let node = &self.nodes[index as usize];
            let coarse = budget > 0;
            budget = budget.saturating_sub(1);
            let few = rays.count_ones() <= FEW;
            let (mask, by_slot) = if few {
                entered_by_rays::<S>(node, packet, rays)
            } else {
                let (low, high) = node.bounds::<S::Eight>();
                (shaft.enters(low, high, 1.0).0 & node.occupied(), 0)
            };
            let mut left = mask;
            while left != 0 {
                let slot = left.trailing_zeros() as usize;
                left &= left - 1;
                match Child::decode(node.child(slot)) {
                    Child::Node(child) => {
                        let inside = if few {
                            S::deposit(by_slot >> (8 * slot) & 0xff, rays)
                        } else if coarse {
                            rays
                        } else {
                            entered::<S>(node, slot, packet, rays)
                        };
                        if inside != 0 {
                            stacks.split[waiting] = (child, inside);
                            waiting += 1;
                        }
                    }
                    Child::Block(child) => {
                        let inside = if few {
                            S::deposit(by_slot >> (8 * slot) & 0xff, rays) & alive
                        } else {
                            entered::<S>(node, slot, packet, rays & alive)
                        };
                        if inside != 0 {
                            alive =
                                self.shadow_block::<S>(&self.blocks[child as usize], packet, alive, inside);
                        }
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
    pub(super) fn occluded_singly<S: Simd>(&self, packet: &Packet, stacks: &mut Stacks) -> u64 {
        let mut occluded = 0;
        for ray in 0..packet.count {
            let hit = self.occludes::<S>(0, packet.origin, packet.end(ray), &mut stacks.single);
            occluded |= u64::from(hit) << ray;
        }
        occluded
    }

    /// The rays out of `alive` that a block leaves when those in `rays` are tested.
    ///
    /// Few rays are tested one by one. For many, the planes of the triangles are set up once, triangles out of a group's
    /// reach are dropped, and each that is left is tested against vectors of rays.
    #[inline(always)]
    fn shadow_block<S: Simd>(&self, block: &Block, packet: &Packet, alive: u64, rays: u64) -> u64 {
        let reach = packet.low.abs().max(packet.high.abs());
        if rays.count_ones() <= DIRECT {
            return alive & !hidden_by_rays::<S>(block, Vector::splat(reach), packet, rays);
        }
        let facets = Facets::<S::Eight>::new(block, packet.origin, Vector::splat(reach));
        let mut within = [0u32; RAYS / GROUP];
        let mut any = 0;
        for (group, within) in within.iter_mut().enumerate() {
            if (rays >> (group * GROUP)) as u16 != 0 {
                let (low, high) = (Vector::splat(packet.lows[group]), Vector::splat(packet.highs[group]));
                *within = facets.reachable(low, high);
                any |= *within;
            }
        }
        if any == 0 {
            return alive;
        }
        alive & !hidden_by_triangles::<S>(block, &facets, any, &within, packet, rays)
    }
}

/// The children that up to eight rays enter, and a byte for each child with a bit for each of the rays that do.
#[inline(always)]
fn entered_by_rays<S: Simd>(node: &Node, packet: &Packet, rays: u64) -> (u32, u64) {
    let (low, high) = node.bounds::<S::Eight>();
    let (origin, end) = (Vector::<S::Eight>::splat(packet.origin), S::Eight::splat(1.0));
    let (mut rows, mut shift) = (0u64, 0);
    let mut left = rays;
    while left != 0 {
        let ray = left.trailing_zeros() as usize;
        left &= left - 1;
        let children =
            enters(low, high, origin, Vector::broadcast(&packet.inverse, ray), end).0 & node.occupied();
        rows |= u64::from(children) << shift;
        shift += 8;
    }
    let columns = transposed(rows);
    let mut any = rows | rows >> 32;
    any |= any >> 16;
    any |= any >> 8;
    (any as u32 & 0xff, columns)
}

/// Exchanges rows and columns of eight times eight bits (Warren, Hacker's Delight 7-3).
#[inline(always)]
fn transposed(mut bits: u64) -> u64 {
    for (shift, mask) in
        [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0x0000_0000_f0f0_f0f0u64)]
    {
        let swap = (bits ^ bits >> shift) & mask;
        bits ^= swap ^ swap << shift;
    }
    bits
}

/// The rays out of `rays` that enter a node's child.
#[inline(always)]
fn entered<S: Simd>(node: &Node, slot: usize, packet: &Packet, rays: u64) -> u64 {
    let (origin, end) = (Vector::<S::Wide>::splat(packet.origin), S::Wide::splat(1.0));
    let (low, high) = node.child_bounds::<S::Wide>(slot);
    let mut inside = 0;
    for at in (0..packet.count).step_by(S::Wide::WIDTH) {
        let some = (rays >> at) as u32 & S::Wide::ALL;
        if some != 0 {
            let inverse = Vector::load(&packet.inverse, at);
            inside |= u64::from(some & enters(low, high, origin, inverse, end).0) << at;
        }
    }
    inside
}

/// The rays out of `rays` that meet one of some triangles, a ray at a time.
#[inline(always)]
fn hidden_by_rays<S: Simd>(block: &Block, reach: Vector<S::Eight>, packet: &Packet, rays: u64) -> u64 {
    let spokes = Spokes::new(block, packet.origin, reach);
    let (mut hidden, mut unsure) = (0, 0);
    let mut left = rays;
    while left != 0 {
        let ray = left.trailing_zeros() as usize;
        left &= left - 1;
        let (may, surely) = spokes.shadow(Vector::broadcast(&packet.d, ray));
        hidden |= u64::from(surely != 0) << ray;
        unsure |= u64::from(may & !surely != 0) << ray;
    }
    hidden | decide(block, block.occupied(), packet, unsure & !hidden)
}

/// The rays out of `rays` that meet one of some triangles, each of which may be met by the groups that have it `within` reach.
#[inline(always)]
fn hidden_by_triangles<S: Simd>(
    block: &Block,
    facets: &Facets<S::Eight>,
    mut triangles: u32,
    within: &[u32; RAYS / GROUP],
    packet: &Packet,
    rays: u64,
) -> u64 {
    let mut planes = Planes::new();
    planes.set(facets);
    let (mut left, mut unsure, all) = (rays, 0, triangles);
    while triangles != 0 && left != 0 {
        let lane = triangles.trailing_zeros() as usize;
        triangles &= triangles - 1;
        let facet = planes.facet::<S::Wide>(lane);
        for at in (0..packet.count).step_by(S::Wide::WIDTH) {
            if within[at / GROUP] >> lane & 1 == 0 {
                continue;
            }
            let (may, surely) = facet.shadow(Vector::load(&packet.d, at));
            left &= !(u64::from(surely & may) << at);
            unsure |= u64::from(may & !surely) << at;
        }
    }
    rays & !left | decide(block, all, packet, unsure & left)
}

/// The rays out of `rays` that meet one of some triangles, in exact arithmetic.
#[inline(always)]
fn decide(block: &Block, triangles: u32, packet: &Packet, rays: u64) -> u64 {
    if rays == 0 { 0 } else { decide_some(block, triangles, packet, rays) }
}

#[cold]
#[inline(never)]
fn decide_some(block: &Block, triangles: u32, packet: &Packet, rays: u64) -> u64 {
    let meets = |ray: usize| {
        (0..8)
            .filter(|lane| triangles >> lane & 1 != 0)
            .any(|lane| exact::meets(packet.origin, packet.end(ray), block.triangle_corners(lane)))
    };
    (0..RAYS).filter(|&ray| rays >> ray & 1 != 0 && meets(ray)).fold(0, |hidden, ray| hidden | 1 << ray)
}

/// A packet on its way through the BVH.
struct Occluded<'a> {
    bvh: &'a Bvh,
    packet: &'a Packet,
    stacks: &'a mut Stacks,
}

impl Kernel for Occluded<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self) -> u64 {
        self.bvh.whole::<S>(self.packet, self.stacks)
    }
}
