//! Statistics that come back with every frame besides the image.
//!
//! The structs are `#[non_exhaustive]`, since later versions count more. Stages of one's own make [`VisibilityStats`] and
//! [`CertificateCounts`] from their defaults and set the fields that they know.

use std::iter::Sum;
use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::fragment::LEVELS;

/// Shadow rays, in the three columns that papers mix up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RayCounts {
    /// Traced to decide on refinement.
    pub refine: u64,
    /// Traced for irradiance alone: level-0 fragments and additional samples.
    #[serde(rename = "final")]
    pub last: u64,
    /// Traced for specular reflection alone.
    #[serde(default)]
    pub specular: u64,
    /// Traced for indirect light alone.
    #[serde(default)]
    pub indirect: u64,
    /// Not traced, because the sample lies below the receiver's or the light's horizon.
    pub skipped: u64,
    /// All traced rays.
    pub total: u64,
}

/// Wall-clock milliseconds of each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StageTimes {
    /// Primary visibility and surface attributes.
    pub gbuffer: f64,
    /// Discontinuity mipmaps.
    pub pyramid: f64,
    /// Refinement without the visibility and the certificates it asks for.
    pub refine: f64,
    /// Masks, with per-frame preparation of the backend and horizon culling.
    pub visibility: f64,
    /// Certificates of what cells see, where they were asked for.
    #[serde(default, alias = "prove")]
    pub certify: f64,
    /// Values of the samples from their masks.
    pub irradiance: f64,
    /// One value a pixel from the samples.
    pub upsample: f64,
    /// Unshadowed irradiance, product and sum over the lights.
    pub compose: f64,
    /// Specular reflection, with its shadow rays. Only with glossy surfaces.
    #[serde(default)]
    pub specular: f64,
    /// Indirect light, all of it. Only where it is asked for.
    #[serde(default)]
    pub indirect: f64,
    /// Edge pixels: their sub-samples, the masks of these, and the sum over the lights. On the GPU, all frames of sub-samples. Only with
    /// antialiasing.
    #[serde(default)]
    pub antialias: f64,
}

/// Counts of antialiasing; all 0 without. On the GPU, which gives every pixel all sub-samples, these alone are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct AntialiasCounts {
    /// Edge pixels: their neighbours see another surface.
    pub edge_pixels: u64,
    /// Edge pixels of which a sub-sample sees another surface than the centre, which are resolved.
    pub resolved_pixels: u64,
    /// Sub-samples that were traced, each a primary ray.
    pub sub_samples: u64,
    /// Visibility masks of sub-samples on surfaces that no pixel nearby sees, all lights together.
    pub masks: u64,
}

/// Counts and times of indirect light; all 0 without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct IndirectCounts {
    /// Points on the surfaces at which direct light was computed.
    pub points: u64,
    /// Sides of points that direct light reaches.
    pub lit: u64,
    /// Receivers at which light was gathered.
    pub records: u64,
    /// Shadow rays from points to the lights.
    pub light_rays: u64,
    /// Shadow rays between receivers and points.
    pub gather_rays: u64,
    /// Time to place points; 0 where those of the frame before were kept, ms.
    pub place_ms: f64,
    /// Time of direct light at the points, ms.
    pub light_ms: f64,
    /// Time to gather, or to inject and propagate, ms.
    pub transport_ms: f64,
    /// Time to interpolate or look up at pixels, ms.
    pub lookup_ms: f64,
}

/// Fragments of a frame, all lights together.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FragmentCounts {
    /// All samples.
    pub total: u64,
    /// Samples of each level, 0 first. Corners that cells share are single pixels, of level 0.
    pub per_level: [u64; LEVELS],
    /// Cells of each level, 0 first: how finely the image was divided. The GPU counts none.
    pub cells: [u64; LEVELS],
}

/// Work of a refiner at one level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LevelWork {
    /// Fragments whose visibility was asked for, whether they were kept or split.
    pub rendered: u64,
    /// Time of the level with the visibility that it asked for, ms.
    pub ms: f64,
}

impl AddAssign for LevelWork {
    fn add_assign(&mut self, other: Self) {
        self.rendered += other.rendered;
        self.ms += other.ms;
    }
}

/// Counts of how a visibility backend computed its masks; fields that have no meaning for a backend stay 0.
///
/// A backend starts with `VisibilityStats::default()` and sets fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct VisibilityStats {
    /// Preparation, once a frame, ms; part of the visibility stage's time.
    pub prepare_ms: f64,
    /// Receivers that were certified to see all of the light.
    pub lit: u64,
    /// Receivers that were certified to see nothing of the light.
    pub umbra: u64,
    /// Rays that these two certificates spared.
    pub spared: u64,
    /// Receivers that took their mask from a list of triangles which neighbours share.
    pub listed: u64,
    /// Receivers that walked the BVH by themselves.
    pub walked: u64,
    /// Receivers that met too many triangles and were left to rays.
    pub left_to_rays: u64,
    /// Triangle entries in the framebuffer's cells.
    pub entries: u64,
    /// Pairs of a receiver and a triangle that shared a cell.
    pub pairs: u64,
    /// Pairs left after rejection.
    pub kept: u64,
    /// Pairs in which the triangle hides a sample; 0 unless counting was asked for.
    pub relevant: u64,
    /// Receivers too near the light's plane to be projected, which looked at all triangles.
    pub unprojected: u64,
}

/// Receiver pixels by what was certified of the cells they lie in; all 0 unless certificates were asked for.
///
/// A refiner starts with `CertificateCounts::default()` and sets fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CertificateCounts {
    /// In cells that were certified to see all of the light.
    pub lit: u64,
    /// In cells that were certified to see nothing of it.
    pub umbra: u64,
    /// In cells in which the visible fraction was certified to vary little.
    pub bounded: u64,
    /// With masks of their own.
    pub traced: u64,
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.refine += other.refine;
        self.last += other.last;
        self.specular += other.specular;
        self.indirect += other.indirect;
        self.skipped += other.skipped;
        self.total += other.total;
    }
}

impl AddAssign for CertificateCounts {
    fn add_assign(&mut self, other: Self) {
        self.lit += other.lit;
        self.umbra += other.umbra;
        self.bounded += other.bounded;
        self.traced += other.traced;
    }
}

impl VisibilityStats {
    /// Receivers that beams answered for.
    pub fn receivers(&self) -> u64 {
        self.lit + self.umbra + self.listed + self.walked + self.left_to_rays
    }
}

impl AddAssign for VisibilityStats {
    fn add_assign(&mut self, other: Self) {
        let Self {
            prepare_ms,
            lit,
            umbra,
            spared,
            listed,
            walked,
            left_to_rays,
            entries,
            pairs,
            kept,
            relevant,
            unprojected,
        } = other;
        self.prepare_ms += prepare_ms;
        self.lit += lit;
        self.umbra += umbra;
        self.spared += spared;
        self.listed += listed;
        self.walked += walked;
        self.left_to_rays += left_to_rays;
        self.entries += entries;
        self.pairs += pairs;
        self.kept += kept;
        self.relevant += relevant;
        self.unprojected += unprojected;
    }
}

impl Sum for VisibilityStats {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        let mut all = Self::default();
        parts.for_each(|part| all += part);
        all
    }
}

/// Statistics of one frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FrameStats {
    /// Fragments by level.
    pub fragments: FragmentCounts,
    /// Shadow rays by purpose.
    pub rays: RayCounts,
    /// How masks were come by.
    pub visibility: VisibilityStats,
    /// Receiver pixels by what was certified of them.
    #[serde(alias = "proofs")]
    pub certified: CertificateCounts,
    /// Edge pixels and their sub-samples.
    #[serde(default)]
    pub antialias: AntialiasCounts,
    /// Indirect light.
    #[serde(default)]
    pub indirect: IndirectCounts,
    /// Work of each level, 0 first, all lights together; empty from refiners that do not work level by level.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<LevelWork>,
    /// Expected squared error of the irradiance over its squares, summed over the image by luminance: what the NMSE₂ against
    /// a reference should be. None from refiners that do not aim at one.
    #[serde(default)]
    pub expected_nmse2: Option<f64>,
    /// Time by stage.
    pub stages_ms: StageTimes,
    /// Time of the whole frame.
    pub total_ms: f64,
    /// Most bytes held by the pipeline and its stages at the end of any frame so far.
    pub peak_bytes: u64,
}
