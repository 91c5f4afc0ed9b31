//! Figures as tables show them; nothing where there is no figure.

/// Returns digits in groups of three.
pub fn integer(value: Option<u64>) -> String {
    let digits = value.map_or(String::new(), |value| value.to_string());
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// Returns milliseconds with two digits, or one from 10 on.
pub fn time(value: Option<f64>) -> String {
    value.map_or(
        String::new(),
        |value| if value < 10.0 { format!("{value:.2}") } else { format!("{value:.1}") },
    )
}

/// Returns a time with its unit: milliseconds, or seconds from one on.
pub fn duration(ms: f64) -> String {
    match ms {
        ms if ms >= 9.95e3 => format!("{:.0} s", ms * 1e-3),
        ms if ms >= 1e3 => format!("{:.1} s", ms * 1e-3),
        ms if ms >= 9.95 => format!("{ms:.0} ms"),
        ms => format!("{ms:.1} ms"),
    }
}

/// Returns an error with three digits, as a power of ten where it is small or large.
pub fn error(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| {
        if value == 0.0 || (0.01..1e4).contains(&value) {
            format!("{value:.3}")
        } else {
            format!("{value:.2e}")
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_grouped_and_short() {
        assert_eq!([0, 999, 1000, 1234567].map(|n| integer(Some(n))), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([1.26, 290.8, 1400.0, 22565.9].map(duration), ["1.3 ms", "291 ms", "1.4 s", "23 s"]);
        assert_eq!([5.42e-4, 1.112, 1473.0].map(|n| error(Some(n))), ["5.42e-4", "1.112", "1473.000"]);
    }
}
