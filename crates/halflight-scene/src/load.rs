//! Loading: from a validated scene file to one world-space mesh.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::light_texture::LightTexture;
use halflight_core::scene::{Material, Mesh, Scene};
use halflight_core::smooth::is_smooth;

use crate::animation::{Animation, Part, Video};
use crate::clean::drop_zero_area;
use crate::context::{Context, MAX_COUNT};
use crate::emission::warn_of_unused;
use crate::emitters::{self, MAX_LIGHTS};
use crate::error::SceneError;
use crate::file::{Emissive, MeshEntry, Origin, SceneFile, Smooth};
use crate::generate::{GenerateError, generate};
use crate::light_texture::TextureEntry;
use crate::model::ModelMesh;
use crate::normals::compute_missing_normals;
use crate::report::{LoadReport, MeshReport};
use crate::section::{Source, line_ends};
use crate::transform::Transform;
use crate::{Loaded, obj, ply};

/// Loads the scene that `text` describes; error messages call it `name`.
pub(crate) fn load(text: &str, name: &str, folder: &Path) -> Result<Loaded, SceneError> {
    // Marks that old editors and systems put around a text.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim_end_matches(['\0', '\u{1a}']);
    let with_line_feeds;
    let text = if text.contains('\n') {
        text
    } else {
        with_line_feeds = text.replace('\r', "\n");
        &with_line_feeds
    };
    let line_ends = line_ends(text);
    let source = Source { name, text, line_ends: &line_ends };
    let file = SceneFile::parse(source)?;
    let mut files = Files::new(&file.meshes, folder);
    let mut context = Context::default();
    let mut report = LoadReport::default();
    let mut all = Mesh::default();
    let mut parts = Vec::with_capacity(file.meshes.len());
    let mut emitted: Vec<AreaLight> = Vec::new();
    for entry in file.meshes {
        let emissive = entry.emissive;
        let (mesh, mut lights, mesh_report) = load_mesh(entry, source, folder, &mut files, &mut context)?;
        let (first, first_light) = (all.positions.len(), file.lights.len() + emitted.len());
        append(&mut all, mesh);
        emitted.append(&mut lights);
        let lights = first_light..file.lights.len() + emitted.len();
        parts.push(Part { vertices: first..all.positions.len(), lights });
        if let Emissive::Lights(line) = emissive
            && emitted.len() > MAX_LIGHTS
        {
            let message = format!(
                "[[mesh]] emissive makes {} lights so far, expected at most {MAX_LIGHTS}; write emissive = \"ignore\" and add a few [[light]]",
                emitted.len()
            );
            return Err(source.fault(line, message));
        }
        report.meshes.push(mesh_report);
        if all.positions.len().max(all.triangles.len()) > MAX_COUNT {
            break;
        }
    }
    report.files.extend(context.libraries.keys().chain(context.textures.by_path.keys()).cloned());
    report.files.extend(context.alpha.by_path.keys().cloned());
    let entries = file.textures.iter().flatten();
    report.files.extend(entries.filter_map(|entry| entry.files(folder).ok()).flatten());
    report.files.sort();
    report.files.dedup();
    report.warnings = context.warnings;
    all.textures = context.textures.textures;
    all.alpha_masks = context.alpha.masks;
    let fault = |source| SceneError::Mesh { file: name.to_string(), source };
    all.validate().map_err(fault)?;
    let (mut lights, light_textures, videos) = load_textures(file.lights, &file.textures, source, folder)?;
    lights.append(&mut emitted);
    let animation = file.animation.map(|entry| entry.place(source, &lights, &all, &parts));
    let animation = Animation::with_videos(animation.transpose()?, videos);
    let scene = Scene { mesh: Arc::new(all), lights, light_textures, camera: file.camera };
    Ok(Loaded { scene, animation, report })
}

/// Lights with their textures, all textures, and the videos among them.
type Textures = (Vec<AreaLight>, Vec<Arc<LightTexture>>, Vec<Video>);

/// Reads the textures of lights.
fn load_textures(
    mut lights: Vec<AreaLight>,
    entries: &[Option<TextureEntry>],
    source: Source<'_>,
    folder: &Path,
) -> Result<Textures, SceneError> {
    let (mut textures, mut videos) = (Vec::new(), Vec::new());
    for (index, (light, entry)) in lights.iter_mut().zip(entries).enumerate() {
        let Some(entry) = entry else { continue };
        let first = textures.len() as u32;
        textures.extend(entry.load(light, source, folder)?);
        *light = light.textured(first);
        if let Some(fps) = entry.video_fps() {
            videos.push(Video { light: index, first, frames: textures.len() as u32 - first, fps });
        }
    }
    Ok((lights, textures, videos))
}

/// Path of a mesh file, and true if `Ks` and `Ns` of its materials are wanted.
type Key = (PathBuf, bool);

/// The mesh files of a scene, each read once.
struct Files {
    /// Number of entries that have yet to use each path, and true if any of them shows its colours.
    uses: HashMap<Key, (usize, bool)>,
    /// Meshes that another entry will use.
    kept: HashMap<Key, ModelMesh>,
}

impl Files {
    fn new(entries: &[MeshEntry], folder: &Path) -> Self {
        let mut uses: HashMap<Key, (usize, bool)> = HashMap::new();
        for entry in entries {
            if let Origin::File(file, _) = &entry.origin {
                let (count, colours) = uses.entry((folder.join(file), entry.specular.phong())).or_default();
                *count += 1;
                *colours |= entry.albedo.is_none() || matches!(entry.emissive, Emissive::Lights(_));
            }
        }
        Self { uses, kept: HashMap::new() }
    }

    /// Mesh of a file; `line` is the line of the scene file that names it.
    fn take(
        &mut self,
        key: Key,
        line: usize,
        scene: Source<'_>,
        context: &mut Context,
    ) -> Result<ModelMesh, SceneError> {
        let (count, colours) = self.uses.get_mut(&key).map_or((0, true), |(count, colours)| {
            *count = count.saturating_sub(1);
            (*count, *colours)
        });
        let mesh = match self.kept.remove(&key) {
            Some(mesh) => mesh,
            None => {
                context.phong = key.1;
                read_file(&key.0, line, scene, colours, context)?
            }
        };
        if count > 0 {
            self.kept.insert(key, mesh.clone());
        }
        Ok(mesh)
    }
}

/// Loads one mesh in world space, clean, and the lights of its emissive faces. Its textures are those of `context`.
fn load_mesh(
    entry: MeshEntry,
    scene: Source<'_>,
    folder: &Path,
    files: &mut Files,
    context: &mut Context,
) -> Result<(Mesh, Vec<AreaLight>, MeshReport), SceneError> {
    let (mut mesh, emission, source) = match entry.origin {
        Origin::File(file, line) => {
            let key = (folder.join(&file), entry.specular.phong());
            let mut mesh = files.take(key, line, scene, context)?;
            let emission = std::mem::take(&mut mesh.emission);
            let mut mesh = entry.transform.place(mesh);
            if entry.albedo.is_none() {
                entry.alpha.apply(&mut mesh, context);
            }
            (mesh, emission, file.display().to_string())
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
            let textures = &mut context.textures.textures;
            let first = textures.len() as u32;
            textures.append(&mut mesh.textures);
            let masks = &mut context.alpha.masks;
            let first_mask = masks.len() as u32;
            masks.append(&mut mesh.alpha_masks);
            for material in &mut mesh.materials {
                material.texture = material.texture.map(|texture| texture + first);
                material.alpha_mask = material.alpha_mask.map(|mask| mask + first_mask);
            }
            entry.transform.apply(&mut mesh);
            (mesh, Vec::new(), name)
        }
    };
    if mesh.positions.len().max(mesh.triangles.len()) > MAX_COUNT {
        let message = format!("[[mesh]] `{source}` has more than {MAX_COUNT} triangles or vertices");
        return Err(scene.fault(entry.line, message));
    }
    let emitting = matches!(entry.emissive, Emissive::Lights(_)).then(|| mesh.material_ids.clone());
    if let Some(albedo) = entry.albedo {
        mesh.materials = vec![Material { albedo, ..Material::default() }];
        mesh.material_ids.fill(0);
    }
    mesh.materials.iter_mut().for_each(|material| entry.specular.apply(material));
    let finite = mesh.positions.iter().all(|position| position.is_finite());
    let mut used = mesh.triangles.as_flattened().iter();
    if !finite && let Some(vertex) = used.find(|&&vertex| !mesh.positions[vertex as usize].is_finite()) {
        let message = if entry.transform == Transform::default() {
            format!("[[mesh]] vertex {vertex} of `{source}` is out of the range of f32")
        } else {
            format!("[[mesh]] transform moves vertex {vertex} of `{source}` out of the range of f32")
        };
        return Err(scene.fault(entry.line, message));
    }
    let lights = match (entry.emissive, emitting) {
        (Emissive::Lights(line), Some(materials)) => {
            emitters::lights(&mesh, &materials, &emission, &source, context)
                .map_err(|reason| scene.fault(line, format!("[[mesh]] emissive makes no light: {reason}")))?
        }
        (Emissive::Unsaid, _) if entry.albedo.is_none() => {
            warn_of_unused(&emission, context);
            Vec::new()
        }
        _ => Vec::new(),
    };
    let zero_area_dropped = drop_zero_area(&mut mesh);
    if mesh.triangles.is_empty() {
        let message = format!("[[mesh]] `{source}` has no triangle with an area, of {zero_area_dropped}");
        return Err(scene.fault(entry.line, message));
    }
    let normals_computed = smooth_normals(&mut mesh, entry.smooth);
    let triangles = mesh.triangles.len();
    let report = MeshReport { source, triangles, zero_area_dropped, normals_computed, lights: lights.len() };
    Ok((mesh, lights, report))
}

/// Keeps the normals that smooth surfaces need, none for a flat mesh, and returns the number of computed ones.
fn smooth_normals(mesh: &mut Mesh, smooth: Smooth) -> usize {
    let given = mesh.normals.iter().any(|&normal| normal != Vec3::ZERO);
    let computed = match smooth {
        Smooth::On(_) => compute_missing_normals(mesh, smooth.crease_deg()),
        Smooth::Auto if given => compute_missing_normals(mesh, smooth.crease_deg()),
        Smooth::Auto | Smooth::Off => {
            mesh.normals.clear();
            return 0;
        }
    };
    if !is_smooth(mesh) {
        mesh.normals.clear();
    }
    computed
}

/// Reads a mesh file by its extension; `line` is the line of the scene file that names it.
fn read_file(
    path: &Path,
    line: usize,
    scene: Source<'_>,
    colours: bool,
    context: &mut Context,
) -> Result<ModelMesh, SceneError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let mesh = match ending.as_deref() {
        Some("obj") => obj::read(path, colours, context),
        Some("ply") => ply::read(path, colours, context),
        _ => {
            let message =
                format!("[[mesh]] file `{}` is of an unknown kind, expected .obj or .ply", path.display());
            return Err(scene.fault(line, message));
        }
    };
    match mesh {
        // The message names the missing mesh and the scene instead of the system's error.
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

/// Appends `mesh` to `all`; texture indices are common to both.
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
    if !(all.normals.is_empty() && mesh.normals.is_empty()) {
        all.normals.resize(all.positions.len(), Vec3::ZERO);
        all.normals.append(&mut mesh.normals);
        all.normals.resize(all.positions.len() + mesh.positions.len(), Vec3::ZERO);
    }
    all.positions.append(&mut mesh.positions);
    all.uvs.append(&mut mesh.uvs);
    all.triangles.append(&mut mesh.triangles);
    all.material_ids.append(&mut mesh.material_ids);
    all.materials.append(&mut mesh.materials);
}
