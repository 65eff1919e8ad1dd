use super::Picture;

/// The BLAKE3 hash of the pixels, rows from the top, each channel as 32-bit little-endian float; in hex.
pub(crate) fn hash(picture: &Picture) -> String {
    let mut hasher = blake3::Hasher::new();
    for row in picture.pixels.chunks(4096) {
        let bytes: Vec<u8> = row.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        hasher.update(&bytes);
    }
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_of_the_bytes() {
        // b3sum of the 24 bytes 0000803f 0000003f 00000000 000080bf 0000c07f 0000807f.
        let pixels = vec![[1.0, 0.5, 0.0], [-1.0, f32::from_bits(0x7fc0_0000), f32::INFINITY]];
        let picture = Picture { width: 2, height: 1, pixels };
        assert_eq!(
            hash(&picture),
            "e5a9839fb645d8d19bf671ae07e0c696d535e6a10daf97d131979cdf5228154f"
        );
    }
}
