//! Material libraries (MTL).

use std::fs;
use std::path::Path;

use glam::Vec3;
use halflight_core::scene::Material;

use crate::error::{Place, SceneError};
use crate::report::LoadReport;
use crate::texture::TextureStore;

/// The albedo of a material whose `Kd` is missing; MTL names none.
const DEFAULT_KD: Vec3 = Vec3::splat(0.8);

/// Reads the library at `path` with tobj, which gets only the statements that are used here, and those well formed:
/// it panics on a `Kd` of fewer than three numbers, and one fault would lose the whole library.
pub(crate) fn read(path: &Path, report: &mut LoadReport) -> Result<Vec<tobj::Material>, SceneError> {
    let bytes = fs::read(path).map_err(|source| SceneError::Read { path: path.to_path_buf(), source })?;
    // Names in old files are not always UTF-8.
    let text = String::from_utf8_lossy(&bytes);
    let mut statements = String::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        let fault = |message: String| SceneError::invalid(path, Place::Line(index + 1), message);
        let numbers =
            || rest.split_whitespace().map(|word| word.parse().ok().filter(|n: &f32| n.is_finite()));
        match keyword.to_ascii_lowercase().as_str() {
            "newmtl" if rest.is_empty() => {
                return Err(fault("newmtl without a name; expected: newmtl NAME".to_string()));
            }
            "newmtl" => statements.push_str(&format!("newmtl {rest}\n")),
            "kd" if rest.starts_with("spectral") || rest.starts_with("xyz") => {
                report.warn(format!("{}: `Kd {rest}` is not supported, only RGB", path.display()));
            }
            "kd" => match numbers().collect::<Option<Vec<f32>>>().as_deref() {
                // A single number is grey.
                Some([grey]) => statements.push_str(&format!("Kd {grey} {grey} {grey}\n")),
                Some([r, g, b]) => statements.push_str(&format!("Kd {r} {g} {b}\n")),
                _ => return Err(fault(format!("`Kd {rest}`, expected one or three finite numbers"))),
            },
            "map_kd" => match texture_name(rest) {
                Some(name) => statements.push_str(&format!("map_Kd {name}\n")),
                None => return Err(fault("map_Kd without a file; expected: map_Kd FILE".to_string())),
            },
            "map_d" => report.warn(format!("{}: alpha masks (map_d) are not supported", path.display())),
            "bump" | "map_bump" | "norm" => {
                report.warn(format!("{}: bump and normal maps are not supported", path.display()));
            }
            "ke" if numbers().flatten().any(|value| value > 0.0) => {
                report.warn(format!("{}: emission (Ke) is not used; lights are [[light]]", path.display()));
            }
            // Tr is 1 - d.
            "d" | "tr" => {
                let opaque = if keyword.eq_ignore_ascii_case("d") { 1.0 } else { 0.0 };
                if numbers().next().flatten().is_some_and(|value| value != opaque) {
                    report.warn(format!("{}: transparency is not supported; all is opaque", path.display()));
                }
            }
            _ => {}
        }
    }
    let (materials, _) = tobj::load_mtl_buf(&mut statements.as_bytes())
        .map_err(|fault| SceneError::invalid(path, Place::File, fault.to_string()))?;
    Ok(materials)
}

/// The file in the arguments of a map: what follows the options, which begin with a dash.
fn texture_name(arguments: &str) -> Option<&str> {
    let mut rest = arguments.trim();
    while let Some(option) = rest.strip_prefix('-') {
        let (name, mut after) = option.split_once(char::is_whitespace)?;
        // Options have one word, two (-mm), or one to three numbers (-o, -s, -t).
        let words = match name {
            "mm" => 2,
            "o" | "s" | "t" => {
                let numbers = after.split_whitespace().take_while(|word| word.parse::<f32>().is_ok());
                numbers.count().min(3)
            }
            _ => 1,
        };
        for _ in 0..words {
            after = after.trim_start().split_once(char::is_whitespace)?.1;
        }
        rest = after.trim_start();
    }
    (!rest.is_empty()).then_some(rest)
}

/// The diffuse part of `material`, whose library lies in `folder`.
pub(crate) fn diffuse(
    material: &tobj::Material,
    library: &Path,
    textures: &mut TextureStore,
    report: &mut LoadReport,
) -> Material {
    let folder = library.parent().unwrap_or(Path::new(""));
    let texture = material.diffuse_texture.as_ref().and_then(|name| textures.find(folder, name, report));
    let kd = material.diffuse.map_or(DEFAULT_KD, Vec3::from_array);
    let mut albedo = kd.clamp(Vec3::ZERO, Vec3::ONE);
    if albedo != kd {
        let library = library.display();
        report
            .warn(format!("{library}: Kd outside 0 to 1 is clamped, first in material `{}`", material.name));
    }
    // Exporters write a black Kd beside a texture that is meant to be seen.
    if texture.is_some() && (albedo == Vec3::ZERO || material.diffuse.is_none()) {
        albedo = Vec3::ONE;
    }
    Material { albedo, texture }
}
