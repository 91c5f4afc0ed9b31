//! Names of materials and files.

use super::trim;

/// Most comments that are considered at the end of a name; more only cost time.
const MAX_COMMENTS: usize = 8;

/// Possible meanings of `name`, likeliest first: the whole text, then the text without a possible comment
/// (`#` at its start or behind white space), longest first; each of them also without quotation marks around
/// it.
pub(crate) fn forms(name: &[u8]) -> Vec<&[u8]> {
    let comments = (0..name.len()).filter(|&at| name[at] == b'#' && (at == 0 || name[at - 1] <= b' '));
    let mut ends: Vec<usize> = comments.take(MAX_COMMENTS).collect();
    ends.push(name.len());
    let mut forms = Vec::with_capacity(2 * ends.len());
    for &end in ends.iter().rev() {
        let form = trim(&name[..end]);
        forms.push(form);
        forms.extend(unquoted(form));
    }
    forms
}

/// Returns the text between the quotation marks around `name`; `None` without marks.
fn unquoted(name: &[u8]) -> Option<&[u8]> {
    match name {
        [b'"', inner @ .., b'"'] | [b'\'', inner @ .., b'\''] => Some(trim(inner)),
        _ => None,
    }
}

/// Splits names by white space; names in double quotation marks may contain white space.
pub(crate) fn words(mut names: &[u8]) -> Vec<&[u8]> {
    let mut words = Vec::new();
    loop {
        names = trim(names);
        let Some(&first) = names.first() else { return words };
        let quoted = if first == b'"' { names[1..].iter().position(|&byte| byte == b'"') } else { None };
        let (word, end) = match quoted {
            Some(length) => (&names[1..1 + length], length + 2),
            None => {
                let end = names.iter().position(|&byte| byte <= b' ').unwrap_or(names.len());
                (&names[..end], end)
            }
        };
        words.push(word);
        names = &names[end..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_tried_from_long_to_short() {
        let cases: [(&str, &[&str]); 7] = [
            ("red", &["red"]),
            ("\"red one\"", &["\"red one\"", "red one"]),
            ("red # it", &["red # it", "red"]),
            ("red #1 # it", &["red #1 # it", "red #1", "red"]),
            ("red#1", &["red#1"]),
            ("\"red\"\t# it", &["\"red\"\t# it", "\"red\"", "red"]),
            ("# it", &["# it", ""]),
        ];
        for (name, expected) in cases {
            let found: Vec<_> = forms(name.as_bytes()).into_iter().map(String::from_utf8_lossy).collect();
            assert_eq!(found, expected, "{name}");
        }
        // The number of forms is limited, and so is their time.
        assert!(forms(" #".repeat(1000).as_bytes()).len() <= MAX_COMMENTS + 1);
        assert_eq!(words(b"a  \"b c\"\td\"e \"f"), [&b"a"[..], b"b c", b"d\"e", b"\"f"]);
    }
}
