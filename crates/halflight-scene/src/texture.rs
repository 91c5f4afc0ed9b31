//! Albedo textures: found regardless of the case of their names, stored in sRGB.

use std::path::{Path, PathBuf};

use halflight_core::scene::Texture;
use image::{ColorType, ImageDecoder, ImageError, ImageReader, Limits};

use crate::context::Context;
use crate::folders::{path_of, shown};
use crate::text::{self, forms};

/// Most texels of an image, 16384 × 16384: a gigabyte.
const MAX_TEXELS: u64 = 1 << 28;

/// Finds the texture that a file in `folder` calls `name`, possibly with quotation marks or a comment.
pub(crate) fn find(folder: &Path, name: &[u8], context: &mut Context) -> Option<PathBuf> {
    let key = (folder.to_path_buf(), name.to_vec());
    if let Some(known) = context.textures.by_name.get(&key) {
        return known.clone();
    }
    let found = forms(name).into_iter().find_map(|name| {
        let name = path_of(name);
        let last = Path::new(name.file_name()?);
        // As named, then by its last component only, beside the library and in `textures/`.
        [
            name.clone(),
            last.to_path_buf(),
            Path::new("textures").join(&name),
            Path::new("textures").join(last),
        ]
        .iter()
        .find_map(|candidate| context.folders.find(folder, candidate))
    });
    context.textures.by_name.insert(key, found.clone());
    found
}

/// Index of the texture at `found`; `None`, with a warning that begins with the `place` of the name, if nothing was found under `name` in
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
        let message = format!("texture `{name}` is missing in {}; its colour is used alone", shown(folder));
        context.warn_at(place, &message);
        return None;
    };
    if let Some(&known) = context.textures.by_path.get(&path) {
        return known;
    }
    let index = match read(&path) {
        Ok(texture) => {
            let index = context.textures.textures.len() as u32;
            if texture.texels.iter().any(|texel| texel[3] != 255) {
                context.textures.transparent.insert(index, path.clone());
            }
            context.textures.textures.push(texture);
            Some(index)
        }
        Err(fault) => {
            let path = path.display();
            context.warn_at(
                place,
                &format!("texture {path} cannot be read ({fault}); its colour is used alone"),
            );
            None
        }
    };
    context.textures.by_path.insert(path, index);
    index
}

/// Decodes an image in the memory of its texels; one of 16 bits per channel temporarily needs twice that.
pub(crate) fn read(path: &Path) -> Result<Texture, String> {
    let fault = |fault: ImageError| match fault {
        ImageError::Unsupported(_) => "it is no PNG, JPEG, TGA or BMP image".to_owned(),
        other => other.to_string(),
    };
    let mut reader = ImageReader::open(path)
        .and_then(ImageReader::with_guessed_format)
        .map_err(|fault| fault.to_string())?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(8 * MAX_TEXELS);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(fault)?;
    let (width, height) = decoder.dimensions();
    let count = u64::from(width) * u64::from(height);
    if count > MAX_TEXELS {
        let side = MAX_TEXELS.isqrt();
        return Err(format!(
            "{width} x {height} texels, more than the limit of {MAX_TEXELS}, {side} x {side}"
        ));
    }
    let count = count as usize;
    let colour = decoder.color_type();
    let channels: fn(&[u8]) -> [u8; 4] = match colour {
        ColorType::L8 => |texel| [texel[0], texel[0], texel[0], 255],
        ColorType::La8 => |texel| [texel[0], texel[0], texel[0], texel[1]],
        ColorType::Rgb8 => |texel| [texel[0], texel[1], texel[2], 255],
        ColorType::Rgba8 => |texel| [texel[0], texel[1], texel[2], texel[3]],
        ColorType::L16 => |texel| [high(texel, 0), high(texel, 0), high(texel, 0), 255],
        ColorType::La16 => |texel| [high(texel, 0), high(texel, 0), high(texel, 0), high(texel, 1)],
        ColorType::Rgb16 => |texel| [high(texel, 0), high(texel, 1), high(texel, 2), 255],
        ColorType::Rgba16 => |texel| [high(texel, 0), high(texel, 1), high(texel, 2), high(texel, 3)],
        other => return Err(format!("texels of the kind {other:?} are not supported")),
    };
    let size = usize::from(colour.bytes_per_pixel());
    let mut texels = vec![[0; 4]; count * size.div_ceil(4)];
    let bytes = texels.as_flattened_mut();
    decoder.read_image(&mut bytes[..count * size]).map_err(fault)?;
    let convert = |at: usize| {
        let texel = channels(&bytes[at * size..(at + 1) * size]);
        bytes[4 * at..4 * at + 4].copy_from_slice(&texel);
    };
    // In place: wide texels from the front and narrow ones from the back overwrite only texels that have been
    // read.
    if size > 4 {
        (0..count).for_each(convert);
    } else {
        (0..count).rev().for_each(convert);
    }
    texels.truncate(count);
    texels.shrink_to_fit();
    Ok(Texture { width, height, texels })
}

/// A channel of 16 bits, rounded to 8.
fn high(texel: &[u8], channel: usize) -> u8 {
    let value = u16::from_ne_bytes([texel[2 * channel], texel[2 * channel + 1]]);
    ((u32::from(value) + 128) / 257) as u8
}
