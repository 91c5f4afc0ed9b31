//! Upsamplers: from fragments to one value per pixel.
//!
//! [`Bilinear`], [`RbfFixed`] and [`RbfAdaptive`] are those of the papers, with their artefacts.
//! [`RbfRobust`], [`Delaunay`] and [`Lattice`] reproduce constants, stay within the bounds of their samples
//! and respect surfaces.
//!
//! Rules for all: background pixels and pixels in no cell get 0. A sample without a value
//! ([`NO_VALUE`](halflight_core::values::NO_VALUE)) is skipped, except by the papers' RBF, where it counts as 0. Arguments whose sizes disagree give an image of zeros.

mod bilinear;
mod cells;
mod delaunay;
mod lattice;
mod nearby;
mod rbf;
mod robust;
mod surface;
#[cfg(test)]
mod tests;

pub use bilinear::{Bilinear, BilinearConfig};
pub use delaunay::{Delaunay, DelaunayConfig};
pub use lattice::{Lattice, LatticeConfig};
pub use rbf::{RbfAdaptive, RbfAdaptiveConfig, RbfFixed, RbfFixedConfig};
pub use robust::{RbfRobust, RbfRobustConfig};
pub use surface::SurfaceLimits;
