//! Every choice of a pipeline as data: what the program's options, experiment files and stored images name.

use std::sync::Arc;

use halflight_core::frame::LightSampling;
use halflight_core::scene::Scene;
use halflight_core::stages::{Refiner, Upsampler};
use serde::{Deserialize, Serialize};

use crate::bvh::Bvh;
use crate::irradiance::Shading;
use crate::pipeline::{Pipeline, PipelineBuilder};
use crate::refine::{Full, Nichols, NicholsConfig, SfvtGass, SfvtGassConfig};
use crate::upsample::{Bilinear, Delaunay, RbfAdaptive, RbfFixed, RbfRobust};

/// A refiner and its constants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
pub enum RefinerConfig {
    /// 3 × 3 neighbourhoods (Nichols10).
    Nichols(NicholsConfig),
    /// Sub-fragment visibility test and gradient-aware refinement (Koa17).
    SfvtGass(SfvtGassConfig),
    /// Every pixel its own samples.
    Full,
}

/// A visibility backend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VisibilityConfig {
    /// Shadow rays through the triangle hierarchy, in packets.
    #[default]
    Bvh,
}

/// An upsampler.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UpsamplerConfig {
    /// Multi-pass bilinear (Nichols10).
    Bilinear,
    /// Gaussian RBF of fixed variance (Koa16).
    RbfFixed,
    /// Gaussian RBF of adaptive variance (Koa17).
    RbfAdaptive,
    /// Normalised, plane-aware RBF weights.
    #[default]
    RbfRobust,
    /// Triangulation of the samples.
    Delaunay,
}

/// All choices of a pipeline but the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PipelineConfig {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Refiner.
    pub refiner: RefinerConfig,
    /// Visibility backend.
    pub visibility: VisibilityConfig,
    /// Upsampler.
    pub upsampler: UpsamplerConfig,
    /// What is interpolated.
    pub shading: Shading,
    /// Light samples.
    pub sampling: LightSampling,
    /// Seed of all randomness.
    pub seed: u32,
}

impl Default for PipelineConfig {
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            refiner: RefinerConfig::SfvtGass(SfvtGassConfig::default()),
            visibility: VisibilityConfig::default(),
            upsampler: UpsamplerConfig::default(),
            shading: Shading::default(),
            sampling: LightSampling::default(),
            seed: 0,
        }
    }
}

impl RefinerConfig {
    /// The names that [`RefinerConfig::named`] knows.
    pub const NAMES: [&str; 3] = ["nichols", "sfvt-gass", "full"];

    /// The refiner of this name with the paper's constants.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "nichols" => Some(Self::Nichols(NicholsConfig::default())),
            "sfvt-gass" => Some(Self::SfvtGass(SfvtGassConfig::default())),
            "full" => Some(Self::Full),
            _ => None,
        }
    }

    /// Its name in options, files and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Nichols(_) => "nichols",
            Self::SfvtGass(_) => "sfvt-gass",
            Self::Full => "full",
        }
    }

    /// The stage itself.
    pub fn stage(&self) -> Box<dyn Refiner> {
        match *self {
            Self::Nichols(config) => Box::new(Nichols::new(config)),
            Self::SfvtGass(config) => Box::new(SfvtGass::new(config)),
            Self::Full => Box::new(Full::default()),
        }
    }
}

impl VisibilityConfig {
    /// The names that [`VisibilityConfig::named`] knows.
    pub const NAMES: [&str; 1] = ["bvh"];

    /// The backend of this name.
    pub fn named(name: &str) -> Option<Self> {
        (name == "bvh").then_some(Self::Bvh)
    }

    /// Its name in options, files and tables.
    pub fn name(&self) -> &'static str {
        "bvh"
    }
}

impl UpsamplerConfig {
    /// The names that [`UpsamplerConfig::named`] knows.
    pub const NAMES: [&str; 5] = ["bilinear", "rbf-fixed", "rbf-adaptive", "rbf-robust", "delaunay"];

    /// All upsamplers, in the order of their names.
    pub const ALL: [Self; 5] =
        [Self::Bilinear, Self::RbfFixed, Self::RbfAdaptive, Self::RbfRobust, Self::Delaunay];

    /// The upsampler of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|upsampler| upsampler.name() == name)
    }

    /// Its name in options, files and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Bilinear => "bilinear",
            Self::RbfFixed => "rbf-fixed",
            Self::RbfAdaptive => "rbf-adaptive",
            Self::RbfRobust => "rbf-robust",
            Self::Delaunay => "delaunay",
        }
    }

    /// The stage itself.
    pub fn stage(&self) -> Box<dyn Upsampler> {
        match self {
            Self::Bilinear => Box::new(Bilinear::default()),
            Self::RbfFixed => Box::new(RbfFixed::default()),
            Self::RbfAdaptive => Box::new(RbfAdaptive::default()),
            Self::RbfRobust => Box::new(RbfRobust::default()),
            Self::Delaunay => Box::new(Delaunay::default()),
        }
    }
}

impl PipelineConfig {
    /// A builder with these choices made; threads, layers and stages of one's own can still be set.
    pub fn builder(&self, scene: Arc<Scene>, bvh: Arc<Bvh>) -> PipelineBuilder {
        let VisibilityConfig::Bvh = self.visibility;
        Pipeline::builder(scene, bvh)
            .size(self.width, self.height)
            .boxed_refiner(self.refiner.stage())
            .boxed_upsampler(self.upsampler.stage())
            .shading(self.shading)
            .sampling(self.sampling)
            .seed(self.seed)
    }
}
