//! `halflight render --frames`: a scene's animation, frame by frame, each on its own.

use std::error::Error;
use std::fs::OpenOptions;
use std::ops::Range;
use std::path::PathBuf;
use std::slice;
use std::time::Instant;

use halflight_cpu::pipeline::Pipeline;
use halflight_lab::program::{message, say};
use halflight_metrics::{is_standard_output, is_stream};
use halflight_scene::Animation;
use indicatif::{ProgressBar, ProgressStyle};

use crate::Outcome;
use crate::moment::Moment;
use crate::output::{Frame, Output};
use crate::paths;
use crate::scene::Ready;

/// Renders frames of an animation and writes what is asked for.
pub(crate) fn run(output: &Output, frames: Range<u32>, ready: &Ready, pipeline: &mut Pipeline) -> Outcome {
    let Some(animation) = &ready.animation else {
        return Err(format!(
            "{} has no [animation], so that all frames would be the same: add one to the scene file or leave --frames out",
            output.name
        )
        .into());
    };
    let style =
        ProgressStyle::with_template("{bar:40} {pos} of {len} frames, {elapsed} of about {duration}")?;
    let bar = ProgressBar::new(frames.len() as u64).with_style(style);
    // Readers of a pipe see its end only after the last frame.
    let files = output.args.outputs();
    let streams = files.iter().filter(|(_, path)| is_stream(path) && !is_standard_output(path));
    let open = |(_, path): &paths::OutputPath| OpenOptions::new().write(true).open(path);
    let _held = streams.map(open).collect::<Result<Vec<_>, _>>()?;
    let (mut first, mut last) = (None, Vec::new());
    for frame in frames {
        let rendered = bar.suspend(|| render(output, animation, ready, pipeline, frame));
        last = rendered.map_err(|fault| format!("frame {frame}: {}", message(fault.as_ref())))?;
        bar.inc(1);
        first.get_or_insert_with(|| last.clone());
    }
    bar.finish_and_clear();
    for (first, last) in first.iter().flatten().zip(&last) {
        match first == last {
            true => paths::say_written(slice::from_ref(first)),
            false => say(&format!("wrote {} to {}", first.display(), last.display())),
        }
    }
    Ok(())
}

/// Renders one frame, which depends on its number alone. Returns the files that it went to.
fn render(
    output: &Output,
    animation: &Animation,
    still: &Ready,
    pipeline: &mut Pipeline,
    frame: u32,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let start = Instant::now();
    let time_s = f64::from(frame) / output.args.fps;
    output.check(Some(Moment::numbered(frame)))?;
    let scene = still.prepared.moved(animation.at(still.prepared.scene(), time_s as f32))?;
    pipeline.set_scene(&scene, output.config.visibility.stage(scene.bvh())?)?;
    let moment = Moment { frame, time_s, move_ms: start.elapsed().as_secs_f64() * 1e3 };
    // All frames have equal light samples.
    pipeline.set_frame_index(0);
    let stats = &pipeline.render()?.stats;
    say(&format!(
        "frame {frame}, {time_s:.3} s: {:.1} ms, {} fragments, {} rays; moved in {:.1} ms",
        stats.total_ms, stats.fragments.total, stats.rays.total, moment.move_ms
    ));
    output.write(&Frame::of(pipeline), &scene, Some(moment))
}
