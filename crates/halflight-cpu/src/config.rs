//! Every choice of a pipeline as data: what the program's options, experiment files and stored images name.

use std::sync::Arc;

use halflight_core::frame::LightSampling;
use halflight_core::stages::{Refiner, Upsampler, Visibility};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::beam::Beam;
use crate::bvh::{Bvh, BvhRays};
use crate::irradiance::Shading;
use crate::pipeline::{Pipeline, PipelineBuilder, PipelineError};
use crate::prepared::PreparedScene;
use crate::raster4d::{Raster4d, Raster4dConfig};
use crate::refine::{
    DiscontinuityLimits, Full, Lattice, LatticeConfig, Nichols, NicholsConfig, SfvtGass, SfvtGassConfig,
};
use crate::upsample::{self, Bilinear, Delaunay, RbfAdaptive, RbfFixed, RbfRobust};
use crate::voxel::{VoxelConfig, Voxels};

/// NMSE₂ that a frame comes down to where nothing else is chosen: the noise of 64 jittered samples in every pixel of a hall is
/// 3e-5 to 1e-4.
pub const DEFAULT_TARGET: f32 = 1e-4;

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
    /// Cells with masks at their corners, split where the visible fraction cannot be predicted.
    Lattice(LatticeConfig),
}

/// A visibility backend and its constants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
pub enum VisibilityConfig {
    /// Shadow rays through the BVH, in packets.
    Bvh,
    /// 4D rasterization (Wang17).
    Raster4d(Raster4dConfig),
    /// Beams and shafts through the BVH.
    Beam,
    /// Beams where few triangles lie between receivers and light, rays elsewhere; their answers are the same.
    #[default]
    Auto,
    /// Voxel marching (Nichols10): approximate.
    Voxel(VoxelConfig),
}

/// A stage with its constants, chosen by name.
pub trait Named: Sized + Serialize + DeserializeOwned {
    /// What the stage is called.
    const STAGE: &str;
    /// The names that [`Named::named`] knows.
    const NAMES: &[&str];

    /// The choice of this name with its default constants.
    fn named(name: &str) -> Option<Self>;

    /// Its name in options, files and tables.
    fn name(&self) -> &'static str;
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
    RbfRobust,
    /// Triangulation of the samples.
    Delaunay,
    /// Bilinear between the corners of cells. On the GPU it takes the lattice refiner.
    #[default]
    Lattice,
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
            refiner: RefinerConfig::default(),
            visibility: VisibilityConfig::default(),
            upsampler: RefinerConfig::default().upsampler(),
            shading: Shading::default(),
            sampling: LightSampling::default(),
            seed: 0,
        }
    }
}

impl Named for RefinerConfig {
    const STAGE: &str = "refiner";
    const NAMES: &[&str] = &["nichols", "sfvt-gass", "full", "lattice"];

    fn named(name: &str) -> Option<Self> {
        match name {
            "nichols" => Some(Self::Nichols(NicholsConfig::default())),
            "sfvt-gass" => Some(Self::SfvtGass(SfvtGassConfig::default())),
            "full" => Some(Self::Full),
            "lattice" => Some(Self::Lattice(LatticeConfig::default())),
            _ => None,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Nichols(_) => "nichols",
            Self::SfvtGass(_) => "sfvt-gass",
            Self::Full => "full",
            Self::Lattice(_) => "lattice",
        }
    }
}

/// The lattice at an error target of [`DEFAULT_TARGET`].
impl Default for RefinerConfig {
    fn default() -> Self {
        Self::Lattice(LatticeConfig { target: DEFAULT_TARGET, ..LatticeConfig::default() })
    }
}

impl RefinerConfig {
    /// Returns the upsampler that fits the refiner, on the CPU and on the GPU: what is taken where none is chosen.
    pub fn upsampler(&self) -> UpsamplerConfig {
        match self {
            Self::Lattice(_) => UpsamplerConfig::Lattice,
            Self::Full => UpsamplerConfig::Bilinear,
            Self::Nichols(_) | Self::SfvtGass(_) => UpsamplerConfig::RbfRobust,
        }
    }

    /// The stage itself.
    pub fn stage(&self) -> Box<dyn Refiner> {
        match *self {
            Self::Nichols(config) => Box::new(Nichols::new(config)),
            Self::SfvtGass(config) => Box::new(SfvtGass::new(config)),
            Self::Full => Box::new(Full::default()),
            Self::Lattice(config) => Box::new(Lattice::new(config)),
        }
    }
}

impl Named for VisibilityConfig {
    const STAGE: &str = "visibility";
    const NAMES: &[&str] = &["bvh", "raster4d", "beam", "auto", "voxel"];

    fn named(name: &str) -> Option<Self> {
        match name {
            "bvh" => Some(Self::Bvh),
            "raster4d" => Some(Self::Raster4d(Raster4dConfig::default())),
            "beam" => Some(Self::Beam),
            "auto" => Some(Self::Auto),
            "voxel" => Some(Self::Voxel(VoxelConfig::default())),
            _ => None,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Bvh => "bvh",
            Self::Raster4d(_) => "raster4d",
            Self::Beam => "beam",
            Self::Auto => "auto",
            Self::Voxel(_) => "voxel",
        }
    }
}

impl VisibilityConfig {
    /// The stage itself.
    ///
    /// # Errors
    /// A constant is out of range.
    pub fn stage(&self, bvh: &Arc<Bvh>) -> Result<Box<dyn Visibility>, PipelineError> {
        Ok(match *self {
            Self::Bvh => Box::new(BvhRays::new(Arc::clone(bvh))),
            Self::Raster4d(config) => Box::new(Raster4d::new(config)?),
            Self::Beam => Box::new(Beam::new(Arc::clone(bvh))),
            Self::Auto => Box::new(Beam::or_rays(Arc::clone(bvh))),
            Self::Voxel(config) => Box::new(Voxels::new(config)?),
        })
    }
}

impl UpsamplerConfig {
    /// The names that [`UpsamplerConfig::named`] knows.
    pub const NAMES: [&str; 6] =
        ["bilinear", "rbf-fixed", "rbf-adaptive", "rbf-robust", "delaunay", "lattice"];

    /// All upsamplers, in the order of their names.
    pub const ALL: [Self; 6] =
        [Self::Bilinear, Self::RbfFixed, Self::RbfAdaptive, Self::RbfRobust, Self::Delaunay, Self::Lattice];

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
            Self::Lattice => "lattice",
        }
    }

    /// The stage itself, behind a refiner: between corners of cells, surfaces end where the lattice refiner says.
    pub fn stage(&self, refiner: &RefinerConfig) -> Box<dyn Upsampler> {
        match self {
            Self::Bilinear => Box::new(Bilinear::default()),
            Self::RbfFixed => Box::new(RbfFixed::default()),
            Self::RbfAdaptive => Box::new(RbfAdaptive::default()),
            Self::RbfRobust => Box::new(RbfRobust::default()),
            Self::Delaunay => Box::new(Delaunay::default()),
            Self::Lattice => {
                let discontinuity = match refiner {
                    RefinerConfig::Lattice(lattice) => lattice.discontinuity,
                    _ => DiscontinuityLimits::default(),
                };
                Box::new(upsample::Lattice::new(upsample::LatticeConfig {
                    discontinuity,
                    ..Default::default()
                }))
            }
        }
    }
}

impl PipelineConfig {
    /// Bytes that a frame takes beside its scene, about, and rather more than less. How many fragments an adaptive refiner
    /// will need is not known before; scenes that need more than is usual take up to twice as much.
    ///
    /// Bytes a pixel, from the peak use of the program at 960 × 720 and 1920 × 1440 pixels in five scenes:
    ///
    /// | refiner | 64 samples | measured | each further 64 samples |
    /// | --- | --- | --- | --- |
    /// | `full` | 180 | 120 to 177 | 16 |
    /// | `lattice` with proofs | 170 | 103 to 157 | 8 |
    /// | others | 130 | 83 to 128 | 8 |
    pub fn bytes_needed(&self) -> u64 {
        let words = u64::from(self.sampling.count.clamp(1, 4096)).div_ceil(64);
        let bytes = match self.refiner {
            RefinerConfig::Full => 180 + 16 * (words - 1),
            RefinerConfig::Lattice(lattice) if lattice.certify => 170 + 8 * (words - 1),
            _ => 130 + 8 * (words - 1),
        };
        u64::from(self.width).saturating_mul(u64::from(self.height)).saturating_mul(bytes)
    }

    /// A builder with these choices made; threads, layers and stages of one's own can still be set.
    pub fn builder(&self, scene: &PreparedScene) -> PipelineBuilder {
        let visibility = self.visibility.stage(scene.bvh());
        let builder = Pipeline::builder(scene)
            .size(self.width, self.height)
            .boxed_refiner(self.refiner.stage())
            .boxed_upsampler(self.upsampler.stage(&self.refiner))
            .shading(self.shading)
            .sampling(self.sampling)
            .seed(self.seed);
        match visibility {
            Ok(stage) => builder.boxed_visibility(stage),
            Err(fault) => builder.failing(fault),
        }
    }
}
