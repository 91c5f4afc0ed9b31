//! Closest-hit traversal by packets of primary rays.

use std::cmp::Ordering;

use glam::Vec3;
use halflight_core::scene::Mesh;

use super::Bvh;
use super::layout::Child;
use super::packet::{Packet, RAYS};
use super::slab::Shaft;
use super::stack::{STACK, push_sorted};
use crate::occluder::{Targets, Vector, exact, is_solid};
use crate::simd::{Isa, Kernel, Lanes, Simd};

/// Bound on the relative error of a ray parameter that was rounded to single precision.
const ROUNDED: f32 = 1.0 / 4_194_304.0;

/// Place of an alpha-masked triangle, which is in no block.
const MASKED: u32 = u32::MAX;

/// Closest hits of a packet's rays.
pub(crate) struct Hits<const N: usize = RAYS> {
    /// Ray parameters; infinite, or the limit of the search, for a miss.
    pub(crate) t: [f32; N],
    /// Lower and upper bounds on the ray parameters.
    least: [f32; N],
    most: [f32; N],
    /// Position of each triangle in the blocks: eight times the block plus the lane; [`MASKED`] for an alpha-masked one.
    place: [u32; N],
    /// Indices of the triangles in the mesh; `u32::MAX` for a miss.
    pub(crate) triangle: [u32; N],
}

impl<const N: usize> Hits<N> {
    pub(crate) fn new() -> Self {
        Self {
            t: [f32::INFINITY; N],
            least: [f32::INFINITY; N],
            most: [f32::INFINITY; N],
            place: [0; N],
            triangle: [u32::MAX; N],
        }
    }
}

/// Largest of the first `count` ray parameters, none of them negative.
#[inline(always)]
fn farthest<L: Lanes, const N: usize>(t: &[f32; N], count: usize) -> f32 {
    let mut most = L::splat(0.0);
    for at in (0..count).step_by(L::WIDTH) {
        most = most.max(L::load(&t[at..]));
    }
    let mut lanes = [0.0f32; 16];
    most.store(&mut lanes);
    let mut most = 0.0f32;
    for lane in lanes {
        most = most.max(lane);
    }
    most
}

/// Search for the nearest triangles along up to [`RAYS`] segments.
struct FirstHits<'a> {
    bvh: &'a Bvh,
    mesh: &'a Mesh,
    origin: Vec3,
    ends: &'a [Vec3],
    parts: &'a mut [f32],
}

impl Kernel for FirstHits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { bvh, mesh, origin, ends, parts } = self;
        let (mut packet, mut hits) = (Packet::<RAYS>::new(), Hits::<RAYS>::new());
        let mut stack = [(0, 0.0); STACK];
        packet.clear(origin);
        ends.iter().for_each(|end| packet.push(*end - origin));
        packet.finish::<S>();
        bvh.closest_hit::<S, RAYS>(&packet, &mut stack, &mut hits);
        bvh.closer_masked_hit::<S, RAYS>(&packet, mesh, &mut stack, &mut hits);
        for (part, &t) in parts.iter_mut().zip(&hits.t) {
            *part = if t < 1.0 { t } else { f32::INFINITY };
        }
    }
}

impl Bvh {
    /// Finds the closest triangle that each ray of a finished packet meets, as [`exact::Ray`] decides it. The
    /// lowest index wins where a ray meets several triangles in one point, because they are coplanar or
    /// touch.
    #[inline(always)]
    pub(crate) fn closest_hit<S: Simd, const N: usize>(
        &self,
        packet: &Packet<N>,
        stack: &mut [(u32, f32); STACK],
        hits: &mut Hits<N>,
    ) {
        self.closest_hit_within::<S, N>(packet, f32::INFINITY, stack, hits);
    }

    /// Finds the closest triangle that each ray of a finished packet meets up to a ray parameter, or hardly beyond it.
    #[inline(always)]
    pub(crate) fn closest_hit_within<S: Simd, const N: usize>(
        &self,
        packet: &Packet<N>,
        limit: f32,
        stack: &mut [(u32, f32); STACK],
        hits: &mut Hits<N>,
    ) {
        *hits = Hits { t: [limit; N], least: [limit; N], most: [limit; N], ..Hits::new() };
        self.closer_hit::<S, N>(packet, None, stack, hits);
    }

    /// Replaces the closest hits of a finished packet where an alpha-masked triangle is met, in a solid point, before them
    /// or in the same point with a lower index.
    #[inline(always)]
    pub(crate) fn closer_masked_hit<S: Simd, const N: usize>(
        &self,
        packet: &Packet<N>,
        mesh: &Mesh,
        stack: &mut [(u32, f32); STACK],
        hits: &mut Hits<N>,
    ) {
        if let Some(masked) = self.masked() {
            S::call(Closer { bvh: self, masked, packet, mesh, stack, hits });
        }
    }

    /// Looks for closer hits than those that are known. Where `mesh` is given, points of triangles count only where
    /// its alpha masks are solid.
    #[inline(always)]
    fn closer_hit<S: Simd, const N: usize>(
        &self,
        packet: &Packet<N>,
        mesh: Option<&Mesh>,
        stack: &mut [(u32, f32); STACK],
        hits: &mut Hits<N>,
    ) {
        if self.nodes.is_empty() || packet.count == 0 {
            return;
        }
        let shaft = Shaft::new(packet.origin, packet.low, packet.high);
        let mut targets = Targets::new();
        let mut end = farthest::<S::Wide, N>(&hits.most, packet.count) * (1.0 + ROUNDED);
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
                    if self.closest_in_block::<S, N>(index, packet, mesh, &mut targets, hits) {
                        end = farthest::<S::Wide, N>(&hits.most, packet.count) * (1.0 + ROUNDED);
                    }
                }
            }
        }
    }

    /// Finds the nearest triangle that each segment from `origin` to one of `ends` meets, world space, and writes the part of the segment before
    /// it, 0 to 1, or infinity where there is none. Of alpha-masked triangles, solid points alone are met. The triangles are those of `mesh`, which the BVH
    /// must be over; a segment without a length meets nothing.
    pub fn first_hits(&self, mesh: &Mesh, origin: Vec3, ends: &[Vec3], parts: &mut [f32]) {
        for (ends, parts) in ends.chunks(RAYS).zip(parts.chunks_mut(RAYS)) {
            Isa::best().run(FirstHits { bvh: self, mesh, origin, ends, parts });
        }
    }

    /// Corners of the triangle that a ray has hit.
    pub(crate) fn hit_corners<const N: usize>(&self, mesh: &Mesh, hits: &Hits<N>, ray: usize) -> [Vec3; 3] {
        if hits.triangle[ray] == u32::MAX {
            return [Vec3::ZERO; 3];
        }
        let place = hits.place[ray];
        if place == MASKED {
            return mesh.corners(hits.triangle[ray] as usize);
        }
        self.blocks[(place >> 3) as usize].triangle_corners((place & 7) as usize)
    }

    /// True if any ray found a closer hit in a block.
    #[inline(always)]
    fn closest_in_block<S: Simd, const N: usize>(
        &self,
        index: u32,
        packet: &Packet<N>,
        mesh: Option<&Mesh>,
        targets: &mut Targets,
        hits: &mut Hits<N>,
    ) -> bool {
        let block = &self.blocks[index as usize];
        let mut within = targets.set::<S::Eight>(block, packet.origin, packet.low, packet.high);
        let width = S::Wide::WIDTH;
        let mut any = false;
        while within != 0 {
            let lane = within.trailing_zeros() as usize;
            within &= within - 1;
            let target = targets.target::<S::Wide>(lane);
            for at in (0..packet.count).step_by(width) {
                let (least, most) = (S::Wide::load(&hits.least[at..]), S::Wide::load(&hits.most[at..]));
                let found = target.find(Vector::load(&packet.d, at), least, most);
                let valid = ((1u64 << (packet.count - at).min(width)) - 1) as u32;
                let may = found.may & valid;
                if may == 0 {
                    continue;
                }
                any = true;
                let place = index << 3 | lane as u32;
                let surely = if mesh.is_none() { found.surely & valid } else { 0 };
                if surely != 0 {
                    S::Wide::load(&hits.t[at..]).select(surely, found.t).store(&mut hits.t[at..]);
                    least.select(surely, found.least).store(&mut hits.least[at..]);
                    most.select(surely, found.most).store(&mut hits.most[at..]);
                    let mut left = surely;
                    while left != 0 {
                        let ray = at + left.trailing_zeros() as usize;
                        left &= left - 1;
                        (hits.place[ray], hits.triangle[ray]) = (place, block.triangle(lane));
                    }
                }
                let mut open = may & !surely;
                while open != 0 {
                    let ray = at + open.trailing_zeros() as usize;
                    open &= open - 1;
                    self.decide(packet, mesh, ray, place, hits);
                }
            }
        }
        any
    }

    /// Decides in exact arithmetic if a triangle is closer than a ray's closest hit so far, in a solid point where
    /// `mesh` is given.
    #[cold]
    #[inline(never)]
    fn decide<const N: usize>(
        &self,
        packet: &Packet<N>,
        mesh: Option<&Mesh>,
        number: usize,
        place: u32,
        hits: &mut Hits<N>,
    ) {
        let at = |place: u32| (&self.blocks[(place >> 3) as usize], (place & 7) as usize);
        let (block, lane) = at(place);
        let ray = exact::Ray { origin: packet.origin, d: packet.direction(number) };
        let (corners, triangle) = (block.triangle_corners(lane), block.triangle(lane));
        let solid = |mesh: &Mesh| is_solid(mesh, triangle, ray.origin, ray.d.as_dvec3());
        if !ray.meets(corners) || !mesh.is_none_or(solid) {
            return;
        }
        if hits.triangle[number] != u32::MAX {
            let (block, lane) = at(hits.place[number]);
            let order = ray.compare(corners, block.triangle_corners(lane));
            if order.then(triangle.cmp(&hits.triangle[number])) != Ordering::Less {
                return;
            }
        }
        let t = ray.parameter(corners) as f32;
        // Beyond the limit of the search.
        if hits.triangle[number] == u32::MAX && t > hits.most[number] {
            return;
        }
        hits.t[number] = t;
        (hits.least[number], hits.most[number]) = (t * (1.0 - ROUNDED), t * (1.0 + ROUNDED));
        (hits.place[number], hits.triangle[number]) = (place, triangle);
    }
}

/// Traversal of the BVH over alpha-masked triangles by a packet whose closest hits among the others are known.
struct Closer<'a, const N: usize> {
    bvh: &'a Bvh,
    masked: &'a Bvh,
    packet: &'a Packet<N>,
    mesh: &'a Mesh,
    stack: &'a mut [(u32, f32); STACK],
    hits: &'a mut Hits<N>,
}

impl<const N: usize> Kernel for Closer<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { bvh, masked, packet, mesh, stack, hits } = self;
        // Places are those of other blocks: which of two hits is closer is decided at the end.
        let mut found = Hits { triangle: [u32::MAX; N], ..*hits };
        masked.closer_hit::<S, N>(packet, Some(mesh), stack, &mut found);
        for number in 0..packet.count {
            let triangle = found.triangle[number];
            if triangle == u32::MAX {
                continue;
            }
            let ray = exact::Ray { origin: packet.origin, d: packet.direction(number) };
            let order = || ray.compare(mesh.corners(triangle as usize), bvh.hit_corners(mesh, hits, number));
            if hits.triangle[number] == u32::MAX
                || order().then(triangle.cmp(&hits.triangle[number])) == Ordering::Less
            {
                (hits.triangle[number], hits.place[number]) = (triangle, MASKED);
                hits.t[number] = found.t[number];
            }
        }
    }
}
