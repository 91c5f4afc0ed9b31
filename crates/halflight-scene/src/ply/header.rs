//! Header of a PLY file.

use memchr::memchr2;

use crate::text::{first_word, shown, trim};

/// Encoding of numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Types of numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"int64" => Self::I64,
            b"uint64" => Self::U64,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Largest number of an unsigned type, which represents -1.
    pub(super) fn minus_one(self) -> f64 {
        match self {
            Self::U8 => u8::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::U64 => u64::MAX as f64,
            _ => -1.0,
        }
    }
}

/// Column of an element's rows: a number or a list.
pub(super) struct Property {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// Type of a list's count.
    pub(super) count: Option<Scalar>,
}

/// A table of the file.
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

impl Element {
    pub(super) fn has(&self, name: &str) -> bool {
        self.properties.iter().any(|property| property.name == name)
    }
}

/// Header of a file: format, elements in the order of the file, textures.
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// Names of texture files, from comments.
    pub(super) textures: Vec<Vec<u8>>,
    /// Bytes of the header, its last line end included.
    pub(super) length: usize,
}

impl Header {
    /// Reads the header of `file`; a fault is a message.
    pub(super) fn read(file: &[u8]) -> Result<Self, String> {
        let mut format = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut textures = Vec::new();
        // Data may begin with a byte that looks like half of a line end: all lines end as the first one does.
        let end = memchr2(b'\n', b'\r', file).unwrap_or(file.len());
        let line_end = if file[end..].starts_with(b"\r\n") { 2 } else { 1 };
        if trim(&file[..end]) != b"ply" {
            return Err("File must start with 'ply'".to_string());
        }
        let mut at = end;
        while at < file.len() {
            at = (at + line_end).min(file.len());
            let end = memchr2(b'\n', b'\r', &file[at..]).map_or(file.len(), |length| at + length);
            let line = trim(&file[at..end]);
            at = end;
            let (keyword, rest) = first_word(line);
            match keyword {
                b"end_header" if end < file.len() => {
                    let format = format.ok_or("Missing format specification")?;
                    return Ok(Self { format, elements, textures, length: (end + line_end).min(file.len()) });
                }
                b"format" => format = Some(read_format(rest)?),
                b"element" => elements.push(read_element(rest)?),
                b"property" => {
                    let element = elements.last_mut().ok_or("a property before any element")?;
                    element.properties.push(read_property(rest)?);
                }
                b"comment" | b"obj_info" => {
                    let (kind, name) = first_word(rest);
                    if kind.eq_ignore_ascii_case(b"TextureFile") && !trim(name).is_empty() {
                        textures.push(trim(name).to_vec());
                    }
                }
                b"" => {}
                _ => return Err(format!("unknown line `{}`", shown(line))),
            }
        }
        Err(if format.is_none() { "Missing format specification" } else { "Unexpected end of file" }
            .to_string())
    }
}

fn read_format(rest: &[u8]) -> Result<Format, String> {
    match first_word(rest).0 {
        b"ascii" => Ok(Format::Ascii),
        b"binary_little_endian" => Ok(Format::LittleEndian),
        b"binary_big_endian" => Ok(Format::BigEndian),
        other => Err(format!("Unknown format: {}", shown(other))),
    }
}

fn read_element(rest: &[u8]) -> Result<Element, String> {
    let (name, rest) = first_word(rest);
    let (count, _) = first_word(rest);
    let number = str::from_utf8(count).ok().and_then(|count| count.parse().ok());
    let count = number.ok_or_else(|| format!("Invalid element count: {}", shown(count)))?;
    Ok(Element { name: shown(name), count, properties: Vec::new() })
}

fn read_property(rest: &[u8]) -> Result<Property, String> {
    let scalar =
        |name: &[u8]| Scalar::named(name).ok_or_else(|| format!("Unknown scalar type: {}", shown(name)));
    let (first, mut rest) = first_word(rest);
    let mut count = None;
    let mut kind = first;
    if first == b"list" {
        let (count_type, after) = first_word(rest);
        count = Some(scalar(count_type)?);
        (kind, rest) = first_word(after);
    }
    let scalar = scalar(kind)?;
    Ok(Property { name: shown(first_word(rest).0), scalar, count })
}
