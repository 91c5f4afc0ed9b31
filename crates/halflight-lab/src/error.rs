//! What can go wrong in an experiment.

use std::io;
use std::path::{Path, PathBuf};

use halflight_cpu::bvh::BvhError;
use halflight_cpu::pipeline::PipelineError;
use halflight_metrics::{CompareError, ImageError, WriteError};
use halflight_scene::SceneError;

use crate::reference::ReferenceError;
use halflight_image::memory::NotEnough;

/// Why an experiment cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AblateError {
    /// The experiment's file says something that it may not.
    #[error("{file}: {message}")]
    Experiment {
        /// The file.
        file: String,
        /// What is wrong, where, and what would be right.
        message: String,
    },
    /// Neither a bundled experiment nor a file.
    #[error("there is no experiment `{name}`; bundled are {}, or give the path of a .toml file", bundled.join(", "))]
    Unknown {
        /// What was asked for.
        name: String,
        /// Those that there are.
        bundled: Vec<&'static str>,
    },
    /// No case of the robustness table.
    #[error("there is no case `{name}`; there are {}", cases.join(", "))]
    Case {
        /// What was asked for.
        name: String,
        /// Those that there are.
        cases: Vec<&'static str>,
    },
    /// An option that says nothing about what is run.
    #[error("{0}")]
    Option(&'static str),
    /// The GPU cannot be used.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] halflight_gpu::GpuError),
    /// A frame is not whole.
    #[cfg(feature = "gpu")]
    #[error("{row}: {count} queries did not fit into the device's buffers")]
    Lost {
        /// The row.
        row: String,
        /// How many.
        count: u64,
    },
    /// Pictures that are none.
    #[error("{count} pictures are not finite, negative, or not there at all; the first: {first}")]
    Unsound {
        /// How many.
        count: usize,
        /// The first: case, method and what is wrong.
        first: String,
    },
    /// A scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A BVH cannot be built.
    #[error("scene {scene}: {source}")]
    Bvh {
        /// The scene.
        scene: String,
        /// Why.
        source: BvhError,
    },
    /// A row cannot be rendered.
    #[error("row {row}: {source}")]
    Pipeline {
        /// The row.
        row: String,
        /// Why.
        source: PipelineError,
    },
    /// A reference cannot be rendered.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// An image does not fit into memory.
    #[error("{0}; choose a smaller --size")]
    Memory(#[from] NotEnough),
    /// No light arrives where errors are to be measured.
    #[error("{setting}: {reason}; errors relative to a black reference are undefined")]
    Unlit {
        /// Scene, light, size and frame.
        setting: String,
        /// Reason why the image is black.
        reason: String,
    },
    /// A row cannot be set against its reference.
    #[error("row {row}: {source}")]
    Compare {
        /// The row.
        row: String,
        /// Why.
        source: CompareError,
    },
    /// An image of the wrong size.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file or folder cannot be read or made.
    #[error("{}: {source}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A table cannot be written as CSV.
    #[error("results cannot be written as CSV: {0}")]
    Csv(#[from] csv::Error),
    /// A row cannot be kept.
    #[error("a row cannot be stored: {0}")]
    Json(#[from] serde_json::Error),
    /// A chart cannot be drawn.
    #[error("chart {chart}: {message}")]
    Chart {
        /// Its title.
        chart: String,
        /// Why.
        message: String,
    },
}

/// Says which file an error is about.
pub(crate) fn at(path: &Path) -> impl FnOnce(io::Error) -> AblateError + '_ {
    move |source| AblateError::File { path: path.to_path_buf(), source }
}
