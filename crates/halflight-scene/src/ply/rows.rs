//! Elements of a PLY file that make a mesh.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3};
use halflight_core::scene::SRGB_TO_LINEAR;

use super::header::{Element, Scalar};
use super::values::{Fault, Values};
use crate::faces::Faces;
use crate::obj::unit_or_zero;

/// Row number and fault.
pub(super) type RowFault = (usize, Fault);

/// Names of the list of a face's vertices.
pub(super) const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Names of texture coordinates of vertices.
pub(super) const UVS: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];

/// Vertices and faces of a file.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) faces: Faces<u32>,
    pub(super) few_corners: usize,
    /// Texture coordinates of the faces' corners, where the file has such.
    pub(super) corner_uvs: Option<Vec<Vec2>>,
    pub(super) uvs_of_wrong_length: usize,
    /// First face of each run, and its look as an index into `looks`; the default look before the first run.
    pub(super) look_runs: Vec<(usize, u32)>,
    /// Looks of faces, each once; the default look is not among them.
    pub(super) looks: Vec<Look>,
    known_looks: HashMap<Look, u32>,
    /// True if a colour is transparent.
    pub(super) transparent: bool,
}

/// Colour and texture of a face.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub(super) struct Look {
    /// Bits of a linear colour.
    pub(super) colour: Option<[u32; 3]>,
    pub(super) texture: Option<i64>,
}

impl Rows {
    pub(super) fn vertices(&mut self, element: &Element, values: &mut Values<'_>) -> Result<(), RowFault> {
        let names = ["x", "y", "z", "nx", "ny", "nz"];
        let uv = UVS.iter().find(|[u, v]| element.has(u) && element.has(v)).copied().unwrap_or_default();
        let slots: Vec<Option<usize>> = element
            .properties
            .iter()
            .map(|property| {
                let mut names = names.iter().chain(&uv);
                names.position(|name| *name == property.name).filter(|_| property.count.is_none())
            })
            .collect();
        let expected = element.count.min(values.left() / element.properties.len().max(1));
        self.positions.reserve(expected);
        self.normals.reserve(expected);
        self.uvs.reserve(expected);
        for row in 0..element.count {
            let mut numbers = [0.0; 8];
            for (property, slot) in element.properties.iter().zip(&slots) {
                match slot {
                    Some(slot) => {
                        numbers[*slot] = values.next(property.scalar).map_err(|fault| (row, fault))?;
                    }
                    None => values.skip(property).map_err(|fault| (row, fault))?,
                }
            }
            let [x, y, z, nx, ny, nz, u, v] = numbers;
            self.positions.push(DVec3::new(x, y, z));
            self.normals.push(unit_or_zero(DVec3::new(nx, ny, nz)));
            self.uvs.push(Vec2::new(u as f32, v as f32));
        }
        Ok(())
    }

    /// Reads faces; with `looks` also their colours and textures.
    pub(super) fn faces(
        &mut self,
        element: &Element,
        values: &mut Values<'_>,
        looks: bool,
    ) -> Result<(), RowFault> {
        let channel = |name: &str| {
            let name = name.strip_prefix("diffuse_").unwrap_or(name);
            ["red", "green", "blue", "alpha"].iter().position(|known| looks && *known == name)
        };
        let roles: Vec<Role> = element
            .properties
            .iter()
            .map(|property| match (property.name.as_str(), property.count) {
                (name, Some(count)) if INDICES.contains(&name) => Role::Indices(count),
                ("texcoord", Some(count)) => Role::Uvs(count),
                ("texnumber", None) if looks => Role::Texture,
                (name, None) => channel(name).map_or(Role::None, Role::Channel),
                _ => Role::None,
            })
            .collect();
        self.begin_element();
        let given = roles.iter().any(|role| matches!(role, Role::Uvs(_)));
        let looks = roles.iter().any(|role| matches!(role, Role::Texture | Role::Channel(_)));
        let mut uvs = Vec::new();
        for row in 0..element.count {
            let first = self.faces.corners.len();
            uvs.clear();
            let look = self.face(element, &roles, values, &mut uvs).map_err(|fault| (row, fault))?;
            if looks {
                self.set_look(look);
            }
            let count = self.faces.corners.len() - first;
            self.few_corners += usize::from(count < 3);
            self.faces.end_face(count);
            self.add_corner_uvs(first, &uvs, given);
        }
        Ok(())
    }

    /// Reads a row of faces: appends its corners and texture coordinates.
    fn face(
        &mut self,
        element: &Element,
        roles: &[Role],
        values: &mut Values<'_>,
        uvs: &mut Vec<f32>,
    ) -> Result<Look, Fault> {
        let mut look = Look::default();
        for (property, role) in element.properties.iter().zip(roles) {
            match *role {
                Role::Indices(count) => {
                    for _ in 0..values.count(count)? {
                        let index = values.next(property.scalar)?;
                        self.faces.corners.push(whole(index)?);
                    }
                }
                Role::Uvs(count) => {
                    for _ in 0..values.count(count)? {
                        uvs.push(values.next(property.scalar)? as f32);
                    }
                }
                Role::Channel(channel) => {
                    let value = values.next(property.scalar)?;
                    match look.colour.get_or_insert_default().get_mut(channel) {
                        Some(colour) => *colour = linear(value, property.scalar).to_bits(),
                        None => self.transparent |= byte(value, property.scalar) < 255,
                    }
                }
                Role::Texture => look.texture = Some(values.next(property.scalar)? as i64),
                Role::None => values.skip(property)?,
            }
        }
        Ok(look)
    }

    /// Resets the look at the start of an element.
    fn begin_element(&mut self) {
        if !self.look_runs.is_empty() {
            self.set_look(Look::default());
        }
    }

    /// Sets the look of the faces from here on.
    fn set_look(&mut self, look: Look) {
        let new = self.looks.len() as u32;
        let index = *self.known_looks.entry(look).or_insert(new);
        if index == new {
            self.looks.push(look);
        }
        if self.look_runs.last().is_none_or(|&(_, last)| last != index) {
            self.look_runs.push((self.faces.count(), index));
        }
    }

    /// Adds the texture coordinates of the face whose corners begin at `first`.
    fn add_corner_uvs(&mut self, first: usize, uvs: &[f32], given: bool) {
        if !given && self.corner_uvs.is_none() {
            return;
        }
        let all = self.corner_uvs.get_or_insert_default();
        all.resize(first, Vec2::ZERO);
        let count = self.faces.corners.len();
        if uvs.len() == 2 * (count - first) {
            all.extend(uvs.as_chunks().0.iter().copied().map(Vec2::from_array));
        } else if given && !uvs.is_empty() {
            self.uvs_of_wrong_length += 1;
        }
        all.resize(count, Vec2::ZERO);
    }

    /// Reads triangle strips of `vertices` vertices: -1 ends a strip, and every second triangle is flipped.
    pub(super) fn strips(
        &mut self,
        element: &Element,
        values: &mut Values<'_>,
        vertices: usize,
    ) -> Result<(), RowFault> {
        self.begin_element();
        for row in 0..element.count {
            let fault = |fault| (row, fault);
            for property in &element.properties {
                let Some(count) = property.count.filter(|_| INDICES.contains(&property.name.as_str())) else {
                    values.skip(property).map_err(fault)?;
                    continue;
                };
                let mut strip = [0; 2];
                let mut length = 0usize;
                for _ in 0..values.count(count).map_err(fault)? {
                    let index = values.next(property.scalar).map_err(fault)?;
                    let minus_one = index == property.scalar.minus_one() && index >= vertices as f64;
                    if index == -1.0 || minus_one {
                        length = 0;
                        continue;
                    }
                    let index = whole(index).map_err(fault)?;
                    let [a, b] = strip;
                    // Triangles that use a corner twice join strips and have no area.
                    if length >= 2 && a != b && b != index && a != index {
                        let triangle = if length.is_multiple_of(2) { [a, b, index] } else { [b, a, index] };
                        let first = self.faces.corners.len();
                        self.faces.corners.extend(triangle);
                        self.faces.end_face(3);
                        self.add_corner_uvs(first, &[], false);
                    }
                    strip = [b, index];
                    length += 1;
                }
            }
        }
        Ok(())
    }
}

/// Meaning of a property of faces.
#[derive(Clone, Copy)]
enum Role {
    /// List of vertices, with the type of its count.
    Indices(Scalar),
    /// List of texture coordinates, two per corner.
    Uvs(Scalar),
    /// Red, green, blue or alpha.
    Channel(usize),
    /// Number of the texture.
    Texture,
    None,
}

/// Vertex index, which may be out of range.
fn whole(index: f64) -> Result<u32, Fault> {
    let number = (index.fract() == 0.0).then(|| u32::try_from(index as i64).ok()).flatten();
    number.ok_or_else(|| {
        Fault::Other(format!("refers to vertex {index}, expected a whole number, counted from 0"))
    })
}

/// A colour channel in 8 bits.
fn byte(value: f64, scalar: Scalar) -> u8 {
    let value = match scalar {
        Scalar::F32 | Scalar::F64 => 255.0 * value,
        Scalar::I16 | Scalar::U16 => value / 257.0,
        _ => value,
    };
    value.round() as u8
}

/// Colour channel as a linear value: integers are sRGB, floating-point numbers are linear.
fn linear(value: f64, scalar: Scalar) -> f32 {
    match scalar {
        Scalar::F32 | Scalar::F64 => {
            if value.is_nan() {
                0.0
            } else {
                (value as f32).clamp(0.0, 1.0)
            }
        }
        _ => SRGB_TO_LINEAR[usize::from(byte(value, scalar))],
    }
}
