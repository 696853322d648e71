//! Text for a page: escaped, as JSON, or bytes in base64; large counts.

use azimesh_core::error::one_line;
use std::io::Write;

/// Escapes text for use between tags and in attributes.
pub fn escape(text: &str) -> String {
    let text = one_line(text).replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// Writes JSON for a script element.
pub fn json_text(value: &serde_json::Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

/// Compresses bytes by zlib and writes them in base64, for `DecompressionStream("deflate")` of a browser.
pub fn packed(bytes: &[u8]) -> String {
    let level = flate2::Compression::new(6);
    let mut writer = flate2::write::ZlibEncoder::new(Vec::new(), level);
    let packed = writer.write_all(bytes).and_then(|()| writer.finish());
    base64_simd::STANDARD.encode_to_string(packed.expect("a vector takes any bytes"))
}

/// Packs numbers as their differences, all first bytes before all second ones: neighbours are alike.
pub fn packed_numbers(numbers: impl Iterator<Item = u32>) -> String {
    let mut last = 0u32;
    let changes = numbers.map(|number| number.wrapping_sub(std::mem::replace(&mut last, number)));
    let changes: Vec<[u8; 4]> = changes.map(u32::to_le_bytes).collect();
    let bytes = (0..4).flat_map(|at| changes.iter().map(move |bytes| bytes[at]));
    packed(&bytes.collect::<Vec<u8>>())
}

/// Writes a count with its digits in groups of three.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let groups: Vec<&[u8]> = digits.as_bytes().rchunks(3).rev().collect();
    let groups = groups.iter().map(|group| String::from_utf8_lossy(group));
    groups.collect::<Vec<_>>().join("\u{202f}")
}
