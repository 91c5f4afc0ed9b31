//! Constants of the Phong pass.

use halflight_cpu::config::Named;
use halflight_cpu::refine::GeometryThresholds;
use serde::{Deserialize, Serialize};

/// Visibility of what a lobe reflects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LobeVisibility {
    /// Nothing hides the light (§3.2.1).
    None,
    /// Each sample is seen or not (§3.3.3, before its last proposal).
    Binary,
    /// Samples of the grid by the variance of occluder distances; light samples are seen or not (§3.3.3).
    #[default]
    Variance,
}

/// Constants of the Phong pass of Nichols10.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PhongConfig {
    /// Light samples: 256 (§3.2.1).
    pub samples: u32,
    /// Level of the coarsest fragments: 4, a 64² grid for a 1024² image (§3.3.2). 0 gathers at every pixel.
    pub coarsest_level: u8,
    /// Thresholds at which geometry alone splits a fragment (§3.2).
    pub geometry: GeometryThresholds,
    /// True if fragments are discarded where the lobe misses the light (§3.2.1).
    pub cull: bool,
    /// Value of (R·L)ⁿ towards every corner of the light below which the lobe misses it, if R misses it as well (§3.2.1, without a figure).
    pub cull_threshold: f32,
    /// True if the point of the light's outline that is nearest to where R passes is tested like a corner: the paper tests corners alone and
    /// loses what lobes narrower than the light reflect of its edges.
    pub cull_outline: bool,
    /// Value of (R·L)ⁿ at the lobe's edge, by which its width and the light samples inside are meant (§3.2.1, without a figure).
    pub lobe_edge: f32,
    /// Largest distance of fragments, as a lobe shifts over the light from one to the next, in widths of the lobe there; more splits them (§3.2.1: below 1).
    /// 0 or less switches this metric off.
    pub spacing: f32,
    /// Change of the value between neighbouring fragments above which they are split, relative to the largest of the coarsest level (§3.4); none
    /// by default, since "material specific metrics typically provide better quality".
    pub threshold: Option<f32>,
    /// Light samples in a lobe below which it is sampled by a grid: 9 (§3.2.1). 0 never does.
    pub few: u32,
    /// Directions along either side of the grid: 5 (§3.2.1).
    pub grid: u32,
    /// True if the light's texture is averaged over the distance of the grid's samples (§3.2.1: a mipmap level that fits); false takes single texels.
    pub filtered: bool,
    /// Visibility (§3.3.3).
    pub visibility: LobeVisibility,
    /// Distance up to which the fragments of a level are blurred, in fragments (§3.3.3, without a figure).
    pub blur: u32,
    /// True if each fragment of a 2 × 2 block traces a quarter of the grid's samples (§3.3.3).
    pub interleaved: bool,
    /// Least variance of occluder distances, in squares of the distance to the light (Donnelly and Lauritzen 2006, §4.1).
    pub least_variance: f32,
}

impl Default for PhongConfig {
    fn default() -> Self {
        Self {
            samples: 256,
            coarsest_level: 4,
            geometry: GeometryThresholds::default(),
            cull: true,
            cull_threshold: 0.01,
            cull_outline: false,
            lobe_edge: 0.1,
            spacing: 1.0,
            threshold: None,
            few: 9,
            grid: 5,
            filtered: true,
            visibility: LobeVisibility::default(),
            blur: 2,
            interleaved: true,
            least_variance: 1e-6,
        }
    }
}

impl PhongConfig {
    /// Checks the constants.
    ///
    /// # Errors
    /// The first constant that is out of range, and its range.
    pub fn check(&self) -> Result<(), String> {
        let part = |name: &str, value: f32| match value > 0.0 && value < 1.0 {
            true => Ok(()),
            false => {
                Err(format!("specular pass with {name} = {value}: expected more than 0 and less than 1"))
            }
        };
        let count = |name: &str, value: u32, least: u32, most: u32| match (least..=most).contains(&value) {
            true => Ok(()),
            false => Err(format!("specular pass with {name} = {value}: expected {least} to {most}")),
        };
        count("samples", self.samples, 1, 4096)?;
        count(
            "coarsest_level",
            u32::from(self.coarsest_level),
            0,
            u32::from(halflight_core::pyramid::MAX_LEVEL),
        )?;
        count("grid", self.grid, 1, 8)?;
        count("blur", self.blur, 0, 16)?;
        part("cull_threshold", self.cull_threshold)?;
        part("lobe_edge", self.lobe_edge)?;
        let numbers = [("least_variance", self.least_variance), ("threshold", self.threshold.unwrap_or(0.0))];
        match numbers.into_iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite())) {
            None if self.spacing.is_finite() => Ok(()),
            None => Err(format!("specular pass with spacing = {}: expected a finite number", self.spacing)),
            Some((name, value)) => Err(format!("specular pass with {name} = {value}: expected 0 or more")),
        }
    }
}

/// Specular pass of an experiment and its constants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
pub enum SpecularPass {
    /// Phong pass of Nichols10.
    Nichols(PhongConfig),
}

impl Named for SpecularPass {
    const STAGE: &str = "specular pass";
    const NAMES: &[&str] = &["nichols"];
    const OLD_NAMES: &[&[&str]] = &[&[]];

    fn named(name: &str) -> Option<Self> {
        (name == "nichols").then(|| Self::Nichols(PhongConfig::default()))
    }

    fn name(&self) -> &'static str {
        "nichols"
    }
}
