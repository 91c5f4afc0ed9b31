//! The experiment file.

use std::path::Path;

use halflight_core::frame::Sharing;
use halflight_core::pattern::PatternKind;
use halflight_cpu::config::{Named, UpsamplerConfig};
use halflight_cpu::irradiance::Shading;
use serde::{Deserialize, Serialize};

use super::{AblateError, bundled};

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
    /// Image width and height, pixels.
    pub size: [u32; 2],
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
}

/// Figures that a paper gives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// Paper, table or figure.
    pub source: String,
    /// In what its figures and ours differ.
    pub differs: String,
    /// Also measure against a reference of so many samples a pixel, as the paper does.
    #[serde(default)]
    pub reference_samples: Option<u32>,
    /// Its figures; there may be none to print.
    #[serde(default, rename = "row")]
    pub rows: Vec<PaperRow>,
}

/// One row of a paper's table, and which of our rows stand beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperRow {
    /// What the paper calls it.
    pub label: String,
    /// Our scene.
    pub scene: String,
    /// Our refiner.
    pub refiner: String,
    /// Our visibility backend, if only one is meant.
    #[serde(default)]
    pub visibility: Option<String>,
    /// Our constants, as in the column `parameters`, if only one set is meant.
    #[serde(default)]
    pub parameters: Option<String>,
    /// Our light samples, if only one number is meant.
    #[serde(default)]
    pub samples: Option<u32>,
    /// Our upsampler, if only one is meant.
    #[serde(default)]
    pub upsampler: Option<String>,
    /// Our shading, if only one is meant.
    #[serde(default)]
    pub shading: Option<String>,
    /// Our light scale, if only one is meant.
    #[serde(default)]
    pub light_scale: Option<f32>,
    /// Triangles.
    #[serde(default)]
    pub triangles: Option<u64>,
    /// Fragments.
    #[serde(default)]
    pub fragments: Option<u64>,
    /// Visibility rays.
    #[serde(default)]
    pub rays: Option<u64>,
    /// Visibility tests, ms.
    #[serde(default)]
    pub visibility_ms: Option<f64>,
    /// Upsampling, ms.
    #[serde(default)]
    pub upsample_ms: Option<f64>,
    /// All, ms.
    #[serde(default)]
    pub total_ms: Option<f64>,
    /// Sum of squared errors of an image in 0 … 1.
    #[serde(default)]
    pub sse: Option<f64>,
    /// SSE over the sum of the reference.
    #[serde(default)]
    pub nmse: Option<f64>,
}

fn one() -> Vec<f32> {
    vec![1.0]
}

fn error_scale() -> f32 {
    crate::picture::ERROR_SCALE
}

fn visibility() -> Vec<toml::Table> {
    let name = halflight_cpu::config::VisibilityConfig::default().name();
    vec![toml::Table::from_iter([("name".to_string(), name.into())])]
}

fn pattern() -> Vec<PatternKind> {
    vec![halflight_core::frame::LightSampling::default().kind]
}

fn sharing() -> Vec<Sharing> {
    vec![halflight_core::frame::LightSampling::default().sharing]
}

impl Experiment {
    /// Reads an experiment; `file` is what errors call it and, without folder and ending, its name.
    ///
    /// # Errors
    /// Text that is not TOML, keys that are unknown or missing, values out of range; each with its place.
    pub fn parse(text: &str, file: &str) -> Result<Self, AblateError> {
        let mut experiment: Self = toml::from_str(text).map_err(|fault| {
            let line = fault.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            AblateError::Experiment {
                file: format!("{file}, line {line}"),
                message: fault.message().lines().collect::<Vec<_>>().join(", "),
            }
        })?;
        experiment.name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        experiment.check().map_err(|message| AblateError::Experiment { file: file.to_string(), message })?;
        Ok(experiment)
    }

    /// The bundled experiment of this name, or else the file at this path.
    ///
    /// # Errors
    /// There is neither, the file cannot be read, or it does not parse.
    pub fn resolve(name: &str) -> Result<Self, AblateError> {
        if let Some(text) = bundled::text(name) {
            return Self::parse(text, &format!("{name}.toml"));
        }
        let path = Path::new(name);
        if !path.is_file() {
            let bundled = bundled::EXPERIMENTS.iter().map(|&(name, _)| name).collect();
            return Err(AblateError::Unknown { name: name.to_string(), bundled });
        }
        let text = std::fs::read_to_string(path).map_err(super::error::at(path))?;
        Self::parse(&text, name)
    }

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

    /// The small version: a sixteenth of 640 × 480, one timed frame. Says that everything works, not how fast it is.
    pub fn make_quick(&mut self) {
        self.size = [160, 120];
        self.repetitions = 1;
        self.scenes.iter_mut().for_each(|scene| scene.repetitions = None);
    }

    /// Timed frames of a row in the scene with this index.
    pub fn repetitions_of(&self, scene: usize) -> u32 {
        self.scenes.get(scene).and_then(|choice| choice.repetitions).unwrap_or(self.repetitions)
    }

    /// Image width in pixels.
    pub fn width(&self) -> u32 {
        self.size[0]
    }

    /// Image height in pixels.
    pub fn height(&self) -> u32 {
        self.size[1]
    }

    fn check(&self) -> Result<(), String> {
        if self.size.contains(&0) {
            return Err("size is 0 wide or high, expected at least [1, 1]".to_string());
        }
        if self.repetitions == 0 || self.scenes.iter().any(|scene| scene.repetitions == Some(0)) {
            return Err("repetitions is 0, expected at least 1".to_string());
        }
        if self.reference.seed == self.seed {
            return Err(format!(
                "reference.seed is {}, the rows' own: choose another, or the reference would contain their samples",
                self.seed
            ));
        }
        if let Some(scale) = self.light_scales.iter().find(|scale| !(**scale > 0.0 && scale.is_finite())) {
            return Err(format!("light_scales has {scale}, expected positive numbers"));
        }
        if !(self.error_scale > 0.0 && self.error_scale.is_finite()) {
            return Err(format!(
                "error_scale is {}, expected a positive share of the peak",
                self.error_scale
            ));
        }
        let empty = |list: &str| Err(format!("{list} is empty, expected at least one entry"));
        if self.light_scales.is_empty() {
            return empty("light_scales");
        }
        if self.scenes.is_empty() {
            return empty("scene");
        }
        if self.grids.is_empty() {
            return empty("grid");
        }
        for (number, grid) in (1..).zip(&self.grids) {
            let lists = [
                ("refiners", grid.refiners.len()),
                ("visibilities", grid.visibilities.len()),
                ("upsamplers", grid.upsamplers.len()),
                ("shadings", grid.shadings.len()),
                ("samples", grid.samples.len()),
                ("patterns", grid.patterns.len()),
                ("sharings", grid.sharings.len()),
            ];
            if let Some((list, _)) = lists.iter().find(|(_, length)| *length == 0) {
                return empty(&format!("grid {number}: {list}"));
            }
        }
        super::plan::rows(self).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"
        title = "t"
        description = "d"
        size = [64, 48]
        repetitions = 1
        [reference]
        samples = 64
        seed = 1
        [[scene]]
        name = "contact"
        [[grid]]
        refiners = [{ name = "full" }]
        upsamplers = ["bilinear"]
        shadings = ["ratio"]
        samples = [4]
    "#;

    fn fault(text: &str) -> String {
        Experiment::parse(text, "small.toml").unwrap_err().to_string()
    }

    #[test]
    fn a_small_one_parses() {
        let experiment = Experiment::parse(SMALL, "folder/small.toml").unwrap();
        assert_eq!(experiment.name, "small");
        assert_eq!(experiment.light_scales, [1.0]);
    }

    #[test]
    fn faults_name_file_line_and_key() {
        let unknown = fault(&SMALL.replace("repetitions", "repetition"));
        assert!(unknown.starts_with("small.toml, line 5: unknown field `repetition`"), "{unknown}");
        let unknown = fault(&SMALL.replace("\"full\" }", "\"full\", level = 3 }"));
        assert!(unknown.contains("small.toml: grid 1: refiner `full` has no constant `level`"), "{unknown}");
        let unknown = fault(&SMALL.replace("\"ratio\"", "\"ration\""));
        assert!(unknown.contains("line 14") && unknown.contains("ration"), "{unknown}");
        let same = fault(&SMALL.replace("seed = 1", "seed = 0"));
        assert!(same.contains("reference.seed is 0"), "{same}");
        let empty = fault(&SMALL.replace("[4]", "[]"));
        assert!(empty.contains("grid 1: samples is empty"), "{empty}");
        let count = fault(&SMALL.replace("[4]", "[5000]"));
        assert!(count.contains("5000 light samples"), "{count}");
    }

    #[test]
    fn an_unknown_name_lists_the_bundled_ones() {
        let fault = Experiment::resolve("defualt").unwrap_err().to_string();
        assert!(fault.contains("`defualt`") && fault.contains("koa-table1"), "{fault}");
    }
}
