//! Work of each row at each level along the scene's animation: fragments and times.

use anyhow::{Context as _, Result, bail};
use halflight_core::stats::{FrameStats, LevelWork};

use super::loaded::Loaded;
use super::progress::Progress;
use super::timing::median;
use crate::experiment::plan::{Row, Setting};
use crate::experiment::{AnimationFrames, Experiment};
use crate::results::FrameWork;

/// Renders rows along the animation of their scene and returns the work of each frame of each row: medians over as many frames as the
/// experiment repeats, after one that is not timed. All rows have the same light samples in all frames.
pub(super) fn measure(
    experiment: &Experiment,
    choice: &AnimationFrames,
    setting: &Setting,
    loaded: &Loaded,
    rows: &[&Row],
    progress: &Progress,
) -> Result<Vec<Vec<FrameWork>>> {
    let Some(animation) = &loaded.animation else {
        let (name, scene) = (&experiment.name, &loaded.name);
        bail!("{name}: [path] needs a scene that moves, and {scene} has no [animation]");
    };
    let still = loaded.lit(setting.light_scale)?;
    let repetitions = experiment.repetitions_of(setting.scene);
    let mut work: Vec<Vec<FrameWork>> = vec![Vec::new(); rows.len()];
    for number in 0..choice.frames {
        let time_s = f64::from(number) * choice.step;
        let scene = still.moved(animation.at(still.scene(), time_s as f32));
        let scene = scene.with_context(|| format!("scene {}", loaded.name))?;
        for (row, work) in rows.iter().zip(&mut work) {
            progress.now(format!(
                "{}: path, frame {number} of {}, {}",
                setting.label,
                choice.frames,
                row.label()
            ));
            let mut pipeline = row.builder(&scene).build().with_context(|| row.named())?;
            let mut frames = Vec::new();
            for _ in 0..=repetitions {
                pipeline.set_frame_index(0);
                frames.push(pipeline.render().with_context(|| row.named())?.stats.clone());
            }
            work.push(medians(time_s, &frames[1..]));
        }
    }
    Ok(work)
}

/// Returns the work of a frame that was rendered several times.
fn medians(time_s: f64, frames: &[FrameStats]) -> FrameWork {
    let count = frames.first().map_or(0, |frame| frame.levels.len());
    let level = |level: usize| {
        let of = |frame: &FrameStats| frame.levels.get(level).copied().unwrap_or_default();
        LevelWork {
            rendered: frames.first().map_or(0, |frame| of(frame).rendered),
            ms: median(frames.iter().map(|frame| of(frame).ms)),
        }
    };
    FrameWork {
        time_s,
        levels: (0..count).map(level).collect(),
        total_ms: median(frames.iter().map(|frame| frame.total_ms)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::plan;

    const EXPERIMENT: &str = r#"
        title = "t"
        description = "d"
        size = [64, 48]
        repetitions = 2
        reference = { samples = 64, seed = 7 }
        path = { frames = 3, step = 2.0 }
        scene = [{ name = "atrium" }]
        [[grid]]
        refiners = [{ name = "nichols" }, { name = "per-pixel" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [16]
    "#;

    fn work(scene: &str) -> Result<Vec<Vec<FrameWork>>> {
        let mut experiment = Experiment::parse(EXPERIMENT, "tiny.toml").unwrap();
        experiment.set_scenes(&[scene.to_string()]);
        let (settings, rows) = plan::plan(&experiment).unwrap();
        let rows: Vec<&Row> = rows.iter().collect();
        let loaded = Loaded::new(&experiment.scenes[0], &Progress::hidden()).unwrap();
        let choice = experiment.path.unwrap();
        measure(&experiment, &choice, &settings[0], &loaded, &rows, &Progress::hidden())
    }

    #[test]
    fn levels_are_counted_as_the_camera_moves() {
        let found = work("atrium").unwrap();
        let [nichols, per_pixel] = &found[..] else { panic!("{} rows", found.len()) };
        assert_eq!(nichols.iter().map(|frame| frame.time_s).collect::<Vec<_>>(), [0.0, 2.0, 4.0]);
        for frame in nichols {
            // Levels 0 to 4; a level renders no more than all of its cells, and time passes.
            assert_eq!(frame.levels.len(), 5);
            for (level, work) in (0..).zip(&frame.levels) {
                let cells = 64u64.div_ceil(1 << level) * 48u64.div_ceil(1 << level);
                assert!(work.rendered <= cells && work.ms > 0.0, "{level}: {work:?}");
            }
            assert!(frame.levels.iter().map(|work| work.ms).sum::<f64>() < frame.total_ms);
            assert!(frame.levels.iter().any(|work| work.rendered > 0));
        }
        let counts = |frame: &FrameWork| frame.levels.iter().map(|work| work.rendered).collect::<Vec<_>>();
        assert_ne!(counts(&nichols[0]), counts(&nichols[2]));
        assert!(per_pixel.iter().all(|frame| frame.levels.is_empty() && frame.total_ms > 0.0));
    }

    #[test]
    fn a_scene_that_stands_still_is_refused() {
        let fault = work("contact").unwrap_err().to_string();
        assert!(fault.contains("[path] needs a scene that moves, and contact has no [animation]"), "{fault}");
    }
}
