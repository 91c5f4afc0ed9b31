//! Refiners: a file each, with its passes, the buffers that it declares, and the order of the passes.

mod lattice;
mod nichols;
mod per_pixel;
mod refiner;
mod request;
mod sfvt_gass;
mod target;
mod tracer;

use halflight_cpu::config::{Named as _, PipelineConfig, RefinerConfig};

use crate::error::GpuError;
use crate::pass::Compiler;
pub(crate) use refiner::Refiner;
pub(crate) use tracer::Tracer;

#[cfg(test)]
pub(crate) use target::Choice;

/// Programs of all refiners.
#[cfg(test)]
pub(crate) const PROGRAMS: &[&[crate::program::Program]] = &[
    lattice::PROGRAMS,
    nichols::PROGRAMS,
    per_pixel::PROGRAMS,
    refiner::PROGRAMS,
    request::PROGRAMS,
    sfvt_gass::PROGRAMS,
    target::PROGRAMS,
    tracer::PROGRAMS,
];

/// Compiles the refiner of a configuration.
///
/// # Errors
/// The refiner does not exist on the GPU, or a shader cannot be compiled.
pub(crate) fn refiner(compiler: &Compiler, config: &PipelineConfig) -> Result<Box<dyn Refiner>, GpuError> {
    Ok(match config.refiner {
        RefinerConfig::PerPixel => Box::new(per_pixel::PerPixel::new(compiler)?),
        RefinerConfig::Nichols(own) => Box::new(nichols::Nichols::new(compiler, own, config.shading)?),
        RefinerConfig::SfvtGass(own) => Box::new(sfvt_gass::SfvtGass::new(compiler, own, config.shading)?),
        RefinerConfig::Lattice(own) => Box::new(lattice::Lattice::new(compiler, own, config.shading)?),
        _ => {
            let stage = config.refiner.name();
            return Err(GpuError::Unsupported {
                stage,
                reason: "this refiner exists on the CPU only; use `lattice`",
            });
        }
    })
}
