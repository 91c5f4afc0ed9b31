//! The experiment file.

use halflight_core::frame::Sharing;
use halflight_core::pattern::PatternKind;
use halflight_cpu::config::{Named as _, UpsamplerConfig, VisibilityConfig};
use halflight_cpu::irradiance::Shading;
use serde::{Deserialize, Deserializer, Serialize};

use super::paper::Paper;

/// An experiment: scenes, grids of pipelines, how often and against what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Its name: the file's, without ending.
    #[serde(skip)]
    pub name: String,
    /// One line.
    pub title: String,
    /// What is varied, and why.
    pub description: String,
    /// Image widths and heights, pixels: `size` in the file, a pair or a list of pairs.
    #[serde(rename = "size", deserialize_with = "pairs")]
    pub sizes: Vec<[u32; 2]>,
    /// Timed frames a row; one more is rendered before and not timed.
    pub repetitions: u32,
    /// Seed of the rows.
    #[serde(default)]
    pub seed: u32,
    /// What the rows are measured against.
    pub reference: ReferenceChoice,
    /// Factors on the edges of all lights about their middles; radiance stays.
    #[serde(default = "one")]
    pub light_scales: Vec<f32>,
    /// The error, as a share of the reference's peak, at the bright end of all error maps.
    #[serde(default = "error_scale")]
    pub error_scale: f32,
    /// Also draws Koa17's error maps: squared error in red, times this factor.
    #[serde(default)]
    pub squared_error_factor: Option<f32>,
    /// A constant of a backend: also draws errors against it.
    #[serde(default)]
    pub sweep: Option<String>,
    /// A visibility backend: also names, for each row of another, its row of nearest time.
    #[serde(default)]
    pub equal_time: Option<String>,
    /// NMSE₂ targets: also tells how long every method takes to reach each of them.
    #[serde(default)]
    pub equal_error: Vec<f64>,
    /// Also draws how time grows, with fitted slopes.
    #[serde(default)]
    pub scaling: Option<Scaling>,
    /// Also takes every row along the animations of the scenes.
    #[serde(default)]
    pub flicker: Option<FlickerChoice>,
    /// The scenes.
    #[serde(rename = "scene")]
    pub scenes: Vec<SceneChoice>,
    /// Each is a full cross product of its axes.
    #[serde(rename = "grid")]
    pub grids: Vec<Grid>,
    /// A paper's figures to print beside ours.
    #[serde(default)]
    pub paper: Option<Paper>,
}

/// How references are rendered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceChoice {
    /// Light samples a pixel.
    pub samples: u32,
    /// Their seed; must not be the rows'.
    pub seed: u32,
}

/// What time is set against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaling {
    /// What grows.
    pub axis: Axis,
}

/// Which frames of an animation flicker is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlickerChoice {
    /// How many frames, the first at time 0.
    pub frames: u32,
    /// Time from one to the next, seconds.
    pub step: f64,
}

/// What an experiment on scaling makes larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// Light samples of a full mask.
    Samples,
    /// Triangles of a scene, by its parameters.
    Triangles,
    /// Pixels of the image.
    Pixels,
}

/// A scene, possibly changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneChoice {
    /// A bundled scene or the path of a scene file.
    pub name: String,
    /// Replaces or adds parameters of its generators.
    #[serde(default)]
    pub parameters: toml::Table,
    /// Light samples a pixel of its reference, if not the experiment's.
    #[serde(default)]
    pub reference_samples: Option<u32>,
    /// Timed frames a row, if not the experiment's.
    #[serde(default)]
    pub repetitions: Option<u32>,
}

/// Pipelines: every combination of the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Refiners: `name` and constants that differ from the default. A list of values is a sweep.
    pub refiners: Vec<toml::Table>,
    /// Visibility backends, like refiners; the default's where left out.
    #[serde(default = "visibility")]
    pub visibilities: Vec<toml::Table>,
    /// Upsamplers.
    pub upsamplers: Vec<UpsamplerConfig>,
    /// What is interpolated.
    pub shadings: Vec<Shading>,
    /// Light samples of a full mask.
    pub samples: Vec<u32>,
    /// Placement of the light samples; the default's where left out.
    #[serde(default = "pattern")]
    pub patterns: Vec<PatternKind>,
    /// Who shares light samples; the default's where left out.
    #[serde(default = "sharing")]
    pub sharings: Vec<Sharing>,
    /// Scenes of the experiment in which it is not run.
    #[serde(default)]
    pub except: Vec<String>,
}

fn pairs<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<[u32; 2]>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "expected [width, height] or a list of such pairs")]
    enum Pairs {
        One([u32; 2]),
        Several(Vec<[u32; 2]>),
    }
    Ok(match Pairs::deserialize(from)? {
        Pairs::One(pair) => vec![pair],
        Pairs::Several(pairs) => pairs,
    })
}

fn one() -> Vec<f32> {
    vec![1.0]
}

fn error_scale() -> f32 {
    halflight_image::picture::ERROR_SCALE
}

fn visibility() -> Vec<toml::Table> {
    let name = VisibilityConfig::Bvh.name();
    vec![toml::Table::from_iter([("name".to_string(), name.into())])]
}

fn pattern() -> Vec<PatternKind> {
    vec![halflight_core::frame::LightSampling::default().kind]
}

fn sharing() -> Vec<Sharing> {
    vec![halflight_core::frame::LightSampling::default().sharing]
}

impl Experiment {
    /// Replaces the scenes by these, unchanged.
    pub fn set_scenes(&mut self, names: &[String]) {
        let plain = |name: &String| SceneChoice {
            name: name.clone(),
            parameters: toml::Table::new(),
            reference_samples: None,
            repetitions: None,
        };
        self.scenes = names.iter().map(plain).collect();
    }

    /// The small version: a sixteenth of 640 × 480 (of each size where there are several), one timed frame. Says that
    /// everything works, not how fast it is.
    pub fn make_quick(&mut self) {
        match self.sizes.as_mut_slice() {
            [size] => *size = [160, 120],
            sizes => sizes.as_flattened_mut().iter_mut().for_each(|side| *side = (*side / 4).max(1)),
        }
        self.repetitions = 1;
        self.scenes.iter_mut().for_each(|scene| scene.repetitions = None);
        if let Some(flicker) = &mut self.flicker {
            flicker.frames = flicker.frames.min(4);
        }
    }

    /// Timed frames of a row in the scene with this index.
    pub fn repetitions_of(&self, scene: usize) -> u32 {
        self.scenes.get(scene).and_then(|choice| choice.repetitions).unwrap_or(self.repetitions)
    }
}
