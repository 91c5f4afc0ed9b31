//! Upsamplers: fragments to one value a pixel.
//!
//! [`Bilinear`], [`RbfFixed`] and [`RbfAdaptive`] are the papers' own, with their faults; [`RbfRobust`], [`Delaunay`] and
//! [`Lattice`] keep a flat field flat, stay within the bounds of their samples and know planes.
//!
//! Rules for all: pixels that see nothing or lie in no cell get 0. A value that is `None` is skipped, except by the
//! papers' RBF, where it counts as 0. Arguments whose sizes disagree give an image of zeros.

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
