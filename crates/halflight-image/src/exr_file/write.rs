//! Writing of OpenEXR files.

use std::io;
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, WritableImage,
};
use halflight_metrics::{WriteError, write_file};

use super::{ExrFile, METADATA};

/// Name of the program in the header.
const SOFTWARE: &str = concat!("halflight ", env!("CARGO_PKG_VERSION"));

impl ExrFile {
    /// Writes the image to a file, a pipe or standard output; see [`write_file`] for what `path` may be. Position and display
    /// window are not kept: the first pixel is (0, 0).
    ///
    /// # Errors
    /// [`WriteError`] where a channel has not width · height values, or the file cannot be written.
    pub fn write(self, path: &Path) -> Result<(), WriteError> {
        let content = self.encode().map_err(|source| WriteError { path: path.to_owned(), source })?;
        write_file(path, &content)
    }

    /// Returns the file's bytes.
    fn encode(self) -> io::Result<Vec<u8>> {
        let pixels = self.width as usize * self.height as usize;
        let metadata = AttributeValue::Text(text(&ascii_json(&self.metadata))?);
        let mut list = SmallVec::new();
        for (name, values) in self.channels {
            if values.len() != pixels {
                let message = format!("channel {name} has {} values for {pixels} pixels", values.len());
                return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
            }
            list.push(AnyChannel::new(text(&name)?, FlatSamples::F32(values)));
        }
        let software_name = Some(text(SOFTWARE)?);
        let mut attributes = LayerAttributes { software_name, ..LayerAttributes::default() };
        // One attribute: several would be written in random order, and equal images would not be equal files.
        attributes.other.insert(text(METADATA)?, metadata);
        let size = (self.width as usize, self.height as usize);
        let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list));
        let mut content = io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut content).map_err(io::Error::other)?;
        Ok(content.into_inner())
    }
}

/// Text for a header, which is Latin-1.
fn text(value: &str) -> io::Result<Text> {
    Text::new_or_none(value)
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, format!("{value:?} is not Latin-1 text")))
}

/// Returns JSON in ASCII alone. Other characters can only lie in strings, where they are replaced by escapes.
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
