//! State that the meshes of a scene share while it is loaded.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;

use halflight_core::alpha::AlphaMask;
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
    /// Paths of the textures that are not opaque.
    pub(crate) transparent: HashMap<u32, PathBuf>,
}

/// Alpha of an image, row by row from the top.
pub(crate) struct AlphaImage {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) alpha: Vec<u8>,
}

/// Image that a mask is made of, by its index.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum AlphaOrigin {
    /// One of the alpha images.
    Map(u32),
    /// One of the albedo textures.
    Albedo(u32),
}

/// Alpha masks of a scene, and the images that they are made of. Until a mesh's masks are chosen, materials refer to the
/// images.
#[derive(Default)]
pub(crate) struct AlphaStore {
    pub(crate) images: Vec<AlphaImage>,
    pub(crate) by_path: HashMap<PathBuf, Option<u32>>,
    pub(crate) masks: Vec<AlphaMask>,
    /// Masks by image and the bits of the cutoff; `None` without holes.
    pub(crate) known: HashMap<(AlphaOrigin, u32), Option<u32>>,
}

/// State that the meshes of a scene share while it is loaded.
#[derive(Default)]
pub(crate) struct Context {
    pub(crate) folders: Folders,
    pub(crate) textures: TextureStore,
    pub(crate) alpha: AlphaStore,
    /// Material libraries that were read, each once.
    pub(crate) libraries: HashMap<PathBuf, Rc<Library>>,
    /// True while meshes are read of which `Ks` and `Ns` are wanted.
    pub(crate) phong: bool,
    pub(crate) warnings: Vec<String>,
    said: HashSet<String>,
}

impl Context {
    /// Records `warning`, which begins with the place that it is about, unless the same was recorded of another place.
    pub(crate) fn warn_at(&mut self, place: &str, warning: &str) {
        if self.said.insert(warning.to_owned()) {
            self.warnings.push(format!("{place}{warning}"));
        }
    }

    /// Records `warning` unless it was recorded before.
    pub(crate) fn warn(&mut self, warning: String) {
        if self.said.insert(warning.clone()) {
            self.warnings.push(warning);
        }
    }
}
