//! Numbers in sentences: rounded for people. Programs read JSON and CSV, which have every digit.

use crate::error::counted;

/// A number in six significant digits at most; a whole number below 1e9 has all of its digits. With an exponent where it is
/// very small or large.
pub fn short(value: f64) -> String {
    if value == value.trunc() && value.abs() < 1e9 {
        // Without the sign of a zero.
        (value + 0.0).to_string()
    } else {
        in_digits(value, 6)
    }
}

/// A number in so many significant digits at most, without zeros at the end.
pub fn in_digits(value: f64, digits: usize) -> String {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    let rounded = text.parse().unwrap_or(value);
    match rounded.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e6).contains(&size) => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// A point: `(1.5, 0, -0.25)`.
pub fn point(x: &[f64; 3]) -> String {
    format!("({})", x.map(short).join(", "))
}

/// A step as sentences name it: with its azimuth in degrees or, where the schedule has none, with its
/// time in seconds, or without both.
pub fn named_step(step: usize, azimuth_deg: Option<f64>, time_s: Option<f64>) -> String {
    match (azimuth_deg, time_s) {
        (None, Some(time)) => format!("step {step} ({} s)", short(time)),
        (Some(azimuth), _) => format!("step {step} (azimuth {} degrees)", short(azimuth)),
        (None, None) => format!("step {step}"),
    }
}

/// Bytes in a unit that fits, in three digits.
pub fn amount(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["B", "kB", "MB", "GB", "TB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 999.5 && unit + 1 < UNITS.len() {
        value /= 1000.0;
        unit += 1;
    }
    format!("{} {}", in_digits(value, 3), UNITS[unit])
}

/// A count as the subject of a sentence: `1 node differs`, `2 nodes differ`. `verb` is singular.
pub fn with_verb(n: usize, noun: &str, verb: &str) -> String {
    let verb = match (n, verb) {
        (1, verb) => verb,
        (_, "is") => "are",
        (_, "has") => "have",
        (_, verb) => verb.strip_suffix('s').unwrap_or(verb),
    };
    format!("{} {verb}", counted(n, noun))
}

/// The shortest text that reads back as the same number; with an exponent where it is very small or large. For files.
pub fn shortest(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-4..1e9).contains(&size) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people_have_six_digits_at_most() {
        for (value, text) in [
            (216.000_000_000_000_03, "216"),
            (0.700_000_000_000_000_1, "0.7"),
            (-0.0, "0"),
            (-2.5, "-2.5"),
            (7.067_508_661_115_35, "7.06751"),
            (0.000_100_713_807_496, "1.00714e-4"),
            (0.000_999_999_99, "0.001"),
            (12_345_678.0, "12345678"),
            (12_345_678.25, "1.23457e7"),
            (1e300, "1e300"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(short(value), text);
        }
        assert_eq!(in_digits(1234.0, 2), "1200");
        assert_eq!(point(&[0.1 + 0.2, -0.0, 1e-7]), "(0.3, 0, 1e-7)");
    }

    #[test]
    fn bytes_are_told_in_a_unit_that_fits() {
        for (bytes, text) in [
            (0, "0 B"),
            (12, "12 B"),
            (1_500, "1.5 kB"),
            (999_600, "1 MB"),
            (7_654_000_000_000_000, "7650 TB"),
        ] {
            assert_eq!(amount(bytes), text);
        }
    }

    #[test]
    fn a_verb_is_singular_for_one() {
        assert_eq!(with_verb(1, "node", "differs"), "1 node differs");
        assert_eq!(with_verb(0, "node", "is"), "0 nodes are");
        assert_eq!(with_verb(2, "cell", "has"), "2 cells have");
    }
}
