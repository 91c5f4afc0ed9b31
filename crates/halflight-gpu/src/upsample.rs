//! Upsamplers: their passes and the order of these.

use halflight_cpu::config::{Named as _, PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight_cpu::upsample::{RbfAdaptiveConfig, RbfFixedConfig, RbfRobustConfig, SurfaceLimits};

use crate::bindings::Slot;
use crate::error::GpuError;
use crate::needs::Needs;
use crate::pass::{Compiler, Pass};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    COPY: "copy" = copy in "upsample/copy";
    BILINEAR: "bilinear" = bilinear in "upsample/bilinear";
    RBF: "rbf" = pixels in "upsample/rbf";
    TRUST: "trust" = trust in "upsample/trust";
    ROBUST: "rbf-robust" = pixels in "upsample/robust";
    LATTICE: "lattice" = pixels in "upsample/lattice";
}

/// An upsampler.
#[derive(Debug)]
pub(crate) enum Upsample {
    /// One pass over all pixels: those that have samples of their own, or corners.
    Pixels(Pass),
    /// Level by level.
    Bilinear(Pass),
    /// Radial basis functions of the papers.
    Rbf(Pass),
    /// Planes fitted to samples that stand for one surface.
    Robust {
        /// Judges the surfaces of samples.
        trust: Pass,
        /// Fits pixels.
        fit: Pass,
    },
}

impl Upsample {
    /// Compiles the passes of a configuration's upsampler.
    ///
    /// # Errors
    /// The upsampler does not exist on the GPU, or a shader cannot be compiled.
    pub(crate) fn new(compiler: &Compiler, config: &PipelineConfig) -> Result<Self, GpuError> {
        let pass = |program, constants: &[(&str, f64)]| compiler.pass(program, constants);
        let rbf = |variance: f32, reach: f32, copied: u8, adaptive: f64| {
            let constants = [
                ("VARIANCE", variance.into()),
                ("REACH", reach.into()),
                ("COPIED_LEVEL", copied.into()),
                ("ADAPTIVE", adaptive),
            ];
            Ok(Self::Rbf(pass(RBF, &constants)?))
        };
        match config.upsampler {
            UpsamplerConfig::Delaunay(_) => Err(GpuError::Unsupported {
                stage: "delaunay",
                reason: "a triangulation is made one point after another; use `rbf-robust`",
            }),
            UpsamplerConfig::Lattice(_) if matches!(config.refiner, RefinerConfig::Lattice(_)) => {
                Ok(Self::Pixels(pass(LATTICE, &[])?))
            }
            _ if matches!(config.refiner, RefinerConfig::Lattice(_)) => Err(GpuError::Unsupported {
                stage: "this upsampler with the refiner `lattice`",
                reason: "its cells share samples at their corners; use `lattice`",
            }),
            _ if config.refiner == RefinerConfig::PerPixel => Ok(Self::Pixels(pass(COPY, &[])?)),
            UpsamplerConfig::Bilinear(_) => Ok(Self::Bilinear(pass(BILINEAR, &[])?)),
            UpsamplerConfig::RbfFixed(RbfFixedConfig { variance, copied_level, reach }) => {
                rbf(variance, reach, copied_level, 0.0)
            }
            UpsamplerConfig::RbfAdaptive(RbfAdaptiveConfig { variance, copied_level, reach }) => {
                rbf(variance, reach, copied_level, 1.0)
            }
            UpsamplerConfig::RbfRobust(RbfRobustConfig { radius, softness_px, stiffness, .. }) => {
                let constants = [
                    ("RADIUS", radius.max(1.0).into()),
                    ("SOFTNESS", softness_px.max(1e-3).powi(2).into()),
                    ("STIFFNESS", stiffness.max(1e-4).into()),
                ];
                Ok(Self::Robust { trust: pass(TRUST, &[])?, fit: pass(ROBUST, &constants)? })
            }
            UpsamplerConfig::Lattice(_) => Err(GpuError::Unsupported {
                stage: "the upsampler `lattice` with this refiner",
                reason: "its cells have no samples at their corners; use `rbf-robust`",
            }),
            _ => Err(GpuError::Unsupported {
                stage: config.upsampler.name(),
                reason: "this upsampler exists on the CPU only; use `rbf-robust`",
            }),
        }
    }

    /// Returns the limits of surfaces within which an upsampler mixes values.
    pub(crate) fn surface_limits(config: &UpsamplerConfig) -> SurfaceLimits {
        match config {
            UpsamplerConfig::Bilinear(config) => config.surface,
            UpsamplerConfig::RbfRobust(config) | UpsamplerConfig::Lattice(config) => config.surface,
            _ => SurfaceLimits::default(),
        }
    }

    /// Declares the buffers of an upsampler: one value a pixel, and values of the refiner's samples.
    pub(crate) fn declare(&self, needs: &mut Needs) {
        needs.declare(Slot::Plane, 4 * needs.pixels());
        let samples = needs.records(Slot::Samples);
        match self {
            Self::Pixels(_) | Self::Rbf(_) => {}
            Self::Bilinear(_) => needs.declare(Slot::Texels, 8 * samples),
            Self::Robust { .. } => needs.declare(Slot::Trusts, 4 * samples),
        }
    }

    /// Records the values of pixels for one light, whose uniforms begin at `first`.
    pub(crate) fn record(&self, recorder: &mut Recorder, first: u32, coarsest: u32) {
        let mut run = |pass, level| recorder.run(pass, Timed::Upsample, first + level, Groups::Tiles(level));
        match self {
            Self::Pixels(pass) | Self::Rbf(pass) => run(pass, 0),
            Self::Bilinear(pass) => (0..=coarsest).rev().for_each(|level| run(pass, level)),
            Self::Robust { trust, fit } => {
                (1..=coarsest).for_each(|level| run(trust, level));
                run(fit, 0);
            }
        }
    }
}
