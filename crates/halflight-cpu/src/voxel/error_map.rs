//! Voxel error maps: the pixels where voxel marching is wrong, and the cause of each error (Nichols10 §4.3).

use glam::{Vec2, Vec3};
use halflight_core::frame::Frame;
use halflight_core::mask::MaskBatch;
use rayon::prelude::*;

use super::march::Rays;
use super::run::Run;
use super::{Course, Voxels};
use crate::bvh::{Bvh, Hits, Packet, RAYS, STACK};
use crate::samples::LANES;
use crate::simd::{Isa, Kernel, Simd};

/// Cause of a receiver's wrong visible fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// False shadow: rays end in voxels that the receiver's own plane touches, or next to the receiver's own
    /// voxel.
    SelfOcclusion,
    /// False shadow by other voxels: their geometry is thinner than they are, or misses the ray by less than
    /// their size.
    Thickness,
    /// False light: the occluder lies outside the grid.
    OutOfView,
    /// False light although the occluder lies in the grid: skipped by steps, or nearer to the receiver or the
    /// light than the bias.
    Missed,
}

impl Cause {
    /// All causes, in the order in which ties are decided.
    pub const ALL: [Self; 4] = [Self::SelfOcclusion, Self::Thickness, Self::OutOfView, Self::Missed];

    /// Colour in [`VoxelErrorMap::image`], sRGB: false shadow red by the receiver itself and yellow by
    /// others; false light blue from out of view and green otherwise.
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::SelfOcclusion => [230, 40, 30],
            Self::Thickness => [240, 200, 20],
            Self::OutOfView => [40, 90, 240],
            Self::Missed => [40, 190, 80],
        }
    }
}

/// Number of wrong receivers, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VoxelErrorCounts {
    /// Number of compared receivers: those with any wanted sample.
    pub receivers: u64,
    /// [`Cause::SelfOcclusion`].
    pub self_occlusion: u64,
    /// [`Cause::Thickness`].
    pub thickness: u64,
    /// [`Cause::OutOfView`].
    pub out_of_view: u64,
    /// [`Cause::Missed`].
    pub missed: u64,
}

impl VoxelErrorCounts {
    /// Number of receivers with a cause.
    pub fn of(&self, cause: Cause) -> u64 {
        match cause {
            Cause::SelfOcclusion => self.self_occlusion,
            Cause::Thickness => self.thickness,
            Cause::OutOfView => self.out_of_view,
            Cause::Missed => self.missed,
        }
    }

    /// Number of all wrong receivers.
    pub fn failures(&self) -> u64 {
        Cause::ALL.iter().map(|&cause| self.of(cause)).sum()
    }

    fn add(&mut self, cause: Cause) {
        match cause {
            Cause::SelfOcclusion => self.self_occlusion += 1,
            Cause::Thickness => self.thickness += 1,
            Cause::OutOfView => self.out_of_view += 1,
            Cause::Missed => self.missed += 1,
        }
    }
}

/// Wrong pixels of an image, with their causes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VoxelErrorMap {
    /// Number of wrong receivers, by cause.
    pub counts: VoxelErrorCounts,
    /// sRGB, row by row from the top left: wrong pixels in their cause's [`Cause::color`]; others grey,
    /// brighter the larger their visible fraction; black where no sample was wanted.
    pub image: Vec<[u8; 3]>,
}

/// Compares the masks of `voxels` with exact ones.
///
/// Both batches hold the same queries about `frame`, one per pixel (a second query about a pixel overwrites
/// the first), and the last frame that `voxels` was prepared for is `frame`. A receiver is wrong if its
/// visible fraction, among the wanted samples, is off by more than `threshold`; its cause is that of most of
/// its wrong samples. `blocked` returns true if the open segment between two points meets a triangle; see
/// [`segments`].
pub fn voxel_error_map(
    frame: &Frame,
    voxels: &Voxels,
    exact: &MaskBatch,
    approximate: &MaskBatch,
    threshold: f32,
    blocked: &(dyn Fn(Vec3, Vec3) -> bool + Sync),
) -> VoxelErrorMap {
    let light = frame.light(exact.light());
    let course = voxels.course(light).filter(|_| light.as_sphere().is_none());
    let verdicts: Vec<Option<(f32, Option<Cause>)>> = (0..exact.len().min(approximate.len()))
        .into_par_iter()
        .map(|query| {
            let wanted = exact.wanted(query);
            let seen = |batch: &MaskBatch| {
                let words = batch.visible(query).iter().zip(wanted);
                words.map(|(visible, wanted)| (visible & wanted).count_ones()).sum::<u32>() as f32
            };
            let asked = wanted.iter().map(|word| word.count_ones()).sum::<u32>() as f32;
            if asked == 0.0 {
                return None;
            }
            let (truth, found) = (seen(exact) / asked, seen(approximate) / asked);
            if (truth - found).abs() <= threshold {
                return Some((truth, None));
            }
            let own;
            let course = match light.as_sphere() {
                None => course.as_ref(),
                Some(_) => {
                    own = voxels.course(&light.seen_from(exact.queries()[query].origin));
                    own.as_ref()
                }
            };
            let cause = cause(frame, course, exact, approximate, query, found < truth, blocked);
            Some((truth, Some(cause)))
        })
        .collect();

    let mut map =
        VoxelErrorMap { image: vec![[0; 3]; frame.gbuffer.pixels()], counts: VoxelErrorCounts::default() };
    for (query, verdict) in exact.queries().iter().zip(verdicts) {
        let Some((truth, cause)) = verdict else { continue };
        map.counts.receivers += 1;
        let grey = 40.0 + 180.0 * truth;
        let color = cause.map_or([grey as u8; 3], Cause::color);
        if let Some(cause) = cause {
            map.counts.add(cause);
        }
        if let Some(pixel) = map.image.get_mut(query.pixel as usize) {
            *pixel = color;
        }
    }
    map
}

/// Cause of most wrong samples of a receiver that is too dark (`shadow`) or too bright.
fn cause(
    frame: &Frame,
    course: Option<&Course>,
    exact: &MaskBatch,
    approximate: &MaskBatch,
    query: usize,
    shadow: bool,
    blocked: &(dyn Fn(Vec3, Vec3) -> bool + Sync),
) -> Cause {
    let receiver = exact.queries()[query];
    let (pattern, light) = (exact.pattern(), frame.light(exact.light()).seen_from(receiver.origin));
    let mut votes = [0u32; 4];
    for sample in 0..pattern.len() {
        let bit = |words: &[u64]| words[sample / 64] >> (sample % 64) & 1 == 1;
        let (truth, found) = (bit(exact.visible(query)), bit(approximate.visible(query)));
        if !bit(exact.wanted(query)) || truth == found || found == shadow {
            continue;
        }
        let position = pattern.position(sample, receiver.key);
        let end = light.point(position);
        let vote = match (course, shadow) {
            (Some(course), true) if course.stopped_by_itself(receiver.origin, receiver.normal, position) => {
                Cause::SelfOcclusion
            }
            (_, true) => Cause::Thickness,
            (Some(course), false) => match course.frustum.part(receiver.origin, end) {
                Some((from, to)) if blocked(from, to) => Cause::Missed,
                _ => Cause::OutOfView,
            },
            (None, false) => Cause::OutOfView,
        };
        votes[vote as usize] += 1;
    }
    let mut most = Cause::ALL[0];
    for cause in Cause::ALL {
        if votes[cause as usize] > votes[most as usize] {
            most = cause;
        }
    }
    most
}

impl Course<'_> {
    /// True if the voxel that stops a ray belongs to the receiver's own surface.
    fn stopped_by_itself(&self, origin: Vec3, normal: Vec3, position: Vec2) -> bool {
        let Some(voxel) = self.stopper(origin, normal, position) else { return false };
        let near = self
            .frustum
            .voxel(self.frustum.place(origin))
            .is_some_and(|own| own.iter().zip(voxel).all(|(&own, voxel)| own.abs_diff(voxel) <= 1));
        let sides = self.frustum.corners(voxel).map(|corner| normal.dot(corner - origin));
        near || sides.iter().any(|&side| side <= 0.0) && sides.iter().any(|&side| side >= 0.0)
    }

    /// First set voxel on a receiver's ray to a position on the light.
    pub(super) fn stopper(&self, origin: Vec3, normal: Vec3, position: Vec2) -> Option<[usize; 3]> {
        let (origin, light) = self.ends(origin, normal);
        let end = light.point(position);
        let found = Isa::BASELINE.run(Trace { course: self, origin, end });
        let side = self.grid.side();
        found.map(|(texel, slice)| [texel % side, texel / side, slice])
    }
}

/// Kernel that finds the texel and slice that stop a single ray; its ends are in homogeneous coordinates.
struct Trace<'a> {
    course: &'a Course<'a>,
    origin: Vec3,
    end: Vec3,
}

impl Kernel for Trace<'_> {
    type Output = Option<(usize, usize)>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let mut found = None;
        let ends = self.end.to_array().map(|along| [along; LANES]);
        let rays = Rays { origin: self.origin, ends: &ends };
        self.course.march::<S>(&rays, Run::WHOLE, 1, |_, texel, from, to| {
            found = self.course.grid.first_set(texel, from, to).map(|slice| (texel, slice));
            found.is_some()
        });
        found
    }
}

/// Returns a function that tests with the BVH if the open segment between two points meets a triangle without an alpha mask; voxels hold no
/// others.
pub fn segments(bvh: &Bvh) -> impl Fn(Vec3, Vec3) -> bool + Sync + '_ {
    struct Segment<'a>(&'a Bvh, Vec3, Vec3);

    impl Kernel for Segment<'_> {
        type Output = bool;

        #[inline(always)]
        fn run<S: Simd>(self) -> bool {
            let Self(bvh, from, to) = self;
            let mut packet = Packet::<RAYS>::new();
            let mut hits = Hits::new();
            packet.clear(from);
            packet.push(to - from);
            packet.finish::<S>();
            bvh.closest_hit::<S, _>(&packet, &mut [(0u32, 0.0f32); STACK], &mut hits);
            hits.t[0] < 1.0
        }
    }

    let isa = Isa::best();
    move |from, to| isa.run(Segment(bvh, from, to))
}
