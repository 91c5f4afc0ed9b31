//! Numbers.

/// Powers of ten that double precision holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Returns the first word of `text`, which is empty at its end or before a comment, and the remaining text.
pub(crate) fn first_word(text: &[u8]) -> (&[u8], &[u8]) {
    let start = text.iter().position(|&byte| byte > b' ').unwrap_or(text.len());
    let text = &text[start..];
    if text.first() == Some(&b'#') {
        return (&[], &[]);
    }
    text.split_at(text.iter().position(|&byte| byte <= b' ').unwrap_or(text.len()))
}

/// Reads the numbers of `text` up to a comment: their count, and the first eight; `None` if one of them is no
/// number.
pub(crate) fn numbers(mut text: &[u8]) -> Option<(usize, [f64; 8])> {
    let mut numbers = [0.0; 8];
    let mut count = 0;
    loop {
        let (number, rest) = first_number(text)?;
        let Some(number) = number else { return Some((count, numbers)) };
        if let Some(place) = numbers.get_mut(count) {
            *place = number;
        }
        count += 1;
        text = rest;
    }
}

/// Reads the first number of `text`, rounded once, and returns it with the remaining text; no number at the
/// end of the text or before a comment, `None` for other content.
pub(crate) fn first_number(text: &[u8]) -> Option<(Option<f64>, &[u8])> {
    let start = text.iter().position(|&byte| byte > b' ').unwrap_or(text.len());
    let text = &text[start..];
    let mut at = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let mut mantissa = 0u64;
    let mut digits = |at: &mut usize| {
        let first = *at;
        while let Some(digit) = text.get(*at).map(|byte| byte.wrapping_sub(b'0')).filter(|&digit| digit < 10)
        {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(digit.into());
            *at += 1;
        }
        *at - first
    };
    let whole = digits(&mut at);
    let mut decimals = 0;
    if text.get(at) == Some(&b'.') {
        at += 1;
        decimals = digits(&mut at);
    }
    // Up to 18 digits do not wrap. A quotient of two exact numbers is rounded once.
    let short = (1..=18).contains(&(whole + decimals)) && mantissa < 1 << 53;
    if short && text.get(at).is_none_or(|&byte| byte <= b' ') {
        let value = mantissa as f64 / POWERS[decimals];
        return Some((Some(if text[0] == b'-' { -value } else { value }), &text[at..]));
    }
    let (word, rest) = first_word(text);
    match word {
        [] => Some((None, rest)),
        _ => any_number(word).map(|(number, commented)| (Some(number), if commented { &[] } else { rest })),
    }
}

/// Reads a word that is a number; the flag is true if a comment follows in the same word.
fn any_number(word: &[u8]) -> Option<(f64, bool)> {
    if let Some(number) = str::from_utf8(word).ok().and_then(|word| word.parse().ok()) {
        return Some((number, false));
    }
    let unsigned = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
    // C libraries print NaN as nan(ind), 1.#IND, 1.#QNAN, 1.#SNAN or 1.#INF for infinity; with few digits the
    // letters are rounded as if they were digits: 1.#IO, 1.#J, 1.#R, 1.$.
    let not_a_number = match unsigned {
        [b'n' | b'N', b'a' | b'A', b'n' | b'N', b'(', .., b')'] => true,
        [b'1', b'.', b'#', letter, ..] => b"IQSJR".contains(letter),
        [b'1', b'.', b'$', ..] => true,
        _ => false,
    };
    if not_a_number {
        return Some((f64::NAN, false));
    }
    let comment = word.iter().position(|&byte| byte == b'#')?;
    let number = str::from_utf8(&word[..comment]).ok()?.parse().ok()?;
    Some((number, true))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_once_and_comments_end_them() {
        let words = [
            "0",
            "-0",
            "1",
            "+1.5",
            ".5",
            "-.5",
            "5.",
            "448259.350",
            "0.1",
            "123456789012345678",
            "1234567890.12345678",
            "9007199254740993",
            "1e3",
            "1.5E-300",
            "1e400",
            "0.00000000000000000000001",
            "12345678901234567890123",
        ];
        for word in words {
            let expected: f64 = word.parse().unwrap();
            let (found, rest) = first_number(word.as_bytes()).unwrap();
            assert_eq!(found.unwrap().to_bits(), expected.to_bits(), "{word}");
            assert!(rest.is_empty());
        }
        assert_eq!(numbers(b" 1\t2 3# 4"), Some((3, [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0])));
        assert_eq!(numbers(b"1 2 # 3").unwrap().0, 2);
        assert_eq!(numbers(b"1 2 3 4 5 6 7 8 9").unwrap(), (9, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]));
        for word in ["x", "1x", "1,5", "--1", "1e", ".", "-", "1.#note", "1.#", "\u{ff11}"] {
            let found = numbers(word.as_bytes());
            assert!(found.is_none() || word.contains('#') && found.unwrap().0 == 1, "{word} {found:?}");
        }
    }

    #[test]
    fn what_c_libraries_print_for_no_number_is_one() {
        for word in [
            "nan",
            "NaN",
            "-nan",
            "inf",
            "-inf",
            "Infinity",
            "1.#IND",
            "-1.#IND00",
            "1.#QNAN0",
            "1.#SNAN",
            "1.#INF",
            "-1.#INF00",
            "1.#IO",
            "-1.#J",
            "1.#R",
            "1.$",
            "nan(ind)",
            "-nan(ind)",
            "-NAN(IND)",
            "nan(snan)",
            "nan(0x8)",
        ] {
            let (count, numbers) = numbers(format!("{word} 2").as_bytes()).expect(word);
            assert!(count == 2 && !numbers[0].is_finite() && numbers[1] == 2.0, "{word}");
        }
    }
}
