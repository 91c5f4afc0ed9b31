//! Names of pictures of rows.

use super::record::Finished;
use crate::experiment::Experiment;

/// Width and height of the part of a picture that is shown magnified, pixels; less where the picture is smaller.
pub const WINDOW: [u32; 2] = [72, 54];

/// Kind of a picture of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// Tone-mapped image.
    Image,
    /// Map of the fragments.
    Fragments,
    /// Map of the error.
    Error,
    /// Map of the squared error, as in Koa17.
    SquaredError,
    /// Map of the receivers that voxel marching gets wrong.
    Failures,
}

impl PictureKind {
    /// All kinds.
    pub const ALL: [Self; 5] =
        [Self::Image, Self::Fragments, Self::Error, Self::SquaredError, Self::Failures];

    /// Returns the name in the report.
    fn name(self) -> &'static str {
        match self {
            Self::Image => "picture",
            Self::Fragments => "fragments",
            Self::Error => "error",
            Self::SquaredError => "squared error",
            Self::Failures => "failures",
        }
    }

    /// Returns the name of the file in the folder of the row's setting.
    pub fn file(self, row: &Finished) -> String {
        match self {
            Self::Image => format!("{}.png", row.row),
            Self::Fragments => format!("{}-fragments.png", row.fragments),
            Self::Error => format!("{}-error.png", row.row),
            Self::SquaredError => format!("{}-squared.png", row.row),
            Self::Failures => format!("{}-failures.png", row.row),
        }
    }

    fn is_made(self, row: &Finished, experiment: &Experiment) -> bool {
        match self {
            Self::SquaredError => experiment.squared_error_factor.is_some(),
            Self::Failures => row.record.off_share.is_some(),
            _ => true,
        }
    }
}

/// Returns names and files of a row's pictures in its setting's folder: picture, fragment map, error map, and where there
/// are any, squared errors and failures of voxel marching.
pub fn pictures(row: &Finished, experiment: &Experiment) -> Vec<(&'static str, String)> {
    let made = PictureKind::ALL.iter().filter(|kind| kind.is_made(row, experiment));
    made.map(|kind| (kind.name(), kind.file(row))).collect()
}
