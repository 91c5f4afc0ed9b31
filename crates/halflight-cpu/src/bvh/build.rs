//! Building the BVH: nodes of eight children from the top down, by the surface area heuristic over bins (Wald
//! 2007).
//!
//! A block of up to eight triangles costs the same however many it holds. A range of n triangles is therefore
//! taken to cost ⌈n / 8⌉ blocks, and blocks come out nearly full. Ranges that no plane separates are split by
//! count: copies of a triangle, triangles around one point, and ranges at great depth. Bins hold minima,
//! maxima and counts, which do not depend on the order of threads. Children are stored in the order in which
//! shadow rays visit them.

use glam::Vec3A;
use halflight_core::scene::Mesh;
use rayon::prelude::*;

use super::layout::{BLOCK, Node, padded};
use crate::occluder::Block;

/// Number of bins along each axis.
const BINS: usize = 16;

/// Most triangles of a block.
const LEAF: usize = 8;

/// Number of triangles from which on a range is binned by several threads (`PARALLEL`) and its children are
/// built by several threads (`FORK`).
const PARALLEL: usize = 1 << 14;
const FORK: usize = 1 << 10;

/// Level of the tree from which on ranges are split by count.
const DEEP: usize = 40;

/// Triangle that has not been assigned to a block yet.
#[derive(Clone, Copy, Debug)]
struct Item {
    bounds: Bounds,
    /// Area, m².
    area: f32,
    /// Index in the mesh.
    triangle: u32,
}

/// Axis-aligned box.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: Vec3A,
    high: Vec3A,
}

impl Bounds {
    const NONE: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    #[inline(always)]
    fn joined(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Half of the surface area.
    #[inline(always)]
    fn area(self) -> f32 {
        let size = (self.high - self.low).max(Vec3A::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// Twice the centre.
    #[inline(always)]
    fn middle(self) -> Vec3A {
        self.low + self.high
    }
}

/// Consecutive items, with the box around them and the box around their centres.
#[derive(Clone, Copy, Debug)]
struct Range {
    first: usize,
    count: usize,
    bounds: Bounds,
    middles: Bounds,
}

impl Range {
    fn of(items: &[Item], first: usize) -> Self {
        let join = |(bounds, middles): (Bounds, Bounds), item: &Item| {
            let middle = item.bounds.middle();
            (bounds.joined(item.bounds), middles.joined(Bounds { low: middle, high: middle }))
        };
        let none = (Bounds::NONE, Bounds::NONE);
        let (bounds, middles) = if items.len() >= PARALLEL {
            let parts = items.par_chunks(PARALLEL / 4).map(|part| part.iter().fold(none, join));
            parts.reduce(|| none, |a, b| (a.0.joined(b.0), a.1.joined(b.1)))
        } else {
            items.iter().fold(none, join)
        };
        Self { first, count: items.len(), bounds, middles }
    }
}

/// Box and number of the triangles in a bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

type Bins = [[Bin; BINS]; 3];

const EMPTY: Bins = [[Bin { bounds: Bounds::NONE, count: 0 }; BINS]; 3];

/// Mapping of centres to bins.
#[derive(Clone, Copy)]
struct Scale {
    low: Vec3A,
    scale: Vec3A,
}

impl Scale {
    fn new(middles: Bounds) -> Self {
        let size = middles.high - middles.low;
        // Ranges that are flat along an axis lie in its first bin.
        let scale = Vec3A::splat(BINS as f32 * (1.0 - 1e-6)) / size;
        Self { low: middles.low, scale: Vec3A::select(size.cmpgt(Vec3A::ZERO), scale, Vec3A::ZERO) }
    }

    #[inline(always)]
    fn bins(&self, item: &Item) -> [usize; 3] {
        let place = (item.bounds.middle() - self.low) * self.scale;
        place.to_array().map(|place| (place as usize).min(BINS - 1))
    }
}

fn collect(items: &[Item], scale: Scale) -> Bins {
    let mut bins = EMPTY;
    for item in items {
        for (bins, place) in bins.iter_mut().zip(scale.bins(item)) {
            let bin = &mut bins[place];
            bin.bounds = bin.bounds.joined(item.bounds);
            bin.count += 1;
        }
    }
    bins
}

fn merge(mut a: Bins, b: Bins) -> Bins {
    for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
        a.bounds = a.bounds.joined(b.bounds);
        a.count += b.count;
    }
    a
}

/// Number of blocks that `count` triangles fill.
fn blocks(count: u32) -> f32 {
    count.div_ceil(LEAF as u32) as f32
}

/// Axis and first bin of the right part of the cheapest split; none where all centres coincide.
fn best_split(bins: &Bins) -> Option<(usize, usize)> {
    let (mut best, mut least) = (None, f32::INFINITY);
    for (axis, bins) in bins.iter().enumerate() {
        let mut costs = [0.0f32; BINS];
        let (mut bounds, mut count) = (Bounds::NONE, 0);
        for at in (1..BINS).rev() {
            bounds = bounds.joined(bins[at].bounds);
            count += bins[at].count;
            costs[at] = if count == 0 { f32::INFINITY } else { bounds.area() * blocks(count) };
        }
        (bounds, count) = (Bounds::NONE, 0);
        for at in 1..BINS {
            bounds = bounds.joined(bins[at - 1].bounds);
            count += bins[at - 1].count;
            let cost = if count == 0 { f32::INFINITY } else { bounds.area() * blocks(count) + costs[at] };
            if cost < least {
                (best, least) = (Some((axis, at)), cost);
            }
        }
    }
    best
}

/// Splits a range of more than [`LEAF`] items in two.
fn halves(items: &mut [Item], range: Range, level: usize) -> [Range; 2] {
    let scale = Scale::new(range.middles);
    let bins = if items.len() >= PARALLEL {
        items.par_chunks(PARALLEL / 4).map(|part| collect(part, scale)).reduce(|| EMPTY, merge)
    } else {
        collect(items, scale)
    };
    let split = if level < DEEP { best_split(&bins) } else { None };
    let middle = match split {
        Some((axis, at)) => partition(items, |item| scale.bins(item)[axis] < at),
        // The left part fills its blocks.
        None => (items.len() / 2).next_multiple_of(LEAF).min(items.len() - 1),
    };
    let (left, right) = items.split_at(middle);
    [Range::of(left, range.first), Range::of(right, range.first + middle)]
}

/// Moves the items of the left part to the front and returns their number.
fn partition(items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> usize {
    let (mut left, mut right) = (0, items.len());
    while left < right {
        if is_left(&items[left]) {
            left += 1;
        } else {
            right -= 1;
            items.swap(left, right);
        }
    }
    left
}

/// Nodes of a subtree and the ranges of items that become its blocks. References to nodes and blocks count
/// from the subtree's own first ones.
struct Subtree {
    nodes: Vec<Node>,
    leaves: Vec<(u32, u32)>,
    /// Total area of the triangles, m².
    area: f32,
}

impl Subtree {
    /// Appends another subtree; returns the index of its first node.
    fn append(&mut self, other: Self) -> u32 {
        let (nodes, blocks) = (self.nodes.len() as u32, self.leaves.len() as u32);
        self.nodes.extend(other.nodes.into_iter().map(|node| node.moved(nodes, blocks)));
        self.leaves.extend(other.leaves);
        nodes
    }
}

/// Builds the node over a range and its subtree.
fn build_node(items: &mut [Item], range: Range, level: usize, padding: f32) -> Subtree {
    let (mut children, count) = open(items, range, level);
    // Children are ordered as their items are.
    let children = &mut children[..count];
    children.sort_unstable_by_key(|child| child.first);
    let mut parts: Vec<(Range, &mut [Item])> = Vec::with_capacity(8);
    let mut rest = items;
    for &child in &*children {
        let (own, others) = rest.split_at_mut(child.count);
        parts.push((child, own));
        rest = others;
    }
    let make = |(child, own): (Range, &mut [Item])| {
        if child.count <= LEAF {
            let area = own.iter().map(|item| item.area).sum();
            Subtree { nodes: Vec::new(), leaves: vec![(child.first as u32, child.count as u32)], area }
        } else {
            build_node(own, child, level + 1, padding)
        }
    };
    let built: Vec<Subtree> = if range.count >= FORK {
        parts.into_par_iter().map(make).collect()
    } else {
        parts.into_iter().map(make).collect()
    };
    let mut built: Vec<(Range, Subtree)> = children.iter().copied().zip(built).collect();
    built.sort_by(|(a, one), (b, other)| priority(a, one.area).total_cmp(&priority(b, other.area)));
    let area = built.iter().map(|(_, subtree)| subtree.area).sum();
    let mut all = Subtree { nodes: vec![Node::EMPTY], leaves: Vec::new(), area };
    for (slot, (child, subtree)) in built.into_iter().enumerate() {
        let reference = if child.count <= LEAF {
            all.leaves.extend(&subtree.leaves);
            (all.leaves.len() - 1) as u32 | BLOCK
        } else {
            all.append(subtree)
        };
        let Bounds { low, high } = child.bounds;
        all.nodes[0].set_child(slot, padded(low.into(), high.into(), padding), reference);
    }
    all
}

/// Splits the child with the largest box until there are eight children.
fn open(items: &mut [Item], range: Range, level: usize) -> ([Range; 8], usize) {
    let mut children = [range; 8];
    let mut count = 1;
    while count < 8 {
        let most = (0..count)
            .filter(|&slot| children[slot].count > LEAF)
            .max_by(|&a, &b| children[a].bounds.area().total_cmp(&children[b].bounds.area()));
        let Some(slot) = most else { break };
        let child = children[slot];
        let own = &mut items[child.first - range.first..][..child.count];
        [children[slot], children[count]] = halves(own, child, level);
        count += 1;
    }
    (children, count)
}

/// Priority of a child in the visiting order, from the total area of its triangles: the probability that a
/// ray enters its box and is stopped there, over the cost of testing it. Among the powers of the triangle
/// count that were tried, the square root is the fastest on a furnished room, a spaceship, two halls and a
/// tree. The child in the last slot is visited first.
fn priority(child: &Range, area: f32) -> f32 {
    area.min(0.5 * child.bounds.area()) / (child.count as f32).sqrt()
}

/// Builds nodes and blocks over the triangles of a mesh that have an alpha mask (`masked`) or have none; node 0 is
/// the root. Every such triangle is in exactly one block.
pub(super) fn build(mesh: &Mesh, padding: f32, masked: bool) -> (Vec<Node>, Vec<Block>) {
    let item = |index: usize| {
        let [a, b, c] = mesh.corners(index).map(Vec3A::from);
        let bounds = Bounds { low: a.min(b).min(c), high: a.max(b).max(c) };
        Item { bounds, area: 0.5 * (b - a).cross(c - a).length(), triangle: index as u32 }
    };
    let mut items: Vec<Item> =
        (0..mesh.triangle_count()).into_par_iter().with_min_len(4096).map(item).collect();
    if !mesh.alpha_masks.is_empty() {
        items.retain(|item| mesh.alpha_mask(item.triangle as usize).is_some() == masked);
    }
    if items.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let range = Range::of(&items, 0);
    let Subtree { mut nodes, leaves, .. } = build_node(&mut items, range, 0, padding);
    nodes.shrink_to_fit();
    let block = |&(first, count): &(u32, u32)| {
        let mut triangles = [0; LEAF];
        let own = &items[first as usize..(first + count) as usize];
        for (to, item) in triangles.iter_mut().zip(own) {
            *to = item.triangle;
        }
        Block::new(mesh, &triangles[..own.len()])
    };
    let blocks = leaves.par_iter().with_min_len(256).map(block).collect();
    (nodes, blocks)
}
