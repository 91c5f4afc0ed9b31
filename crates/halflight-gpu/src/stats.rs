//! Times and counts of a frame, read back when the caller wants them.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use halflight_core::stats::{FrameStats, StageTimes};

use crate::bindings::Slot;
use crate::error::{GpuError, caught};
use crate::needs::{LEVELS, Needs};

/// Counters before the tallies, and buckets of each: `shaders/shared/counters.wgsl`.
const TALLY: usize = 16;
const BUCKETS: usize = 64;

/// Counters that hold the bits of floats: expected squared error, and the image's square.
pub(crate) const EXPECTED: usize = 5;
pub(crate) const ENERGY: usize = 6;

/// Kinds of tallies: rays to refine, for irradiance alone and skipped, samples of each level, cells of each level; rays of
/// specular lobes.
const TALLIES: usize = LOBE_RAYS + 1;
const _: () = assert!(SAMPLES_PER_LEVEL + LEVELS == CELLS_PER_LEVEL);
const SAMPLES_PER_LEVEL: usize = 3;
const CELLS_PER_LEVEL: usize = 11;
const LOBE_RAYS: usize = 19;
const _: () = assert!(CELLS_PER_LEVEL + LEVELS == LOBE_RAYS);

/// Declares the counters.
pub(crate) fn declare(needs: &mut Needs) {
    needs.declare(Slot::Counters, 4 * (TALLY + TALLIES * BUCKETS) as u64);
}

/// Stage whose time is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Timed {
    Gbuffer,
    Pyramid,
    Refine,
    Visibility,
    Irradiance,
    Upsample,
    Compose,
    Specular,
}

/// Passes of a frame that are timed at most; others are not.
const PASSES: u32 = 1024;

/// Timestamps of a frame.
#[derive(Debug)]
pub(crate) struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Nanoseconds a tick.
    period: f32,
    passes: Vec<Timed>,
}

impl Clock {
    /// Returns a clock, if the device has one.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("times"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * PASSES,
            }),
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("times"),
                size: 16 * u64::from(PASSES),
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            period: queue.get_timestamp_period(),
            passes: Vec::new(),
        })
    }

    /// Starts a frame: passes of the last one are removed.
    pub(crate) fn start(&mut self) {
        self.passes.clear();
    }

    /// Returns the first of two places for the times of a pass.
    fn place(&mut self, stage: Timed) -> Option<u32> {
        let place = 2 * self.passes.len() as u32;
        (place < 2 * PASSES).then(|| {
            self.passes.push(stage);
            place
        })
    }

    /// Returns the timestamps of a compute pass.
    pub(crate) fn compute(&mut self, stage: Timed) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let place = self.place(stage)?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(place),
            end_of_pass_write_index: Some(place + 1),
        })
    }

    /// Returns the timestamps of a render pass.
    pub(crate) fn render(&mut self, stage: Timed) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let place = self.place(stage)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(place),
            end_of_pass_write_index: Some(place + 1),
        })
    }
}

/// Statistics of a frame that has been recorded. Nothing is lost when it is dropped.
#[derive(Debug)]
pub struct PendingStats {
    device: wgpu::Device,
    counters: wgpu::Buffer,
    times: Option<wgpu::Buffer>,
    passes: Vec<Timed>,
    period: f32,
    expects: bool,
}

impl PendingStats {
    pub(crate) fn record(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        counters: &wgpu::Buffer,
        clock: Option<&Clock>,
        expects: bool,
    ) -> Self {
        let staging = |size: u64| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("statistics"),
                size,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        };
        let copy = staging(counters.size());
        encoder.copy_buffer_to_buffer(counters, 0, &copy, 0, counters.size());
        let clock = clock.filter(|clock| !clock.passes.is_empty());
        let times = clock.map(|clock| {
            let count = 2 * clock.passes.len() as u32;
            encoder.resolve_query_set(&clock.queries, 0..count, &clock.resolved, 0);
            let copy = staging(8 * u64::from(count));
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, &copy, 0, copy.size());
            copy
        });
        Self {
            device: device.clone(),
            counters: copy,
            times,
            passes: clock.map_or_else(Vec::new, |clock| clock.passes.clone()),
            period: clock.map_or(0.0, |clock| clock.period),
            expects,
        }
    }

    /// Calls `done` with the statistics once the frame has been submitted and the caller has polled the device. Times are 0
    /// where the device takes none.
    pub fn read(self, done: impl FnOnce(Result<GpuStats, GpuError>) + Send + 'static) {
        let buffers: Vec<_> = std::iter::once(self.counters.clone()).chain(self.times.clone()).collect();
        let waiting = Arc::new(AtomicUsize::new(buffers.len()));
        let device = self.device.clone();
        let shared = Arc::new(std::sync::Mutex::new(Some((self, done))));
        let map = |buffer: wgpu::Buffer| {
            let (waiting, shared) = (Arc::clone(&waiting), Arc::clone(&shared));
            buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
                let last = waiting.fetch_sub(1, Ordering::AcqRel) == 1;
                if result.is_ok() && !last {
                    return;
                }
                let taken = shared.lock().ok().and_then(|mut shared| shared.take());
                if let Some((stats, done)) = taken {
                    done(match result {
                        Ok(()) => stats.collect(),
                        Err(error) => Err(GpuError::Readback(error.to_string())),
                    });
                }
            });
        };
        // `done` hears of whatever goes wrong here.
        let _ = caught(&device, GpuError::Readback, || {
            buffers.into_iter().for_each(map);
            Ok(())
        });
    }

    fn collect(&self) -> Result<GpuStats, GpuError> {
        let failed = |error: wgpu::MapRangeError| GpuError::Readback(error.to_string());
        let view = self.counters.slice(..).get_mapped_range().map_err(failed)?;
        let counters: Vec<u32> = bytemuck::pod_collect_to_vec(&view);
        let tally = |kind: usize| {
            let first = TALLY + kind * BUCKETS;
            counters[first..first + BUCKETS].iter().map(|&count| u64::from(count)).sum()
        };
        let mut frame = FrameStats::default();
        for (level, total) in frame.fragments.per_level.iter_mut().take(LEVELS).enumerate() {
            *total = tally(SAMPLES_PER_LEVEL + level);
        }
        for (level, total) in frame.fragments.cells.iter_mut().take(LEVELS).enumerate() {
            *total = tally(CELLS_PER_LEVEL + level);
        }
        frame.fragments.total = frame.fragments.per_level.iter().sum();
        (frame.rays.refine, frame.rays.last, frame.rays.skipped) = (tally(0), tally(1), tally(2));
        frame.rays.specular = tally(LOBE_RAYS);
        frame.rays.total = frame.rays.refine + frame.rays.last + frame.rays.specular;
        if self.expects {
            let [error, energy] = [EXPECTED, ENERGY].map(|place| f64::from(f32::from_bits(counters[place])));
            frame.expected_nmse2 = Some(if energy > 0.0 { error / energy } else { 0.0 });
        }
        if let Some(times) = &self.times {
            let view = times.slice(..).get_mapped_range().map_err(failed)?;
            let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&view);
            for (stage, ticks) in self.passes.iter().zip(ticks.chunks_exact(2)) {
                let ms = ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(self.period) * 1e-6;
                *column(&mut frame.stages_ms, *stage) += ms;
            }
            let (first, last) = (ticks.iter().min(), ticks.iter().max());
            if let (Some(first), Some(last)) = (first, last) {
                frame.total_ms = (last - first) as f64 * f64::from(self.period) * 1e-6;
            }
        }
        Ok(GpuStats { frame, lost: counters[4].into() })
    }
}

fn column(times: &mut StageTimes, stage: Timed) -> &mut f64 {
    match stage {
        Timed::Gbuffer => &mut times.gbuffer,
        Timed::Pyramid => &mut times.pyramid,
        Timed::Refine => &mut times.refine,
        Timed::Visibility => &mut times.visibility,
        Timed::Irradiance => &mut times.irradiance,
        Timed::Upsample => &mut times.upsample,
        Timed::Compose => &mut times.compose,
        Timed::Specular => &mut times.specular,
    }
}

/// Statistics of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct GpuStats {
    /// Times and counts, as from the CPU.
    pub frame: FrameStats,
    /// Queries that did not fit into their buffer. Buffers are sized so that there are none; more than 0 is a fault of the
    /// renderer, and the image lacks what they would have added.
    pub lost: u64,
}
