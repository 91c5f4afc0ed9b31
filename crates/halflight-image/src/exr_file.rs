//! OpenEXR files with all layers of a frame.
//!
//! Channels are named as OpenEXR defines layers: `irradiance.R`, `depth.Z`. `R`, `G`, `B` without a layer's name are the
//! default layer, which every program shows: the radiance in files of Halflight. All channels are written as 32-bit floats,
//! losslessly compressed. The header has the attribute [`METADATA`], a JSON object that tells how the image was made.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;

use crate::picture;

pub use read::ReadError;

mod read;
mod write;

/// Name of the header attribute that holds the metadata.
pub const METADATA: &str = "halflight";

/// Channels of a colour layer.
pub const RGB: [&str; 3] = ["R", "G", "B"];

/// Channels of a layer of vectors.
pub const XYZ: [&str; 3] = ["X", "Y", "Z"];

/// Name of the default layer, whose channels have no layer's name before theirs.
pub const DEFAULT_LAYER: &str = "";

/// Name of the layer of visible fractions of the light.
pub const VISIBILITY: &str = "visibility";

/// Name of the layer of radiance that indirect light causes.
pub const INDIRECT: &str = "indirect";

/// Name of the layer of indirect irradiance.
pub const INDIRECT_IRRADIANCE: &str = "indirect_irradiance";

/// Rectangle of pixels in the coordinates that all OpenEXR windows share; pixel (0, 0) need not be the first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Window {
    /// First column.
    pub x: i64,
    /// First row.
    pub y: i64,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Window {
    /// Returns whether all pixels of `other` lie in this window.
    pub fn contains(&self, other: &Self) -> bool {
        let within = |first: i64, size: u32, other_first: i64, other_size: u32| {
            first <= other_first && other_first + i64::from(other_size) <= first + i64::from(size)
        };
        within(self.x, self.width, other.x, other.width) && within(self.y, self.height, other.y, other.height)
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { x, y, width, height } = self;
        write!(f, "{width}×{height} pixels from ({x}, {y})")
    }
}

/// Image of named channels, all of one size. Each channel has width · height values, row by row from the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrFile {
    /// File that the image was read from; empty for one made in memory.
    pub path: PathBuf,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Column and row of the first pixel, where the data window begins.
    pub position: [i64; 2],
    /// Frame in which the image is shown. The data window may cover a part of it, or more.
    pub display: Window,
    /// Values by full name, such as `irradiance.R`.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// Name of the layer that programs show which know no layers: [`DEFAULT_LAYER`], or the name of the first part with
    /// colours where channels of the default layer are missing.
    pub shown_layer: String,
    /// Names of the parts of the file that were not read, since their data windows differ from the others'.
    pub left_out: Vec<String>,
    /// JSON object with the scene and configuration that made the image; null where the file has none.
    pub metadata: serde_json::Value,
}

impl ExrFile {
    /// Returns an image of `width` × `height` pixels without channels.
    pub fn new(width: u32, height: u32, metadata: serde_json::Value) -> Self {
        let display = Window { width, height, ..Window::default() };
        Self { width, height, display, metadata, ..Self::default() }
    }

    /// Adds a layer of three channels, named [`RGB`] or [`XYZ`]; `values` has one vector a pixel.
    pub fn add_vectors(&mut self, layer: &str, names: [&str; 3], values: &[Vec3]) {
        for (axis, name) in names.into_iter().enumerate() {
            self.channels.insert(full_name(layer, name), values.iter().map(|value| value[axis]).collect());
        }
    }

    /// Adds a layer of one channel; `values` has one value a pixel.
    pub fn add_plane(&mut self, layer: &str, name: &str, values: Vec<f32>) {
        self.channels.insert(full_name(layer, name), values);
    }

    /// Adds the layers `irradiance` (W/m²) and `radiance` (albedo/π · irradiance, W/m²/sr). The radiance is the default layer
    /// as well.
    pub fn add_light(&mut self, irradiance: &[Vec3], albedo: &[Vec3]) {
        self.add_resolved_light(irradiance, &picture::radiance(irradiance, albedo));
    }

    /// Adds the layers that [`ExrFile::add_light`] adds, from a radiance that does not follow from the pixels' albedos: the mean over
    /// sub-samples.
    pub fn add_resolved_light(&mut self, irradiance: &[Vec3], radiance: &[Vec3]) {
        self.add_vectors("irradiance", RGB, irradiance);
        self.add_vectors("radiance", RGB, radiance);
        self.add_vectors(DEFAULT_LAYER, RGB, radiance);
    }

    /// Adds the parts of the radiance, W/m²/sr: the layers `diffuse` and `specular` of light that is reflected at pixels' centres, and `emission` of lights that
    /// are seen, each where there is any.
    pub fn add_parts(&mut self, diffuse: &[Vec3], specular: &[Vec3], emission: &[Vec3]) {
        for (layer, values) in [("diffuse", diffuse), ("specular", specular), ("emission", emission)] {
            if !values.is_empty() {
                self.add_vectors(layer, RGB, values);
            }
        }
    }

    /// Adds the layers of indirect light: `direct` and `indirect`, the radiance albedo/π · irradiance of either (W/m²/sr), and
    /// [`INDIRECT_IRRADIANCE`] (W/m²). All three are of pixels' centres; `irradiance` and `indirect` have one value a pixel.
    pub fn add_indirect(&mut self, irradiance: &[Vec3], indirect: &[Vec3], albedo: &[Vec3]) {
        self.add_vectors("direct", RGB, &picture::radiance(irradiance, albedo));
        self.add_vectors(INDIRECT, RGB, &picture::radiance(indirect, albedo));
        self.add_vectors(INDIRECT_IRRADIANCE, RGB, indirect);
    }

    /// Adds the layer [`VISIBILITY`] of visible fractions of the light, 0 … 1, in three equal channels.
    pub fn add_visibility(&mut self, fractions: &[f32]) {
        let channels: Vec<Vec3> = fractions.iter().map(|&fraction| Vec3::splat(fraction)).collect();
        self.add_vectors(VISIBILITY, RGB, &channels);
    }

    /// Adds the surface that each pixel sees: the layers `albedo` (0 … 1), `normal` (geometric, unit length, world space), `shading_normal` (of scenes
    /// with smooth surfaces), `position`
    /// (world space, m) and `depth.Z` (m), which is infinite where nothing is seen.
    pub fn add_geometry(&mut self, gbuffer: &GBuffer) {
        self.add_vectors("albedo", RGB, &gbuffer.albedo);
        self.add_vectors("normal", XYZ, &gbuffer.normal);
        if !gbuffer.shading.is_empty() {
            self.add_vectors("shading_normal", XYZ, &gbuffer.shading);
        }
        self.add_vectors("position", XYZ, &gbuffer.position);
        self.add_plane("depth", "Z", gbuffer.depth.clone());
    }

    /// Returns the values of a layer of three channels, one vector a pixel.
    ///
    /// # Errors
    /// [`ReadError::Layer`] where one of the channels is missing.
    pub fn vectors(&self, layer: &str, names: [&str; 3]) -> Result<Vec<Vec3>, ReadError> {
        let [x, y, z] = names.map(|name| self.channels.get(&full_name(layer, name)));
        let (Some(x), Some(y), Some(z)) = (x, y, z) else { return Err(self.missing(layer, &names)) };
        Ok(x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Vec3::new(x, y, z)).collect())
    }

    /// Returns the values of a layer of any kind, one vector a pixel: three channels `R`, `G`, `B` or `X`, `Y`, `Z`, or else
    /// a single channel, whose value all three components take.
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

    /// Returns the values of one channel.
    ///
    /// # Errors
    /// [`ReadError::Layer`] where the channel is missing.
    pub fn plane(&self, layer: &str, name: &str) -> Result<&[f32], ReadError> {
        let values = self.channels.get(&full_name(layer, name));
        values.map(Vec::as_slice).ok_or_else(|| self.missing(layer, &[name]))
    }

    /// Returns the data window: the pixels that the channels hold.
    pub fn window(&self) -> Window {
        let [x, y] = self.position;
        Window { x, y, width: self.width, height: self.height }
    }

    /// Returns the part of a channel's or a layer's `values` that lies in a window which the data window contains.
    pub fn crop<T: Copy>(&self, values: &[T], window: &Window) -> Vec<T> {
        let [x, y] =
            [window.x - self.position[0], window.y - self.position[1]].map(|first| first.max(0) as usize);
        let rows = values.chunks(self.width.max(1) as usize).skip(y).take(window.height as usize);
        rows.flat_map(|row| row.iter().skip(x).take(window.width as usize)).copied().collect()
    }

    fn missing(&self, layer: &str, names: &[&str]) -> ReadError {
        let left_out =
            self.left_out.iter().map(|part| format!("part `{part}` of another data window, not read"));
        ReadError::Layer {
            path: self.path.clone(),
            layer: layer_in_words(layer),
            wanted: names.join(", "),
            found: self.channels.keys().cloned().chain(left_out).collect(),
        }
    }
}

/// Returns a layer's name for messages.
pub fn layer_in_words(layer: &str) -> String {
    if layer == DEFAULT_LAYER { "default layer".to_owned() } else { format!("layer `{layer}`") }
}

/// Returns a channel's name in a file.
fn full_name(layer: &str, name: &str) -> String {
    if layer == DEFAULT_LAYER { name.to_owned() } else { format!("{layer}.{name}") }
}
