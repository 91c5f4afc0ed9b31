//! Alpha masks of a mesh: where its scene file takes them from, and which texels are solid.

use std::path::{Path, PathBuf};

use halflight_core::alpha::{AlphaMask, DEFAULT_CUTOFF};
use halflight_core::scene::{Mesh, Texture};

use crate::context::{AlphaImage, AlphaOrigin, Context};
use crate::error::SceneError;
use crate::folders::shown;
use crate::section::Section;
use crate::text::{self, forms};
use crate::texture::read;

/// Alpha masks that a `[[mesh]]` asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AlphaChoice {
    pub(crate) source: AlphaSource,
    /// Alpha from which on a texel is solid.
    pub(crate) cutoff: f32,
}

/// Image whose alpha is a mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AlphaSource {
    /// No image: all is solid.
    Nothing,
    /// The one that a material names as its mask.
    Map,
    /// Mask of the material, or else the material's texture.
    Albedo,
}

impl AlphaChoice {
    /// Keys of a `[[mesh]]`.
    pub(crate) const KEYS: [&'static str; 2] = ["alpha", "alpha_cutoff"];

    /// Reads the keys; `own_materials` is false where the mesh has no materials that could have masks.
    pub(crate) fn read(section: &mut Section<'_>, own_materials: bool) -> Result<Self, SceneError> {
        let word = section.text("alpha")?;
        let source = match word.as_ref().map(|word| word.value.as_str()) {
            None | Some("map_d") => AlphaSource::Map,
            Some("none") => AlphaSource::Nothing,
            Some("albedo") => AlphaSource::Albedo,
            Some(other) => {
                let message = format!("alpha is \"{other}\", expected \"map_d\", \"albedo\" or \"none\"");
                return Err(section.fault(word.map_or(section.line, |word| word.line), message));
            }
        };
        let cutoff = section.number("alpha_cutoff")?;
        if let Some(cutoff) = &cutoff {
            if !(0.0..=1.0).contains(&cutoff.value) {
                let message = format!("alpha_cutoff is {}, expected a number from 0 to 1", cutoff.value);
                return Err(section.fault(cutoff.line, message));
            }
            if source == AlphaSource::Nothing {
                let message = "alpha_cutoff is for alpha masks; remove it, or alpha = \"none\"";
                return Err(section.fault(cutoff.line, message));
            }
        }
        let line = word.map(|word| word.line).or(cutoff.as_ref().map(|cutoff| cutoff.line));
        match line {
            Some(line) if !own_materials => {
                let message =
                    "alpha and alpha_cutoff are for the materials of a file, without albedo; remove them";
                Err(section.fault(line, format!("has no materials of its own: {message}")))
            }
            _ => Ok(Self { source, cutoff: cutoff.map_or(DEFAULT_CUTOFF, |cutoff| cutoff.value) }),
        }
    }

    /// Replaces the alpha images of a mesh's materials by the masks of the choice. Materials whose image has no hole get none.
    pub(crate) fn apply(self, mesh: &mut Mesh, context: &mut Context) {
        for material in &mut mesh.materials {
            let image = material.alpha_mask.take().map(AlphaOrigin::Map);
            let transparent =
                material.texture.filter(|texture| context.textures.transparent.contains_key(texture));
            let origin = match self.source {
                AlphaSource::Nothing => None,
                AlphaSource::Map => image,
                AlphaSource::Albedo => image.or(transparent.map(AlphaOrigin::Albedo)),
            };
            material.alpha_mask = origin.and_then(|origin| mask(origin, self.cutoff, context));
            if let Some(texture) = transparent
                && origin.is_none()
                && self.source != AlphaSource::Nothing
            {
                let path = context.textures.transparent[&texture].display();
                context.warn(format!(
                    "texture {path} is transparent in places; it is taken as opaque: alpha = \"albedo\" makes it a mask"
                ));
            }
        }
    }
}

/// Index of the mask of an image, made once for each cutoff.
fn mask(origin: AlphaOrigin, cutoff: f32, context: &mut Context) -> Option<u32> {
    let Context { alpha, textures, .. } = context;
    let key = (origin, cutoff.to_bits());
    if let Some(&known) = alpha.known.get(&key) {
        return known;
    }
    let mask = match origin {
        AlphaOrigin::Map(image) => {
            let AlphaImage { width, height, alpha } = &alpha.images[image as usize];
            AlphaMask::new(*width, *height, alpha.iter().copied(), cutoff)
        }
        AlphaOrigin::Albedo(texture) => {
            let Texture { width, height, texels } = &textures.textures[texture as usize];
            AlphaMask::new(*width, *height, texels.iter().map(|texel| texel[3]), cutoff)
        }
    };
    let index = mask.ok().filter(|mask| !mask.is_opaque()).map(|mask| {
        alpha.masks.push(mask);
        (alpha.masks.len() - 1) as u32
    });
    alpha.known.insert(key, index);
    index
}

/// Index of the alpha image at `found`; `None`, with a warning that begins with the `place` of the name, if nothing was found under `name` in
/// `folder` or it cannot be decoded.
pub(crate) fn load(
    folder: &Path,
    name: &[u8],
    found: Option<PathBuf>,
    place: &str,
    context: &mut Context,
) -> Option<u32> {
    let Some(path) = found else {
        let name = text::shown(forms(name).last().copied().unwrap_or(name));
        let message = format!("alpha mask `{name}` is missing in {}; all is opaque", shown(folder));
        context.warn_at(place, &message);
        return None;
    };
    if let Some(&known) = context.alpha.by_path.get(&path) {
        return known;
    }
    // Most files are the texture of the same material.
    let texture = context.textures.by_path.get(&path).copied().flatten();
    let image = match texture {
        Some(texture) => Ok(alpha_of(&context.textures.textures[texture as usize])),
        None => read(&path).map(|texture| alpha_of(&texture)),
    };
    let index = match image {
        Ok(image) => {
            context.alpha.images.push(image);
            Some((context.alpha.images.len() - 1) as u32)
        }
        Err(fault) => {
            let path = path.display();
            context.warn_at(place, &format!("alpha mask {path} cannot be read ({fault}); all is opaque"));
            None
        }
    };
    context.alpha.by_path.insert(path, index);
    index
}

/// Alpha of an image; luminance where its alpha is 255 everywhere.
fn alpha_of(image: &Texture) -> AlphaImage {
    let Texture { width, height, texels } = image;
    let opaque = texels.iter().all(|texel| texel[3] == 255);
    let alpha = |&[r, g, b, alpha]: &[u8; 4]| {
        // ITU-R BT.709; a grey is its own luminance.
        let luminance = (u32::from(r) * 2126 + u32::from(g) * 7152 + u32::from(b) * 722 + 5000) / 10_000;
        if opaque { luminance as u8 } else { alpha }
    };
    AlphaImage { width: *width, height: *height, alpha: texels.iter().map(alpha).collect() }
}
