//! The materials of an OBJ file: its libraries, and which face has which.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use halflight_core::scene::Material;

use super::merge::Merged;
use crate::context::Context;
use crate::folders::{path_of, shown};
use crate::mtl::{self, Library, UvTransform};
use crate::text::{forms, words};

/// Materials in use and the faces they begin at.
pub(super) struct Surfaces {
    pub(super) materials: Vec<Material>,
    /// Transforms of texture coordinates, one a material.
    pub(super) uvs: Vec<UvTransform>,
    /// Numbers of faces, and the material from there on; the first is 0.
    pub(super) runs: Vec<(usize, u32)>,
}

impl Default for Surfaces {
    /// The default material alone.
    fn default() -> Self {
        Self { materials: vec![Material::default()], uvs: vec![UvTransform::default()], runs: Vec::new() }
    }
}

impl Surfaces {
    /// The materials of the file at `path`. Names are looked up when all of the file is known, since some files name their
    /// library last. Where several libraries define a name, the last one that is named before its use counts, or else the
    /// first.
    pub(super) fn of(path: &Path, merged: &Merged, definitions: &Definitions, context: &mut Context) -> Self {
        let mut undefined: Vec<(usize, usize)> = Vec::new();
        let mut meanings: Vec<Option<Meaning<'_>>> = merged.names.iter().map(|_| None).collect();
        let mut used = BTreeMap::new();
        let mut runs = vec![(0, None)];
        for naming in merged.namings.iter().filter(|naming| !naming.library) {
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
            let (library, index) = &definitions.all[definition];
            surfaces.add(mtl::surface(library, *index, context));
        }
        let default = surfaces.materials.len() as u32;
        surfaces.add((Material::default(), UvTransform::default()));
        let material =
            |definition: Option<usize>| definition.and_then(|at| used.get(&at).copied()).unwrap_or(default);
        surfaces.runs = runs.into_iter().map(|(face, definition)| (face, material(definition))).collect();
        if let Some(&(name, line)) = undefined.first().filter(|_| definitions.complete) {
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

/// Meaning of a material's name.
enum Meaning<'a> {
    Undefined,
    /// No name: the default material.
    Default,
    /// For every library that defines it, the line that names the library, and the definition.
    Defined(&'a [(usize, usize)]),
}

/// The materials of all libraries of a file.
pub(super) struct Definitions {
    all: Vec<(Rc<Library>, usize)>,
    libraries: HashSet<PathBuf>,
    exact: HashMap<Vec<u8>, Vec<(usize, usize)>>,
    /// By names without what may be a comment or quotation marks.
    shortened: HashMap<Vec<u8>, Vec<(usize, usize)>>,
    /// False where a library is missing.
    complete: bool,
}

impl Default for Definitions {
    fn default() -> Self {
        Self {
            all: Vec::new(),
            libraries: HashSet::new(),
            exact: HashMap::new(),
            shortened: HashMap::new(),
            complete: true,
        }
    }
}

impl Definitions {
    /// Loads the libraries of the file at `path`.
    pub(super) fn of(path: &Path, merged: &Merged, context: &mut Context) -> Self {
        let mut definitions = Self::default();
        for naming in merged.namings.iter().filter(|naming| naming.library) {
            definitions.load(path, &merged.names[naming.name], naming.line, context);
        }
        definitions
    }

    fn meaning(&self, name: &[u8]) -> Meaning<'_> {
        let forms = forms(name);
        let found = forms.iter().find_map(|form| self.exact.get(*form).or_else(|| self.shortened.get(*form)));
        match found {
            Some(places) => Meaning::Defined(places),
            None if forms.last().is_none_or(|form| form.is_empty()) => Meaning::Default,
            None => Meaning::Undefined,
        }
    }

    /// Loads the libraries that the `mtllib` on `line` names.
    fn load(&mut self, path: &Path, names: &[u8], line: usize, context: &mut Context) {
        let folder = path.parent().unwrap_or(Path::new(""));
        for found in self.find(path, folder, names, context) {
            if !self.libraries.insert(found.clone()) {
                continue;
            }
            let Some(library) = mtl::library(&found, context) else {
                self.complete = false;
                continue;
            };
            let first = self.all.len();
            for (index, name) in library.names().enumerate() {
                let definition = self.all.len();
                self.all.push((Rc::clone(&library), index));
                let places = self.exact.entry(name.to_vec()).or_default();
                match places.last_mut() {
                    // Of two in one library the second counts, of two libraries on one line the first.
                    Some((_, known)) if *known >= first => *known = definition,
                    Some((known, _)) if *known == line => {}
                    _ => places.push((line, definition)),
                }
                for form in forms(name).into_iter().filter(|form| !form.is_empty() && *form != name) {
                    let places = self.shortened.entry(form.to_vec()).or_default();
                    if places.last().is_none_or(|&(known, _)| known != line) {
                        places.push((line, definition));
                    }
                }
            }
        }
    }

    /// The libraries that `names` means: one file, or several with spaces between them.
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
            // Paths of another machine: the file's name has to do.
            let last = wanted.file_name().map(Path::new);
            let library = context
                .folders
                .find(folder, &wanted)
                .or_else(|| last.and_then(|last| context.folders.find(folder, last)));
            if library.is_none() {
                self.complete = false;
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
