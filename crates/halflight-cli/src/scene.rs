//! Scenes by name or path, ready to render.

use std::path::{Path, PathBuf};

use halflight_cpu::flush::{FlushLight, separate_lights};
use halflight_cpu::prepared::PreparedScene;
use halflight_lab::program::say;
use halflight_scene::{Animation, LoadReport};

/// Scene with its BVH.
pub(crate) struct Ready {
    pub(crate) prepared: PreparedScene,
    pub(crate) animation: Option<Animation>,
    pub(crate) report: LoadReport,
    /// Lights that are flush with geometry.
    pub(crate) flush: Vec<FlushLight>,
}

/// Loads a scene, says what loading it left out, and builds its BVH.
pub(crate) fn load(name_or_path: &str) -> Result<Ready, Box<dyn std::error::Error>> {
    let loaded = halflight_scene::resolve(name_or_path)?;
    for warning in &loaded.report.warnings {
        say(&format!("warning: {warning}"));
    }
    let halflight_scene::Loaded { scene, animation, report } = loaded;
    let prepared = PreparedScene::new(scene)?;
    let flush = separate_lights(prepared.scene(), Some(prepared.bvh())).1;
    for flush in &flush {
        say(&format!("warning: {flush}"));
    }
    Ok(Ready { prepared, animation, report, flush })
}

/// Returns a scene's name for files: a bundled name, or the scene file's without its ending.
pub(crate) fn stem(name_or_path: &str) -> String {
    let path = Path::new(name_or_path);
    // Standard input has no name.
    let stem = path.file_stem().filter(|_| name_or_path != "-");
    stem.map_or_else(|| "image".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Returns the scene's file; `None` for a bundled scene.
pub(crate) fn file(name_or_path: &str) -> Option<PathBuf> {
    let bundled = halflight_scene::bundled().iter().any(|(name, _)| *name == name_or_path);
    (!bundled).then(|| PathBuf::from(name_or_path))
}

impl Ready {
    /// Returns the files that the scene of this name was made of, as far as they are known: its own, its meshes, and their materials and textures.
    pub(crate) fn files(&self, name_or_path: &str) -> Vec<PathBuf> {
        let Some(scene) = file(name_or_path) else { return Vec::new() };
        let folder = scene.parent().unwrap_or(Path::new("")).to_owned();
        let meshes = self.report.meshes.iter().map(|mesh| folder.join(&mesh.source));
        let all = meshes.chain(self.report.files.iter().cloned());
        all.filter(|file| file.is_file()).chain([scene.clone()]).collect()
    }
}
