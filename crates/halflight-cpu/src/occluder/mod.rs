//! Light samples that triangles hide from one receiver: the test that all exact backends share.
//!
//! The result is exact (`exact`). A single-precision filter with error bounds decides nearly all cases
//! (`facet`): for rays, for the samples of a mask one by one (`points`) or by rows (`rows`), or for the light
//! as a whole (`over`). The range of samples that a triangle may hide is bounded beforehand (`window`). Hits of
//! alpha-masked triangles are tested once more (`alpha`).

mod alpha;
mod block;
mod closest;
pub(crate) mod exact;
mod expansion;
mod facet;
mod over;
mod points;
mod rows;
mod spokes;
mod window;

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::mask::Query;
use halflight_core::pattern::{Pattern, PatternKind};

pub(crate) use crate::vector::Vector;
pub(crate) use alpha::is_solid;
pub(crate) use block::{Block, Triangle};
pub(crate) use closest::Targets;
pub(crate) use facet::{Facets, Planes, barycentric, corner_weights};
pub(crate) use over::OverLight;
pub(crate) use points::Points;
pub(crate) use rows::Rows;
pub(crate) use spokes::Spokes;

use crate::simd::Simd;

/// Samples that one receiver wants and that no triangle has hidden yet.
pub(crate) trait Samples: Send {
    /// Creates an empty set, for no light.
    fn new() -> Self;

    /// Sets the sample pattern and the light.
    fn set(&mut self, pattern: Pattern, light: &AreaLight);

    /// Restarts with a receiver and its wanted samples.
    fn aim<S: Simd>(&mut self, query: &Query, wanted: &[u64]);

    /// Removes the samples that eight triangles hide. Returns the lane of a triangle that hides all of the
    /// light, if any.
    fn occlude<S: Simd>(&mut self, block: &Block) -> Option<usize>;

    /// True if samples are left.
    fn any(&self) -> bool;

    /// Writes the remaining samples as a visibility mask.
    fn write(&self, visible: &mut [u64]);
}

/// Empty pattern and light: the state before [`Samples::set`].
const NOTHING: Pattern = Pattern { kind: PatternKind::Grid, columns: 0, rows: 0 };
pub(crate) const NOWHERE: AreaLight = AreaLight::parallelogram(Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::ZERO);
