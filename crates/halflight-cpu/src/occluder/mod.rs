//! What triangles hide of a light from one receiver: the one question that every exact backend answers.
//!
//! The answer is exact (`exact`). Nearly always a filter in single precision knows it (`facet`), which comes with bounds
//! on its errors: for rays, for the samples of a mask one by one (`points`) or by rows (`rows`), for the light as a whole
//! (`over`). Where on the light a triangle's samples can lie is bounded beforehand (`window`).

mod block;
mod closest;
pub(crate) mod exact;
mod expansion;
mod facet;
mod over;
mod points;
mod rows;
mod spokes;
mod vector;
mod window;

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::mask::Query;
use halflight_core::pattern::{Pattern, PatternKind};

pub(crate) use block::{Block, Triangle};
pub(crate) use closest::Targets;
pub(crate) use facet::{Facets, Planes, barycentric, corner_weights};
pub(crate) use over::OverLight;
pub(crate) use points::Points;
pub(crate) use rows::Rows;
pub(crate) use spokes::Spokes;
pub(crate) use vector::Vector;

use crate::simd::Simd;

/// The samples that one receiver has asked for and that no triangle hides so far.
pub(crate) trait Samples: Send {
    /// Samples of no light yet.
    fn new() -> Self;

    /// Takes another pattern and light.
    fn set(&mut self, pattern: Pattern, light: &AreaLight);

    /// Starts anew with a receiver and the samples that it asks for.
    fn aim<S: Simd>(&mut self, query: &Query, wanted: &[u64]);

    /// Takes away what eight triangles hide. Returns one that hides all of the light, if any does.
    fn occlude<S: Simd>(&mut self, block: &Block) -> Option<usize>;

    /// Whether samples are left.
    fn any(&self) -> bool;

    /// Writes the samples that are left.
    fn write(&self, visible: &mut [u64]);
}

/// No samples at all, of no light: what there is before [`Samples::set`].
const NOTHING: Pattern = Pattern { kind: PatternKind::Grid, columns: 0, rows: 0 };
pub(crate) const NOWHERE: AreaLight = AreaLight {
    corner: Vec3::ZERO,
    edge_u: Vec3::X,
    edge_v: Vec3::Z,
    radiance: Vec3::ZERO,
    two_sided: false,
};
