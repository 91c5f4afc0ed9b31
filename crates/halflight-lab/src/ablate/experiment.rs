//! The experiment file.

use std::path::Path;

use halflight_core::frame::Sharing;
use halflight_core::pattern::PatternKind;
use halflight_cpu::config::{Named, UpsamplerConfig, VisibilityConfig};
use halflight_cpu::irradiance::Shading;
use serde::{Deserialize, Deserializer, Serialize};

use super::paper::Paper;
use super::plan::Setting;
use super::{AblateError, bundled};
use crate::reference::ReferenceConfig;

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

    /// What the reference of a setting is.
    pub fn reference_of(&self, setting: &Setting) -> ReferenceConfig {
        let [width, height] = setting.size;
        let own = self.scenes.get(setting.scene).and_then(|choice| choice.reference_samples);
        let ReferenceChoice { samples, seed } = self.reference;
        ReferenceConfig { width, height, samples: own.unwrap_or(samples), seed }
    }

    /// Timed frames of a row in the scene with this index.
    pub fn repetitions_of(&self, scene: usize) -> u32 {
        self.scenes.get(scene).and_then(|choice| choice.repetitions).unwrap_or(self.repetitions)
    }

    fn check(&self) -> Result<(), String> {
        if self.sizes.as_flattened().contains(&0) {
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
        if let Some(target) = self.equal_error.iter().find(|target| !(**target > 0.0 && target.is_finite())) {
            return Err(format!("equal_error has {target}, expected positive NMSE₂ targets"));
        }
        if let Some(FlickerChoice { frames, step }) = self.flicker {
            if frames < 2 {
                return Err(format!("flicker.frames is {frames}, expected at least 2"));
            }
            if !(step > 0.0 && step.is_finite()) {
                return Err(format!("flicker.step is {step}, expected seconds above 0"));
            }
        }
        let empty = |list: &str| Err(format!("{list} is empty, expected at least one entry"));
        if self.sizes.is_empty() {
            return empty("size");
        }
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
            let known = |name: &&String| self.scenes.iter().any(|scene| scene.name == **name);
            if let Some(name) = grid.except.iter().find(|name| !known(name)) {
                return Err(format!(
                    "grid {number}: except has `{name}`, which is no scene of the experiment"
                ));
            }
        }
        if let Some(name) = &self.equal_time
            && VisibilityConfig::named(name).is_none()
        {
            let known = VisibilityConfig::NAMES.join(", ");
            return Err(format!("equal_time is `{name}`, expected a visibility backend: {known}"));
        }
        let rows = super::plan::rows(self)?;
        if let Some(constant) = &self.sweep
            && !rows.iter().any(|row| super::sweep::value(&row.parameters, constant).is_some())
        {
            return Err(format!("sweep is `{constant}`, but no row sets this constant to a number"));
        }
        Ok(())
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
        assert_eq!((experiment.light_scales, experiment.sizes), (vec![1.0], vec![[64, 48]]));
        let several = SMALL.replace("[64, 48]", "[[64, 48], [128, 96]]");
        let mut experiment = Experiment::parse(&several, "small.toml").unwrap();
        assert_eq!(experiment.sizes, [[64, 48], [128, 96]]);
        experiment.make_quick();
        assert_eq!(experiment.sizes, [[16, 12], [32, 24]]);
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
        let size = fault(&SMALL.replace("[64, 48]", "[64]"));
        assert!(size.contains("line 4") && size.contains("a list of such pairs"), "{size}");
        let with = |line: &str| fault(&SMALL.replace("repetitions = 1", &format!("repetitions = 1\n{line}")));
        let sweep = with("sweep = \"resolution\"");
        assert!(sweep.contains("no row sets this constant"), "{sweep}");
        let backend = with("equal_time = \"rays\"");
        assert!(backend.contains("`rays`") && backend.contains("bvh, raster4d"), "{backend}");
        for (keys, expected) in [
            ("frames = 1, step = 0.1", "flicker.frames is 1, expected at least 2"),
            ("frames = 2, step = 0", "flicker.step is 0, expected seconds above 0"),
            ("frames = 2", "missing field `step`"),
        ] {
            let frames = with(&format!("flicker = {{ {keys} }}"));
            assert!(frames.contains(expected), "{frames}");
        }
        let count = fault(&SMALL.replace("[4]", "[5000]"));
        assert!(count.contains("5000 light samples"), "{count}");
    }

    #[test]
    fn an_unknown_name_lists_the_bundled_ones() {
        let fault = Experiment::resolve("defualt").unwrap_err().to_string();
        assert!(fault.contains("`defualt`") && fault.contains("koa-table1"), "{fault}");
    }
}
