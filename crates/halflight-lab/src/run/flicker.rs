//! Flicker: each row along the scene's animation, frame by frame, against references that move alike.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::scene::Scene;
use halflight_cpu::gbuffer;
use halflight_metrics::{Image, flicker, nmse2};

use super::loaded::Loaded;
use super::progress::Progress;
use crate::error::AblateError;
use crate::experiment::plan::{Row, Setting};
use crate::experiment::{Experiment, FlickerChoice};
use crate::reference::unlit::unlit;
use crate::reference::{Reference, ReferenceConfig, reference};
use crate::results::FrameError;

/// What a frame leaves behind for the next.
struct Before {
    reference: Reference,
    receivers: Vec<bool>,
    /// One image a row.
    images: Vec<Vec<Vec3>>,
}

/// Takes rows along the animation of their scene and returns the frames of each. A row builds everything anew in each
/// frame and has the same light samples in all of them.
pub(super) fn measure(
    experiment: &Experiment,
    choice: &FlickerChoice,
    references: &Path,
    setting: &Setting,
    loaded: &Loaded,
    rows: &[&Row],
    progress: &Progress,
) -> Result<Vec<Vec<FrameError>>, AblateError> {
    let Some(animation) = &loaded.animation else {
        let message = format!("[flicker] needs a scene that moves, and {} has no [animation]", loaded.name);
        return Err(AblateError::Experiment { file: experiment.name.clone(), message });
    };
    let still = loaded.lit(setting.light_scale);
    let config = experiment.reference_of(setting);
    let mut frames: Vec<Vec<FrameError>> = vec![Vec::new(); rows.len()];
    let mut before: Option<Before> = None;
    for number in 0..choice.frames {
        let time_s = f64::from(number) * choice.step;
        let scene = Arc::new(animation.at(&still, time_s as f32));
        let bvh = if animation.moves_triangles() {
            let moved = loaded.bvh.follow(&scene.mesh);
            Arc::new(moved.map_err(|source| AblateError::Bvh { scene: loaded.name.clone(), source })?)
        } else {
            Arc::clone(&loaded.bvh)
        };
        let of = choice.frames;
        let mut said = |done: u32, all: u32| {
            progress.now(format!(
                "{}: frame {number} of {of}, reference, {done} of {all} samples a pixel",
                setting.label
            ));
        };
        let truth = reference(&scene, &bvh, &config, Some(references), &mut said)?;
        let seen = seen(&scene, &bvh, &config);
        if let Some(reason) = unlit(&scene, &seen, &truth.irradiance) {
            return Err(AblateError::Unlit { setting: format!("{}, frame {number}", setting.label), reason });
        }
        let receivers: Vec<bool> = (0..seen.pixels()).map(|pixel| seen.is_receiver(pixel)).collect();
        let mut images = Vec::with_capacity(rows.len());
        for (index, row) in rows.iter().enumerate() {
            progress.now(format!("{}: frame {number} of {of}, {}", setting.label, row.label()));
            let fault = |source| AblateError::Pipeline { row: row.label(), source };
            let mut pipeline =
                row.config.builder(Arc::clone(&scene), Arc::clone(&bvh)).build().map_err(fault)?;
            let image = pipeline.render().map_err(fault)?.irradiance.clone();
            let unlike = |source| AblateError::Compare { row: row.label(), source };
            let now = [view(&config, &image, &receivers)?, view(&config, &truth.irradiance, &receivers)?];
            let flicker = match &before {
                Some(old) => {
                    let then = [&old.images[index], &old.reference.irradiance];
                    let [then, reference] = then.map(|pixels| view(&config, pixels, &old.receivers));
                    Some(flicker([then?, reference?], now).map_err(unlike)?)
                }
                None => None,
            };
            let nmse2 = nmse2(now[0], now[1]).map_err(unlike)?;
            frames[index].push(FrameError { time_s, nmse2, flicker, noise: truth.noise_flicker });
            images.push(image);
        }
        before = Some(Before { reference: truth, receivers, images });
    }
    Ok(frames)
}

fn seen(scene: &Scene, bvh: &halflight_cpu::bvh::Bvh, config: &ReferenceConfig) -> GBuffer {
    let mut seen = GBuffer::default();
    gbuffer::trace(bvh, scene, config.width, config.height, &mut seen);
    seen
}

fn view<'a>(
    config: &ReferenceConfig,
    pixels: &'a [Vec3],
    mask: &'a [bool],
) -> Result<Image<'a>, AblateError> {
    Ok(Image::new(config.width, config.height, pixels)?.with_mask(mask)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::plan;
    use crate::results::Means;

    const EXPERIMENT: &str = r#"
        title = "t"
        description = "d"
        size = [40, 30]
        repetitions = 1
        reference = { samples = 1024, seed = 7 }
        flicker = { frames = 3, step = 0.25 }
        scene = [{ name = "contact" }]
        [[grid]]
        refiners = [{ name = "full" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [4, 64]
    "#;

    /// Frames of the rows of [`EXPERIMENT`], in a box under a light with this animation.
    fn frames(test: &str, animation: &str) -> Result<Vec<Vec<FrameError>>, AblateError> {
        let folder = std::env::temp_dir().join(format!("halflight-flicker-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (_, contact) = halflight_scene::bundled().iter().find(|(name, _)| *name == "contact").unwrap();
        let path = folder.join("box.toml");
        std::fs::write(&path, format!("{contact}\n{animation}\n")).unwrap();
        let mut experiment = Experiment::parse(EXPERIMENT, "tiny.toml").unwrap();
        experiment.set_scenes(&[path.to_string_lossy().into_owned()]);
        let (settings, rows) = plan::plan(&experiment).unwrap();
        let rows: Vec<&Row> = rows.iter().collect();
        let progress = Progress::hidden();
        let loaded = Loaded::new(&experiment.scenes[0], &progress).unwrap();
        let choice = experiment.flicker.unwrap();
        let found = measure(&experiment, &choice, &folder, &settings[0], &loaded, &rows, &progress);
        std::fs::remove_dir_all(&folder).unwrap();
        found
    }

    #[test]
    fn few_samples_flicker_more_than_many_and_more_than_the_reference() {
        let found =
            frames("moving", "[[animation.light]]\nkeys = [{ time = 1, translate = [0.6, 0, 0] }]").unwrap();
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [3, 3]);
        assert!(found[0][0].flicker.is_none() && found[0][2].time_s == 0.5);
        let [few, many] = [&found[0], &found[1]].map(|frames| Means::of(frames).unwrap());
        assert!(few.mean > 2.0 * many.mean && many.mean > many.noise, "{few:?} {many:?}");
        assert!(few.p99 > few.mean && few.nmse2 > many.nmse2 && many.nmse2 > 0.0, "{few:?} {many:?}");
    }

    #[test]
    fn what_does_not_move_does_not_flicker() {
        let found = frames("still", "[[animation.light]]\nkeys = [{ time = 1 }]").unwrap();
        let means = Means::of(&found[0]).unwrap();
        assert_eq!((means.mean, means.p99), (0.0, 0.0));
        assert!(means.nmse2 > 0.0);
        assert_eq!(Means::of(&found[0][..1]), None);
    }

    #[test]
    fn a_scene_without_an_animation_is_refused() {
        let fault = frames("none", "").unwrap_err().to_string();
        assert!(fault.contains("box has no [animation]"), "{fault}");
    }
}
