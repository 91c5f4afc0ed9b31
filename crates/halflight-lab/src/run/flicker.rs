//! Flicker of each row along the scene's animation, frame by frame, against references that move alike.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use glam::Vec3;
use halflight_cpu::pipeline;
use halflight_cpu::prepared::PreparedScene;
use halflight_metrics::{Image, flicker, nmse2};

use super::loaded::Loaded;
use super::progress::Progress;
use super::truth::check_light;
use crate::experiment::Experiment;
use crate::experiment::plan::{Row, Setting};
use crate::reference::bounce::one_bounce;
use crate::reference::{ReferenceConfig, ReferenceError, receivers, reference, seen};
use crate::results::FrameError;

/// Light whose flicker is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Light {
    /// Irradiance of the lights.
    Direct,
    /// Irradiance of one diffuse reflection.
    Indirect,
}

/// Reference of a frame, and the mean flicker that its noise makes.
struct Truth {
    irradiance: Vec<Vec3>,
    noise: f64,
}

impl Light {
    fn config(self, experiment: &Experiment, setting: &Setting) -> ReferenceConfig {
        match self {
            Self::Direct => experiment.reference_of(setting),
            Self::Indirect => experiment.indirect_reference_of(setting),
        }
    }

    fn truth(
        self,
        scene: &PreparedScene,
        config: &ReferenceConfig,
        references: &Path,
        said: &mut dyn FnMut(u32, u32),
    ) -> Result<Truth, ReferenceError> {
        match self {
            Self::Direct => reference(scene, config, Some(references), said)
                .map(|found| Truth { irradiance: found.irradiance, noise: found.noise_flicker }),
            Self::Indirect => one_bounce(scene, config, Some(references), said)
                .map(|found| Truth { irradiance: found.irradiance, noise: found.noise_flicker }),
        }
    }

    fn of(self, image: &pipeline::Image) -> &[Vec3] {
        match self {
            Self::Direct => &image.irradiance,
            Self::Indirect => &image.indirect,
        }
    }
}

/// Images of the frame before.
struct Before {
    reference: Vec<Vec3>,
    receivers: Vec<bool>,
    /// Images, one a row.
    images: Vec<Vec<Vec3>>,
}

/// Renders rows along the animation of their scene and returns the errors of each frame of each row; none where the experiment does not ask for
/// flicker. A row builds everything anew in each frame and has the same light samples in all of them.
pub(super) fn measure(
    light: Light,
    experiment: &Experiment,
    references: &Path,
    setting: &Setting,
    loaded: &Loaded,
    rows: &[&Row],
    progress: &Progress,
) -> Result<Vec<Vec<FrameError>>> {
    let mut frames: Vec<Vec<FrameError>> = vec![Vec::new(); rows.len()];
    let Some(choice) = &experiment.flicker else { return Ok(frames) };
    let Some(animation) = &loaded.animation else {
        let (name, scene) = (&experiment.name, &loaded.name);
        bail!("{name}: [flicker] needs a scene that moves, and {scene} has no [animation]");
    };
    let still = loaded.lit(setting.light_scale)?;
    let config = light.config(experiment, setting);
    let mut before: Option<Before> = None;
    for number in 0..choice.frames {
        let time_s = f64::from(number) * choice.step;
        let scene = still.moved(animation.at(still.scene(), time_s as f32));
        let scene = scene.with_context(|| format!("scene {}", loaded.name))?;
        let of = choice.frames;
        let mut said = |done: u32, all: u32| {
            progress.now(format!(
                "{}: frame {number} of {of}, reference, {done} of {all} samples a pixel",
                setting.label
            ));
        };
        let truth = light.truth(&scene, &config, references, &mut said)?;
        let seen = seen(&scene, [config.width, config.height]);
        check_light(&format!("{}, frame {number}", setting.label), scene.scene(), &seen, &truth.irradiance)?;
        let receivers = receivers(&seen);
        let mut images = Vec::with_capacity(rows.len());
        for (index, row) in rows.iter().enumerate() {
            progress.now(format!("{}: frame {number} of {of}, {}", setting.label, row.label()));
            let mut pipeline = row.builder(&scene).build().with_context(|| row.named())?;
            let image = light.of(pipeline.render().with_context(|| row.named())?).to_vec();
            let now = [view(&config, &image, &receivers)?, view(&config, &truth.irradiance, &receivers)?];
            let flicker = match &before {
                Some(old) => {
                    let then = [&old.images[index], &old.reference];
                    let [then, reference] = then.map(|pixels| view(&config, pixels, &old.receivers));
                    Some(flicker([then?, reference?], now).with_context(|| row.named())?)
                }
                None => None,
            };
            let nmse2 = nmse2(now[0], now[1]).with_context(|| row.named())?;
            frames[index].push(FrameError { time_s, nmse2, flicker, noise: truth.noise });
            images.push(image);
        }
        before = Some(Before { reference: truth.irradiance, receivers, images });
    }
    Ok(frames)
}

fn view<'a>(config: &ReferenceConfig, pixels: &'a [Vec3], mask: &'a [bool]) -> Result<Image<'a>> {
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
        refiners = [{ name = "per-pixel" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [4, 64]
    "#;

    /// Frames of the rows of [`EXPERIMENT`], in a box under a light with this animation.
    fn frames(animation: &str) -> Result<Vec<Vec<FrameError>>> {
        let folder = tempfile::tempdir().unwrap();
        let (_, contact) = halflight_scene::bundled().iter().find(|(name, _)| *name == "contact").unwrap();
        let path = folder.path().join("box.toml");
        std::fs::write(&path, format!("{contact}\n{animation}\n")).unwrap();
        let mut experiment = Experiment::parse(EXPERIMENT, "tiny.toml").unwrap();
        experiment.set_scenes(&[path.to_string_lossy().into_owned()]);
        let (settings, rows) = plan::plan(&experiment).unwrap();
        let rows: Vec<&Row> = rows.iter().collect();
        let progress = Progress::hidden();
        let loaded = Loaded::new(&experiment.scenes[0], &progress).unwrap();
        measure(Light::Direct, &experiment, folder.path(), &settings[0], &loaded, &rows, &progress)
    }

    #[test]
    fn few_samples_flicker_more_than_many_and_more_than_the_reference() {
        let found = frames("[[animation.light]]\nkeys = [{ time = 1, translate = [0.6, 0, 0] }]").unwrap();
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [3, 3]);
        assert!(found[0][0].flicker.is_none() && found[0][2].time_s == 0.5);
        let [few, many] = [&found[0], &found[1]].map(|frames| Means::of(frames).unwrap());
        assert!(few.mean > 2.0 * many.mean && many.mean > many.noise, "{few:?} {many:?}");
        assert!(few.p99 > few.mean && few.nmse2 > many.nmse2 && many.nmse2 > 0.0, "{few:?} {many:?}");
    }

    #[test]
    fn what_does_not_move_does_not_flicker() {
        let found = frames("[[animation.light]]\nkeys = [{ time = 1 }]").unwrap();
        let means = Means::of(&found[0]).unwrap();
        assert_eq!((means.mean, means.p99), (0.0, 0.0));
        assert!(means.nmse2 > 0.0);
        assert_eq!(Means::of(&found[0][..1]), None);
    }

    #[test]
    fn a_scene_without_an_animation_is_refused() {
        let fault = frames("").unwrap_err().to_string();
        assert!(fault.contains("box has no [animation]"), "{fault}");
    }
}
