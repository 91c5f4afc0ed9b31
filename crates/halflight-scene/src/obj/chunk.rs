//! Piece of an OBJ file, parsed independently, so that several threads can parse a file.

use std::ops::Range;

use glam::{DVec3, Vec2, Vec3};

use crate::faces::Faces;
use crate::text::{Statements, first_word, keyword_and_rest, numbers, shown};
use crate::vertices::Corner;

/// Statements whose first occurrence is reported.
#[derive(Clone, Copy)]
pub(super) enum Note {
    Curves,
    VertexColours,
    FewCorners,
}

impl Note {
    pub(super) const ALL: [(Self, &'static str); 3] = [
        (Self::Curves, "curves and free-form surfaces are not supported"),
        (Self::VertexColours, "vertex colours are not used"),
        (Self::FewCorners, "faces of fewer than three corners are left out"),
    ];
}

/// Kinds of attributes of face corners, as indices into arrays of three.
pub(super) const POSITION: usize = 0;
pub(super) const UV: usize = 1;
pub(super) const NORMAL: usize = 2;

/// Names of the kinds in messages.
pub(super) const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Index in a face, and its line.
#[derive(Clone, Copy)]
pub(super) struct Reference {
    /// Index as written; negative ones count back from the line.
    pub(super) index: i64,
    /// Index counted from 1: from the file's first, or for negative indices from the chunk's first.
    pub(super) reach: i64,
    /// Line in the chunk.
    pub(super) line: usize,
}

/// Statement `usemtl` or `mtllib`.
pub(super) struct Naming {
    pub(super) is_library: bool,
    /// Number of the chunk's faces before it.
    pub(super) face: usize,
    pub(super) line: usize,
    /// Range of its name in [`Chunk::names`].
    pub(super) name: Range<usize>,
}

/// Content of a piece of a file. Lines count from 1 in the piece.
#[derive(Default)]
pub(super) struct Chunk {
    pub(super) lines: usize,
    pub(super) positions: Vec<DVec3>,
    pub(super) uvs: Vec<Vec2>,
    /// Unit normals; zero where there is none.
    pub(super) normals: Vec<Vec3>,
    /// Corners are indices into positions, texture coordinates and normals, counted from 1; 0 is none.
    pub(super) faces: Faces<Corner>,
    /// Positions in the faces' corners, three per corner, of indices that count from the chunk's first.
    pub(super) relative: Vec<usize>,
    /// Largest index of each kind.
    pub(super) highest: [Option<Reference>; 3],
    /// Index of each kind that refers back farthest.
    pub(super) lowest: [Option<Reference>; 3],
    /// First index of each kind that is 0.
    pub(super) zero: [Option<Reference>; 3],
    /// Lines of the positions that are not finite, and their indices from 0.
    pub(super) not_finite: Vec<(usize, usize)>,
    /// Line of the first texture coordinate that is not finite.
    pub(super) uv_not_finite: Option<usize>,
    pub(super) namings: Vec<Naming>,
    pub(super) names: Vec<u8>,
    /// First line of each note.
    pub(super) notes: [Option<usize>; Note::ALL.len()],
    /// Line and reason of the fault at which reading stopped.
    pub(super) fault: Option<(usize, String)>,
}

impl Chunk {
    pub(super) fn read(text: &[u8]) -> Self {
        let mut chunk = Self::default();
        let mut statements = Statements::new(text);
        while let Some((line, statement)) = statements.next() {
            if let Err(message) = chunk.statement(line, statement) {
                chunk.fault = Some((line, message));
                break;
            }
        }
        chunk.lines = statements.lines();
        chunk
    }

    fn statement(&mut self, line: usize, statement: &[u8]) -> Result<(), String> {
        let (keyword, rest) = keyword_and_rest(statement);
        match keyword {
            b"v" => self.position(line, rest),
            b"f" | b"fo" => self.face(line, rest),
            b"vn" => self.normal(rest),
            b"vt" => self.texture_coordinate(line, rest),
            b"usemtl" | b"mtllib" => {
                let start = self.names.len();
                self.names.extend_from_slice(rest);
                let (face, name) = (self.faces.count(), start..self.names.len());
                self.namings.push(Naming { is_library: keyword == b"mtllib", face, line, name });
                Ok(())
            }
            b"curv" | b"curv2" | b"surf" => {
                self.note(Note::Curves, line);
                Ok(())
            }
            // Groups, smoothing, points, lines and other statements do not change the triangles.
            _ => Ok(()),
        }
    }

    fn note(&mut self, note: Note, line: usize) {
        self.notes[note as usize].get_or_insert(line);
    }

    fn position(&mut self, line: usize, rest: &[u8]) -> Result<(), String> {
        let (count, numbers) = numbers_of("v", rest)?;
        if count < 3 {
            return Err(format!("`v {}`, expected three coordinates", shown(rest)));
        }
        if count > 4 {
            self.note(Note::VertexColours, line);
        }
        // A fourth number divides the others; three after the position are a colour.
        let divisor = if count == 4 { numbers[3] } else { 1.0 };
        let position = DVec3::new(numbers[0], numbers[1], numbers[2]) / divisor;
        if !position.is_finite() || !divisor.is_finite() {
            self.not_finite.push((line, self.positions.len()));
            self.positions.push(DVec3::NAN);
        } else {
            self.positions.push(position);
        }
        Ok(())
    }

    fn texture_coordinate(&mut self, line: usize, rest: &[u8]) -> Result<(), String> {
        let (count, numbers) = numbers_of("vt", rest)?;
        if count == 0 {
            return Err("`vt`, expected one to three numbers".to_string());
        }
        let uv = Vec2::new(numbers[0] as f32, numbers[1] as f32);
        if !uv.is_finite() {
            self.uv_not_finite.get_or_insert(line);
        }
        self.uvs.push(uv);
        Ok(())
    }

    fn normal(&mut self, rest: &[u8]) -> Result<(), String> {
        let (count, numbers) = numbers_of("vn", rest)?;
        if count < 3 {
            return Err(format!("`vn {}`, expected three numbers", shown(rest)));
        }
        self.normals.push(unit_or_zero(DVec3::new(numbers[0], numbers[1], numbers[2])));
        Ok(())
    }

    fn face(&mut self, line: usize, mut rest: &[u8]) -> Result<(), String> {
        let first = self.faces.corners.len();
        let first_relative = self.relative.len();
        let mut named = [true; 3];
        loop {
            let (word, after) = first_word(rest);
            if word.is_empty() {
                break;
            }
            let (indices, commented) = corner(word)?;
            self.add_corner(line, indices, &mut named)?;
            rest = if commented { &[] } else { after };
        }
        let count = self.faces.corners.len() - first;
        if count < 3 {
            self.note(Note::FewCorners, line);
            self.faces.corners.truncate(first);
            self.relative.truncate(first_relative);
            return Ok(());
        }
        // Attributes that not all corners of a face have are dropped.
        for kind in (UV..=NORMAL).filter(|&kind| !named[kind]) {
            self.faces.corners[first..].iter_mut().for_each(|corner| corner[kind] = 0);
            let relative = self.relative.split_off(first_relative);
            self.relative.extend(relative.into_iter().filter(|place| place % 3 != kind));
        }
        self.faces.end_face(count);
        Ok(())
    }

    fn add_corner(
        &mut self,
        line: usize,
        indices: [Option<i64>; 3],
        named: &mut [bool; 3],
    ) -> Result<(), String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let mut corner = [0; 3];
        for kind in 0..3 {
            let Some(index) = indices[kind] else {
                named[kind] = false;
                continue;
            };
            let reach = if index < 0 { counts[kind] as i64 + 1 + index } else { index };
            let reference = Reference { index, reach, line };
            if index < 0 {
                self.relative.push(3 * self.faces.corners.len() + kind);
                // Indices that refer back this far are before any file's first.
                corner[kind] = i32::try_from(reach).unwrap_or(i32::MIN) as u32;
                if self.lowest[kind].is_none_or(|lowest| reach < lowest.reach) {
                    self.lowest[kind] = Some(reference);
                }
            } else if index == 0 {
                self.zero[kind].get_or_insert(reference);
            } else {
                corner[kind] = u32::try_from(index).unwrap_or(u32::MAX);
                if self.highest[kind].is_none_or(|highest| reach > highest.reach) {
                    self.highest[kind] = Some(reference);
                }
            }
        }
        self.faces.corners.push(corner);
        Ok(())
    }
}

fn numbers_of(keyword: &str, rest: &[u8]) -> Result<(usize, [f64; 8]), String> {
    numbers(rest).ok_or_else(|| format!("`{keyword} {}`, expected numbers after {keyword}", shown(rest)))
}

/// Unit normal in single precision; zero, which means to be computed, where it has no direction.
pub(crate) fn unit_or_zero(normal: DVec3) -> Vec3 {
    let unit = normal.as_vec3().normalize_or_zero();
    if unit == Vec3::ZERO { normal.normalize_or_zero().as_vec3() } else { unit }
}

/// Indices of a corner; the flag is true if a comment follows in the same word.
fn corner(word: &[u8]) -> Result<([Option<i64>; 3], bool), String> {
    let mut indices = [None; 3];
    let mut at = 0;
    for index in &mut indices {
        let negative = word.get(at) == Some(&b'-');
        let first = at + usize::from(matches!(word.get(at), Some(b'-' | b'+')));
        let mut end = first;
        let mut value = 0i64;
        while let Some(digit) = word.get(end).map(|byte| byte.wrapping_sub(b'0')).filter(|&digit| digit < 10)
        {
            value = value.wrapping_mul(10).wrapping_add(digit.into());
            end += 1;
        }
        // Up to 18 digits do not wrap.
        if (1..=18).contains(&(end - first)) {
            *index = Some(if negative { -value } else { value });
        } else if end > at {
            return Err(corner_fault(word));
        }
        match word.get(end) {
            Some(b'/') => at = end + 1,
            None if indices[POSITION].is_some() => return Ok((indices, false)),
            Some(b'#') if indices[POSITION].is_some() => return Ok((indices, true)),
            _ => return Err(corner_fault(word)),
        }
    }
    Err(corner_fault(word))
}

/// Description of the fault of a corner.
fn corner_fault(word: &[u8]) -> String {
    let word = shown(word.split(|&byte| byte == b'#').next().unwrap_or(word));
    let mut parts = word.split('/');
    match parts.find(|part| !part.is_empty() && part.parse::<i64>().is_err()) {
        Some(part) => format!("face index `{part}`, expected a whole number"),
        None => format!("face corner `{word}`, expected VERTEX, VERTEX/UV or VERTEX/UV/NORMAL"),
    }
}
