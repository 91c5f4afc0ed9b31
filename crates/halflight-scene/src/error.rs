//! Why a scene cannot be loaded.

use std::fmt;
use std::path::{Path, PathBuf};

use halflight_core::light::LightError;
use halflight_core::scene::MeshError;

/// Why a scene cannot be loaded. Every message names the file and, where there is one, the line or element.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Neither a bundled scene nor a file.
    #[error("there is no scene `{name}`: neither a file of that name nor one of the bundled scenes {}", bundled.join(", "))]
    UnknownScene {
        /// What was asked for.
        name: String,
        /// The bundled scenes.
        bundled: Vec<&'static str>,
    },
    /// A file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// A file was read, but what it says is wrong.
    #[error("{file}{place}: {message}")]
    Invalid {
        /// The file as it was named to the loader.
        file: String,
        /// Where in the file.
        place: Place,
        /// What is wrong and what would be right.
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

/// Where in a file a fault lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// An element of a file without meaningful lines, counted from 0: `vertex 12`.
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
    /// A fault at `place` of a mesh file.
    pub(crate) fn invalid(path: &Path, place: Place, message: impl Into<String>) -> Self {
        Self::Invalid { file: path.display().to_string(), place, message: message.into() }
    }
}
