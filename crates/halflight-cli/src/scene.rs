//! Scenes by name or path, ready to render.

use std::path::Path;
use std::sync::Arc;

use halflight_core::scene::Scene;
use halflight_cpu::bvh::Bvh;
use halflight_scene::{Animation, LoadReport};

use crate::terminal::say;

/// A scene with its hierarchy.
pub(crate) struct Ready {
    pub(crate) scene: Arc<Scene>,
    pub(crate) bvh: Arc<Bvh>,
    pub(crate) animation: Option<Animation>,
    pub(crate) report: LoadReport,
}

/// Loads a scene, says what loading it left out, and builds its hierarchy.
pub(crate) fn load(name_or_path: &str) -> Result<Ready, Box<dyn std::error::Error>> {
    let loaded = halflight_scene::resolve(name_or_path)?;
    for warning in &loaded.report.warnings {
        say(&format!("warning: {warning}"));
    }
    let bvh = Bvh::build(&loaded.scene.mesh)?;
    let halflight_scene::Loaded { scene, animation, report } = loaded;
    Ok(Ready { scene: Arc::new(scene), bvh: Arc::new(bvh), animation, report })
}

/// A scene's name for files: a bundled name, or the scene file's without its ending.
pub(crate) fn stem(name_or_path: &str) -> String {
    let path = Path::new(name_or_path);
    // Standard input has no name.
    let stem = path.file_stem().filter(|_| name_or_path != "-");
    stem.map_or_else(|| "image".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Gives everything that runs in parallel this many threads.
pub(crate) fn use_threads(threads: Option<u16>) -> Result<(), rayon::ThreadPoolBuildError> {
    match threads {
        Some(threads) => rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global(),
        None => Ok(()),
    }
}

/// Refuses an output file whose folder is missing, before any work is done for it.
pub(crate) fn check_folder(file: &Path) -> Result<(), String> {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(format!("cannot write {}: there is no folder {}", file.display(), folder.display()))
        }
        _ => Ok(()),
    }
}
