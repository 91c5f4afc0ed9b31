//! Quality of pictures: named bounds on their errors.

use std::fmt;
use std::str::FromStr;

use super::LatticeConfig;

/// Quality of a picture, as bounds on its errors that the lattice refiner works towards.
///
/// | quality | NMSE₂ | visible error of a sample ([`LatticeConfig::visible_error`]) | grain, in foliage | 99th percentile of ꟻLIP |
/// | --- | --- | --- | --- | --- |
/// | `draft` | 3e-4 | 0.1 | 0.25, 0.3 | 0.1 |
/// | `good` | 1e-4 | 0.04 | 0.1, 0.2 | 0.08 |
/// | `final` | 1e-5 | 0.015 | 0.05, 0.1 | 0.045 |
///
/// The first two are what the refiner works towards; the last two, of whole pictures against references of 4,096 samples a pixel, are what it keeps
/// in the test `quality` on a box, a courtyard, toys and a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// First look.
    Draft,
    /// Clean pictures.
    #[default]
    Good,
    /// Pictures without visible difference from a reference.
    Final,
}

impl Quality {
    /// All qualities, the lowest first.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Good, Self::Final];

    /// Returns the name in options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Good => "good",
            Self::Final => "final",
        }
    }

    /// Returns the number of sub-samples a pixel that the program takes for the quality on the CPU: 8, or 1 for `draft`.
    pub fn antialias(self) -> u32 {
        match self {
            Self::Draft => 1,
            Self::Good | Self::Final => 8,
        }
    }

    /// Returns the lattice refiner's options for the quality.
    pub fn lattice(self) -> LatticeConfig {
        let (target, visible_error) = match self {
            Self::Draft => (3e-4, 0.1),
            Self::Good => (1e-4, 0.04),
            Self::Final => (1e-5, 0.015),
        };
        LatticeConfig { target, visible_error, ..LatticeConfig::default() }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Name that is no quality's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no quality `{0}`, expected draft, good or final")]
pub struct UnknownQuality(String);

impl FromStr for Quality {
    type Err = UnknownQuality;

    fn from_str(name: &str) -> Result<Self, UnknownQuality> {
        let found = Self::ALL.into_iter().find(|quality| quality.name() == name);
        found.ok_or_else(|| UnknownQuality(name.to_owned()))
    }
}
