//! Statements of OBJ and MTL files: lines, joined where a backslash continues them.

use memchr::{memchr2, memrchr2};

use super::{BYTE_ORDER_MARK, trim};

/// Reader of a text statement by statement. Lines end with LF, CR LF or CR.
pub(crate) struct Statements<'a> {
    rest: &'a [u8],
    /// Lines read so far.
    lines: usize,
    joined: Vec<u8>,
}

impl<'a> Statements<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self { rest: text, lines: 0, joined: Vec::new() }
    }

    /// Number of lines read so far.
    pub(crate) fn lines(&self) -> usize {
        self.lines
    }

    /// Returns the next statement, without white space at its ends and possibly empty, and its first line,
    /// counted from 1.
    pub(crate) fn next(&mut self) -> Option<(usize, &[u8])> {
        if self.rest.is_empty() {
            return None;
        }
        let line = self.lines + 1;
        let mut piece = self.line();
        if before_continuation(piece).is_none() {
            return Some((line, piece));
        }
        self.joined.clear();
        while let Some(before) = before_continuation(piece) {
            self.joined.extend_from_slice(before);
            self.joined.push(b' ');
            piece = self.line();
        }
        self.joined.extend_from_slice(piece);
        Some((line, trim(&self.joined)))
    }

    fn line(&mut self) -> &'a [u8] {
        self.lines += 1;
        let end = memchr2(b'\n', b'\r', self.rest).unwrap_or(self.rest.len());
        let (line, after) = self.rest.split_at(end);
        self.rest = match after {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => after,
        };
        // Concatenated files have byte order marks inside.
        let line = trim(line);
        if line.first() == Some(&BYTE_ORDER_MARK[0]) {
            return trim(line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line));
        }
        line
    }
}

/// Returns the text before the backslash that continues `line`. A backslash that ends a comment does not
/// count.
fn before_continuation(line: &[u8]) -> Option<&[u8]> {
    let before = line.strip_suffix(b"\\")?;
    let begins_comment = |at: usize| before[at] == b'#' && (at == 0 || before[at - 1] <= b' ');
    (!(0..before.len()).any(begins_comment)).then_some(before)
}

/// Splits a statement into its keyword and the rest, without white space around it.
pub(crate) fn keyword_and_rest(statement: &[u8]) -> (&[u8], &[u8]) {
    let end = statement.iter().position(|&byte| byte <= b' ').unwrap_or(statement.len());
    let (keyword, rest) = statement.split_at(end);
    (keyword, trim(rest))
}

/// Returns the first offset, not before `from`, at which a statement of `text` ends, its line end included.
pub(crate) fn statement_end(text: &[u8], mut from: usize) -> usize {
    while let Some(found) = text.get(from..).and_then(|rest| memchr2(b'\n', b'\r', rest)) {
        from += found;
        let line = before_line_end(text, from);
        let half = text[from] == b'\r' && text.get(from + 1) == Some(&b'\n');
        from += if half { 2 } else { 1 };
        if !ends_in_backslash(line) {
            return from;
        }
    }
    text.len()
}

/// Returns the text before the line end at `at`, which may be the second half of a CR LF.
fn before_line_end(text: &[u8], at: usize) -> &[u8] {
    let before = &text[..at];
    if text[at] == b'\n' { before.strip_suffix(b"\r").unwrap_or(before) } else { before }
}

/// True if the last line of `text` ends with a backslash and white space.
fn ends_in_backslash(text: &[u8]) -> bool {
    let last = text.iter().rev().find(|&&byte| byte > b' ' || byte == b'\n' || byte == b'\r');
    last == Some(&b'\\')
}

/// Returns the last offset at which a statement of `text` ends and another one may begin, for an incomplete
/// text.
pub(crate) fn last_statement_end(text: &[u8]) -> Option<usize> {
    let mut end = text.len();
    while let Some(at) = memrchr2(b'\n', b'\r', &text[..end]) {
        // A CR at the end may be half of a line end.
        let whole = text[at] == b'\n' || at + 1 < text.len();
        if whole && !ends_in_backslash(before_line_end(text, at)) {
            return Some(at + 1);
        }
        end = at;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Vec<(usize, String)> {
        let mut statements = Statements::new(text);
        let mut all = Vec::new();
        while let Some((line, statement)) = statements.next() {
            if !statement.is_empty() {
                all.push((line, String::from_utf8_lossy(statement).into_owned()));
            }
        }
        all
    }

    #[test]
    fn lines_end_in_three_ways_and_a_backslash_joins_them() {
        let text = "\u{feff}v 1\n\n\tf 1 \\\n 2 \\  \n3\n# note \\\nv 2 # C:\\\n\u{feff}v 3\nf 4 \\";
        let expected =
            [(1, "v 1"), (3, "f 1  2  3"), (6, "# note \\"), (7, "v 2 # C:\\"), (8, "v 3"), (9, "f 4")];
        for end in ["\n", "\r\n", "\r"] {
            let text = text.replace('\n', end);
            let found = read(text.as_bytes());
            let found: Vec<(usize, &str)> = found.iter().map(|(line, text)| (*line, text.as_str())).collect();
            assert_eq!(found, expected, "{end:?}");
        }
        assert_eq!(read(b"v 1\0\0\n\x1a"), [(1, "v 1".to_string())]);
    }

    #[test]
    fn cuts_are_ends_of_statements() {
        for end in ["\n", "\r\n", "\r"] {
            let text = "f 1 \\\n2 \\ \n3\n\nv 1\nf 4 \\\n5\n".replace('\n', end);
            let text = text.as_bytes();
            let whole = read(text);
            for from in 0..=text.len() {
                let cut = statement_end(text, from);
                assert!(cut >= from);
                let count = |part: &[u8]| read(part).len();
                assert_eq!(count(&text[..cut]) + count(&text[cut..]), whole.len(), "{end:?} {from}");
                // Incomplete text: the statements before the last cut do not depend on the rest.
                if let Some(cut) = last_statement_end(&text[..from]) {
                    assert_eq!(count(&text[..cut]) + count(&text[cut..]), whole.len(), "{end:?} {from}");
                    assert_ne!(&text[cut - 1..(cut + 1).min(text.len())], b"\r\n");
                }
            }
        }
        assert_eq!(last_statement_end(b"f 1 \\\n2"), None);
    }
}
