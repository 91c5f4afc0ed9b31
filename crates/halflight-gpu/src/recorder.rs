//! A frame while it is recorded.

use crate::buffers::Buffers;
use crate::stage::Stage;
use crate::stats::{Clock, Timed};

/// How much is dispatched.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Groups {
    /// An invocation a cell of a level, in tiles of 8 × 8; level 0 is a pixel.
    Tiles(u32),
    /// An invocation a corner of a level's cells, likewise.
    Corners(u32),
    /// So many invocations, 64 to a workgroup.
    Count(u64),
    /// What the device knows: rays of the queries at hand.
    Rays,
    /// The queries at hand.
    Queries,
    /// The cells at hand.
    Cells,
    /// All queries so far.
    AllQueries,
    /// Rays of the queries that were left to them.
    Spilled,
    /// What the backend has counted.
    Tasks,
}

/// Workgroups along one side at most.
pub(crate) const SIDE: u64 = 65_535;

/// An encoder with what every pass needs.
pub(crate) struct Recorder<'a> {
    pub(crate) encoder: &'a mut wgpu::CommandEncoder,
    pub(crate) buffers: &'a Buffers,
    pub(crate) clock: Option<&'a mut Clock>,
}

impl Recorder<'_> {
    /// A pass of its own; `frame` is the uniform's index.
    pub(crate) fn run(&mut self, stage: &Stage, timed: Timed, frame: u32, groups: Groups) {
        let mut compute = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(stage.name()),
            timestamp_writes: self.clock.as_mut().and_then(|clock| clock.compute(timed)),
        });
        stage.set(&mut compute, frame * self.buffers.frame_stride);
        let indirect = match groups {
            Groups::Tiles(level) => {
                let tiles = |pixels: u32| pixels.div_ceil(1 << level).div_ceil(8);
                let size = &self.buffers.size;
                compute.dispatch_workgroups(tiles(size.width), tiles(size.height), 1);
                return;
            }
            Groups::Corners(level) => {
                let tiles = |pixels: u32| (pixels.div_ceil(1 << level) + 1).div_ceil(8);
                let size = &self.buffers.size;
                compute.dispatch_workgroups(tiles(size.width), tiles(size.height), 1);
                return;
            }
            Groups::Count(invocations) => {
                let groups = invocations.div_ceil(64);
                compute.dispatch_workgroups(groups.min(SIDE) as u32, groups.div_ceil(SIDE) as u32, 1);
                return;
            }
            Groups::Rays => 0,
            Groups::Queries => 1,
            Groups::Cells => 2,
            Groups::AllQueries => 3,
            Groups::Spilled => 4,
            Groups::Tasks => 5,
        };
        compute.dispatch_workgroups_indirect(&self.buffers.arguments, 12 * indirect);
    }

    /// Forgets the queries so far.
    pub(crate) fn clear_queries(&mut self) {
        self.encoder.clear_buffer(&self.buffers.counters, 0, Some(16));
    }
}
