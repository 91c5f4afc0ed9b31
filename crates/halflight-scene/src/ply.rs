//! PLY meshes (ASCII and both binary formats), read by serde-ply.

use std::fmt;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek};
use std::path::Path;

use glam::{Vec2, Vec3};
use halflight_core::scene::{Material, Mesh};
use serde::Deserialize;
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_ply::{DeserializeError, ElementDef, PlyFormat, PlyReader};

use crate::error::{Place, SceneError};
use crate::polygon::triangulate;
use crate::report::LoadReport;

/// A row of the element `vertex`. Widths and number types are the file's own; serde-ply converts.
#[derive(Deserialize)]
struct Vertex {
    x: f32,
    y: f32,
    z: f32,
    #[serde(default)]
    nx: f32,
    #[serde(default)]
    ny: f32,
    #[serde(default)]
    nz: f32,
}

/// A row of the element `face`.
#[derive(Deserialize)]
struct Face {
    #[serde(alias = "vertex_index")]
    vertex_indices: Vec<i64>,
}

/// A row of an element that is not used.
#[derive(Deserialize)]
struct Other {}

/// Reads the PLY file at `path`. Normals that the file does not give are zero; all faces get the default material.
pub(crate) fn read(path: &Path, report: &mut LoadReport) -> Result<Mesh, SceneError> {
    let unreadable = |source| SceneError::Read { path: path.to_path_buf(), source };
    let mut file = File::open(path).map_err(unreadable)?;
    let header_fault =
        |fault: DeserializeError| SceneError::invalid(path, Place::File, format!("header: {}", fault.0));
    let format = PlyReader::from_reader(BufReader::new(&file)).map_err(header_fault)?.header().format;
    file.rewind().map_err(unreadable)?;
    // serde-ply ends a number in text only at white space, so that the last one needs it.
    let tail: &[u8] = if format == PlyFormat::Ascii { b"\n" } else { b"" };
    let mut reader = PlyReader::from_reader(BufReader::new(file).chain(tail)).map_err(header_fault)?;

    let mut mesh = Mesh { materials: vec![Material::default()], ..Mesh::default() };
    while let Some(element) = reader.current_element().cloned() {
        check_header(path, &element, report)?;
        match element.name.as_str() {
            "vertex" => {
                rows(path, "vertex", &element, &mut reader, |row: Vertex| add_vertex(&mut mesh, &row))?;
            }
            "face" if mesh.positions.is_empty() => {
                return Err(SceneError::invalid(path, Place::File, "has faces before its vertices"));
            }
            "face" => {
                let mut corners = Vec::new();
                rows(path, "face", &element, &mut reader, |row: Face| {
                    add_face(&mut mesh, &row, &mut corners)
                })?;
            }
            _ => rows(path, "element", &element, &mut reader, |_: Other| Ok(()))?,
        }
    }
    if mesh.triangles.is_empty() {
        let message =
            "has no faces of three or more corners, expected an element `face` with a list `vertex_indices`";
        return Err(SceneError::invalid(path, Place::File, message));
    }
    Ok(mesh)
}

/// Refuses elements that cannot be read, and says what is left out.
fn check_header(path: &Path, element: &ElementDef, report: &mut LoadReport) -> Result<(), SceneError> {
    let fault = |message: String| Err(SceneError::invalid(path, Place::File, message));
    if element.properties.is_empty() && element.count > 0 {
        return fault(format!("header: element `{}` has no properties", element.name));
    }
    match element.name.as_str() {
        "vertex" => {
            if let Some(missing) = ["x", "y", "z"].iter().find(|name| !element.has_property(name)) {
                return fault(format!("header: element `vertex` has no property `{missing}`"));
            }
            if element.has_property("red") || element.has_property("diffuse_red") {
                report.warn(format!(
                    "{}: vertex colours are not used; give the mesh an albedo",
                    path.display()
                ));
            }
        }
        "face" if !element.has_property("vertex_indices") && !element.has_property("vertex_index") => {
            return fault("header: element `face` has no list `vertex_indices`".to_string());
        }
        "tristrips" => {
            return fault("has triangle strips, which are not supported; export it with faces".to_string());
        }
        _ => {}
    }
    Ok(())
}

fn add_vertex(mesh: &mut Mesh, row: &Vertex) -> Result<(), String> {
    let position = Vec3::new(row.x, row.y, row.z);
    if !position.is_finite() {
        return Err(format!("the position {position} is not finite"));
    }
    mesh.positions.push(position);
    mesh.normals.push(Vec3::new(row.nx, row.ny, row.nz).normalize_or_zero());
    mesh.uvs.push(Vec2::ZERO);
    Ok(())
}

fn add_face(mesh: &mut Mesh, row: &Face, corners: &mut Vec<u32>) -> Result<(), String> {
    let count = mesh.positions.len();
    corners.clear();
    for &index in &row.vertex_indices {
        let vertex = u32::try_from(index).ok().filter(|&vertex| (vertex as usize) < count);
        let vertex = vertex
            .ok_or_else(|| format!("refers to vertex {index}, but there are {count}, which count from 0"))?;
        corners.push(vertex);
    }
    triangulate(corners, &mesh.positions, &mut mesh.triangles);
    mesh.material_ids.resize(mesh.triangles.len(), 0);
    Ok(())
}

/// Reads all rows of the reader's current element into `add`, without holding them.
fn rows<T: DeserializeOwned, R: BufRead>(
    path: &Path,
    kind: &'static str,
    element: &ElementDef,
    reader: &mut PlyReader<R>,
    add: impl FnMut(T) -> Result<(), String>,
) -> Result<(), SceneError> {
    let mut row = 0;
    let rows = Rows { row: &mut row, add, marker: std::marker::PhantomData };
    let mut reader = reader;
    MapAccess::next_value_seed(&mut reader, rows).map_err(|fault| {
        let message = match fault.0.kind() {
            ErrorKind::UnexpectedEof => {
                format!("the file ends here, expected {} of element `{}`", element.count, element.name)
            }
            _ => fault.0.to_string(),
        };
        SceneError::invalid(path, Place::Element(kind, row), message)
    })
}

/// Feeds rows to a function and counts them, so that a fault can name its row.
struct Rows<'a, T, F> {
    row: &'a mut usize,
    add: F,
    marker: std::marker::PhantomData<T>,
}

impl<'de, T: Deserialize<'de>, F: FnMut(T) -> Result<(), String>> DeserializeSeed<'de> for Rows<'_, T, F> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, T: Deserialize<'de>, F: FnMut(T) -> Result<(), String>> Visitor<'de> for Rows<'_, T, F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("rows")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut rows: A) -> Result<(), A::Error> {
        while let Some(row) = rows.next_element()? {
            (self.add)(row).map_err(serde::de::Error::custom)?;
            *self.row += 1;
        }
        Ok(())
    }
}
