//! Every choice of a pipeline as data: what the program's options, experiment files and stored images name.

use std::fmt;
use std::sync::Arc;

use halflight_core::frame::LightSampling;
use halflight_core::pattern::PatternKind;
use halflight_core::stages::{Refiner, Upsampler, Visibility};
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::beam::Beam;
use crate::bvh::Bvh;
use crate::indirect::{Gather, GatherConfig, Indirect, Lpv, LpvConfig, MOST_POINTS};
use crate::irradiance::Shading;
use crate::pipeline::{Pipeline, PipelineBuilder, PipelineError};
use crate::prepared::PreparedScene;
use crate::raster4d::{Raster4d, Raster4dConfig};
use crate::rays::BvhRays;
use crate::refine::{
    DiscontinuityLimits, Lattice, LatticeConfig, Nichols, NicholsConfig, PerPixel, SfvtGass, SfvtGassConfig,
};
pub use crate::refine::{Quality, UnknownQuality};
use crate::upsample::{
    self, Bilinear, BilinearConfig, Delaunay, DelaunayConfig, RbfAdaptive, RbfAdaptiveConfig, RbfFixed,
    RbfFixedConfig, RbfRobust, RbfRobustConfig,
};
use crate::voxel::{VoxelConfig, Voxels};

/// Declares the stages of one kind, an entry a stage: documentation, variant, constants, name and old names. Names, defaults by
/// name and the list of all stages follow from it.
macro_rules! stages {
    ($(#[$about:meta])* $kind:ident, $title:literal, $($(#[$doc:meta])* $variant:ident $(($constants:ty))? = $name:literal $(| $old:literal)*,)+) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "name", rename_all = "kebab-case", remote = "Self")]
        #[non_exhaustive]
        pub enum $kind {
            $($(#[$doc])* #[serde(rename = $name $(, alias = $old)*)] $variant $(($constants))?,)+
        }

        impl Named for $kind {
            const STAGE: &str = $title;
            const NAMES: &[&str] = &[$($name),+];
            const OLD_NAMES: &[&[&str]] = &[$(&[$($old),*]),+];

            fn named(name: &str) -> Option<Self> {
                match name {
                    $($name $(| $old)* => Some(Self::$variant $((<$constants>::default()))?),)+
                    _ => None,
                }
            }

            fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => $name,)+
                }
            }
        }

        impl Serialize for $kind {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $kind::serialize(self, serializer)
            }
        }

        /// Reads a stage from its name alone, for its default constants, or from a table with name and constants.
        impl<'de> Deserialize<'de> for $kind {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct NameOrTable;

                impl<'de> Visitor<'de> for NameOrTable {
                    type Value = $kind;

                    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                        write!(f, "the name of a {}, or a table with its name and constants", $title)
                    }

                    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<$kind, E> {
                        $kind::named(name).ok_or_else(|| E::unknown_variant(name, $kind::NAMES))
                    }

                    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<$kind, A::Error> {
                        $kind::deserialize(MapAccessDeserializer::new(map))
                    }
                }

                deserializer.deserialize_any(NameOrTable)
            }
        }
    };
}

/// A stage with its constants, chosen by name.
pub trait Named: Sized + Serialize + DeserializeOwned {
    /// Kind of stage: `refiner`, `visibility` or `upsampler`.
    const STAGE: &str;
    /// Names of all stages of the kind.
    const NAMES: &[&str];
    /// Former names that are still read, a list for each of [`Named::NAMES`].
    const OLD_NAMES: &[&[&str]];

    /// Returns the stage of this name, or former name, with its default constants.
    fn named(name: &str) -> Option<Self>;

    /// Returns the stage's name in options, files and tables.
    fn name(&self) -> &'static str;

    /// Returns all stages of the kind with their default constants, in the order of their names.
    fn all() -> Vec<Self> {
        Self::NAMES.iter().filter_map(|name| Self::named(name)).collect()
    }
}

stages! {
    /// A refiner and its constants.
    RefinerConfig, "refiner",
    /// 3 × 3 neighbourhoods (Nichols10).
    Nichols(NicholsConfig) = "nichols",
    /// Sub-fragment visibility test and gradient-aware refinement (Koa17).
    SfvtGass(SfvtGassConfig) = "sfvt-gass",
    /// Every pixel with light samples of its own.
    PerPixel = "per-pixel" | "full",
    /// Cells with masks at their corners, split where the visible fraction cannot be predicted.
    Lattice(LatticeConfig) = "lattice",
}

stages! {
    /// A visibility backend and its constants.
    #[derive(Default)]
    VisibilityConfig, "visibility",
    /// Shadow rays through the BVH, in packets.
    Bvh = "bvh",
    /// 4D rasterization (Wang17).
    Raster4d(Raster4dConfig) = "raster4d",
    /// Beams and shafts through the BVH.
    Beam = "beam",
    /// Beams where few triangles lie between receivers and light, rays elsewhere; their answers are equal.
    #[default]
    Auto = "auto",
    /// Voxel marching (Nichols10): approximate.
    Voxel(VoxelConfig) = "voxel",
}

stages! {
    /// An upsampler and its constants.
    UpsamplerConfig, "upsampler",
    /// Multi-pass bilinear (Nichols10).
    Bilinear(BilinearConfig) = "bilinear",
    /// Gaussian RBF of fixed variance (Koa16).
    RbfFixed(RbfFixedConfig) = "rbf-fixed",
    /// Gaussian RBF of adaptive variance (Koa17).
    RbfAdaptive(RbfAdaptiveConfig) = "rbf-adaptive",
    /// Normalised, plane-aware RBF weights.
    RbfRobust(RbfRobustConfig) = "rbf-robust",
    /// Triangulation of the samples.
    Delaunay(DelaunayConfig) = "delaunay",
    /// Bilinear between the corners of cells, which end at the lattice refiner's discontinuities. The constants are those of
    /// `rbf-robust`, for pixels that no corner serves. On the GPU it takes the lattice refiner.
    Lattice(RbfRobustConfig) = "lattice",
}

stages! {
    /// A method for indirect light and its constants.
    #[derive(Default)]
    IndirectConfig, "indirect",
    /// No indirect light.
    #[default]
    None = "none",
    /// Light propagation volume (Koa16).
    Lpv(LpvConfig) = "lpv",
    /// Light of one reflection, gathered from points on the surfaces.
    Gather(GatherConfig) = "gather",
}

impl IndirectConfig {
    /// Makes the stage; none for no indirect light.
    pub fn stage(&self) -> Option<Box<dyn Indirect>> {
        match *self {
            Self::None => None,
            Self::Lpv(config) => Some(Box::new(Lpv::new(config))),
            Self::Gather(config) => Some(Box::new(Gather::new(config))),
        }
    }
}

impl Default for UpsamplerConfig {
    /// The one that fits the default refiner.
    fn default() -> Self {
        RefinerConfig::default().upsampler()
    }
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
    /// Quantity that is interpolated.
    pub shading: Shading,
    /// Light samples.
    pub sampling: LightSampling,
    /// Indirect light; on the CPU only.
    #[serde(default)]
    pub indirect: IndirectConfig,
    /// Seed of all randomness.
    pub seed: u32,
    /// Sub-samples of pixels that see several surfaces: 1 (off), 4, 8 or 16. On the GPU, of all pixels, by
    /// `Gpu::render_antialiased`.
    #[serde(default = "no_antialiasing")]
    pub antialias: u32,
}

/// Returns the number of sub-samples in files that do not say it.
fn no_antialiasing() -> u32 {
    1
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
            indirect: IndirectConfig::default(),
            seed: 0,
            antialias: no_antialiasing(),
        }
    }
}

/// The lattice at the default [`Quality`].
impl Default for RefinerConfig {
    fn default() -> Self {
        Self::Lattice(Quality::default().lattice())
    }
}

impl RefinerConfig {
    /// Returns the upsampler that fits the refiner, on the CPU and on the GPU: what is taken where none is chosen.
    pub fn upsampler(&self) -> UpsamplerConfig {
        match self {
            Self::Lattice(_) => UpsamplerConfig::Lattice(RbfRobustConfig::default()),
            Self::PerPixel => UpsamplerConfig::Bilinear(BilinearConfig::default()),
            Self::Nichols(_) | Self::SfvtGass(_) => UpsamplerConfig::RbfRobust(RbfRobustConfig::default()),
        }
    }

    /// The stage itself.
    pub fn stage(&self) -> Box<dyn Refiner> {
        match *self {
            Self::Nichols(config) => Box::new(Nichols::new(config)),
            Self::SfvtGass(config) => Box::new(SfvtGass::new(config)),
            Self::PerPixel => Box::new(PerPixel::default()),
            Self::Lattice(config) => Box::new(Lattice::new(config)),
        }
    }
}

impl VisibilityConfig {
    /// Returns true where every light sample is answered exactly.
    pub fn is_exact(&self) -> bool {
        !matches!(self, Self::Voxel(_))
    }

    /// Returns true where regions can be certified, as the lattice's `certify` needs.
    pub fn certifies(&self) -> bool {
        matches!(self, Self::Bvh | Self::Beam | Self::Auto)
    }

    /// Returns the light samples with the placement that the backend needs: rows for 4D rasterization.
    pub fn fit(&self, sampling: LightSampling) -> LightSampling {
        match (self, sampling.kind) {
            (Self::Raster4d(_), PatternKind::Jittered) => {
                LightSampling { kind: PatternKind::ShiftedRows, ..sampling }
            }
            _ => sampling,
        }
    }

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
    /// Makes the stage, to go behind a refiner: between corners of cells, surfaces end where the lattice refiner says.
    pub fn stage(&self, refiner: &RefinerConfig) -> Box<dyn Upsampler> {
        match *self {
            Self::Bilinear(config) => Box::new(Bilinear::new(config)),
            Self::RbfFixed(config) => Box::new(RbfFixed::new(config)),
            Self::RbfAdaptive(config) => Box::new(RbfAdaptive::new(config)),
            Self::RbfRobust(config) => Box::new(RbfRobust::new(config)),
            Self::Delaunay(config) => Box::new(Delaunay::new(config)),
            Self::Lattice(rest) => {
                let discontinuity = match refiner {
                    RefinerConfig::Lattice(lattice) => lattice.discontinuity,
                    _ => DiscontinuityLimits::default(),
                };
                Box::new(upsample::Lattice::new(upsample::LatticeConfig { discontinuity, rest }))
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
    /// | `per-pixel` | 180 | 120 to 177 | 16 |
    /// | `lattice` with `certify` | 170 | 103 to 157 | 8 |
    /// | others | 130 | 83 to 128 | 8 |
    ///
    /// Antialiasing adds 20, and 18 for each sub-sample: a quarter of the pixels at edges, as in furnished rooms. Indirect light adds 64 a pixel, 1,500 and a light sample's
    /// share of masks a point, and 400 a cell of its grid.
    pub fn bytes_needed(&self) -> u64 {
        let words = u64::from(self.sampling.count.clamp(1, 4096)).div_ceil(64);
        let bytes = match self.refiner {
            RefinerConfig::PerPixel => 180 + 16 * (words - 1),
            RefinerConfig::Lattice(lattice) if lattice.certify => 170 + 8 * (words - 1),
            _ => 130 + 8 * (words - 1),
        };
        let antialias = if self.antialias > 1 { 20 + 18 * u64::from(self.antialias.min(16)) } else { 0 };
        let of_points = |points: u32, samples: u32| {
            let words = u64::from(samples.clamp(1, 4096)).div_ceil(64);
            (1500 + 32 * words) * u64::from(points.min(MOST_POINTS))
        };
        let (indirect, fixed) = match self.indirect {
            IndirectConfig::None => (0, 0),
            IndirectConfig::Gather(config) => (64, of_points(config.points, config.light_samples)),
            IndirectConfig::Lpv(config) => {
                let cells = u64::from(config.cells.clamp(4, 128)) + 8;
                (64, of_points(config.points, config.light_samples) + 400 * cells.pow(3))
            }
        };
        let pixels = u64::from(self.width).saturating_mul(u64::from(self.height));
        pixels.saturating_mul(bytes + antialias + indirect).saturating_add(fixed)
    }

    /// A builder with these choices made; threads, layers and stages of one's own can still be set.
    pub fn builder(&self, scene: &PreparedScene) -> PipelineBuilder {
        let visibility = if self.indirect != IndirectConfig::None && !self.visibility.is_exact() {
            Err(PipelineError::InexactIndirect(self.visibility.name()))
        } else {
            self.visibility.stage(scene.bvh())
        };
        let builder = Pipeline::builder(scene)
            .size(self.width, self.height)
            .boxed_refiner(self.refiner.stage())
            .boxed_upsampler(self.upsampler.stage(&self.refiner))
            .shading(self.shading)
            .sampling(self.sampling)
            .boxed_indirect(self.indirect.stage())
            .seed(self.seed)
            .antialias(self.antialias);
        match visibility {
            Ok(stage) => builder.boxed_visibility(stage),
            Err(fault) => builder.failing(fault),
        }
    }
}
