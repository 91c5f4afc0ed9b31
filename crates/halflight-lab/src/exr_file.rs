//! Images with all their layers in one OpenEXR file.
//!
//! Channels are named the way OpenEXR defines layers: `irradiance.R`, `depth.Z`. All are 32-bit floats, losslessly
//! compressed; the standard viewers show each layer under its name. What the image was made with is in the header, as
//! a JSON object in the attribute [`METADATA`].

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels, ReadLayers,
    SmallVec, WritableImage,
};
use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_metrics::{WriteError, write_atomically};

/// Name of the header attribute that holds the metadata.
pub const METADATA: &str = "halflight";

/// Channels of a colour layer.
pub const RGB: [&str; 3] = ["R", "G", "B"];

/// Channels of a layer of vectors.
pub const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// Why an image file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened.
    #[error("cannot read {}: {source}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file is not an OpenEXR image, is cut off, or is of a kind that is not supported (deep data).
    #[error("{} is not a complete OpenEXR image: {message}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// The layer is not in the file.
    #[error("{} has no layer `{layer}` with channels {wanted}; it has {}", path.display(), found.join(", "))]
    Layer {
        /// The file.
        path: PathBuf,
        /// The layer asked for.
        layer: String,
        /// Its channels.
        wanted: String,
        /// All channels of the file by their full names.
        found: Vec<String>,
    },
}

/// An image of named channels, all of one size, rows from the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrFile {
    /// Where it was read from; empty for one made in memory.
    pub path: PathBuf,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Values by full name, `irradiance.R`.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// What the image was made with; null where the file does not say.
    pub metadata: serde_json::Value,
}

impl ExrFile {
    /// An image without channels.
    pub fn new(width: u32, height: u32, metadata: serde_json::Value) -> Self {
        Self { width, height, metadata, ..Self::default() }
    }

    /// Adds a layer of three channels ([`RGB`] or [`XYZ`]).
    pub fn add_vectors(&mut self, layer: &str, names: [&str; 3], values: &[Vec3]) {
        for (axis, name) in names.into_iter().enumerate() {
            self.channels.insert(format!("{layer}.{name}"), values.iter().map(|value| value[axis]).collect());
        }
    }

    /// Adds a layer of one channel.
    pub fn add_plane(&mut self, layer: &str, name: &str, values: Vec<f32>) {
        self.channels.insert(format!("{layer}.{name}"), values);
    }

    /// Adds `irradiance` and `radiance` (albedo/π times irradiance, W/m²/sr).
    pub fn add_light(&mut self, irradiance: &[Vec3], albedo: &[Vec3]) {
        self.add_vectors("irradiance", RGB, irradiance);
        let radiance: Vec<Vec3> = crate::picture::radiance(irradiance, albedo);
        self.add_vectors("radiance", RGB, &radiance);
    }

    /// Adds what each pixel sees: `albedo`, `normal`, `position`, and `depth.Z`, which is infinite where nothing is
    /// seen.
    pub fn add_geometry(&mut self, gbuffer: &GBuffer) {
        self.add_vectors("albedo", RGB, &gbuffer.albedo);
        self.add_vectors("normal", XYZ, &gbuffer.normal);
        self.add_vectors("position", XYZ, &gbuffer.position);
        self.add_plane("depth", "Z", gbuffer.depth.clone());
    }

    /// The values of a layer of three channels.
    ///
    /// # Errors
    /// [`ReadError::Layer`] where one of them is missing.
    pub fn vectors(&self, layer: &str, names: [&str; 3]) -> Result<Vec<Vec3>, ReadError> {
        let [x, y, z] = names.map(|name| self.channels.get(&format!("{layer}.{name}")));
        let (Some(x), Some(y), Some(z)) = (x, y, z) else { return Err(self.missing(layer, &names)) };
        Ok(x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Vec3::new(x, y, z)).collect())
    }

    /// The values of a layer of any kind as vectors: three channels `R`, `G`, `B` or `X`, `Y`, `Z`, or else a single
    /// one, whose values all three take.
    ///
    /// # Errors
    /// [`ReadError::Layer`] where there is no such layer.
    pub fn layer(&self, layer: &str) -> Result<Vec<Vec3>, ReadError> {
        if let Ok(values) = self.vectors(layer, RGB).or_else(|_| self.vectors(layer, XYZ)) {
            return Ok(values);
        }
        let single = ["Y", "Z"].into_iter().find_map(|name| self.plane(layer, name).ok());
        let values = single.ok_or_else(|| self.missing(layer, &RGB))?;
        Ok(values.iter().map(|&value| Vec3::splat(value)).collect())
    }

    /// The values of one channel.
    ///
    /// # Errors
    /// [`ReadError::Layer`] where it is missing.
    pub fn plane(&self, layer: &str, name: &str) -> Result<&[f32], ReadError> {
        let values = self.channels.get(&format!("{layer}.{name}"));
        values.map(Vec::as_slice).ok_or_else(|| self.missing(layer, &[name]))
    }

    fn missing(&self, layer: &str, names: &[&str]) -> ReadError {
        ReadError::Layer {
            path: self.path.clone(),
            layer: layer.to_owned(),
            wanted: names.join(", "),
            found: self.channels.keys().cloned().collect(),
        }
    }

    /// Writes the image, whole or not at all.
    ///
    /// # Errors
    /// [`WriteError`] where a channel has the wrong size or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        write_atomically(path, |file| {
            let pixels = self.width as usize * self.height as usize;
            let mut list = SmallVec::new();
            for (name, values) in &self.channels {
                if values.len() != pixels {
                    let message = format!("channel {name} has {} values for {pixels} pixels", values.len());
                    return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
                }
                list.push(AnyChannel::new(text(name)?, FlatSamples::F32(values.clone())));
            }
            let software_name = Some(text(crate::PROGRAM)?);
            let mut attributes = LayerAttributes { software_name, ..LayerAttributes::default() };
            // One attribute: several would be written in random order, and equal images would not be equal files.
            let metadata = AttributeValue::Text(text(&ascii_json(&self.metadata))?);
            attributes.other.insert(text(METADATA)?, metadata);
            let size = (self.width as usize, self.height as usize);
            let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list));
            Image::from_layer(layer).write().to_buffered(file).map_err(io::Error::other)
        })
    }
}

/// Reads all channels of an image at full size, of whatever number format.
///
/// # Errors
/// The file cannot be opened, is no OpenEXR image, or is cut off.
pub fn read(path: &Path) -> Result<ExrFile, ReadError> {
    let open = |source| ReadError::Open { path: path.to_owned(), source };
    let format = |message: String| ReadError::Format { path: path.to_owned(), message };
    // Read as a whole first: the file system's own errors are told apart from faults of the format.
    let bytes = std::fs::read(path).map_err(open)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(io::Cursor::new(bytes))
        .map_err(|error| format(error.to_string()))?;
    let Some(first) = image.layer_data.first() else { return Err(format("it has no layers".to_owned())) };
    let (width, height) = (first.size.x(), first.size.y());
    let mut file = ExrFile { path: path.to_owned(), ..ExrFile::default() };
    file.width = u32::try_from(width).map_err(|error| format(error.to_string()))?;
    file.height = u32::try_from(height).map_err(|error| format(error.to_string()))?;
    let mut attributes = image.attributes.other.iter().chain(&first.attributes.other);
    if let Some((_, AttributeValue::Text(json))) = attributes.find(|(name, _)| **name == *METADATA) {
        file.metadata = serde_json::from_str(&json.to_string()).unwrap_or_default();
    }
    for layer in image.layer_data {
        if (layer.size.x(), layer.size.y()) != (width, height) {
            return Err(format("its layers differ in size".to_owned()));
        }
        let prefix = layer.attributes.layer_name.as_ref().map(|name| format!("{name}."));
        for channel in layer.channel_data.list {
            let name = format!("{}{}", prefix.as_deref().unwrap_or_default(), channel.name);
            let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
            // Subsampled channels have fewer.
            if values.len() == width * height {
                file.channels.insert(name, values);
            }
        }
    }
    Ok(file)
}

/// Text for a header, which is Latin-1.
fn text(value: &str) -> io::Result<Text> {
    Text::new_or_none(value)
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, format!("{value:?} is not Latin-1 text")))
}

/// JSON in ASCII alone: whatever is beyond it can only lie in strings, where an escape means the same.
fn ascii_json(value: &serde_json::Value) -> String {
    let mut out = String::new();
    for character in value.to_string().chars() {
        if character.is_ascii() {
            out.push(character);
        } else {
            let mut units = [0; 2];
            for unit in character.encode_utf16(&mut units) {
                out.push_str(&format!("\\u{unit:04x}"));
            }
        }
    }
    out
}
