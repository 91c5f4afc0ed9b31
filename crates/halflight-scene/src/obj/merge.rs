//! Content of an OBJ file, merged from its chunks.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3};

use super::chunk::{Chunk, KINDS, NORMAL, Note, POSITION, Reference, UV};
use crate::faces::Faces;
use crate::vertices::{Corner, Vertices};

/// Statement `usemtl` or `mtllib`, by its line in the file.
pub(super) struct Naming {
    pub(super) is_library: bool,
    /// Number of faces before it.
    pub(super) face: usize,
    pub(super) line: usize,
    /// Index into [`Merged::names`].
    pub(super) name: usize,
}

/// Content of a file. Lines are those of the file.
#[derive(Default)]
pub(super) struct Merged {
    pub(super) lines: usize,
    pub(super) positions: Vec<DVec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    pub(super) vertices: Vertices,
    /// Corners as vertex indices.
    pub(super) faces: Faces<u32>,
    highest: [Option<Reference>; 3],
    /// First undefined index of each kind that was dropped.
    left_out: [Option<Reference>; 3],
    /// Lines of the positions that are not finite, and their indices from 0.
    pub(super) not_finite: Vec<(usize, usize)>,
    pub(super) uv_not_finite: Option<usize>,
    pub(super) namings: Vec<Naming>,
    pub(super) names: Vec<Vec<u8>>,
    name_ids: HashMap<Vec<u8>, usize>,
    notes: [Option<usize>; Note::ALL.len()],
}

impl Merged {
    /// Appends a chunk. A fault is a line and a message.
    pub(super) fn add(&mut self, mut chunk: Chunk) -> Result<(), (usize, String)> {
        let lines = self.lines;
        let bases = [self.positions.len(), self.uvs.len(), self.normals.len()];
        for &place in &chunk.relative {
            let index = &mut chunk.faces.corners[place / 3][place % 3];
            let absolute = i64::from(*index as i32) + bases[place % 3] as i64;
            *index = u32::try_from(absolute).unwrap_or(0);
        }
        let here = |reference: Reference| Reference { line: reference.line + lines, ..reference };
        for (kind, base) in bases.into_iter().enumerate() {
            let base = base as i64;
            let lowest = chunk.lowest[kind].filter(|lowest| lowest.reach + base < 1);
            let undefined = chunk.zero[kind].into_iter().chain(lowest).min_by_key(|reference| reference.line);
            if kind == POSITION
                && let Some(reference) = undefined.map(here)
            {
                let defined = base + chunk.positions.len() as i64;
                // A negative index counts back from the attributes defined at its line.
                let before = base + reference.reach - reference.index - 1;
                let count = if reference.index < 0 { before } else { defined };
                return Err((reference.line, undefined_position(reference.index, count)));
            }
            self.left_out[kind] = self.left_out[kind].or(undefined.map(here));
            let highest = chunk.highest[kind].map(here);
            if highest.is_some_and(|new| self.highest[kind].is_none_or(|known| new.reach > known.reach)) {
                self.highest[kind] = highest;
            }
        }
        if let Some((line, message)) = chunk.fault {
            return Err((lines + line, message));
        }
        self.positions.append(&mut chunk.positions);
        self.uvs.append(&mut chunk.uvs);
        self.normals.append(&mut chunk.normals);
        let face = self.faces.count();
        self.vertices.define(self.positions.len());
        self.faces.append(&chunk.faces, |&corner| self.vertices.of(corner));
        self.not_finite
            .extend(chunk.not_finite.iter().map(|&(line, index)| (lines + line, bases[POSITION] + index)));
        self.uv_not_finite = self.uv_not_finite.or(chunk.uv_not_finite.map(|line| lines + line));
        for naming in chunk.namings {
            let name = self.name_id(&chunk.names[naming.name]);
            let (face, line) = (face + naming.face, lines + naming.line);
            self.namings.push(Naming { is_library: naming.is_library, face, line, name });
        }
        for (known, new) in self.notes.iter_mut().zip(chunk.notes) {
            *known = known.or(new.map(|line| lines + line));
        }
        self.lines += chunk.lines;
        Ok(())
    }

    fn name_id(&mut self, name: &[u8]) -> usize {
        if let Some(&known) = self.name_ids.get(name) {
            return known;
        }
        self.names.push(name.to_vec());
        self.name_ids.insert(name.to_vec(), self.names.len() - 1);
        self.names.len() - 1
    }

    /// Checks, after the whole file was read, that faces refer to positions that exist.
    pub(super) fn finish(&mut self) -> Result<(), (usize, String)> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        for (kind, count) in counts.into_iter().enumerate() {
            let count = count as i64;
            let Some(highest) = self.highest[kind].filter(|highest| highest.reach > count) else { continue };
            if kind == POSITION {
                return Err((highest.line, undefined_position(highest.index, count)));
            }
            self.left_out[kind] = self.left_out[kind].or(Some(highest));
        }
        Ok(())
    }

    /// Returns notes on statements and indices that were left out, each once.
    pub(super) fn notes(&self) -> Vec<String> {
        let notes = Note::ALL.iter().filter_map(|&(note, text)| {
            self.notes[note as usize].map(|line| format!("{text}, first on line {line}"))
        });
        let indices = (UV..=NORMAL).filter_map(|kind| {
            let Reference { index, line, .. } = self.left_out[kind]?;
            let kind = KINDS[kind];
            Some(format!(
                "indices of {kind}s that are not defined are left out, such as {index} on line {line}"
            ))
        });
        notes.chain(indices).collect()
    }

    /// Position, texture coordinate and normal of a vertex; zero for missing ones.
    pub(super) fn attributes(&self, [position, uv, normal]: Corner) -> (DVec3, Vec2, Vec3) {
        let at = |index: u32| (index as usize).wrapping_sub(1);
        (
            self.positions.get(at(position)).copied().unwrap_or(DVec3::NAN),
            self.uvs.get(at(uv)).copied().unwrap_or_default(),
            self.normals.get(at(normal)).copied().unwrap_or_default(),
        )
    }
}

fn undefined_position(index: i64, count: i64) -> String {
    format!("face refers to vertex {index}, but {count} are defined, which count from 1 (or back from -1)")
}
