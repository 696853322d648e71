//! Bytes as text that a web page can hold: compressed by zlib, then in base64.

use std::io::Write;

/// Level of the compression.
const LEVEL: u32 = 6;

/// The text of some bytes. `new Response(stream.pipeThrough(new DecompressionStream("deflate")))` unpacks it in a browser.
pub fn embedded(bytes: &[u8]) -> String {
    let level = flate2::Compression::new(LEVEL);
    let mut writer = flate2::write::ZlibEncoder::new(Vec::new(), level);
    let packed = writer.write_all(bytes).and_then(|()| writer.finish());
    let packed = packed.expect("a vector takes any bytes");
    base64_simd::STANDARD.encode_to_string(packed)
}

/// The bytes of a text.
#[cfg(test)]
pub fn unembedded(text: &str) -> Vec<u8> {
    use std::io::Read;
    let packed = base64_simd::STANDARD
        .decode_to_vec(text)
        .expect("it is base64");
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(&packed[..])
        .read_to_end(&mut bytes)
        .expect("it is zlib");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_in_a_page_gives_the_bytes_back() {
        let bytes: Vec<u8> = (0..100_000u32)
            .map(|i| (i.wrapping_mul(i) >> 7) as u8)
            .collect();
        assert_eq!(unembedded(&embedded(&bytes)), bytes);
    }
}
