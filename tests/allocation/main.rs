//! Allocations of frames: buffers are kept from frame to frame, and nothing is built that the configured
//! stages do not use.
//!
//! The test has a program of its own, since it counts all allocations of the process.

#![allow(clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::glam::Vec3;
use halflight::pattern::PatternKind;
use halflight::refine::LatticeConfig;
use halflight_tests::{Stage, blocker_over_floor};

/// Allocator that counts bytes in blocks too large for bookkeeping of a thread pool.
struct Counting;

/// Smaller blocks are job queues and channels of the thread pool, not buffers.
const LARGE: usize = 4096;

static LARGE_BYTES: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on to the system allocator unchanged.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() >= LARGE {
            LARGE_BYTES.fetch_add(layout.size(), Ordering::Relaxed);
        }
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Held by each test while it counts.
static ALONE: Mutex<()> = Mutex::new(());

/// Most frames until all buffers have their final sizes. The third frame would suffice, except for threads
/// that had no work so far: scheduling decides which these are.
const WARM: usize = 20;

/// Number of consecutive frames that must not allocate.
const STILL: usize = 3;

/// Renders until buffers have their final sizes and frames do not allocate; returns the peak of allocated
/// bytes.
fn render_warm(stage: &Stage, config: &PipelineConfig, what: &str) -> u64 {
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    let (mut asked, mut still, mut peak_bytes) = (0, 0, 0);
    let mut frames = 0..WARM;
    while still < STILL && frames.next().is_some() {
        pipeline.set_frame_index(0);
        let before = LARGE_BYTES.load(Ordering::Relaxed);
        peak_bytes = pipeline.render().unwrap().stats.peak_bytes;
        asked = LARGE_BYTES.load(Ordering::Relaxed) - before;
        still = if asked == 0 { still + 1 } else { 0 };
    }
    assert_eq!(still, STILL, "{what}: warm frames ask for {asked} bytes");
    peak_bytes
}

#[test]
fn a_warm_frame_allocates_no_buffer_and_holds_only_what_it_uses() {
    let _alone = ALONE.lock();
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let mut held = Vec::new();
    for &name in RefinerConfig::NAMES {
        for upsampler in UpsamplerConfig::all() {
            // Spade rebuilds its triangulation every frame and owns its memory.
            if upsampler == UpsamplerConfig::Delaunay(Default::default()) {
                continue;
            }
            let refiner = RefinerConfig::named(name).unwrap();
            let config =
                PipelineConfig { width: 320, height: 240, refiner, upsampler, ..PipelineConfig::default() };
            let peak_bytes = render_warm(&stage, &config, &format!("{name} {upsampler:?}"));
            if upsampler == UpsamplerConfig::RbfRobust(Default::default()) {
                held.push((name, peak_bytes));
            }
        }
    }
    for &name in VisibilityConfig::NAMES {
        let sampling = LightSampling { kind: PatternKind::ShiftedRows, ..LightSampling::default() };
        let visibility = VisibilityConfig::named(name).unwrap();
        let config =
            PipelineConfig { width: 320, height: 240, visibility, sampling, ..PipelineConfig::default() };
        render_warm(&stage, &config, name);
    }
    let refiner = RefinerConfig::Lattice(LatticeConfig { target: 1e-4, ..LatticeConfig::default() });
    let config = PipelineConfig { width: 320, height: 240, refiner, ..PipelineConfig::default() };
    render_warm(&stage, &config, "an error target");
    render_warm(&stage, &PipelineConfig { antialias: 8, ..config }, "antialiasing");
    // Check of the counter itself.
    let before = LARGE_BYTES.load(Ordering::Relaxed);
    drop(vec![1u8; 2 * LARGE]);
    assert!(LARGE_BYTES.load(Ordering::Relaxed) >= before + 2 * LARGE);
    // The per-pixel refiner has a mask per pixel and no pyramid; the other refiners have a pyramid and fewer
    // masks.
    let bytes = |name: &str| held.iter().find(|entry| entry.0 == name).unwrap().1;
    assert!(bytes("per-pixel") > 320 * 240 * 60 && bytes("sfvt-gass") < bytes("per-pixel"), "{held:?}");
}

#[test]
fn moving_lights_and_cameras_allocates_nothing_that_grows_with_the_mesh() {
    let _alone = ALONE.lock();
    let stage = Stage::bundled("toys").unwrap();
    let mesh = &stage.scene.mesh;
    assert!(size_of_val(mesh.positions.as_slice()) > 16 * LARGE, "too small a mesh to tell");
    let config = PipelineConfig { width: 64, height: 48, ..PipelineConfig::default() };
    let mut pipeline = config.builder(&stage.prepared).build().unwrap();
    let (mut lights, mut camera) = (stage.scene.lights.clone(), stage.scene.camera);
    for _ in 0..10 {
        let before = LARGE_BYTES.load(Ordering::Relaxed);
        lights.iter_mut().for_each(|light| *light = light.moved(Vec3::X * 0.01));
        camera.eye.y += 0.01;
        pipeline.set_lights(&lights).unwrap();
        pipeline.set_camera(camera).unwrap();
        assert_eq!(LARGE_BYTES.load(Ordering::Relaxed), before);
        pipeline.render().unwrap();
    }
}
