//! Amounts of memory on the command line, and the size of mapped input.

use std::path::Path;

/// Reads `4G`, `500M`, `1.5GiB`, `2GB`, or bytes. K, M, G and T are powers of 1024, as in Slurm and systemd; KB, MB, GB and
/// TB are powers of 1000.
pub fn parse(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let n_digits = text.find(|c: char| !c.is_ascii_digit() && c != '.');
    let (number, unit) = text.split_at(n_digits.unwrap_or(text.len()));
    let unit = unit.trim().to_ascii_lowercase();
    let base: f64 = if unit.len() == 2 { 1000.0 } else { 1024.0 };
    let power = match unit.as_str() {
        "" | "b" => Some(0),
        "k" | "kb" | "kib" => Some(1),
        "m" | "mb" | "mib" => Some(2),
        "g" | "gb" | "gib" => Some(3),
        "t" | "tb" | "tib" => Some(4),
        _ => None,
    };
    let number = number.parse::<f64>().ok().filter(|number| *number > 0.0);
    match (number, power) {
        (Some(number), Some(power)) => Ok((number * base.powi(power)) as u64),
        _ => Err("write an amount of memory such as 4G, 500M or 2GB".to_owned()),
    }
}

/// Returns the bytes of a file that is mapped instead of stored in memory; 0 if it cannot be mapped.
pub fn mapped_bytes(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |found| if found.is_file() { found.len() } else { 0 })
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn amounts_of_memory_are_read_as_batch_systems_mean_them() {
        let gibi = 1 << 30;
        for (text, bytes) in [
            ("4G", 4 * gibi),
            ("4g", 4 * gibi),
            ("1.5GiB", gibi + gibi / 2),
            ("2GB", 2_000_000_000),
            ("500M", 500 << 20),
            ("64 KiB", 64 << 10),
            ("123", 123),
        ] {
            assert_eq!(parse(text), Ok(bytes), "{text}");
        }
        for wrong in ["", "G", "-1G", "0", "4 apples", "4X", "1e9", "nan"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
