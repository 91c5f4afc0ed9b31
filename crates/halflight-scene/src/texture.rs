//! Albedo textures: found whatever the case of their names, decoded from sRGB to linear.

use std::collections::HashMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use glam::Vec3;
use halflight_core::scene::Texture;

use crate::report::LoadReport;

/// The textures of a scene, each file read once.
#[derive(Default)]
pub(crate) struct TextureStore {
    pub(crate) textures: Vec<Texture>,
    by_path: HashMap<PathBuf, Option<u32>>,
}

impl TextureStore {
    /// The index of the texture that a material library in `folder` calls `name`; `None`, with a warning, where it
    /// is missing or cannot be decoded.
    pub(crate) fn find(&mut self, folder: &Path, name: &str, report: &mut LoadReport) -> Option<u32> {
        let Some(path) = find_texture(folder, name) else {
            report
                .warn(format!("texture `{name}` is missing in {}; its colour is used alone", shown(folder)));
            return None;
        };
        if let Some(&known) = self.by_path.get(&path) {
            return known;
        }
        let index = match read(&path) {
            Ok((texture, opaque)) => {
                if !opaque {
                    let path = path.display();
                    report.warn(format!("texture {path} is transparent in places; it is taken as opaque"));
                }
                self.textures.push(texture);
                Some((self.textures.len() - 1) as u32)
            }
            Err(fault) => {
                let path = path.display();
                report.warn(format!("texture {path} cannot be read ({fault}); its colour is used alone"));
                None
            }
        };
        self.by_path.insert(path, index);
        index
    }
}

/// A folder as messages show it: the current one is not empty.
pub(crate) fn shown(folder: &Path) -> String {
    if folder.as_os_str().is_empty() { "./".to_string() } else { folder.display().to_string() }
}

/// Looks for a texture where its name says, then by its last part only, beside the library and in `textures/`.
fn find_texture(folder: &Path, name: &str) -> Option<PathBuf> {
    // Exporters on Windows write backslashes and absolute paths of their own machine.
    let name = PathBuf::from(name.replace('\\', "/"));
    let last = Path::new(name.file_name()?);
    [name.clone(), last.to_path_buf(), Path::new("textures").join(&name), Path::new("textures").join(last)]
        .iter()
        .find_map(|candidate| find_ignoring_case(folder, candidate))
}

/// The file at `relative` in `folder`, part by part: as written, or else the first name, in order, that differs only
/// in case.
pub(crate) fn find_ignoring_case(folder: &Path, relative: &Path) -> Option<PathBuf> {
    let mut found = folder.to_path_buf();
    for part in relative.components() {
        let exact = found.join(part);
        let Component::Normal(name) = part else {
            found = exact;
            continue;
        };
        if exact.exists() {
            found = exact;
            continue;
        }
        let wanted = name.to_string_lossy().to_lowercase();
        // An empty path means the current folder to `join`, but not to `read_dir`.
        let listed = if found.as_os_str().is_empty() { Path::new(".") } else { &found };
        let names = fs::read_dir(listed).ok()?.filter_map(|entry| Some(entry.ok()?.file_name()));
        found = found.join(names.filter(|name| name.to_string_lossy().to_lowercase() == wanted).min()?);
    }
    found.is_file().then_some(found)
}

/// The texture and whether it is opaque throughout.
fn read(path: &Path) -> Result<(Texture, bool), image::ImageError> {
    let image = image::ImageReader::open(path)?.with_guessed_format()?.decode()?;
    let linear: Vec<f32> = (0..=255u8).map(srgb_to_linear).collect();
    let pixels = image.to_rgba8();
    let opaque = pixels.pixels().all(|pixel| pixel.0[3] == 255);
    let texels = pixels.pixels().map(|pixel| {
        let [r, g, b, _] = pixel.0.map(|channel| linear[usize::from(channel)]);
        Vec3::new(r, g, b)
    });
    Ok((Texture { width: pixels.width(), height: pixels.height(), texels: texels.collect() }, opaque))
}

/// IEC 61966-2-1, decoding.
fn srgb_to_linear(encoded: u8) -> f32 {
    let value = f64::from(encoded) / 255.0;
    let linear = if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    linear as f32
}
