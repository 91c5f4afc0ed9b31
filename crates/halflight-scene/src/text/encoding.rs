//! Encodings of text.

/// The byte order mark of UTF-8.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// True if a text with these first bytes needs no conversion: UTF-8, or an encoding that extends ASCII.
pub(crate) fn is_utf8(start: &[u8]) -> bool {
    width(start).is_none()
}

/// Converts a text to UTF-8 without a byte order mark. UTF-16 and UTF-32 are recognised by their mark or,
/// without one, by the zero bytes of ASCII characters; other encodings are kept.
pub(crate) fn decode(mut bytes: Vec<u8>) -> Vec<u8> {
    let Some((width, little)) = width(&bytes) else {
        if bytes.starts_with(BYTE_ORDER_MARK) {
            bytes.drain(..BYTE_ORDER_MARK.len());
        }
        return bytes;
    };
    let units = bytes.chunks_exact(width).map(|unit| {
        let append = |value: u32, &byte: &u8| value << 8 | u32::from(byte);
        if little { unit.iter().rev().fold(0, append) } else { unit.iter().fold(0, append) }
    });
    let text: String = if width == 4 {
        units.map(|unit| char::from_u32(unit).unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    } else {
        char::decode_utf16(units.map(|unit| unit as u16))
            .map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect()
    };
    text.strip_prefix('\u{feff}').unwrap_or(&text).as_bytes().to_vec()
}

/// Bytes per unit, and true if the lowest comes first; `None` for units of one byte.
fn width(start: &[u8]) -> Option<(usize, bool)> {
    match start {
        [0xff, 0xfe, 0, 0, ..] => Some((4, true)),
        [0, 0, 0xfe, 0xff, ..] => Some((4, false)),
        [0xff, 0xfe, ..] => Some((2, true)),
        [0xfe, 0xff, ..] => Some((2, false)),
        [a, 0, b, 0, ..] if *a != 0 && *b != 0 => Some((2, true)),
        [0, a, 0, b, ..] if *a != 0 && *b != 0 => Some((2, false)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utf_8_16_and_32_are_the_same_text() {
        let text = "v 1 2\r\nusemtl größe 𝄞\n";
        let units: Vec<u16> = text.encode_utf16().collect();
        let marked: Vec<u16> = [0xfeff].into_iter().chain(units.iter().copied()).collect();
        let wide: Vec<u32> = [0xfeff].into_iter().chain(text.chars().map(u32::from)).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            [BYTE_ORDER_MARK, text.as_bytes()].concat(),
            units.iter().flat_map(|unit| unit.to_le_bytes()).collect(),
            units.iter().flat_map(|unit| unit.to_be_bytes()).collect(),
            marked.iter().flat_map(|unit| unit.to_le_bytes()).collect(),
            marked.iter().flat_map(|unit| unit.to_be_bytes()).collect(),
            wide.iter().flat_map(|unit| unit.to_le_bytes()).collect(),
            wide.iter().flat_map(|unit| unit.to_be_bytes()).collect(),
        ] {
            assert_eq!(decode(bytes.clone()), text.as_bytes(), "{bytes:?}");
        }
        // Latin-1, a lone NUL, less than a unit.
        for bytes in [&b"usemtl gr\xf6\xdfe"[..], b"v 1\0", b"\xff\xfe\x76", b"\0", b""] {
            let expected = if bytes.starts_with(b"\xff\xfe") { b"" } else { bytes };
            assert_eq!(decode(bytes.to_vec()), expected);
        }
    }
}
