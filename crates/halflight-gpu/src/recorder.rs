//! A frame while it is recorded.

use halflight_core::light::AreaLight;

use crate::bindings::Slot;
use crate::buffers::Buffers;
use crate::needs::Needs;
use crate::pass::{ByLight, Pass};
use crate::stats::{Clock, Timed};

/// Size of a dispatch.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Groups {
    /// An invocation a cell of a level, in tiles of 8 × 8; level 0 stands for pixels.
    Tiles(u32),
    /// An invocation a corner of a level's cells, likewise.
    Corners(u32),
    /// A number of invocations, 64 to a workgroup.
    Count(u64),
    /// Indirect: rays of the batch of queries.
    Rays,
    /// The batch of queries.
    Queries,
    /// Cells of the batch.
    Cells,
    /// All queries so far.
    AllQueries,
    /// Rays of the queries that were left to them.
    Spilled,
    /// Tasks that the backend has counted.
    Tasks,
}

/// Workgroups along one side at most.
pub(crate) const SIDE: u64 = 65_535;

/// Indirect dispatches: the last kinds of [`Groups`].
const INDIRECT: u64 = 6;

/// An encoder with all that passes share.
pub(crate) struct Recorder<'a> {
    pub(crate) encoder: &'a mut wgpu::CommandEncoder,
    pub(crate) device: &'a wgpu::Device,
    pub(crate) buffers: &'a Buffers,
    pub(crate) lights: &'a [AreaLight],
    /// True if the light that is recorded has a texture.
    pub(crate) textured: bool,
    pub(crate) clock: Option<&'a mut Clock>,
}

impl Recorder<'_> {
    /// Declares the buffers that all passes share.
    pub(crate) fn declare(needs: &mut Needs) {
        needs.declare(Slot::Arguments, 12 * INDIRECT);
    }

    /// Records a pass; `frame` is the uniform's index.
    pub(crate) fn run(&mut self, pass: &Pass, timed: Timed, frame: u32, groups: Groups) {
        self.run_given(pass, timed, frame, groups, &[]);
    }

    /// Records the program of the light that is recorded.
    pub(crate) fn run_by_light(&mut self, pass: &ByLight, timed: Timed, frame: u32, groups: Groups) {
        self.run(pass.of(self.textured), timed, frame, groups);
    }

    /// Records a pass that reads textures of the caller's.
    pub(crate) fn run_given(
        &mut self,
        pass: &Pass,
        timed: Timed,
        frame: u32,
        groups: Groups,
        given: &[(Slot, &wgpu::TextureView)],
    ) {
        let buffers = self.buffers;
        let mut compute = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(pass.name()),
            timestamp_writes: self.clock.as_mut().and_then(|clock| clock.compute(timed)),
        });
        pass.set(&mut compute, self.device, buffers, frame * buffers.frame_stride, given);
        let Needs { width, height, .. } = buffers.needs;
        let indirect = match groups {
            Groups::Tiles(level) => {
                let tiles = |pixels: u32| pixels.div_ceil(1 << level).div_ceil(8);
                return compute.dispatch_workgroups(tiles(width), tiles(height), 1);
            }
            Groups::Corners(level) => {
                let tiles = |pixels: u32| (pixels.div_ceil(1 << level) + 1).div_ceil(8);
                return compute.dispatch_workgroups(tiles(width), tiles(height), 1);
            }
            Groups::Count(invocations) => {
                let groups = invocations.div_ceil(64);
                return compute.dispatch_workgroups(groups.min(SIDE) as u32, groups.div_ceil(SIDE) as u32, 1);
            }
            Groups::Rays => 0,
            Groups::Queries => 1,
            Groups::Cells => 2,
            Groups::AllQueries => 3,
            Groups::Spilled => 4,
            Groups::Tasks => 5,
        };
        compute.dispatch_workgroups_indirect(&buffers[Slot::Arguments], 12 * indirect);
    }

    /// Sets all of a buffer to zero.
    pub(crate) fn clear(&mut self, slot: Slot) {
        self.encoder.clear_buffer(&self.buffers[slot], 0, None);
    }

    /// Sets `words` words of a buffer to zero, from word `first` on.
    pub(crate) fn clear_words(&mut self, slot: Slot, first: u64, words: u64) {
        self.encoder.clear_buffer(&self.buffers[slot], 4 * first, Some(4 * words));
    }

    /// Removes all queries.
    pub(crate) fn clear_queries(&mut self) {
        self.clear_words(Slot::Counters, 0, 4);
    }
}
