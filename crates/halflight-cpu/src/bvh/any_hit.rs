//! Any-hit traversal by shadow rays: all rays of one receiver, or all rays to one light sample, at once.
//!
//! A packet first enters nodes as a whole: a box is entered when any ray between the bounds of the packet's
//! directions might enter it. Further down, each ray has box tests of its own. At a block, the planes of the
//! eight triangles are set up once for all rays. Triangles out of reach of a group of 16 rays are dropped,
//! and the remaining ones are tested against a vector of rays at a time. When few rays are left, each is
//! tested alone against eight boxes or eight triangles at once. Children are visited in slot order: any hit
//! ends a ray, and sorting by distance gains less than it costs.

use super::Bvh;
use super::layout::{Child, Node};
use super::packet::{GROUP, Packet, RAYS};
use super::slab::{Shaft, enters};
use super::stack::Stacks;
use crate::occluder::{Block, Facets, Planes, Spokes, Vector, exact};
use crate::simd::{Kernel, Lanes, Simd};

/// Number of rays up to which each ray is tested against a node's eight boxes at once. More rays are tested
/// as vectors against one box after the other.
const FEW: u32 = 8;

/// Number of nodes that a packet enters as a whole before its rays have box tests of their own.
const COARSE: u32 = 3;

/// Number of rays up to which each ray is tested against a block's eight triangles at once. More rays are
/// tested as vectors against one triangle after the other.
const DIRECT: u32 = 10;

/// Mask of the first `count` rays.
#[inline(always)]
fn first(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

impl Bvh {
    /// Mask of the rays of a finished packet that meet a triangle at 0 < t < 1.
    #[inline(always)]
    pub(crate) fn occluded<S: Simd>(&self, packet: &Packet, stacks: &mut Stacks) -> u64 {
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
                                self.any_hit_block::<S>(&self.blocks[child as usize], packet, alive, inside);
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

    /// Mask of the occluded rays, traced one after another.
    #[inline(always)]
    pub(crate) fn occluded_singly<S: Simd>(&self, packet: &Packet, stacks: &mut Stacks) -> u64 {
        let mut occluded = 0;
        for ray in 0..packet.count {
            let hit = self.occludes::<S>(0, packet.origin, packet.end(ray), &mut stacks.single);
            occluded |= u64::from(hit) << ray;
        }
        occluded
    }

    /// Mask of the rays in `alive` that remain unoccluded after those in `rays` are tested against a block.
    ///
    /// Few rays are tested one by one. For many, the planes of the triangles are set up once, triangles out
    /// of a group's reach are dropped, and each remaining one is tested against vectors of rays.
    #[inline(always)]
    fn any_hit_block<S: Simd>(&self, block: &Block, packet: &Packet, alive: u64, rays: u64) -> u64 {
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

/// Mask of the children that up to eight rays enter, and one byte per child with a bit for each ray that
/// enters it.
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

/// Transposes an 8 × 8 bit matrix (Warren, Hacker's Delight 7-3).
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

/// Mask of the rays in `rays` that enter a node's child.
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

/// Mask of the rays in `rays` that meet any triangle of a block, tested one ray at a time.
#[inline(always)]
fn hidden_by_rays<S: Simd>(block: &Block, reach: Vector<S::Eight>, packet: &Packet, rays: u64) -> u64 {
    let spokes = Spokes::new(block, packet.origin, reach);
    let (mut hidden, mut unsure) = (0, 0);
    let mut left = rays;
    while left != 0 {
        let ray = left.trailing_zeros() as usize;
        left &= left - 1;
        let (may, surely) = spokes.any_hit(Vector::broadcast(&packet.d, ray));
        hidden |= u64::from(surely != 0) << ray;
        unsure |= u64::from(may & !surely != 0) << ray;
    }
    hidden | decide(block, block.occupied(), packet, unsure & !hidden)
}

/// Mask of the rays in `rays` that meet any triangle of a block. `within` tells for each group of rays which
/// triangles are in its reach.
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
            let (may, surely) = facet.any_hit(Vector::load(&packet.d, at));
            left &= !(u64::from(surely & may) << at);
            unsure |= u64::from(may & !surely) << at;
        }
    }
    rays & !left | decide(block, all, packet, unsure & left)
}

/// Mask of the rays in `rays` that meet any of the given triangles, decided in exact arithmetic.
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

/// Traversal of the BVH by a packet.
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
