//! From a checked scene file to one world-space mesh.

use std::path::Path;

use halflight_core::scene::{Material, Mesh, Scene};

use crate::clean::{compute_missing_normals, drop_zero_area};
use crate::error::SceneError;
use crate::file::{MeshEntry, Origin, SceneFile};
use crate::generate::{GenerateError, generate};
use crate::report::{LoadReport, MeshReport};
use crate::section::Source;
use crate::texture::TextureStore;
use crate::{Loaded, obj, ply};

/// What the renderer can index, and triangle corners in 32 bits; checked before any index could wrap.
const MAX_COUNT: usize = (u32::MAX / 4) as usize;

/// Loads the scene that `text` describes; `name` is what faults call it.
pub(crate) fn load(text: &str, name: &str, folder: &Path) -> Result<Loaded, SceneError> {
    let source = Source { name, text };
    let file = SceneFile::parse(source)?;
    let mut textures = TextureStore::default();
    let mut report = LoadReport::default();
    let mut all = Mesh::default();
    let mut vertices = Vec::with_capacity(file.meshes.len());
    for entry in file.meshes {
        let (mesh, mesh_report) = load_mesh(entry, source, folder, &mut textures, &mut report)?;
        let first = all.positions.len();
        append(&mut all, mesh);
        vertices.push(first..all.positions.len());
        report.meshes.push(mesh_report);
    }
    all.textures = textures.textures;
    let fault = |source| SceneError::Mesh { file: name.to_string(), source };
    all.validate().map_err(fault)?;
    let animation = file.animation.map(|entry| entry.place(source, &file.lights, &all, &vertices));
    let animation = animation.transpose()?;
    let scene = Scene { mesh: all, lights: file.lights, camera: file.camera };
    Ok(Loaded { scene, animation, report })
}

/// One mesh in world space, clean. Its textures are in `textures`.
fn load_mesh(
    entry: MeshEntry,
    scene: Source<'_>,
    folder: &Path,
    textures: &mut TextureStore,
    report: &mut LoadReport,
) -> Result<(Mesh, MeshReport), SceneError> {
    let colours = entry.albedo.is_none();
    let (mut mesh, source) = match entry.origin {
        Origin::File(file, line) => {
            let path = folder.join(&file);
            let mesh = read_file(&path, line, scene, colours, textures, report)?;
            (mesh, file.display().to_string())
        }
        Origin::Generator { name, line, parameters, lines } => {
            let mut mesh = generate(&name, parameters).map_err(|fault| {
                let key = match &fault {
                    GenerateError::UnknownParameter { key, .. } => key.as_str(),
                    GenerateError::BadParameter { key, .. } => key,
                    GenerateError::UnknownGenerator { .. } => "generator",
                };
                let line = lines.iter().find(|(known, _)| known == key).map_or(line, |&(_, line)| line);
                scene.fault(line, format!("[[mesh]] {fault}"))
            })?;
            mesh.validate().map_err(|source| SceneError::Mesh { file: scene.name.to_string(), source })?;
            let first = textures.textures.len() as u32;
            textures.textures.append(&mut mesh.textures);
            for texture in mesh.materials.iter_mut().filter_map(|material| material.texture.as_mut()) {
                *texture += first;
            }
            (mesh, name)
        }
    };
    if mesh.positions.len().max(mesh.triangles.len()) > MAX_COUNT {
        let message = format!("[[mesh]] `{source}` has more than {MAX_COUNT} triangles or vertices");
        return Err(scene.fault(entry.line, message));
    }
    if let Some(albedo) = entry.albedo {
        mesh.materials = vec![Material { albedo, texture: None }];
        mesh.material_ids.fill(0);
    }
    entry.transform.apply(&mut mesh);
    if let Some(vertex) = mesh.positions.iter().position(|position| !position.is_finite()) {
        let message =
            format!("[[mesh]] transform moves vertex {vertex} of `{source}` out of the range of f32");
        return Err(scene.fault(entry.line, message));
    }
    let zero_area_dropped = drop_zero_area(&mut mesh);
    if mesh.triangles.is_empty() {
        let message = format!("[[mesh]] `{source}` has no triangle with an area, of {zero_area_dropped}");
        return Err(scene.fault(entry.line, message));
    }
    let normals_computed = compute_missing_normals(&mut mesh);
    let triangles = mesh.triangles.len();
    Ok((mesh, MeshReport { source, triangles, zero_area_dropped, normals_computed }))
}

/// Reads a mesh file by its ending; `line` is where the scene names it.
fn read_file(
    path: &Path,
    line: usize,
    scene: Source<'_>,
    colours: bool,
    textures: &mut TextureStore,
    report: &mut LoadReport,
) -> Result<Mesh, SceneError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let mesh = match ending.as_deref() {
        Some("obj") => obj::read(path, colours, textures, report),
        Some("ply") => ply::read(path, report),
        _ => {
            let message =
                format!("[[mesh]] file `{}` is of an unknown kind, expected .obj or .ply", path.display());
            return Err(scene.fault(line, message));
        }
    };
    match mesh {
        // Which mesh of which scene is missing says more than the operating system does.
        Err(SceneError::Read { path: missing, source })
            if missing == path && source.kind() == std::io::ErrorKind::NotFound =>
        {
            let message =
                format!("[[mesh]] there is no file {}; paths are relative to the scene file", path.display());
            Err(scene.fault(line, message))
        }
        other => other,
    }
}

/// Appends `mesh` to `all`; texture indices hold for both.
fn append(all: &mut Mesh, mut mesh: Mesh) {
    let first_vertex = all.positions.len() as u32;
    let first_material = all.materials.len() as u32;
    if all.positions.is_empty() {
        *all = mesh;
        return;
    }
    for index in mesh.triangles.as_flattened_mut() {
        *index += first_vertex;
    }
    for material in &mut mesh.material_ids {
        *material += first_material;
    }
    all.positions.append(&mut mesh.positions);
    all.normals.append(&mut mesh.normals);
    all.uvs.append(&mut mesh.uvs);
    all.triangles.append(&mut mesh.triangles);
    all.material_ids.append(&mut mesh.material_ids);
    all.materials.append(&mut mesh.materials);
}
