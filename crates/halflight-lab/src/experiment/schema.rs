//! Schema of experiment files.

use halflight_core::frame::Sharing;
use halflight_core::pattern::PatternKind;
use halflight_cpu::config::{Named as _, UpsamplerConfig, VisibilityConfig};
use halflight_cpu::irradiance::Shading;
use serde::{Deserialize, Deserializer, Serialize};

use super::paper::Paper;

/// Experiment: scenes, grids of pipelines, repetitions, reference, and the comparisons that are asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Name of the file, without ending.
    #[serde(skip)]
    pub name: String,
    /// Title in one line.
    pub title: String,
    /// Quantities that are varied, and the reason.
    pub description: String,
    /// Image widths and heights, pixels: `size` in the file, a pair or a list of pairs.
    #[serde(rename = "size", deserialize_with = "pairs")]
    pub sizes: Vec<[u32; 2]>,
    /// Set for a report that opens with one chart a scene, findings in words and pictures side by side. It needs a row of the
    /// lattice at quality `good`.
    #[serde(default)]
    pub front_page: bool,
    /// Timed frames a row; one more is rendered before and not timed.
    pub repetitions: u32,
    /// Seed of the rows.
    #[serde(default)]
    pub seed: u32,
    /// Sub-samples of pixels that see several surfaces: 1 (off), 4, 8 or 16. Times include them; errors are those of the irradiance at
    /// pixel centres, which they do not change.
    #[serde(default = "no_antialiasing")]
    pub antialias: u32,
    /// Reference that the rows are measured against.
    pub reference: ReferenceChoice,
    /// Factors on the edges of all lights about their middles; radiance stays.
    #[serde(default = "one")]
    pub light_scales: Vec<f32>,
    /// Error at the bright end of all error maps, as a share of the reference's peak.
    #[serde(default = "error_scale")]
    pub error_scale: f32,
    /// Factor of Koa17's error maps (squared error in red), which are drawn as well.
    pub squared_error_factor: Option<f32>,
    /// Constant of a backend that errors are drawn against as well.
    pub sweep: Option<String>,
    /// Visibility backend whose row of nearest time is named for each row of another backend.
    pub equal_time: Option<String>,
    /// NMSE₂ targets for a table of the time that every method takes to reach each of them.
    #[serde(default)]
    pub equal_error: Vec<f64>,
    /// Axis of charts of growing time with fitted slopes.
    pub scaling: Option<Scaling>,
    /// Frames of the scenes' animations that every row is rendered in as well.
    pub flicker: Option<AnimationFrames>,
    /// Frames of the scenes' animations in which the work of each level is recorded for every row whose refiner tells it.
    pub path: Option<AnimationFrames>,
    /// Scenes.
    #[serde(rename = "scene")]
    pub scenes: Vec<SceneChoice>,
    /// Rivals, like refiners: `name` and constants that differ from the default. A list of values is a sweep.
    #[serde(default)]
    pub rivals: Vec<toml::Table>,
    /// Specular passes, like refiners: `name` and constants that differ from the default. They are measured by themselves, by what they reflect; scenes need
    /// glossy surfaces.
    #[serde(default)]
    pub specular: Vec<toml::Table>,
    /// Methods for indirect light, like refiners: `name` and constants that differ from the default. Each is rendered beside the direct light of the first grid's first pipeline, and
    /// measured by itself against one diffuse reflection.
    #[serde(default)]
    pub indirect: Vec<toml::Table>,
    /// Pipelines, each grid a full cross product of its axes.
    #[serde(rename = "grid")]
    pub grids: Vec<Grid>,
    /// Figures of a paper to print beside ours.
    pub paper: Option<Paper>,
}

/// Samples and seed of references.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceChoice {
    /// Light samples a pixel.
    pub samples: u32,
    /// Rays over the hemisphere of each pixel in references of indirect light, if not as many as there are samples.
    pub rays: Option<u32>,
    /// Seed of the light samples; must not be that of the rows.
    pub seed: u32,
}

/// Quantity that time is set against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaling {
    /// Quantity that grows.
    pub axis: Axis,
}

/// Frames of an animation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnimationFrames {
    /// Number of frames, the first at time 0.
    pub frames: u32,
    /// Time from one to the next, seconds.
    pub step: f64,
}

/// Quantity that an experiment on scaling makes larger.
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

/// Scene, possibly changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneChoice {
    /// Name of a bundled scene or path of a scene file.
    pub name: String,
    /// Parameters that replace those of its generators or add to them.
    #[serde(default)]
    pub parameters: toml::Table,
    /// Light samples a pixel of its reference, if not the experiment's.
    pub reference_samples: Option<u32>,
    /// Timed frames a row, if not the experiment's.
    pub repetitions: Option<u32>,
}

/// Pipelines: every combination of its axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Refiners: `name` and constants that differ from the default. A list of values is a sweep.
    pub refiners: Vec<toml::Table>,
    /// Visibility backends, like refiners; the default's where left out.
    #[serde(default = "visibility")]
    pub visibilities: Vec<toml::Table>,
    /// Upsamplers: names, or tables with `name` and constants.
    pub upsamplers: Vec<UpsamplerConfig>,
    /// Quantities that are interpolated.
    pub shadings: Vec<Shading>,
    /// Light samples of a full mask.
    pub samples: Vec<u32>,
    /// Placement of the light samples; the default's where left out.
    #[serde(default = "pattern")]
    pub patterns: Vec<PatternKind>,
    /// Sharing of light samples; the default's where left out.
    #[serde(default = "sharing")]
    pub sharings: Vec<Sharing>,
    /// Scenes of the experiment in which the grid is not run.
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

fn no_antialiasing() -> u32 {
    1
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
    /// Replaces the scenes by others, without parameters.
    pub fn set_scenes(&mut self, names: &[String]) {
        let plain = |name: &String| SceneChoice {
            name: name.clone(),
            parameters: toml::Table::new(),
            reference_samples: None,
            repetitions: None,
        };
        self.scenes = names.iter().map(plain).collect();
    }

    /// Shrinks the experiment to a check that everything works: 160 × 120 pixels, or a sixteenth of each size where there are
    /// several, and one timed frame.
    pub fn make_quick(&mut self) {
        match self.sizes.as_mut_slice() {
            [size] => *size = [160, 120],
            sizes => sizes.as_flattened_mut().iter_mut().for_each(|side| *side = (*side / 4).max(1)),
        }
        self.repetitions = 1;
        self.scenes.iter_mut().for_each(|scene| scene.repetitions = None);
        for frames in [&mut self.flicker, &mut self.path].into_iter().flatten() {
            frames.frames = frames.frames.min(4);
        }
    }

    /// Returns the number of timed frames of a row in the scene with this index.
    pub fn repetitions_of(&self, scene: usize) -> u32 {
        self.scenes.get(scene).and_then(|choice| choice.repetitions).unwrap_or(self.repetitions)
    }
}
