//! Materials of an OBJ file: its libraries, and the material of each face.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use halflight_core::scene::Material;

use super::merge::Merged;
use crate::context::Context;
use crate::emission::Emission;
use crate::folders::{path_of, shown};
use crate::library::Library;
use crate::mtl::{self, UvTransform};
use crate::text::{forms, words};

/// Materials in use and the runs of faces that use them.
pub(super) struct Surfaces {
    pub(super) materials: Vec<Material>,
    /// Transforms of texture coordinates, one per material.
    pub(super) uvs: Vec<UvTransform>,
    /// Emission of each material but the default one.
    pub(super) emission: Vec<Option<Emission>>,
    /// First face and material of each run; material 0 before the first run.
    pub(super) runs: Vec<(usize, u32)>,
}

impl Default for Surfaces {
    /// Returns the default material alone.
    fn default() -> Self {
        Self {
            materials: vec![Material::default()],
            uvs: vec![UvTransform::default()],
            emission: Vec::new(),
            runs: Vec::new(),
        }
    }
}

impl Surfaces {
    /// Materials of the file at `path`. Names are resolved after the whole file was read, since some files
    /// name their library last. If several libraries define a name, the last one named before its use wins,
    /// or else the first.
    pub(super) fn of(path: &Path, merged: &Merged, definitions: &Definitions, context: &mut Context) -> Self {
        let mut undefined: Vec<(usize, usize)> = Vec::new();
        let mut meanings: Vec<Option<Meaning>> = merged.names.iter().map(|_| None).collect();
        let mut used = BTreeMap::new();
        let mut runs = vec![(0, None)];
        for naming in merged.namings.iter().filter(|naming| !naming.is_library) {
            let name = &merged.names[naming.name];
            let meaning = meanings[naming.name].get_or_insert_with(|| {
                let meaning = definitions.meaning(name);
                if let Meaning::Undefined = meaning {
                    undefined.push((naming.name, naming.line));
                }
                meaning
            });
            let definition = match meaning {
                Meaning::Undefined | Meaning::Default => None,
                Meaning::Defined(places) => {
                    let before = places.partition_point(|&(line, _)| line < naming.line);
                    Some(places[before.saturating_sub(1)].1)
                }
            };
            used.extend(definition.map(|definition| (definition, 0)));
            runs.push((naming.face, definition));
        }
        // Materials in the order of their libraries, then the default one.
        let mut surfaces = Self { materials: Vec::new(), uvs: Vec::new(), ..Self::default() };
        for (&definition, material) in &mut used {
            *material = surfaces.materials.len() as u32;
            let (library, index) = definition;
            surfaces.add(mtl::surface(&definitions.libraries[library].1, index, context));
            surfaces.emission.push(mtl::emission(&definitions.libraries[library].1, index));
        }
        let default = surfaces.materials.len() as u32;
        surfaces.add((Material::default(), UvTransform::default()));
        let material = |definition: Option<Definition>| {
            definition.and_then(|at| used.get(&at).copied()).unwrap_or(default)
        };
        surfaces.runs = runs.into_iter().map(|(face, definition)| (face, material(definition))).collect();
        if let Some(&(name, line)) = undefined.first().filter(|_| !definitions.incomplete) {
            let (path, name) = (path.display(), crate::text::shown(&merged.names[name]));
            context.warn(match undefined.len() {
                1 => format!("{path}: material `{name}` on line {line} is not defined; grey is used instead"),
                count => format!(
                    "{path}: {count} materials are not defined, the first is `{name}` on line {line}; grey is used instead"
                ),
            });
        }
        surfaces
    }

    fn add(&mut self, (material, uv): (Material, UvTransform)) {
        self.materials.push(material);
        self.uvs.push(uv);
    }
}

/// Number of a library, and a material in it.
type Definition = (usize, usize);

/// Result of resolving a material's name.
enum Meaning {
    Undefined,
    /// No name: the default material.
    Default,
    /// For every library that defines the name, the line that names the library, and the definition.
    Defined(Vec<(usize, Definition)>),
}

/// Most libraries that are searched one by one. More libraries get an index by name, which files that share a
/// large library do not need.
const FEW: usize = 4;

/// Materials of all libraries of a file.
#[derive(Default)]
pub(super) struct Definitions {
    /// Libraries and the lines that name them.
    libraries: Vec<(usize, Rc<Library>)>,
    /// Numbers of the libraries that define a name.
    by_name: HashMap<Vec<u8>, Vec<usize>>,
    /// True if a library is missing.
    incomplete: bool,
}

impl Definitions {
    /// Loads the libraries of the file at `path`.
    pub(super) fn of(path: &Path, merged: &Merged, context: &mut Context) -> Self {
        let mut definitions = Self::default();
        let mut known = HashSet::new();
        let folder = path.parent().unwrap_or(Path::new(""));
        for naming in merged.namings.iter().filter(|naming| naming.is_library) {
            for found in definitions.find(path, folder, &merged.names[naming.name], context) {
                if known.insert(found.clone()) {
                    match mtl::library(&found, context) {
                        Some(library) => definitions.libraries.push((naming.line, library)),
                        None => definitions.incomplete = true,
                    }
                }
            }
        }
        if definitions.libraries.len() > FEW {
            for (number, (_, library)) in definitions.libraries.iter().enumerate() {
                for name in library.names() {
                    definitions.by_name.entry(name.to_vec()).or_default().push(number);
                }
            }
        }
        definitions
    }

    fn meaning(&self, name: &[u8]) -> Meaning {
        let forms = forms(name);
        for form in &forms {
            for shortened in [false, true] {
                let places = self.places(form, shortened);
                if !places.is_empty() {
                    return Meaning::Defined(places);
                }
            }
        }
        match forms.last() {
            Some(form) if !form.is_empty() => Meaning::Undefined,
            _ => Meaning::Default,
        }
    }

    /// Definitions of a name and the lines of their libraries; of several on one line the first.
    fn places(&self, name: &[u8], shortened: bool) -> Vec<(usize, Definition)> {
        let few: [usize; FEW] = std::array::from_fn(|number| number);
        let numbers = if self.libraries.len() <= FEW {
            &few[..self.libraries.len()]
        } else {
            self.by_name.get(name).map_or(&[][..], Vec::as_slice)
        };
        let mut places: Vec<(usize, Definition)> = Vec::new();
        for &number in numbers {
            let (line, library) = &self.libraries[number];
            let found = library.find(name, shortened);
            if let Some(index) = found.filter(|_| places.last().is_none_or(|(known, _)| known != line)) {
                places.push((*line, (number, index)));
            }
        }
        places
    }

    /// Libraries that `names` refers to: one file, or several separated by spaces.
    fn find(&mut self, path: &Path, folder: &Path, names: &[u8], context: &mut Context) -> Vec<PathBuf> {
        let forms = forms(names);
        let whole = forms.iter().find_map(|form| context.folders.find(folder, &path_of(form)));
        if let Some(found) = whole {
            return vec![found];
        }
        let all = words(forms.last().copied().unwrap_or_default());
        let mut found = Vec::new();
        for name in all {
            let wanted = path_of(name);
            // Paths of another machine: only the file's name is used.
            let last = wanted.file_name().map(Path::new);
            let library = context
                .folders
                .find(folder, &wanted)
                .or_else(|| last.and_then(|last| context.folders.find(folder, last)));
            if library.is_none() {
                self.incomplete = true;
                let (path, name, folder) = (path.display(), crate::text::shown(name), shown(folder));
                context.warn(format!(
                    "{path}: material library `{name}` is missing in {folder}; grey is used instead"
                ));
            }
            found.extend(library);
        }
        found
    }
}
