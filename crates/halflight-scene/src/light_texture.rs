//! Textures and videos of lights.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::light_texture::LightTexture;
use image::{DynamicImage, ImageError, ImageReader, Limits};

use crate::error::SceneError;
use crate::generate::screen;
use crate::section::{Found, Section, Source};

/// Most texels of all textures of a light, 8192 × 8192: most of a gigabyte.
const MAX_TEXELS: u64 = 1 << 26;

/// Largest difference between the aspect ratios of a light and of its texture, relative to one of them.
const ASPECT: f32 = 0.05;

/// Frames a second of a video where the file does not say.
const FPS: f32 = 24.0;

/// Most frames of a generated film.
const MAX_FRAMES: u32 = 1000;

/// Texture of a `[[light]]`, before it is read.
#[derive(Debug)]
pub(crate) struct TextureEntry {
    origin: Origin,
    /// Frames a second of a video.
    fps: f32,
    /// True if the texture's aspect ratio may differ from the light's.
    stretch: bool,
    line: usize,
}

/// Source of a texture.
#[derive(Debug)]
enum Origin {
    /// Path as written in the scene file; a run of `#` stands for the digits of a frame's number.
    File { name: String, encoding: Encoding },
    /// Pattern of [`screen`], and its number of frames.
    Generated { pattern: String, frames: u32 },
}

/// Meaning of the numbers in a texture's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    /// Encoding of its format: linear in Radiance HDR and OpenEXR files, sRGB in others.
    Auto,
    Srgb,
    Linear,
}

impl TextureEntry {
    /// Keys of a `[[light]]` that describe its texture.
    pub(crate) const KEYS: [&'static str; 6] = [
        "texture",
        "texture_encoding",
        "texture_generator",
        "texture_frames",
        "texture_fps",
        "texture_stretch",
    ];

    /// Reads the keys of a light's texture, if it has one.
    pub(crate) fn read(section: &mut Section<'_>) -> Result<Option<Self>, SceneError> {
        let name = section.text("texture")?;
        let generator = section.text("texture_generator")?;
        let encoding = section.text("texture_encoding")?;
        let frames = section.number("texture_frames")?;
        let fps = section.number("texture_fps")?;
        let stretch = section.flag("texture_stretch")?;
        let (origin, line) = match (name, generator) {
            (None, None) => {
                let lines = [
                    encoding.map(|found| found.line),
                    frames.map(|found| found.line),
                    fps.map(|found| found.line),
                    stretch.map(|found| found.line),
                ];
                return match lines.into_iter().flatten().next() {
                    Some(line) => {
                        Err(section
                            .fault(line, "has no `texture`; write for example: texture = \"screen.png\""))
                    }
                    None => Ok(None),
                };
            }
            (Some(_), Some(generator)) => {
                let message = "has both a texture and a texture_generator; keep one of them";
                return Err(section.fault(generator.line, message));
            }
            (Some(name), None) => {
                if let Some(frames) = frames {
                    let message =
                        "texture_frames is of a texture_generator; frames of files are those that are there";
                    return Err(section.fault(frames.line, message));
                }
                (Origin::File { name: name.value, encoding: read_encoding(section, encoding)? }, name.line)
            }
            (None, Some(generator)) => {
                if let Some(encoding) = encoding {
                    let message = "texture_encoding is of a file; a texture_generator has none";
                    return Err(section.fault(encoding.line, message));
                }
                if !screen::PATTERNS.contains(&generator.value.as_str()) {
                    let known = screen::PATTERNS.join(", ");
                    let message =
                        format!("texture_generator is `{}`, expected one of {known}", generator.value);
                    return Err(section.fault(generator.line, message));
                }
                let count = frames.as_ref().map_or(1.0, |found| found.value);
                if let Some(found) = &frames
                    && !((1.0..=MAX_FRAMES as f32).contains(&count) && count.fract() == 0.0)
                {
                    let message =
                        format!("texture_frames is {count}, expected a whole number from 1 to {MAX_FRAMES}");
                    return Err(section.fault(found.line, message));
                }
                (Origin::Generated { pattern: generator.value, frames: count as u32 }, generator.line)
            }
        };
        if let Some(found) = fps.as_ref().filter(|found| found.value <= 0.0) {
            let message = format!("texture_fps is {}, expected frames a second above 0", found.value);
            return Err(section.fault(found.line, message));
        }
        Ok(Some(Self {
            origin,
            fps: fps.map_or(FPS, |found| found.value),
            stretch: stretch.is_some_and(|found| found.value),
            line,
        }))
    }

    /// Frames a second of a video; none for a single texture.
    pub(crate) fn video_fps(&self) -> Option<f32> {
        let moves = match &self.origin {
            Origin::File { name, .. } => name.contains('#'),
            Origin::Generated { frames, .. } => *frames > 1,
        };
        moves.then_some(self.fps)
    }

    /// Files of the texture, one for each frame of a video, none where it is generated; or why there are none.
    pub(crate) fn files(&self, folder: &Path) -> Result<Vec<PathBuf>, String> {
        match &self.origin {
            Origin::File { name, .. } if name.contains('#') => frames(name, folder),
            Origin::File { name, .. } => Ok(vec![folder.join(name)]),
            Origin::Generated { .. } => Ok(Vec::new()),
        }
    }

    /// Reads the textures of a light, one for each frame of a video.
    pub(crate) fn load(
        &self,
        light: &AreaLight,
        scene: Source<'_>,
        folder: &Path,
    ) -> Result<Vec<Arc<LightTexture>>, SceneError> {
        let fault = |message: String| scene.fault(self.line, format!("[[light]] {message}"));
        let (textures, name) = match &self.origin {
            Origin::File { name, encoding } => {
                (read_files(self.files(folder).map_err(fault)?, *encoding).map_err(fault)?, name)
            }
            Origin::Generated { pattern, frames } => (generated(pattern, *frames).map_err(fault)?, pattern),
        };
        if let Some(first) = textures.first().filter(|_| !self.stretch) {
            let frame = light.frame();
            let (texture, screen) =
                (first.width() as f32 / first.height() as f32, frame.u.length() / frame.v.length());
            if (texture / screen).max(screen / texture) > 1.0 + ASPECT {
                return Err(fault(format!(
                    "texture `{}` has {}x{} texels, {texture:.3} times as wide as high, but edge_u is {screen:.3} times as long as edge_v; \
                     change an edge, or write texture_stretch = true",
                    name,
                    first.width(),
                    first.height()
                )));
            }
        }
        Ok(textures)
    }
}

/// Reads the textures of files, one for each frame of a video, or says why it cannot.
fn read_files(files: Vec<PathBuf>, encoding: Encoding) -> Result<Vec<Arc<LightTexture>>, String> {
    let mut textures: Vec<Arc<LightTexture>> = Vec::with_capacity(files.len());
    let mut texels = 0;
    for file in files {
        let named = file.display().to_string();
        let texture =
            decode(&file, encoding, texels).map_err(|message| format!("texture `{named}` {message}"))?;
        texels += u64::from(texture.width()) * u64::from(texture.height());
        let size = |texture: &LightTexture| (texture.width(), texture.height());
        if let Some(first) = textures.first().filter(|first| size(first) != size(&texture)) {
            let ((w, h), (width, height)) = (size(&texture), size(first));
            return Err(format!(
                "texture `{named}` has {w}x{h} texels, expected {width}x{height} as in the first frame"
            ));
        }
        textures.push(Arc::new(texture));
    }
    Ok(textures)
}

/// Generates the textures of a pattern, one for each frame of a film.
fn generated(pattern: &str, frames: u32) -> Result<Vec<Arc<LightTexture>>, String> {
    let [width, height] = screen::SIZE;
    let texture = |frame| {
        let texels = screen::texels(pattern, frame, frames).unwrap_or_default();
        LightTexture::new(width, height, texels)
            .map(Arc::new)
            .map_err(|fault| format!("texture_generator `{pattern}`: {fault}"))
    };
    (0..frames).map(texture).collect()
}

/// Files of a video in the order of their numbers, which follow each other.
fn frames(name: &str, folder: &Path) -> Result<Vec<PathBuf>, String> {
    let (path, pattern) = (folder.join(name), name);
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let (Some(first), Some(last)) = (name.find('#'), name.rfind('#')) else {
        return Err(format!("texture `{pattern}` has # in the name of a folder, expected it in the file's"));
    };
    let (before, after, digits) = (&name[..first], &name[last + 1..], last + 1 - first);
    let parent = path.parent().unwrap_or(folder);
    let listed = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    let number = |found: &str| -> Option<u64> {
        let middle = found.strip_prefix(before)?.strip_suffix(after)?;
        let whole = middle.len() >= digits && middle.bytes().all(|byte| byte.is_ascii_digit());
        whole.then(|| middle.parse().ok()).flatten()
    };
    let names = fs::read_dir(listed).into_iter().flatten().flatten();
    let mut frames: Vec<(u64, PathBuf)> = names
        .filter_map(|entry| Some((number(&entry.file_name().to_string_lossy())?, entry.path())))
        .collect();
    frames.sort();
    if frames.is_empty() {
        return Err(format!("texture `{}`: there is no such file for any number", path.display()));
    }
    if let Some(pair) = frames.windows(2).find(|pair| pair[1].0 != pair[0].0 + 1) {
        return Err(format!("texture `{}` lacks frame {}", path.display(), pair[0].0 + 1));
    }
    Ok(frames.into_iter().map(|(_, path)| path).collect())
}

/// Reads one texture; `before` texels have been read already.
fn decode(path: &Path, encoding: Encoding, before: u64) -> Result<LightTexture, String> {
    let reader = ImageReader::open(path).map_err(|fault| match fault.kind() {
        std::io::ErrorKind::NotFound => "is missing; paths are relative to the scene file".to_string(),
        _ => format!("cannot be read: {fault}"),
    })?;
    let mut reader = reader.with_guessed_format().map_err(|fault| format!("cannot be read: {fault}"))?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(16 * MAX_TEXELS);
    reader.limits(limits);
    let texture = reader.decode().map_err(|fault| match fault {
        ImageError::Unsupported(_) => {
            "cannot be read: it is no PNG, JPEG, TGA, BMP, Radiance HDR or OpenEXR image".to_owned()
        }
        other => format!("cannot be read: {other}"),
    })?;
    let (width, height) = (texture.width(), texture.height());
    if before + u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(format!("is too large: the textures of a light may have {MAX_TEXELS} texels in all"));
    }
    let floats = matches!(texture, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let linear = encoding == Encoding::Linear || floats && encoding == Encoding::Auto;
    let decode = |texel: [f32; 3]| Vec3::from_array(if linear { texel } else { texel.map(srgb_to_linear) });
    let texels: Vec<Vec3> = if floats {
        texture.into_rgb32f().pixels().map(|texel| decode(texel.0)).collect()
    } else {
        let scale = |texel: &image::Rgb<u16>| decode(texel.0.map(|value| f32::from(value) / 65535.0));
        texture.into_rgb16().pixels().map(scale).collect()
    };
    LightTexture::new(width, height, texels).map_err(|fault| format!("cannot be used: {fault}"))
}

/// Reads the key `texture_encoding`.
fn read_encoding(section: &Section<'_>, found: Option<Found<String>>) -> Result<Encoding, SceneError> {
    let Some(Found { value, line }) = found else { return Ok(Encoding::Auto) };
    match value.as_str() {
        "auto" => Ok(Encoding::Auto),
        "srgb" => Ok(Encoding::Srgb),
        "linear" => Ok(Encoding::Linear),
        other => {
            let message = format!("texture_encoding is `{other}`, expected auto, srgb or linear");
            Err(section.fault(line, message))
        }
    }
}

/// Linear value of an sRGB one (IEC 61966-2-1).
fn srgb_to_linear(value: f32) -> f32 {
    let value = f64::from(value);
    (if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }) as f32
}
