//! Radiance's pictures of four bytes a pixel.

use std::io::{self, BufRead, Write};

use image::{ExtendedColorType, ImageDecoder, ImageEncoder, codecs::hdr};

use super::Picture;

/// Least and greatest value that the shared exponent holds.
const RANGE: [f32; 2] = [1e-38, 1e38];

/// Writes `.hdr`. Channels are truncated to 8 bits under the exponent of the greatest, as Radiance does.
pub(super) fn write(picture: &Picture, out: &mut dyn Write) -> io::Result<()> {
    let bytes: Vec<u8> = picture
        .pixels
        .iter()
        .flatten()
        .map(|&c| if c >= RANGE[0] { c.min(RANGE[1]) } else { 0.0 })
        .flat_map(f32::to_ne_bytes)
        .collect();
    hdr::HdrEncoder::new(out)
        .write_image(&bytes, picture.width, picture.height, ExtendedColorType::Rgb32F)
        .map_err(to_io)
}

/// Reads `.hdr` and `.pic`, to radiance: the exposure that the file names is taken out.
pub(super) fn read(bytes: impl BufRead) -> image::ImageResult<Picture> {
    let decoder = hdr::HdrDecoder::new(bytes)?;
    let exposure = decoder.metadata().exposure.filter(|&e| e > 0.0 && e.is_finite()).unwrap_or(1.0);
    let (width, height) = decoder.dimensions();
    let mut bytes = super::read::buffer(decoder.total_bytes())?;
    decoder.read_image(&mut bytes)?;
    let value = |c: &[u8]| f32::from_ne_bytes([c[0], c[1], c[2], c[3]]);
    let pixels = bytes
        .chunks_exact(12)
        .map(|p| [value(&p[0..4]), value(&p[4..8]), value(&p[8..12])])
        .map(|pixel| middle(pixel).map(|c| c / exposure))
        .collect();
    Ok(Picture { width, height, pixels })
}

/// The middle of the steps that the bytes stand for: they were truncated (Radiance's `colr_color`).
fn middle(pixel: [f32; 3]) -> [f32; 3] {
    let greatest = pixel[0].max(pixel[1]).max(pixel[2]);
    if greatest <= 0.0 {
        return pixel;
    }
    // The greatest has eight bits, 128 to 255 steps: half a step is its power of two over 256.
    let power = f32::from_bits(greatest.to_bits() & 0xff80_0000);
    pixel.map(|c| c + power / 256.0)
}

fn to_io(error: image::ImageError) -> io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_to_a_file_and_back_is_within_half_a_step() {
        let pixels = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.5, 0.25],
            [1e-45, f32::NAN, -3.0],
            [f32::INFINITY, 1.0, 2.0],
            [123.4, 0.9, 67.0],
            [3.3e-30, 2.2e-30, 1e-31],
        ];
        let picture = Picture { width: 2, height: 3, pixels };
        let mut bytes = Vec::new();
        write(&picture, &mut bytes).unwrap();
        let back = read(&bytes[..]).unwrap();
        assert_eq!((back.width, back.height), (2, 3));
        assert_eq!(back.pixels[0], [0.0; 3]);
        assert_eq!(back.pixels[2], [0.0; 3]);
        assert!(back.pixels[3][0] > 9e37);
        for i in [1, 4, 5] {
            let greatest = picture.pixels[i].iter().fold(0.0f32, |a, &b| a.max(b));
            for (a, b) in picture.pixels[i].iter().zip(back.pixels[i]) {
                assert!((a - b).abs() <= greatest / 255.0, "{a} {b}");
            }
        }
    }

    #[test]
    fn the_exposure_is_taken_out() {
        // Mantissas 128, 64, 0 under exponent 129: 1, 0.5, 0 and half a step of 2/256, seen at twice.
        let mut bytes =
            b"#?RADIANCE\nEXPOSURE=4\nEXPOSURE=.5\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".to_vec();
        bytes.extend([128, 64, 0, 129]);
        let picture = read(&bytes[..]).unwrap();
        let half = 1.0 / 256.0;
        assert_eq!(picture.pixels, [[(1.0 + half) / 2.0, (0.5 + half) / 2.0, half / 2.0]]);
    }
}
