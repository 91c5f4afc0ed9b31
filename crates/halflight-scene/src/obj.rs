//! OBJ meshes.

mod blocks;
mod chunk;
mod materials;
mod merge;
mod uvs;

use std::fs::File;
use std::path::Path;

use rayon::prelude::*;

use crate::context::{Context, MAX_COUNT};
use crate::error::{Place, SceneError};
use crate::model::ModelMesh;
use blocks::{Blocks, chunks};
use chunk::Chunk;
use materials::{Definitions, Surfaces};
use merge::Merged;

pub(crate) use chunk::unit_or_zero;

/// Reads the OBJ file at `path` and its material libraries. Missing normals are zero. Without `colours` no
/// library is read, and all faces get the default material.
pub(crate) fn read(path: &Path, colours: bool, context: &mut Context) -> Result<ModelMesh, SceneError> {
    let invalid = |(line, message): (usize, String)| SceneError::invalid(path, Place::Line(line), message);
    let mut merged = read_statements(path)?;
    merged.finish().map_err(invalid)?;
    let definitions = colours.then(|| Definitions::of(path, &merged, context));
    for note in merged.notes() {
        context.warn(format!("{}: {note}", path.display()));
    }
    let surfaces = definitions.map(|definitions| Surfaces::of(path, &merged, &definitions, context));
    let surfaces = surfaces.unwrap_or_default();
    let mut mesh = ModelMesh::default();
    let count = merged.vertices.corners.len();
    mesh.positions.reserve_exact(count);
    mesh.uvs.reserve_exact(count);
    mesh.normals.reserve_exact(count);
    for &corner in &merged.vertices.corners {
        let (position, uv, normal) = merged.attributes(corner);
        mesh.positions.push(position);
        mesh.uvs.push(uv);
        mesh.normals.push(normal);
    }
    mesh.faces = std::mem::take(&mut merged.faces);
    mesh.runs = surfaces.runs;
    mesh.materials = surfaces.materials;
    mesh.emission = surfaces.emission;
    if let Some((dropped, vertex)) = mesh.drop_faces_that_are_not_finite() {
        let position = merged.vertices.corners[vertex as usize][chunk::POSITION] as usize - 1;
        let found = merged.not_finite.binary_search_by_key(&position, |&(_, index)| index);
        let line = found.map_or(0, |at| merged.not_finite[at].0);
        if mesh.faces.count() == 0 {
            let message = "the position is not finite, and every face has one like it";
            return Err(invalid((line, message.to_string())));
        }
        context.warn(format!(
            "{}: faces with a position that is not finite are left out: {dropped}, the first by that of line {line}",
            path.display()
        ));
    }
    let uv_not_finite = merged.uv_not_finite;
    drop(merged);
    if mesh.faces.count() == 0 {
        let message = "has no faces of three or more corners, expected lines such as: f 1 2 3";
        return Err(SceneError::invalid(path, Place::File, message));
    }
    uvs::apply(&mut mesh, &surfaces.uvs);
    if mesh.replace_uvs_that_are_not_finite() {
        let path = path.display();
        let line = uv_not_finite.map_or(String::new(), |line| format!(", first on line {line}"));
        context.warn(format!("{path}: texture coordinates that are not finite are taken as 0{line}"));
    }
    Ok(mesh)
}

fn read_statements(path: &Path) -> Result<Merged, SceneError> {
    let unreadable = |source| SceneError::Read { path: path.to_path_buf(), source };
    let mut blocks = Blocks::new(File::open(path).map_err(unreadable)?);
    let mut merged = Merged::default();
    loop {
        let block = blocks.next().map_err(unreadable)?;
        if block.is_empty() {
            return Ok(merged);
        }
        let read: Vec<Chunk> = chunks(block).into_par_iter().map(Chunk::read).collect();
        for chunk in read {
            merged
                .add(chunk)
                .map_err(|(line, message)| SceneError::invalid(path, Place::Line(line), message))?;
            let count =
                merged.positions.len().max(merged.vertices.corners.len()).max(merged.faces.corners.len() / 3);
            if count > MAX_COUNT {
                let message = format!("has more than {MAX_COUNT} triangles or vertices");
                return Err(SceneError::invalid(path, Place::File, message));
            }
        }
    }
}
