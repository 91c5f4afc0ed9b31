//! Frames of animations: number, time and names of files.

use std::path::{Path, PathBuf};

use halflight_metrics::is_stream;
use serde::Serialize;

/// Frame of an animation, as it goes into statistics and images.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Moment {
    pub(crate) frame: u32,
    pub(crate) time_s: f64,
    /// Time it took to move the scene and to fit its BVH.
    pub(crate) move_ms: f64,
}

impl Moment {
    /// Returns a frame of which only the number is known.
    pub(crate) fn numbered(frame: u32) -> Self {
        Self { frame, time_s: 0.0, move_ms: 0.0 }
    }

    /// Returns the file of this frame: its number goes before the ending. Pipes and devices take all frames.
    fn file(&self, path: &Path) -> PathBuf {
        if is_stream(path) {
            return path.to_owned();
        }
        let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        let mut name = format!("{}-{:04}", part(path.file_stem()), self.frame);
        if path.extension().is_some() {
            name = format!("{name}.{}", part(path.extension()));
        }
        path.with_file_name(name)
    }
}

/// Returns the file of a frame of an animation, or of the only frame.
pub(crate) fn file(path: &Path, moment: Option<Moment>) -> PathBuf {
    moment.map_or_else(|| path.to_owned(), |moment| moment.file(path))
}
