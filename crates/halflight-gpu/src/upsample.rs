//! Upsamplers: which passes they are made of.

use halflight_cpu::config::{PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight_cpu::upsample::{RbfAdaptiveConfig, RbfFixedConfig, RbfRobustConfig};

use crate::GpuError;
use crate::buffers::Size;
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::{Compiler, Stage};
use crate::stats::Timed;

/// An upsampler.
#[derive(Debug)]
pub(crate) enum Upsample {
    /// One pass over all pixels: those that have samples of their own, or corners.
    Pixels(Stage),
    /// Level by level.
    Bilinear(Stage),
    /// The papers' radial basis functions.
    Rbf(Stage),
    /// Our own.
    Robust {
        /// Judges the surfaces of samples.
        trust: Stage,
        /// Fits pixels.
        fit: Stage,
    },
}

impl Upsample {
    /// Compiles the passes of a configuration's upsampler.
    ///
    /// # Errors
    /// It does not exist here, or a shader cannot be compiled.
    pub(crate) fn new(compiler: &Compiler, config: &PipelineConfig) -> Result<Self, GpuError> {
        let stage = |program, constants: &[(&str, f64)]| compiler.stage(program, constants);
        let rbf = |variance: f32, reach: f32, copied: u8, adaptive: f64| {
            let constants = [
                ("VARIANCE", variance.into()),
                ("REACH", reach.into()),
                ("COPIED_LEVEL", copied.into()),
                ("ADAPTIVE", adaptive),
            ];
            Ok(Self::Rbf(stage(programs::RBF, &constants)?))
        };
        match config.upsampler {
            UpsamplerConfig::Delaunay => Err(GpuError::Unsupported {
                stage: "delaunay",
                reason: "a triangulation is made one point after another; use `rbf-robust`",
            }),
            UpsamplerConfig::Lattice if matches!(config.refiner, RefinerConfig::Lattice(_)) => {
                Ok(Self::Pixels(stage(programs::LATTICE, &[])?))
            }
            _ if matches!(config.refiner, RefinerConfig::Lattice(_)) => Err(GpuError::Unsupported {
                stage: "this upsampler with the refiner `lattice`",
                reason: "its cells share samples at their corners; use `lattice`",
            }),
            _ if config.refiner == RefinerConfig::Full => Ok(Self::Pixels(stage(programs::COPY, &[])?)),
            UpsamplerConfig::Bilinear => Ok(Self::Bilinear(stage(programs::BILINEAR, &[])?)),
            UpsamplerConfig::RbfFixed => {
                let RbfFixedConfig { variance, copied_level, reach } = RbfFixedConfig::default();
                rbf(variance, reach, copied_level, 0.0)
            }
            UpsamplerConfig::RbfAdaptive => {
                let RbfAdaptiveConfig { variance, copied_level, reach } = RbfAdaptiveConfig::default();
                rbf(variance, reach, copied_level, 1.0)
            }
            UpsamplerConfig::RbfRobust => {
                let RbfRobustConfig { radius, softness_px, stiffness, .. } = RbfRobustConfig::default();
                let constants = [
                    ("RADIUS", radius.max(1.0).into()),
                    ("SOFTNESS", softness_px.max(1e-3).powi(2).into()),
                    ("STIFFNESS", stiffness.max(1e-4).into()),
                ];
                Ok(Self::Robust {
                    trust: stage(programs::TRUST, &[])?,
                    fit: stage(programs::ROBUST, &constants)?,
                })
            }
            UpsamplerConfig::Lattice => Err(GpuError::Unsupported {
                stage: "the upsampler `lattice` with this refiner",
                reason: "its cells have no samples at their corners; use `rbf-robust`",
            }),
        }
    }

    /// The size that its own buffers take besides those of the refiner.
    pub(crate) fn size(&self, size: Size) -> Size {
        match self {
            Self::Pixels(_) | Self::Rbf(_) => size,
            Self::Bilinear(_) => Size { texels: size.samples, ..size },
            Self::Robust { .. } => Size { trusts: size.samples, ..size },
        }
    }

    /// Records what is done for one light, whose uniforms begin at `first`.
    pub(crate) fn record(&self, recorder: &mut Recorder, first: u32, coarsest: u32) {
        let mut run =
            |stage, level| recorder.run(stage, Timed::Upsample, first + level, Groups::Tiles(level));
        match self {
            Self::Pixels(stage) | Self::Rbf(stage) => run(stage, 0),
            Self::Bilinear(stage) => (0..=coarsest).rev().for_each(|level| run(stage, level)),
            Self::Robust { trust, fit } => {
                (1..=coarsest).for_each(|level| run(trust, level));
                run(fit, 0);
            }
        }
    }

    /// All stages, to bind.
    pub(crate) fn stages(&mut self) -> Vec<&mut Stage> {
        match self {
            Self::Pixels(stage) | Self::Bilinear(stage) | Self::Rbf(stage) => vec![stage],
            Self::Robust { trust, fit } => vec![trust, fit],
        }
    }
}
