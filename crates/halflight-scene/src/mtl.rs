//! Material libraries (MTL).

mod map;
mod specular;

use std::fs;
use std::path::Path;
use std::rc::Rc;

use glam::Vec3;
use halflight_core::scene::Material;

use crate::context::Context;
use crate::emission::Emission;
use crate::library::{Definition, Library, Written};
use crate::text::{Statements, decode, first_number, first_word, keyword_and_rest, numbers, shown};
use map::Keyword;
pub(crate) use map::UvTransform;
use specular::specular;

/// The albedo of a material whose `Kd` is missing; MTL names none.
const DEFAULT_KD: Vec3 = Vec3::splat(0.8);

/// Library at `path`, read once per scene; `None`, with a warning, where it cannot be read.
pub(crate) fn library(path: &Path, context: &mut Context) -> Option<Rc<Library>> {
    if let Some(known) = context.libraries.get(path) {
        return Some(Rc::clone(known));
    }
    let bytes = match fs::read(path) {
        Ok(bytes) => decode(bytes),
        Err(fault) => {
            context.warn(format!(
                "material library {} cannot be read ({fault}); grey is used instead",
                path.display()
            ));
            return None;
        }
    };
    let mut reader = Reader { path, context, materials: Vec::new(), left_out: 0, first_left_out: None };
    let mut statements = Statements::new(&bytes);
    while let Some((line, statement)) = statements.next() {
        reader.statement(line, statement);
    }
    reader.end_material();
    let materials = reader.finish();
    let library = Rc::new(Library::new(path, materials));
    context.libraries.insert(path.to_path_buf(), Rc::clone(&library));
    Some(library)
}

/// A library's material, and the transform of its texture coordinates. Its alpha mask is the index of an alpha image until
/// [`AlphaChoice::apply`](crate::alpha::AlphaChoice::apply).
pub(crate) fn surface(library: &Library, index: usize, context: &mut Context) -> (Material, UvTransform) {
    let material = &library.materials[index];
    let (texture, uv) = Keyword::Kd.look_up(&library.path, material.map.as_ref(), context);
    let (alpha_mask, alpha_uv) = Keyword::Alpha.look_up(&library.path, material.alpha.as_ref(), context);
    let uv = if texture.is_some() { uv } else { alpha_uv };
    if alpha_mask.is_some() && uv != alpha_uv {
        let (path, name) = (library.path.display(), shown(&material.name));
        context.warn(format!(
            "{path}: map_d is placed as map_Kd is, not by its own -s and -o, first in material `{name}`"
        ));
    }
    let kd = material.kd.unwrap_or(DEFAULT_KD);
    let mut albedo = kd.clamp(Vec3::ZERO, Vec3::ONE);
    if albedo != kd {
        let (path, name) = (library.path.display(), shown(&material.name));
        context.warn(format!("{path}: Kd outside 0 to 1 is clamped, first in material `{name}`"));
    }
    // Exporters write a black Kd beside a texture that is meant to be visible.
    if texture.is_some() && (albedo == Vec3::ZERO || material.kd.is_none()) {
        albedo = Vec3::ONE;
    }
    (Material { albedo, texture, alpha_mask, specular: specular(material, &library.path, context) }, uv)
}

/// Emission of a library's material, if it emits.
pub(crate) fn emission(library: &Library, index: usize) -> Option<Emission> {
    let material = &library.materials[index];
    (material.ke != Vec3::ZERO || material.map_ke).then(|| Emission {
        radiance: material.ke,
        textured: material.map_ke,
        file: library.path.clone(),
        line: material.emission_line,
        material: shown(&material.name),
    })
}

/// Reader of statements. A faulty statement is skipped with a warning and affects no other line.
struct Reader<'a> {
    path: &'a Path,
    context: &'a mut Context,
    materials: Vec<Definition>,
    left_out: usize,
    first_left_out: Option<String>,
}

impl Reader<'_> {
    fn statement(&mut self, line: usize, statement: &[u8]) {
        let (keyword, rest) = keyword_and_rest(statement);
        let keyword = keyword.to_ascii_lowercase();
        if keyword == b"newmtl" {
            self.end_material();
            self.materials.push(Definition { name: rest.to_vec(), ..Definition::default() });
            return;
        }
        match keyword.as_slice() {
            b"kd" if rest.starts_with(b"spectral") || rest.starts_with(b"xyz") => {
                self.warn(&format!("`Kd {}` is not supported, only RGB", shown(rest)));
            }
            b"kd" => match colour(rest) {
                Some((kd, whole)) => {
                    if !whole {
                        let rest = shown(rest);
                        self.warn(&format!(
                            "`Kd {rest}` on line {line} has more than three numbers; the rest is not used"
                        ));
                    }
                    self.set(line, |material| material.kd = Some(kd));
                }
                None => {
                    self.leave_out(
                        line,
                        format!("`Kd {}`, expected one or three finite numbers", shown(rest)),
                    );
                }
            },
            b"ks" | b"ns" | b"pr" | b"pm" => self.specular(line, &keyword, rest),
            b"map_pr" | b"map_pm" | b"map_ks" | b"map_ns" => {
                self.warn(
                    "textures of specular reflection (map_Ks, map_Ns, map_Pr, map_Pm) are not supported",
                );
            }
            b"map_kd" => match map::parse(rest) {
                Some(_) => self.set(line, |material| material.map = Some((line, rest.to_vec()))),
                None => self.leave_out(line, "map_Kd without a file; expected: map_Kd FILE".to_string()),
            },
            b"map_d" => match map::parse(rest) {
                Some(_) => self.set(line, |material| material.alpha = Some((line, rest.to_vec()))),
                None => self.leave_out(line, "map_d without a file; expected: map_d FILE".to_string()),
            },
            b"map_tr" => self.warn("map_Tr is not supported, only alpha masks by map_d"),
            b"bump" | b"map_bump" | b"norm" => self.warn("bump and normal maps are not supported"),
            b"ke" => match colour(rest).filter(|(ke, _)| ke.min_element() >= 0.0) {
                Some((ke, _)) => {
                    self.set(line, |material| (material.ke, material.emission_line) = (ke, line));
                }
                None => {
                    let message =
                        format!("`Ke {}`, expected one or three finite numbers from 0", shown(rest));
                    self.leave_out(line, message);
                }
            },
            b"map_ke" => {
                self.set(line, |material| (material.map_ke, material.emission_line) = (true, line));
            }
            // Tr is 1 - d.
            b"d" | b"tr" => {
                let opaque = if keyword == b"d" { 1.0 } else { 0.0 };
                let value = match first_word(rest) {
                    (b"-halo", factor) => factor,
                    _ => rest,
                };
                if first_number(value).and_then(|(value, _)| value).is_some_and(|value| value != opaque) {
                    self.warn_of_transparency();
                }
            }
            b"tf" => {
                let filters = above_zero(rest) || rest.starts_with(b"spectral") || rest.starts_with(b"xyz");
                self.set(line, |material| material.filters = filters);
            }
            b"illum" => {
                let illumination = first_number(rest).and_then(|(value, _)| value);
                self.set(line, |material| material.illumination = illumination);
            }
            _ => {}
        }
    }

    /// Reads a statement of specular reflection. Faults of `Ks` and `Ns` matter only where these are wanted.
    fn specular(&mut self, line: usize, keyword: &[u8], rest: &[u8]) {
        let text = rest.to_vec();
        if keyword == b"ks" {
            let value = colour(rest).map(|(ks, _)| ks);
            self.set(line, |material| material.ks = Some(Written { value, line, text }));
            return;
        }
        let value = first_number(rest).and_then(|(value, _)| value).map(|value| value as f32);
        let value = value.filter(|value| value.is_finite());
        if value.is_none() && keyword != b"ns" {
            let message = format!("`{} {}`, expected a finite number", shown(keyword), shown(rest));
            return self.leave_out(line, message);
        }
        let written = Some(Written { value, line, text });
        self.set(line, |material| match keyword {
            b"ns" => material.ns = written,
            b"pr" => material.roughness = written,
            _ => material.metallic = written,
        });
    }

    /// Changes the current material.
    fn set(&mut self, line: usize, change: impl FnOnce(&mut Definition)) {
        match self.materials.last_mut() {
            Some(material) => change(material),
            None => self.leave_out(line, "a statement before the first newmtl".to_string()),
        }
    }

    /// Warns of glass that is written as a filter with a transparent illumination model, in any order.
    fn end_material(&mut self) {
        let glass = self.materials.last().is_some_and(|material| match material.illumination {
            Some(model @ 4.0..=9.0) => material.filters || ![5.0, 8.0].contains(&model),
            _ => false,
        });
        if glass {
            self.warn_of_transparency();
        }
    }

    fn warn_of_transparency(&mut self) {
        self.warn("transparency is not supported; all is opaque");
    }

    fn warn(&mut self, warning: &str) {
        self.context.warn(format!("{}: {warning}", self.path.display()));
    }

    fn leave_out(&mut self, line: usize, message: String) {
        self.left_out += 1;
        self.first_left_out.get_or_insert_with(|| format!("{}:{line}: {message}", self.path.display()));
    }

    /// Materials, after all statements were read.
    fn finish(self) -> Vec<Definition> {
        if let Some(first) = self.first_left_out {
            self.context.warn(match self.left_out {
                1 => format!("{first}; the line is left out"),
                count => format!("{first}; {count} such lines are left out"),
            });
        }
        self.materials
    }
}

/// Reads a colour of one or three finite numbers; the flag is true if nothing follows them.
fn colour(mut rest: &[u8]) -> Option<(Vec3, bool)> {
    let mut colour = [0.0; 3];
    let mut count = 0;
    let whole = loop {
        match first_number(rest) {
            Some((None, _)) => break true,
            Some((Some(number), after)) if count < 3 => {
                colour[count] = number as f32;
                count += 1;
                rest = after;
            }
            _ => break false,
        }
    };
    let colour = match (count, whole) {
        (1, true) => Vec3::splat(colour[0]),
        (3, _) => Vec3::from_array(colour),
        _ => return None,
    };
    colour.is_finite().then_some((colour, whole))
}

fn above_zero(rest: &[u8]) -> bool {
    numbers(rest).is_some_and(|(_, numbers)| numbers.iter().any(|&number| number > 0.0))
}
