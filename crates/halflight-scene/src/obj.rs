//! OBJ meshes, read by tobj.

mod lines;

use std::cell::RefCell;
use std::collections::HashSet;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use halflight_core::scene::{Material, Mesh};

use crate::error::{Place, SceneError};
use crate::mtl;
use crate::polygon::triangulate;
use crate::report::LoadReport;
use crate::texture::{TextureStore, find_ignoring_case, shown};
use lines::CheckedLines;

/// Reads the OBJ file at `path` and its material libraries. Normals that the file does not give are zero; textures
/// go to `textures`. Without `colours` no material is read, and all faces get the default one.
pub(crate) fn read(
    path: &Path,
    colours: bool,
    textures: &mut TextureStore,
    report: &mut LoadReport,
) -> Result<Mesh, SceneError> {
    let file = File::open(path).map_err(|source| SceneError::Read { path: path.to_path_buf(), source })?;
    let mut lines = CheckedLines::new(path, BufReader::new(file));
    // tobj asks for libraries from a closure that cannot change anything.
    let libraries = RefCell::new(Libraries::new(path, colours, report));
    // Polygons are triangulated here and not by tobj, which fans concave ones across their notches.
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let loaded = tobj::load_obj_buf(&mut lines, &options, |name| libraries.borrow_mut().load(name));
    let Libraries { report, materials, complete, fault, .. } = libraries.into_inner();
    lines.report(report);
    if let Some(fault) = fault.or(lines.fault.take()) {
        return Err(fault);
    }
    let (models, _) = loaded.map_err(|fault| SceneError::invalid(path, Place::File, fault.to_string()))?;

    let mut mesh = Mesh::default();
    for (library, material) in &materials {
        mesh.materials.push(mtl::diffuse(material, library, textures, report));
    }
    if colours && complete {
        let known: HashSet<&str> = materials.iter().map(|(_, material)| material.name.as_str()).collect();
        if let Some((name, line)) = lines.materials.iter().find(|(name, _)| !known.contains(name.as_str())) {
            let path = path.display();
            report.warn(format!(
                "{path}: material `{name}` on line {line} is not defined; grey is used instead"
            ));
        }
    }
    // For faces without a material.
    mesh.materials.push(Material::default());
    for model in models {
        append(&mut mesh, &model.mesh);
    }
    if mesh.triangles.is_empty() {
        return Err(SceneError::invalid(
            path,
            Place::File,
            "has no faces of three or more corners, expected lines such as: f 1 2 3",
        ));
    }
    Ok(mesh)
}

/// The material libraries of an OBJ file, as far as they have been read.
struct Libraries<'a> {
    path: &'a Path,
    wanted: bool,
    report: &'a mut LoadReport,
    /// Every material and the library that it is from, in the order of tobj's indices.
    materials: Vec<(PathBuf, tobj::Material)>,
    /// Whether no library is missing.
    complete: bool,
    fault: Option<SceneError>,
}

impl<'a> Libraries<'a> {
    fn new(path: &'a Path, wanted: bool, report: &'a mut LoadReport) -> Self {
        Self { path, wanted, report, materials: Vec::new(), complete: true, fault: None }
    }

    /// The materials of the libraries that an `mtllib` line names: one file, or several with spaces between them.
    fn load(&mut self, names: &Path) -> tobj::MTLLoadResult {
        let first = self.materials.len();
        if self.wanted && self.fault.is_none() {
            let folder = self.path.parent().unwrap_or(Path::new(""));
            let text = names.to_string_lossy().replace('\\', "/");
            let files = match find_ignoring_case(folder, Path::new(&text)) {
                Some(file) => vec![file],
                None => text.split_whitespace().filter_map(|name| self.find(folder, name)).collect(),
            };
            for file in files {
                match mtl::read(&file, self.report) {
                    Ok(read) => {
                        self.materials.extend(read.into_iter().map(|material| (file.clone(), material)));
                    }
                    Err(fault) => self.fault = Some(fault),
                }
            }
        }
        let added: Vec<_> = self.materials[first..].iter().map(|(_, material)| material.clone()).collect();
        let indices =
            added.iter().enumerate().map(|(index, material)| (material.name.clone(), index)).collect();
        Ok((added, indices))
    }

    fn find(&mut self, folder: &Path, name: &str) -> Option<PathBuf> {
        let found = find_ignoring_case(folder, Path::new(name));
        if found.is_none() {
            self.complete = false;
            let (path, folder) = (self.path.display(), shown(folder));
            self.report.warn(format!(
                "{path}: material library `{name}` is missing in {folder}; grey is used instead"
            ));
        }
        found
    }
}

/// Appends one of tobj's pieces: faces of one material and one layout.
fn append(mesh: &mut Mesh, piece: &tobj::Mesh) {
    let first = mesh.positions.len() as u32;
    let (positions, _) = piece.positions.as_chunks();
    mesh.positions.extend(positions.iter().copied().map(Vec3::from_array));
    let (uvs, _) = piece.texcoords.as_chunks();
    mesh.uvs.extend(uvs.iter().copied().map(Vec2::from_array));
    mesh.uvs.resize(mesh.positions.len(), Vec2::ZERO);
    let (normals, _) = piece.normals.as_chunks();
    mesh.normals.extend(normals.iter().map(|&normal| Vec3::from_array(normal).normalize_or_zero()));
    mesh.normals.resize(mesh.positions.len(), Vec3::ZERO);

    let corners: Vec<u32> = piece.indices.iter().map(|index| first + index).collect();
    if piece.face_arities.is_empty() {
        mesh.triangles.extend_from_slice(corners.as_chunks().0);
    } else {
        let mut rest = corners.as_slice();
        for &arity in &piece.face_arities {
            let Some((face, after)) = rest.split_at_checked(arity as usize) else { break };
            triangulate(face, &mesh.positions, &mut mesh.triangles);
            rest = after;
        }
    }
    let default = mesh.materials.len() - 1;
    mesh.material_ids.resize(mesh.triangles.len(), piece.material_id.unwrap_or(default) as u32);
}
