//! State that the meshes of a scene share while it is loaded.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;

use halflight_core::scene::Texture;

use crate::folders::Folders;
use crate::library::Library;

/// Largest number of vertices and of triangles: what the renderer can index, with triangle corners in 32
/// bits.
pub(crate) const MAX_COUNT: usize = (u32::MAX / 4) as usize;

/// Textures of a scene, each file read once.
#[derive(Default)]
pub(crate) struct TextureStore {
    pub(crate) textures: Vec<Texture>,
    pub(crate) by_path: HashMap<PathBuf, Option<u32>>,
    pub(crate) by_name: HashMap<(PathBuf, Vec<u8>), Option<PathBuf>>,
}

/// State that the meshes of a scene share while it is loaded.
#[derive(Default)]
pub(crate) struct Context {
    pub(crate) folders: Folders,
    pub(crate) textures: TextureStore,
    /// Material libraries that were read, each once.
    pub(crate) libraries: HashMap<PathBuf, Rc<Library>>,
    /// True while meshes are read of which `Ks` and `Ns` are wanted.
    pub(crate) phong: bool,
    pub(crate) warnings: Vec<String>,
    said: HashSet<String>,
}

impl Context {
    /// Records `warning` unless it was recorded before.
    pub(crate) fn warn(&mut self, warning: String) {
        if self.said.insert(warning.clone()) {
            self.warnings.push(warning);
        }
    }
}
