//! Reading of OpenEXR files of any program.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, ChannelDescription, IntegerBounds, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::{AnyChannels, FlatSamples, Image, Layers, ReadChannels, ReadLayers};

use super::{DEFAULT_LAYER, ExrFile, METADATA, RGB, Window, full_name};
use crate::memory::{self, NotEnough};

/// Reason why an image file or one of its layers cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened.
    #[error("cannot read {}: {source}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file is not an OpenEXR image, or is cut off.
    #[error("{} is not a complete OpenEXR image: {message}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Fault of the format.
        message: String,
    },
    /// The file is an OpenEXR image of a kind that cannot be read: deep data, subsampled channels, rare compressions.
    #[error("{} cannot be read: {message}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Feature that is not supported.
        message: String,
    },
    /// The pixels do not fit into memory.
    #[error("{}: {source}", path.display())]
    Memory {
        /// The file.
        path: PathBuf,
        /// Bytes needed and available.
        source: NotEnough,
    },
    /// The layer is not in the file.
    #[error("{} has no {layer} with channels {wanted}; it has {}", path.display(), found.join(", "))]
    Layer {
        /// The file.
        path: PathBuf,
        /// The layer asked for, in words.
        layer: String,
        /// Channels of such a layer.
        wanted: String,
        /// Full names of all channels of the file.
        found: Vec<String>,
    },
}

/// First bytes of an OpenEXR file.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// First bytes of other pictures that may be given by mistake.
const OTHERS: [(&[u8], &str); 8] = [
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"#?", "a Radiance HDR picture"),
    (b"PF\n", "a PFM picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"GIF8", "a GIF picture"),
    (b"BM", "a BMP picture"),
];

impl ExrFile {
    /// Reads all channels of an image at full size, of whatever number format: scan lines or tiles, one part or several.
    ///
    /// Parts whose data window differs from the data window of the part that is shown are left out.
    ///
    /// # Errors
    /// The file cannot be opened, is no OpenEXR image, is cut off, or does not fit into memory.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let format = |message: String| ReadError::Format { path: path.to_owned(), message };
        let bytes = load(path)?;
        let fault = |error: exr::error::Error| match error {
            exr::error::Error::NotSupported(_) => {
                ReadError::Unsupported { path: path.to_owned(), message: error.to_string() }
            }
            other => format(other.to_string()),
        };
        let meta = MetaData::read_from_buffered(bytes.as_slice(), false).map_err(fault)?;
        let sizes = meta.headers.iter().map(|header| (header.layer_size.x(), header.layer_size.y()));
        let (width, height) = sizes.max().unwrap_or_default();
        memory::check(format!("an image of {width}x{height} pixels"), needed(&meta))
            .map_err(|source| ReadError::Memory { path: path.to_owned(), source })?;
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(io::Cursor::new(bytes))
            .map_err(fault)?;
        let mut file = from_parts(image).map_err(format)?;
        path.clone_into(&mut file.path);
        Ok(file)
    }
}

/// Returns the bytes of a file that begins as OpenEXR files do. Errors of the file system are told apart from faults of the
/// format by reading the whole file first.
fn load(path: &Path) -> Result<Vec<u8>, ReadError> {
    let open = |source| ReadError::Open { path: path.to_owned(), source };
    let mut file = File::open(path).map_err(open)?;
    let mut bytes = Vec::new();
    // Endless devices are not read to their end.
    file.by_ref().take(MAGIC.len() as u64).read_to_end(&mut bytes).map_err(open)?;
    if bytes != MAGIC {
        return Err(ReadError::Format { path: path.to_owned(), message: foreign(&bytes) });
    }
    memory::check("the file", file.metadata().map_err(open)?.len())
        .map_err(|source| ReadError::Memory { path: path.to_owned(), source })?;
    file.read_to_end(&mut bytes).map_err(open)?;
    Ok(bytes)
}

/// Returns the channels of all parts that have the data window of the part that is shown.
fn from_parts(image: Image<Layers<AnyChannels<FlatSamples>>>) -> Result<ExrFile, String> {
    let colours = |name: &str| RGB.contains(&name) || name == "Y";
    let main = image
        .layer_data
        .iter()
        .find(|part| part.channel_data.list.iter().any(|channel| colours(&channel.name.to_string())));
    let main = main.or(image.layer_data.first()).ok_or("it has no layers")?;
    let bounds = |position, size| window(IntegerBounds::new(position, size));
    let shown = bounds(main.attributes.layer_position, main.size)?;
    let part_name =
        |part: &Option<Text>| part.as_ref().map_or_else(|| DEFAULT_LAYER.to_owned(), ToString::to_string);
    let mut file = ExrFile {
        width: shown.width,
        height: shown.height,
        position: [shown.x, shown.y],
        display: window(image.attributes.display_window)?,
        shown_layer: part_name(&main.attributes.layer_name),
        ..ExrFile::default()
    };
    let mut attributes = image.attributes.other.iter().chain(&main.attributes.other);
    if let Some((_, AttributeValue::Text(json))) = attributes.find(|(name, _)| **name == *METADATA) {
        file.metadata = serde_json::from_str(&json.to_string()).unwrap_or_default();
    }
    for part in image.layer_data {
        let name = part_name(&part.attributes.layer_name);
        if bounds(part.attributes.layer_position, part.size) != Ok(shown) {
            file.left_out.push(name);
            continue;
        }
        for channel in part.channel_data.list {
            let own = channel.name.to_string();
            // Channels with a layer's name of their own are not known by that of their part.
            let known = own.contains('.') && !file.channels.contains_key(&own);
            let full = if known { own } else { full_name(&name, &own) };
            file.channels.insert(full, channel.sample_data.values_as_f32().collect());
        }
    }
    if RGB.iter().chain(&["Y"]).any(|name| file.channels.contains_key(*name)) {
        file.shown_layer = DEFAULT_LAYER.to_owned();
    }
    Ok(file)
}

/// Returns a description of a file that does not begin as OpenEXR files do.
fn foreign(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "it is empty".to_owned();
    }
    match OTHERS.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        Some((_, kind)) => format!("it is {kind}"),
        None => "it does not begin as such files do".to_owned(),
    }
}

/// Number of bytes that all samples take, as they are decoded and as `f32`.
fn needed(meta: &MetaData) -> u64 {
    let bytes = |header: &Header| {
        let pixels = (header.layer_size.x() as u64).saturating_mul(header.layer_size.y() as u64);
        let one = |channel: &ChannelDescription| match channel.sample_type {
            SampleType::F16 => 2 + 4,
            SampleType::F32 | SampleType::U32 => 4 + 4,
        };
        pixels.saturating_mul(header.channels.list.iter().map(one).sum())
    };
    meta.headers.iter().map(bytes).fold(0, u64::saturating_add)
}

fn window(bounds: IntegerBounds) -> Result<Window, String> {
    let side = |size: usize| u32::try_from(size).map_err(|error| error.to_string());
    let (x, y) = (i64::from(bounds.position.x()), i64::from(bounds.position.y()));
    Ok(Window { x, y, width: side(bounds.size.x())?, height: side(bounds.size.y())? })
}
