//! Rivals: methods that users know from games and renderers, built small to stand beside ours in experiments.
//!
//! | name | method | source |
//! | --- | --- | --- |
//! | `pcss` | percentage-closer soft shadows from a shadow map at the light's centre | Fernando 2005 |
//! | `filtered` | few light samples a pixel and an edge-aware filter guided by variance, without history | Schied 2017 |
//! | `coarse-maps` | a coarse shadow map from each light sample | Nichols10, Fig. 8; Ritschel 2008 |
//! | `unshadowed` | multiresolution gather without visibility | Nichols10, §3.2 |
//!
//! All are stages of the pipeline, so that surfaces, unshadowed irradiance and clocks are those of all other rows.

use halflight_core::frame::{LightSampling, Sharing};
use halflight_core::light::AreaLight;
use halflight_core::stages::UnsupportedLight;
use std::ops::RangeInclusive;

use halflight_cpu::config::{
    IndirectConfig, Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig,
};
use halflight_cpu::irradiance::Shading;
use halflight_cpu::pipeline::PipelineBuilder;
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::upsample::BilinearConfig;
use serde::{Deserialize, Serialize};

mod coarse_maps;
mod pcss;
mod shadow_map;
mod svgf;
#[cfg(test)]
mod tests;
mod unshadowed;

pub use coarse_maps::CoarseMapsConfig;
pub use pcss::PcssConfig;
pub use svgf::SvgfConfig;
pub use unshadowed::UnshadowedConfig;

/// Largest number of samples: that of a mask.
const MAX_SAMPLES: u32 = 4096;

/// Rival and its constants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
pub enum Rival {
    /// Percentage-closer soft shadows.
    Pcss(PcssConfig),
    /// Few light samples, filtered.
    Filtered(SvgfConfig),
    /// A coarse shadow map from each light sample.
    CoarseMaps(CoarseMapsConfig),
    /// Multiresolution gather without visibility.
    Unshadowed(UnshadowedConfig),
}

impl Named for Rival {
    const STAGE: &str = "rival";
    const NAMES: &[&str] = &["pcss", "filtered", "unshadowed", "coarse-maps"];
    const OLD_NAMES: &[&[&str]] = &[&[], &[], &[], &[]];

    fn named(name: &str) -> Option<Self> {
        match name {
            "pcss" => Some(Self::Pcss(PcssConfig::default())),
            "filtered" => Some(Self::Filtered(SvgfConfig::default())),
            "coarse-maps" => Some(Self::CoarseMaps(CoarseMapsConfig::default())),
            "unshadowed" => Some(Self::Unshadowed(UnshadowedConfig::default())),
            _ => None,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Pcss(_) => "pcss",
            Self::Filtered(_) => "filtered",
            Self::CoarseMaps(_) => "coarse-maps",
            Self::Unshadowed(_) => "unshadowed",
        }
    }
}

/// Checks that a light is flat: shadow maps look along the normal of a light, from points that all receivers share.
fn flat(rival: &str, light: &AreaLight) -> Result<(), UnsupportedLight> {
    if light.as_sphere().is_none() {
        return Ok(());
    }
    let reason = "its shadow maps look along the normal of a flat light; use the rival filtered, or a disk";
    Err(UnsupportedLight::new(rival, "sphere lights", reason))
}

impl Rival {
    /// Names of the rivals' visibility, in tables.
    pub const VISIBILITIES: [&str; 4] = ["shadow-map", "bvh", "none", "shadow-maps"];
    /// Names of the rivals' filters, which take the place of upsamplers in tables.
    pub const UPSAMPLERS: [&str; 4] = ["pcf", "svgf", "bilinear", "none"];

    /// Checks the constants.
    ///
    /// # Errors
    /// The first constant that is out of range, and its range.
    pub fn check(&self) -> Result<(), String> {
        let within = |constant: &str, value: u32, range: RangeInclusive<u32>| match range.contains(&value) {
            true => Ok(()),
            false => {
                let (least, most) = range.into_inner();
                Err(format!("{} with {constant} = {value}: expected {least} to {most}", self.name()))
            }
        };
        match self {
            Self::Pcss(pcss) => {
                within("resolution", pcss.resolution, 16..=8192)?;
                within("search", pcss.search, 1..=MAX_SAMPLES)?;
                within("samples", pcss.samples, 1..=MAX_SAMPLES)?;
                (pcss.bias >= 0.0 && pcss.bias.is_finite())
                    .then_some(())
                    .ok_or_else(|| format!("pcss with bias = {}: expected 0 or more", pcss.bias))
            }
            Self::Filtered(svgf) => {
                within("samples", svgf.samples, 1..=MAX_SAMPLES)?;
                within("passes", svgf.passes, 1..=svgf::MAX_PASSES)?;
                (svgf.luminance > 0.0 && svgf.luminance.is_finite()).then_some(()).ok_or_else(|| {
                    format!("filtered with luminance = {}: expected more than 0", svgf.luminance)
                })
            }
            Self::CoarseMaps(maps) => {
                within("resolution", maps.resolution, 8..=1024)?;
                within("samples", maps.samples, 1..=MAX_SAMPLES)?;
                (maps.bias >= 0.0 && maps.bias.is_finite())
                    .then_some(())
                    .ok_or_else(|| format!("coarse-maps with bias = {}: expected 0 or more", maps.bias))
            }
            Self::Unshadowed(unshadowed) => within("samples", unshadowed.samples, 1..=MAX_SAMPLES),
        }
    }

    /// Returns the names of refiner, visibility and upsampler in tables.
    pub fn stages(&self) -> [&'static str; 3] {
        let place = match self {
            Self::Pcss(_) => 0,
            Self::Filtered(_) => 1,
            Self::Unshadowed(_) => 2,
            Self::CoarseMaps(_) => 3,
        };
        [self.name(), Self::VISIBILITIES[place], Self::UPSAMPLERS[place]]
    }

    /// Returns the configuration of a pipeline that the rival's stages are put into: size, samples and seed hold, its own
    /// stages do not.
    pub fn config(&self, [width, height]: [u32; 2], seed: u32) -> PipelineConfig {
        // Rivals of Nichols10 gather irradiance from light samples that all receivers share, as published.
        let (count, shading, sharing) = match self {
            Self::Pcss(config) => (config.samples, Shading::Ratio, Sharing::Receiver),
            Self::Filtered(config) => (config.samples, Shading::Ratio, Sharing::Receiver),
            Self::CoarseMaps(config) => (config.samples, Shading::Sampled, Sharing::Frame),
            Self::Unshadowed(config) => (config.samples, Shading::Sampled, Sharing::Frame),
        };
        let refiner = match self {
            Self::Unshadowed(config) => RefinerConfig::Nichols(config.refiner()),
            _ => RefinerConfig::PerPixel,
        };
        PipelineConfig {
            width,
            height,
            refiner,
            visibility: VisibilityConfig::Bvh,
            upsampler: UpsamplerConfig::Bilinear(BilinearConfig::default()),
            shading,
            sampling: LightSampling { count, sharing, ..LightSampling::default() },
            indirect: IndirectConfig::None,
            antialias: 1,
            seed,
        }
    }

    /// Returns a builder of a pipeline with the rival's stages.
    pub fn builder(&self, config: &PipelineConfig, scene: &PreparedScene) -> PipelineBuilder {
        let builder = config.builder(scene);
        match self {
            Self::Pcss(pcss) => pcss::stages(*pcss, builder, scene.bvh()),
            Self::Filtered(svgf) => builder.upsampler(svgf::Svgf::new(*svgf)),
            Self::CoarseMaps(maps) => builder.visibility(coarse_maps::CoarseMaps::new(*maps, scene.bvh())),
            Self::Unshadowed(_) => builder.visibility(unshadowed::Open),
        }
    }

    /// Returns about how many bytes a frame takes beside its scene and what its pipeline takes.
    pub fn bytes_needed(&self, config: &PipelineConfig) -> u64 {
        match self {
            Self::Pcss(pcss) => pcss.bytes_needed(),
            Self::Filtered(_) => svgf::bytes_needed(config.width, config.height),
            Self::CoarseMaps(maps) => maps.bytes_needed(),
            Self::Unshadowed(_) => 0,
        }
    }
}
