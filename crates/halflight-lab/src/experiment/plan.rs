//! Settings and rows of an experiment.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Result, anyhow};
use halflight_core::frame::LightSampling;
use halflight_cpu::config::{IndirectConfig, Named, PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight_cpu::irradiance::Shading;
use halflight_cpu::pipeline::PipelineBuilder;
use halflight_cpu::prepared::PreparedScene;
use itertools::{Itertools as _, iproduct};
use serde::Serialize;

use super::constants;
use super::schema::{Experiment, ReferenceChoice, SceneChoice};
use crate::phong::{PhongConfig, SpecularPass};
use crate::reference::ReferenceConfig;
use crate::rivals::Rival;

/// Scene under a light at an image size, with a reference of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Index of the scene in the experiment.
    pub scene: usize,
    /// Factor on the lights' edges.
    pub light_scale: f32,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Name in titles, without the folders of a path.
    pub label: String,
    /// Name in file names.
    pub slug: String,
}

/// Pipeline that is rendered in every setting but those of excepted scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Configuration of the pipeline.
    pub config: PipelineConfig,
    /// Rival whose stages take the place of the configuration's.
    pub rival: Option<Rival>,
    /// Constants that the experiment sets.
    pub parameters: String,
    /// Names of scenes in which the row is not rendered.
    pub except: Vec<String>,
}

impl Experiment {
    /// Returns the configuration of a setting's reference.
    pub fn reference_of(&self, setting: &Setting) -> ReferenceConfig {
        let [width, height] = setting.size;
        let own = self.scenes.get(setting.scene).and_then(|choice| choice.reference_samples);
        let ReferenceChoice { samples, seed, .. } = self.reference;
        ReferenceConfig { width, height, samples: own.unwrap_or(samples), seed, antialias: 1 }
    }

    /// Returns the configuration of a setting's reference of indirect light.
    pub fn indirect_reference_of(&self, setting: &Setting) -> ReferenceConfig {
        let config = self.reference_of(setting);
        ReferenceConfig { samples: self.reference.rays.unwrap_or(config.samples), ..config }
    }
}

/// Returns all settings of an experiment, scene by scene.
pub fn settings(experiment: &Experiment) -> Vec<Setting> {
    let mut settings = Vec::new();
    for (scene, choice) in experiment.scenes.iter().enumerate() {
        for (&light_scale, &size) in iproduct!(&experiment.light_scales, &experiment.sizes) {
            let mut label = scene_label(choice);
            if experiment.light_scales.len() > 1 {
                label.push_str(&format!(" light ×{light_scale}"));
            }
            if let ([width, height], 2..) = (size, experiment.sizes.len()) {
                label.push_str(&format!(" {width}×{height}"));
            }
            let slug = slug(&label.replace('×', "x"));
            settings.push(Setting { scene, light_scale, size, label, slug });
        }
    }
    settings
}

/// Returns a scene's name in tables: the last part of a path, and the parameters that were changed.
pub fn scene_label(choice: &SceneChoice) -> String {
    let mut label = Path::new(&choice.name)
        .file_stem()
        .map_or(choice.name.clone(), |stem| stem.to_string_lossy().into_owned());
    for (key, value) in &choice.parameters {
        label.push_str(&format!(" {key}={value}"));
    }
    label
}

/// Returns all pipelines of an experiment, grid by grid, at its first size.
///
/// # Errors
/// A stage or constant that is unknown or out of range; a pipeline that occurs twice.
pub fn rows(experiment: &Experiment) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let mut seen = BTreeSet::new();
    let [width, height] = experiment.sizes.first().copied().unwrap_or_default();
    for (number, grid) in (1..).zip(&experiment.grids) {
        let at = |message: String| format!("grid {number}: {message}");
        let refiners = constants::expand_all::<RefinerConfig>(&grid.refiners).map_err(at)?;
        let visibilities = constants::expand_all::<VisibilityConfig>(&grid.visibilities).map_err(at)?;
        let samplings: Vec<LightSampling> = iproduct!(&grid.samples, &grid.patterns, &grid.sharings)
            .map(|(&count, &kind, &sharing)| LightSampling { count, kind, sharing })
            .collect();
        for sampling in &samplings {
            sampling.pattern().map_err(|fault| at(fault.to_string()))?;
        }
        for (refiner, visibility, &sampling, &shading, &upsampler) in
            iproduct!(&refiners, &visibilities, &samplings, &grid.shadings, &grid.upsamplers)
        {
            let config = PipelineConfig {
                width,
                height,
                refiner: refiner.stage,
                visibility: visibility.stage,
                upsampler,
                shading,
                sampling,
                indirect: IndirectConfig::None,
                seed: experiment.seed,
                antialias: experiment.antialias,
            };
            let said = [&refiner.parameters, &visibility.parameters];
            let parameters = said.into_iter().filter(|said| !said.is_empty()).join(";");
            let row = Row { config, rival: None, parameters, except: grid.except.clone() };
            if !seen.insert(row.slug()) {
                return Err(at(format!("{} is there already", row.label())));
            }
            rows.push(row);
        }
    }
    for choice in constants::expand_all::<Rival>(&experiment.rivals)? {
        choice.stage.check().map_err(|fault| format!("rivals: {fault}"))?;
        let config = choice.stage.config([width, height], experiment.seed);
        let rival = Some(choice.stage);
        let row = Row { config, rival, parameters: choice.parameters, except: Vec::new() };
        if !seen.insert(row.slug()) {
            return Err(format!("rivals: {} is there already", row.label()));
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Specular pass of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecularChoice {
    /// Constants.
    pub config: PhongConfig,
    /// Name of the pass and the constants that the experiment sets.
    pub label: String,
}

impl SpecularChoice {
    /// Returns the name in file names.
    pub fn slug(&self) -> String {
        slug(&format!("specular {}", self.label))
    }
}

/// Returns all specular passes of an experiment.
///
/// # Errors
/// A pass or constant that is unknown or out of range; a pass that occurs twice.
pub fn specular(experiment: &Experiment) -> Result<Vec<SpecularChoice>, String> {
    let mut seen = BTreeSet::new();
    let choice = |choice: constants::Choice<SpecularPass>| {
        let SpecularPass::Nichols(config) = choice.stage;
        config.check()?;
        let label = format!("{} {}", choice.stage.name(), choice.parameters).trim_end().to_string();
        if !seen.insert(label.clone()) {
            return Err(format!("specular: {label} is there already"));
        }
        Ok(SpecularChoice { config, label })
    };
    constants::expand_all::<SpecularPass>(&experiment.specular)?.into_iter().map(choice).collect()
}

/// Method for indirect light of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct IndirectChoice {
    /// Pipeline that renders it, with direct light by the first row.
    pub row: Row,
    /// Name of the method and the constants that the experiment sets.
    pub label: String,
}

impl IndirectChoice {
    /// Returns the name in file names.
    pub fn slug(&self) -> String {
        slug(&format!("indirect {}", self.label))
    }
}

/// Returns all methods for indirect light of an experiment.
///
/// # Errors
/// A method or constant that is unknown or out of range; a method that occurs twice; no pipeline for direct light.
pub fn indirect(experiment: &Experiment) -> Result<Vec<IndirectChoice>, String> {
    if experiment.indirect.is_empty() {
        return Ok(Vec::new());
    }
    let direct = rows(experiment)?.into_iter().find(|row| row.rival.is_none());
    let Some(direct) = direct else { return Err("indirect: no grid renders direct light".to_string()) };
    let mut seen = BTreeSet::new();
    let choice = |choice: constants::Choice<IndirectConfig>| {
        let name = choice.stage.name();
        if choice.stage == IndirectConfig::None {
            return Err(format!(
                "indirect: {name} is no method, expected one of {}",
                IndirectConfig::NAMES[1..].join(", ")
            ));
        }
        let label = format!("{name} {}", choice.parameters).trim_end().to_string();
        if !seen.insert(label.clone()) {
            return Err(format!("indirect: {label} is there already"));
        }
        let config = PipelineConfig { indirect: choice.stage, ..direct.config };
        Ok(IndirectChoice { row: Row { config, ..direct.clone() }, label })
    };
    constants::expand_all::<IndirectConfig>(&experiment.indirect)?.into_iter().map(choice).collect()
}

/// Returns [`settings`] and [`rows`], with the experiment's name in the error.
///
/// # Errors
/// As [`rows`].
pub fn plan(experiment: &Experiment) -> Result<(Vec<Setting>, Vec<Row>)> {
    let rows = rows(experiment).map_err(|message| anyhow!("{}: {message}", experiment.name))?;
    Ok((settings(experiment), rows))
}

/// Returns the kebab-case name of a unit variant.
pub(crate) fn word(value: impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_string)).unwrap_or_default()
}

impl Row {
    /// Returns plain Monte Carlo, as papers render their references.
    pub fn monte_carlo(width: u32, height: u32, count: u32, seed: u32) -> Self {
        let config = PipelineConfig {
            width,
            height,
            refiner: RefinerConfig::PerPixel,
            shading: Shading::Sampled,
            sampling: LightSampling { count, ..LightSampling::default() },
            seed,
            ..PipelineConfig::default()
        };
        Self { config, rival: None, parameters: String::new(), except: Vec::new() }
    }

    /// Returns the names of refiner, visibility backend and upsampler.
    pub fn stages(&self) -> [&'static str; 3] {
        let PipelineConfig { refiner, visibility, upsampler, .. } = &self.config;
        let own = [refiner.name(), visibility.name(), upsampler.name()];
        self.rival.map_or(own, |rival| rival.stages())
    }

    /// Returns a builder of the row's pipeline.
    pub fn builder(&self, scene: &PreparedScene) -> PipelineBuilder {
        match &self.rival {
            Some(rival) => rival.builder(&self.config, scene),
            None => self.config.builder(scene),
        }
    }

    /// Returns about how many bytes a frame takes beside its scene.
    pub fn bytes_needed(&self) -> u64 {
        let more = self.rival.map_or(0, |rival| rival.bytes_needed(&self.config));
        self.config.bytes_needed().saturating_add(more)
    }

    /// Returns the visibility backend's name, unless it is the one that experiments take where they name none.
    fn backend(&self) -> Option<&'static str> {
        let [_, visibility, _] = self.stages();
        (visibility != VisibilityConfig::Bvh.name()).then_some(visibility)
    }

    /// Returns whether the row is rendered in a scene.
    pub fn is_in(&self, scene: &SceneChoice) -> bool {
        !self.except.contains(&scene.name)
    }

    /// Returns the row at another image size.
    #[must_use]
    pub fn sized(&self, [width, height]: [u32; 2]) -> Self {
        Self { config: PipelineConfig { width, height, ..self.config }, ..self.clone() }
    }

    /// Returns the name of the row's fragments in file names. Rows that differ in upsampler and shading alone share it.
    pub fn fragments_slug(&self) -> String {
        let sampling = &self.config.sampling;
        let [refiner, ..] = self.stages();
        let stages = [refiner, self.backend().unwrap_or_default(), &self.parameters];
        let stages = stages.into_iter().filter(|part| !part.is_empty()).join(" ");
        slug(&format!("{stages} {} {} {}", sampling.count, word(sampling.kind), word(sampling.sharing)))
    }

    /// Returns the row's name in file names.
    pub fn slug(&self) -> String {
        let [_, _, upsampler] = self.stages();
        format!("{}-{upsampler}-{}", self.fragments_slug(), word(self.config.shading))
    }

    /// Returns the row's name in errors.
    pub fn named(&self) -> String {
        format!("row {}", self.label())
    }

    /// Returns the row's name for people. The upsampler of `per-pixel` is left out, since every pixel is a fragment.
    pub fn label(&self) -> String {
        let sampling = self.config.sampling;
        let [refiner, _, upsampler] = self.stages();
        let mut parts = vec![refiner.to_string()];
        let per_pixel = self.rival.is_none() && self.config.refiner == RefinerConfig::PerPixel;
        let parameters = (!self.parameters.is_empty()).then(|| self.parameters.clone());
        if per_pixel {
            parts.push(sampling.count.to_string());
        } else {
            parts.extend(parameters.clone());
            parts.push(upsampler.to_string());
        }
        parts.push(word(self.config.shading));
        parts.extend(self.backend().map(str::to_string));
        // Masks of `per-pixel` are its backend's.
        parts.extend(parameters.filter(|_| per_pixel));
        let usual = LightSampling::default();
        if self.rival.is_none() && (sampling.kind, sampling.sharing) != (usual.kind, usual.sharing) {
            parts.push(format!("{}/{}", word(sampling.kind), word(sampling.sharing)));
        }
        parts.join(" · ")
    }
}

/// Replaces everything but ASCII letters, digits, `.` and `_` by single hyphens.
pub(crate) fn slug(text: &str) -> String {
    let mut slug = String::new();
    for character in text.chars() {
        if character.is_ascii_alphanumeric() || "._".contains(character) {
            slug.push(character);
        } else if !slug.ends_with('-') {
            slug.push('-');
        }
    }
    slug
}

#[cfg(test)]
mod tests {
    use halflight_cpu::config::UpsamplerConfig;
    use halflight_cpu::refine::Quality;

    use super::*;

    #[test]
    fn the_default_experiment_has_every_stage() {
        let experiment = Experiment::resolve("default").unwrap();
        let rows = rows(&experiment).unwrap();
        let missing =
            |names: &[&'static str], of: fn(&PipelineConfig) -> &'static str| -> Vec<&'static str> {
                let there = |name: &&&str| rows.iter().any(|row| of(&row.config) == **name);
                names.iter().filter(|name| !there(name)).copied().collect()
            };
        for names in [
            missing(RefinerConfig::NAMES, |config| config.refiner.name()),
            missing(VisibilityConfig::NAMES, |config| config.visibility.name()),
            missing(UpsamplerConfig::NAMES, |config| config.upsampler.name()),
        ] {
            assert!(names.is_empty(), "{names:?}");
        }
        for quality in Quality::ALL {
            let lattice = RefinerConfig::Lattice(quality.lattice());
            assert!(rows.iter().any(|row| row.config.refiner == lattice), "{quality}");
        }
    }

    #[test]
    fn labels_hide_folders() {
        let mut experiment = Experiment::resolve("default").unwrap();
        experiment.set_scenes(&["/some/where/hall.toml".to_string()]);
        assert_eq!(settings(&experiment)[0].label, "hall");
    }

    #[test]
    fn sizes_are_settings_and_parameters_are_in_labels() {
        let mut experiment = Experiment::resolve("voxel").unwrap();
        experiment.sizes = vec![[64, 48], [128, 96]];
        let (settings, rows) = plan(&experiment).unwrap();
        assert_eq!((settings[1].slug.as_str(), settings[1].size), ("atrium-128x96", [128, 96]));
        let row = rows[0].sized(settings[1].size);
        assert_eq!((row.config.width, row.config.height, row.slug()), (128, 96, rows[0].slug()));
        let labels: BTreeSet<String> = rows.iter().map(Row::label).collect();
        assert_eq!(labels.len(), rows.len());
    }

    #[test]
    fn rivals_are_rows_with_stages_of_their_own() {
        let mut experiment = Experiment::resolve("rivals").unwrap();
        let rows = rows(&experiment).unwrap();
        let rivals: Vec<&Row> = rows.iter().filter(|row| row.rival.is_some()).collect();
        assert_eq!(rivals[0].stages(), ["pcss", "shadow-map", "pcf"]);
        assert_eq!(rivals[0].label(), "pcss · resolution=512 · pcf · ratio · shadow-map");
        assert_eq!(rivals[3].label(), "filtered · samples=1 · svgf · ratio");
        assert_eq!((rivals[3].config.sampling.count, rivals[0].config.sampling.count), (1, 64));
        let slugs: BTreeSet<String> = rows.iter().map(Row::slug).collect();
        assert_eq!(slugs.len(), rows.len());
        for (text, words) in [
            ("name = 'vsm'", "unknown rival `vsm`, expected one of pcss, filtered, unshadowed, coarse-maps"),
            ("name = 'pcss'\nsharpness = 1", "rival `pcss` has no constant `sharpness`"),
            ("name = 'filtered'\npasses = 9", "rivals: filtered with passes = 9: expected 1 to 5"),
        ] {
            experiment.rivals = vec![text.parse().unwrap()];
            let fault = super::rows(&experiment).unwrap_err();
            assert!(fault.contains(words), "{fault}");
        }
    }

    #[test]
    fn specular_passes_are_swept() {
        let mut experiment = Experiment::resolve("default").unwrap();
        let mut with = |text: &str| {
            experiment.specular = vec![text.parse().unwrap()];
            specular(&experiment)
        };
        let found = with("name = 'nichols'\nvisibility = ['none', 'variance']\nfew = 0").unwrap();
        let labels: Vec<&str> = found.iter().map(|choice| choice.label.as_str()).collect();
        assert_eq!(labels, ["nichols few=0;visibility=\"none\"", "nichols few=0;visibility=\"variance\""]);
        assert_eq!(found[0].slug(), "specular-nichols-few-0-visibility-none-");
        for (text, words) in [
            ("name = 'ggx'", "unknown specular pass `ggx`, expected one of nichols"),
            ("name = 'nichols'\nshininess = 3", "specular pass `nichols` has no constant `shininess`"),
            ("name = 'nichols'\ngrid = 9", "specular pass with grid = 9: expected 1 to 8"),
            ("name = 'nichols'\ngrid = [5, 5]", "nichols grid=5 is there already"),
        ] {
            let fault = with(text).unwrap_err();
            assert!(fault.contains(words), "{fault}");
        }
    }

    #[test]
    fn methods_for_indirect_light_are_swept_beside_the_first_row() {
        let mut experiment = Experiment::resolve("default").unwrap();
        assert!(indirect(&experiment).unwrap().is_empty());
        let mut with = |text: &str| {
            experiment.indirect = vec![text.parse().unwrap()];
            (rows(&experiment).unwrap(), indirect(&experiment))
        };
        let (rows, found) = with("name = 'gather'\npoints = [500, 1000]");
        let found = found.unwrap();
        let labels: Vec<&str> = found.iter().map(|choice| choice.label.as_str()).collect();
        assert_eq!(labels, ["gather points=500", "gather points=1000"]);
        assert_eq!(found[0].slug(), "indirect-gather-points-500");
        assert_eq!(
            found[0].row.config,
            PipelineConfig { indirect: found[0].row.config.indirect, ..rows[0].config }
        );
        for (text, words) in [
            ("name = 'radiosity'", "unknown indirect `radiosity`, expected one of none, lpv, gather"),
            ("name = 'gather'\npoint = 3", "indirect `gather` has no constant `point`"),
            ("name = 'none'", "none is no method, expected one of lpv, gather"),
            ("name = 'gather'\npoints = [5, 5]", "gather points=5 is there already"),
        ] {
            let fault = with(text).1.unwrap_err();
            assert!(fault.contains(words), "{fault}");
        }
    }

    #[test]
    fn a_row_given_twice_is_refused() {
        let mut experiment = Experiment::resolve("default").unwrap();
        experiment.grids.push(experiment.grids[0].clone());
        let fault = rows(&experiment).unwrap_err();
        assert!(fault.contains("there already"), "{fault}");
    }

    #[test]
    fn fragments_are_shared_by_rows_that_differ_in_upsampler_and_shading_alone() {
        let rows = rows(&Experiment::resolve("koa-fig7").unwrap()).unwrap();
        let slugs: BTreeSet<String> = rows.iter().map(Row::fragments_slug).collect();
        assert_eq!((rows.len(), slugs.len()), (2 * 5, 2));
    }
}
