//! PLY meshes (ASCII and both binary formats).

mod header;
mod rows;
mod values;

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use halflight_core::scene::Material;

use crate::context::{Context, MAX_COUNT};
use crate::error::{Place, SceneError};
use crate::model::ModelMesh;
use crate::text::{BYTE_ORDER_MARK, decode, is_utf8};
use crate::texture;
use crate::vertices::Vertices;
use header::{Element, Header};
use rows::{INDICES, Look, Rows, UVS};
use values::{Fault, Values};

/// Reads the PLY file at `path`. Missing normals are zero. Colours of faces and textures become materials;
/// without `colours` all faces get the default one.
pub(crate) fn read(path: &Path, colours: bool, context: &mut Context) -> Result<ModelMesh, SceneError> {
    let whole = |message: String| SceneError::invalid(path, Place::File, message);
    let mut bytes = fs::read(path).map_err(|source| SceneError::Read { path: path.to_path_buf(), source })?;
    if !is_utf8(&bytes) {
        bytes = decode(bytes);
    }
    let file = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&bytes);
    let header = Header::read(file).map_err(|message| whole(format!("header: {message}")))?;
    for element in &header.elements {
        check(element).map_err(|message| whole(format!("header: {message}")))?;
    }
    let mut rows = read_rows(path, &header, &file[header.length..], colours)?;
    drop(bytes);
    check_indices(path, &header, &rows)?;
    let mut look_runs = std::mem::take(&mut rows.look_runs);
    let warn_of = say_what_is_left_out(&header, &rows, colours);
    for warning in warn_of {
        context.warn(format!("{}: {warning}", path.display()));
    }

    let mut mesh = ModelMesh::default();
    let textured = has_uvs(&header) || rows.corner_uvs.is_some();
    let names = if colours && textured { header.textures.as_slice() } else { &[] };
    let first = material(path, Look::default(), names, context);
    mesh.materials = rows.looks.iter().map(|&look| material(path, look, names, context)).collect();
    mesh.materials.push(first);
    split_vertices(&mut mesh, &mut rows);
    mesh.runs.push((0, (mesh.materials.len() - 1) as u32));
    mesh.runs.append(&mut look_runs);
    mesh.faces = rows.faces;
    if let Some((dropped, vertex)) = mesh.drop_faces_that_are_not_finite() {
        if mesh.faces.triangles() == 0 {
            let position = mesh.positions[vertex as usize];
            return Err(whole(format!(
                "the position {position} is not finite, and every face has one like it"
            )));
        }
        context.warn(format!(
            "{}: faces with a position that is not finite are left out: {dropped}",
            path.display()
        ));
    }
    if mesh.faces.triangles() == 0 {
        let message =
            "has no faces of three or more corners, expected an element `face` with a list `vertex_indices`";
        return Err(whole(message.to_string()));
    }
    if mesh.replace_uvs_that_are_not_finite() {
        context.warn(format!("{}: texture coordinates that are not finite are taken as 0", path.display()));
    }
    Ok(mesh)
}

/// Refuses elements that cannot be read.
fn check(element: &Element) -> Result<(), String> {
    let name = &element.name;
    if element.properties.is_empty() && element.count > 0 {
        return Err(format!("element `{name}` has no properties"));
    }
    let indices = element.properties.iter().find(|property| INDICES.contains(&property.name.as_str()));
    match name.as_str() {
        "vertex" => {
            for axis in ["x", "y", "z"] {
                match element.properties.iter().find(|property| property.name == axis) {
                    None => return Err(format!("element `vertex` has no property `{axis}`")),
                    Some(property) if property.count.is_some() => {
                        return Err(format!(
                            "property `{axis}` of element `vertex` is a list, expected a number"
                        ));
                    }
                    Some(_) => {}
                }
            }
        }
        "face" | "tristrips" => match indices {
            Some(list) if list.count.is_some() && !list.scalar.is_float() => {}
            Some(list) => {
                return Err(format!("`{}` of element `{name}` is no list of whole numbers", list.name));
            }
            None => return Err(format!("element `{name}` has no list `vertex_indices`")),
        },
        _ => {}
    }
    Ok(())
}

fn read_rows(path: &Path, header: &Header, data: &[u8], colours: bool) -> Result<Rows, SceneError> {
    let mut rows = Rows::default();
    let mut values = Values::new(header.format, data);
    let vertices = header.elements.iter().filter(|element| element.name == "vertex");
    let vertices = vertices.map(|element| element.count).fold(0, usize::saturating_add);
    for element in &header.elements {
        let (kind, read) = match element.name.as_str() {
            "vertex" => ("vertex", rows.vertices(element, &mut values)),
            "face" => ("face", rows.faces(element, &mut values, colours)),
            "tristrips" => ("strip", rows.strips(element, &mut values, vertices)),
            _ => ("element", skip(element, &mut values)),
        };
        read.map_err(|(row, fault)| {
            let message = match fault {
                Fault::End => {
                    format!("the file ends here, expected {} of element `{}`", element.count, element.name)
                }
                Fault::Other(message) => message,
            };
            SceneError::invalid(path, Place::Element(kind, row), message)
        })?;
        if rows.positions.len().max(rows.faces.corners.len() / 3) > MAX_COUNT {
            let message = format!("has more than {MAX_COUNT} triangles or vertices");
            return Err(SceneError::invalid(path, Place::File, message));
        }
    }
    Ok(rows)
}

fn skip(element: &Element, values: &mut Values<'_>) -> Result<(), (usize, Fault)> {
    for row in 0..element.count {
        for property in &element.properties {
            values.skip(property).map_err(|fault| (row, fault))?;
        }
    }
    Ok(())
}

/// Refuses faces of vertices that do not exist. Faces may precede vertices, so the check comes last.
fn check_indices(path: &Path, header: &Header, rows: &Rows) -> Result<(), SceneError> {
    let count = rows.positions.len();
    let beyond = |&vertex: &u32| vertex as usize >= count;
    if !rows.faces.corners.iter().any(beyond) {
        return Ok(());
    }
    let faces = rows.faces.iter().enumerate();
    let found = faces
        .filter_map(|(face, corners)| Some((face, *corners.iter().find(|corner| beyond(corner))?)))
        .next();
    let (face, vertex) = found.unwrap_or_default();
    let message = format!("refers to vertex {vertex}, but there are {count}, which count from 0");
    // For strips, the triangles of all of them are counted.
    let strips = header.elements.iter().any(|element| element.name == "tristrips");
    let kind = if strips { "triangle" } else { "face" };
    Err(SceneError::invalid(path, Place::Element(kind, face), message))
}

fn has_uvs(header: &Header) -> bool {
    let mut vertices = header.elements.iter().filter(|element| element.name == "vertex");
    vertices.any(|element| UVS.iter().any(|[u, v]| element.has(u) && element.has(v)))
}

fn say_what_is_left_out(header: &Header, rows: &Rows, colours: bool) -> Vec<String> {
    let mut said = Vec::new();
    let has = |element: &str, property: &str| {
        header.elements.iter().any(|known| known.name == element && known.has(property))
    };
    if rows.few_corners > 0 {
        said.push(format!("faces of fewer than three corners are left out: {}", rows.few_corners));
    }
    if !colours {
        return said;
    }
    if has("vertex", "red") || has("vertex", "diffuse_red") {
        said.push("vertex colours are not used; give the mesh an albedo".to_string());
    }
    if has("tristrips", "red") || has("tristrips", "diffuse_red") {
        said.push("colours of strips are not used; give the mesh an albedo".to_string());
    }
    if header.elements.iter().any(|element| element.name == "material" && element.count > 0) {
        said.push("materials are not used; give the mesh an albedo".to_string());
    }
    if rows.transparent {
        said.push("transparency is not supported; all is opaque".to_string());
    }
    if rows.uvs_of_wrong_length > 0 {
        let count = rows.uvs_of_wrong_length;
        said.push(format!(
            "lists `texcoord` of another length than two numbers a corner are left out: {count}"
        ));
    }
    if !header.textures.is_empty() && !has_uvs(header) && rows.corner_uvs.is_none() {
        said.push("the texture is not used, since there are no texture coordinates".to_string());
    }
    said
}

/// Material of faces with a look, in a file with textures of these names.
fn material(path: &Path, look: Look, names: &[Vec<u8>], context: &mut Context) -> Material {
    let folder = path.parent().unwrap_or(Path::new(""));
    let number = usize::try_from(look.texture.unwrap_or(0)).ok();
    let texture = number.and_then(|number| names.get(number)).and_then(|name| {
        let found = texture::find(folder, name, context);
        texture::load(folder, name, found, "", context)
    });
    let colour = look.colour.map(|bits| Vec3::from_array(bits.map(f32::from_bits)));
    let plain = if texture.is_some() { Vec3::ONE } else { Material::default().albedo };
    Material { albedo: colour.unwrap_or(plain), texture, ..Material::default() }
}

/// Moves the vertices to `mesh`; if corners have their own texture coordinates, creates one vertex for each
/// pair.
fn split_vertices(mesh: &mut ModelMesh, rows: &mut Rows) {
    let Some(uvs) = rows.corner_uvs.take() else {
        mesh.positions = std::mem::take(&mut rows.positions);
        mesh.normals = std::mem::take(&mut rows.normals);
        mesh.uvs = std::mem::take(&mut rows.uvs);
        return;
    };
    let mut vertices = Vertices::default();
    vertices.define(rows.positions.len());
    for (corner, uv) in rows.faces.corners.iter_mut().zip(&uvs) {
        *corner = vertices.of([*corner + 1, uv.x.to_bits(), uv.y.to_bits()]);
    }
    for &[position, u, v] in &vertices.corners {
        let at = position as usize - 1;
        mesh.positions.push(rows.positions.get(at).copied().unwrap_or(DVec3::NAN));
        mesh.normals.push(rows.normals.get(at).copied().unwrap_or_default());
        mesh.uvs.push(Vec2::new(f32::from_bits(u), f32::from_bits(v)));
    }
}
