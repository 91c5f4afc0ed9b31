//! Materials of one MTL file, by name.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::text::forms;

/// Materials of a file.
pub(crate) struct Library {
    pub(crate) path: PathBuf,
    pub(crate) materials: Vec<Definition>,
    /// Materials by name; of two with one name the second is used.
    exact: HashMap<Vec<u8>, usize>,
    /// Materials by their names without possible comments or quotation marks; of two the first is used.
    shortened: HashMap<Vec<u8>, usize>,
}

/// Value of a statement.
pub(crate) struct Written<T> {
    /// The value; none where the statement is faulty and counts only where the value is wanted.
    pub(crate) value: Option<T>,
    pub(crate) line: usize,
    /// Arguments of the statement.
    pub(crate) text: Vec<u8>,
}

/// Material of a library, as its statements define it.
#[derive(Default)]
pub(crate) struct Definition {
    pub(crate) name: Vec<u8>,
    pub(crate) kd: Option<Vec3>,
    /// Line and arguments of `map_Kd`.
    pub(crate) map: Option<(usize, Vec<u8>)>,
    /// Phong's specular colour and exponent.
    pub(crate) ks: Option<Written<Vec3>>,
    pub(crate) ns: Option<Written<f32>>,
    /// Roughness and metallicity of the physically based extension.
    pub(crate) roughness: Option<Written<f32>>,
    pub(crate) metallic: Option<Written<f32>>,
    /// Line and arguments of `map_d`.
    pub(crate) alpha: Option<(usize, Vec<u8>)>,
    pub(crate) illumination: Option<f64>,
    pub(crate) filters: bool,
    /// `Ke`, zero where it is missing.
    pub(crate) ke: Vec3,
    pub(crate) map_ke: bool,
    /// Line of the last `Ke` or `map_Ke`.
    pub(crate) emission_line: usize,
}

impl Library {
    pub(crate) fn new(path: &Path, materials: Vec<Definition>) -> Self {
        let mut library =
            Self { path: path.to_path_buf(), materials, exact: HashMap::new(), shortened: HashMap::new() };
        for (index, material) in library.materials.iter().enumerate() {
            let name = material.name.as_slice();
            library.exact.insert(name.to_vec(), index);
            for form in forms(name).into_iter().filter(|form| !form.is_empty() && *form != name) {
                library.shortened.entry(form.to_vec()).or_insert(index);
            }
        }
        library
    }

    /// Material with a name: exactly as in the library, or shortened.
    pub(crate) fn find(&self, name: &[u8], shortened: bool) -> Option<usize> {
        if shortened { self.shortened.get(name) } else { self.exact.get(name) }.copied()
    }

    /// All names, exactly as in the library and shortened.
    pub(crate) fn names(&self) -> impl Iterator<Item = &[u8]> {
        self.exact.keys().chain(self.shortened.keys()).map(Vec::as_slice)
    }
}
