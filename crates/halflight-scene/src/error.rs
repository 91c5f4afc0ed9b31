//! Errors of loading scenes.

use std::fmt;
use std::path::{Path, PathBuf};

use halflight_core::light::LightError;
use halflight_core::scene::MeshError;

/// Error of loading a scene. Every message names the file and, where there is one, the line or element.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Neither a bundled scene nor a file.
    #[error("there is no scene `{name}`: neither a file of that name nor one of the bundled scenes {}", bundled.join(", "))]
    UnknownScene {
        /// Requested name.
        name: String,
        /// Names of the bundled scenes.
        bundled: Vec<&'static str>,
    },
    /// A file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Invalid content of a file.
    #[error("{file}{place}: {message}")]
    Invalid {
        /// Name of the file as given to the loader.
        file: String,
        /// Location in the file.
        place: Place,
        /// Description of the fault, and of valid content.
        message: String,
    },
    /// The merged mesh breaks an invariant of the renderer, for example by being too large.
    #[error("{file}: {source}")]
    Mesh {
        /// The scene file.
        file: String,
        /// The broken invariant.
        source: MeshError,
    },
    /// A light breaks an invariant of the renderer.
    #[error("{file}:{line}: {source}")]
    Light {
        /// The scene file.
        file: String,
        /// The line of the light's table, counted from 1.
        line: usize,
        /// The broken invariant.
        source: LightError,
    },
}

/// Location of a fault in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Whole file.
    File,
    /// Line, counted from 1.
    Line(usize),
    /// Element of a file without meaningful lines, counted from 0: `vertex 12`.
    Element(&'static str, usize),
}

impl fmt::Display for Place {
    /// Continues a file name: `:12` for a line, `: vertex 12` for an element, nothing for the whole file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Element(kind, index) => write!(f, ": {kind} {index}"),
        }
    }
}

impl SceneError {
    /// Fault at a location of a mesh file.
    pub(crate) fn invalid(path: &Path, place: Place, message: impl Into<String>) -> Self {
        Self::Invalid { file: path.display().to_string(), place, message: message.into() }
    }
}
