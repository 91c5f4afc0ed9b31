//! Text of OBJ, MTL and scene files as bytes: encodings, statements, names and numbers.

mod encoding;
mod names;
mod number;
mod statements;

pub(crate) use encoding::{BYTE_ORDER_MARK, decode, is_utf8};
pub(crate) use names::{forms, words};
pub(crate) use number::{first_number, first_word, numbers};
pub(crate) use statements::{Statements, keyword_and_rest, last_statement_end, statement_end};

/// Returns `text` without white space at its ends. Control characters count as white space: files of old
/// systems end with NUL or Ctrl-Z.
pub(crate) fn trim(mut text: &[u8]) -> &[u8] {
    while let [..=b' ', rest @ ..] = text {
        text = rest;
    }
    while let [rest @ .., ..=b' '] = text {
        text = rest;
    }
    text
}

/// Returns `text` for a message, cut to a readable length.
pub(crate) fn shown(text: &[u8]) -> String {
    const LENGTH: usize = 80;
    let mut cut = String::from_utf8_lossy(&text[..text.len().min(4 * LENGTH)]).into_owned();
    if let Some((end, _)) = cut.char_indices().nth(LENGTH) {
        cut.truncate(end);
        cut.push('…');
    }
    cut
}
