//! `halflight render --frames`: a scene's animation, frame by frame, each on its own.

use std::error::Error;
use std::fs::OpenOptions;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::slice;
use std::sync::Arc;
use std::time::Instant;

use halflight_cpu::pipeline::Pipeline;
use halflight_lab::program::{message, say};
use halflight_metrics::{is_standard_output, is_stream};
use halflight_scene::Animation;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::Outcome;
use crate::outputs;
use crate::render::{Frame, Job};
use crate::scene::Ready;

/// A frame of an animation, as it goes into statistics and images.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Moment {
    pub(crate) frame: u32,
    pub(crate) time_s: f64,
    /// Time it took to move the scene and to fit its BVH.
    move_ms: f64,
}

impl Moment {
    /// A frame before anything is known of it but its number.
    pub(crate) fn numbered(frame: u32) -> Self {
        Self { frame, time_s: 0.0, move_ms: 0.0 }
    }

    /// The file for this frame: its number goes before the ending. Pipes and devices take all frames.
    pub(crate) fn file(&self, path: &Path) -> PathBuf {
        if is_stream(path) {
            return path.to_owned();
        }
        let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        let mut name = format!("{}-{:04}", part(path.file_stem()), self.frame);
        if path.extension().is_some() {
            name = format!("{name}.{}", part(path.extension()));
        }
        path.with_file_name(name)
    }
}

/// Renders these frames and writes what the job asks for.
pub(crate) fn run(job: &Job, frames: Range<u32>, ready: &Ready, pipeline: &mut Pipeline) -> Outcome {
    let Some(animation) = &ready.animation else {
        return Err(format!(
            "{} has no [animation], so that all frames would be the same: add one to the scene file or leave --frames out",
            job.name
        )
        .into());
    };
    let style =
        ProgressStyle::with_template("{bar:40} {pos} of {len} frames, {elapsed} of about {duration}")?;
    let bar = ProgressBar::new(frames.len() as u64).with_style(style);
    // Readers of a pipe see its end only after the last frame.
    let outputs = job.args.outputs();
    let streams = outputs.iter().filter(|(_, path)| is_stream(path) && !is_standard_output(path));
    let open = |(_, path): &outputs::Output| OpenOptions::new().write(true).open(path);
    let _held = streams.map(open).collect::<Result<Vec<_>, _>>()?;
    let (mut first, mut last) = (None, Vec::new());
    for frame in frames {
        let rendered = bar.suspend(|| render(job, animation, ready, pipeline, frame));
        last = rendered.map_err(|fault| format!("frame {frame}: {}", message(fault.as_ref())))?;
        bar.inc(1);
        first.get_or_insert_with(|| last.clone());
    }
    bar.finish_and_clear();
    for (first, last) in first.iter().flatten().zip(&last) {
        match first == last {
            true => outputs::say_written(slice::from_ref(first)),
            false => say(&format!("wrote {} to {}", first.display(), last.display())),
        }
    }
    Ok(())
}

/// One frame, which depends on its number alone; returns the files that it went to.
fn render(
    job: &Job,
    animation: &Animation,
    still: &Ready,
    pipeline: &mut Pipeline,
    frame: u32,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let start = Instant::now();
    let time_s = f64::from(frame) / job.args.fps;
    job.check(Some(Moment::numbered(frame)))?;
    let scene = Arc::new(animation.at(&still.scene, time_s as f32));
    let mut prepared = still.prepared.clone();
    if animation.moves_triangles() {
        prepared.move_mesh(Arc::clone(&scene.mesh))?;
    }
    prepared.set_lights(scene.lights.clone());
    prepared.set_camera(scene.camera);
    let bvh = Arc::clone(prepared.bvh());
    pipeline.set_scene(&prepared, job.config.visibility.stage(&bvh)?)?;
    let moment = Moment { frame, time_s, move_ms: start.elapsed().as_secs_f64() * 1e3 };
    // The same light samples in all frames.
    pipeline.set_frame_index(0);
    let stats = &pipeline.render()?.stats;
    say(&format!(
        "frame {frame}, {time_s:.3} s: {:.1} ms, {} fragments, {} rays; moved in {:.1} ms",
        stats.total_ms, stats.fragments.total, stats.rays.total, moment.move_ms
    ));
    job.write(&Frame::of(pipeline), &scene, &bvh, Some(moment))
}
