//! Radiance's pictures of four bytes a pixel.

use std::io::{self, Read, Write};

use image::{ExtendedColorType, ImageDecoder, ImageEncoder, codecs::hdr};

use super::{
    Picture,
    read::{Error, black, in_io},
};

/// Least and greatest value that the shared exponent holds.
const RANGE: [f32; 2] = [1e-38, 1e38];

/// Longest line whose channels are stored as runs: its mark has 15 bits for the length.
const LENGTH_MAX: u32 = 0x7fff;

/// Writes `.hdr`. Channels are truncated to 8 bits under the exponent of the greatest, as Radiance does.
///
/// # Errors
/// Those of `out`.
pub fn write(picture: &Picture, out: &mut dyn Write) -> io::Result<()> {
    let bytes: Vec<u8> = picture
        .pixels
        .iter()
        .flatten()
        .map(|&c| if c >= RANGE[0] { c.min(RANGE[1]) } else { 0.0 })
        .flat_map(f32::to_ne_bytes)
        .collect();
    let (width, height) = (picture.width, picture.height);
    let encode = |out: &mut dyn Write, width, height| {
        let encoder = hdr::HdrEncoder::new(out);
        encoder.write_image(&bytes, width, height, ExtendedColorType::Rgb32F).map_err(in_io)
    };
    if width != LENGTH_MAX + 1 {
        return encode(out, width, height);
    }
    // The encoder makes runs of this width, which has no mark. A column has none.
    let mut column = Vec::new();
    encode(&mut column, 1, width * height)?;
    let body = column.len() - picture.pixels.len() * 4;
    write!(out, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n")?;
    out.write_all(&column[body..])
}

/// Reads `.hdr` and `.pic` in any orientation, to radiance: the exposures that the file names are taken out.
pub(crate) fn read(bytes: &[u8], pixels_max: u64) -> Result<Picture, Error> {
    let (header, body) = Header::read(bytes)?;
    let Header { lines, length, .. } = header;
    let (width, height) = if header.columns { (lines, length) } else { (length, lines) };
    let mut picture = black(width, height, pixels_max)?;

    // The decoder knows rows from the top alone: each is decoded as one, and put where it belongs.
    let damaged = |error: image::ImageError| Error::Damaged(error.to_string());
    let mut rest = body;
    let mut line = vec![0; length as usize * 12];
    for i in 0..lines {
        let start = format!("#?RADIANCE\n\n-Y 1 +X {length}\n");
        hdr::HdrDecoder::new(start.as_bytes().chain(&mut rest))
            .and_then(|decoder| decoder.read_image(&mut line))
            .map_err(damaged)?;
        let value = |c: &[u8]| f32::from_ne_bytes([c[0], c[1], c[2], c[3]]);
        for (j, p) in (0..).zip(line.chunks_exact(12)) {
            let (x, y) = header.place(i, j);
            let pixel = middle([value(&p[0..4]), value(&p[4..8]), value(&p[8..12])]);
            picture.pixels[y as usize * width as usize + x as usize] =
                pixel.map(|c| c / header.exposure);
        }
    }
    Ok(picture)
}

/// What stands before the pixels.
#[derive(Debug, PartialEq)]
struct Header {
    exposure: f32,
    /// Rows, or columns, in the order of the file, and pixels of each.
    lines: u32,
    length: u32,
    /// The lines are columns.
    columns: bool,
    /// They begin at the left and at the top.
    from_left: bool,
    from_top: bool,
}

impl Header {
    /// Gives the rest as well.
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), Error> {
        let mut rest = bytes;
        let mut line = || {
            let end = rest.iter().position(|&b| b == b'\n');
            let end = end.ok_or_else(|| Error::Damaged("its header has no end".into()))?;
            let (line, after) = rest.split_at(end);
            rest = after.get(1..).unwrap_or_default();
            Ok(String::from_utf8_lossy(line).trim_end().to_owned())
        };
        let mut exposure = 1.0_f64;
        loop {
            let line = line()?;
            if line.is_empty() {
                break;
            }
            // The lines of those that it was made from are indented.
            match line.split_once('=').map(|(name, value)| (name.trim_end(), value.trim())) {
                Some(("EXPOSURE", value)) => {
                    let value = value.parse().ok().filter(|e: &f64| *e > 0.0 && e.is_finite());
                    exposure *= value.unwrap_or(1.0);
                }
                Some(("FORMAT", "32-bit_rle_rgbe")) | None => {}
                Some(("FORMAT", "32-bit_rle_xyze")) => {
                    return Err(Error::Kind(
                        "its colours are XYZ; make it RGB with Radiance's 'ra_xyze -r FILE NEW.hdr'".into(),
                    ));
                }
                Some(("FORMAT", other)) => {
                    return Err(Error::Kind(format!(
                        "its format is '{other}'; give one of 32-bit_rle_rgbe"
                    )));
                }
                Some(_) => {}
            }
        }
        let size = line()?;
        let exposure = exposure as f32;
        let is_number = exposure.is_normal() && (1.0 / exposure).is_normal();
        let header = Self::sized(&size, if is_number { exposure } else { 1.0 });
        let wrong = || Error::Damaged(format!("'{size}' is no size, as in -Y 480 +X 640"));
        Ok((header.ok_or_else(wrong)?, rest))
    }

    /// By the line that tells size and orientation, as in `-Y 480 +X 640`.
    fn sized(line: &str, exposure: f32) -> Option<Self> {
        let words: Vec<_> = line.split_ascii_whitespace().collect();
        let [outer, lines, inner, length] = words[..] else { return None };
        let (columns, x, y) = match (outer, inner) {
            ("-Y" | "+Y", "+X" | "-X") => (false, inner, outer),
            ("+X" | "-X", "-Y" | "+Y") => (true, outer, inner),
            _ => return None,
        };
        let (lines, length) = (lines.parse().ok()?, length.parse().ok()?);
        Some(Self { exposure, lines, length, columns, from_left: x == "+X", from_top: y == "-Y" })
    }

    /// Column and row of a line's pixel.
    fn place(&self, line: u32, pixel: u32) -> (u32, u32) {
        let along = |at: u32, of: u32, forward: bool| if forward { at } else { of - 1 - at };
        if self.columns {
            let x = along(line, self.lines, self.from_left);
            (x, along(pixel, self.length, self.from_top))
        } else {
            let y = along(line, self.lines, self.from_top);
            (along(pixel, self.length, self.from_left), y)
        }
    }
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
        let back = read(&bytes, 6).unwrap();
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
        let picture = read(&bytes, 1).unwrap();
        let half = 1.0 / 256.0;
        assert_eq!(picture.pixels, [[(1.0 + half) / 2.0, (0.5 + half) / 2.0, half / 2.0]]);
    }

    /// Two rows of three pixels, whose red says where they belong: 100 + 10 × row + column.
    #[test]
    fn any_orientation_is_read() {
        let expected = [[100, 101, 102], [110, 111, 112]];
        for (size, order) in [
            ("-Y 2 +X 3", [100, 101, 102, 110, 111, 112]),
            ("-Y 2 -X 3", [102, 101, 100, 112, 111, 110]),
            ("+Y 2 +X 3", [110, 111, 112, 100, 101, 102]),
            ("+Y 2 -X 3", [112, 111, 110, 102, 101, 100]),
            ("+X 3 -Y 2", [100, 110, 101, 111, 102, 112]),
            ("-X 3 -Y 2", [102, 112, 101, 111, 100, 110]),
            ("+X 3 +Y 2", [110, 100, 111, 101, 112, 102]),
            ("-X 3 +Y 2", [112, 102, 111, 101, 110, 100]),
        ] {
            let mut bytes = format!("#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
            // With green above all of them: red is no part of a code.
            order.iter().for_each(|&red| bytes.extend([red, 200, 0, 136]));
            let picture = read(&bytes, 6).unwrap();
            assert_eq!((picture.width, picture.height), (3, 2), "{size}");
            let reds: Vec<_> = picture.pixels.iter().map(|p| p[0] as u32).collect();
            assert_eq!(reds, expected.concat(), "{size}");
        }
    }

    #[test]
    fn what_was_done_to_other_pictures_is_not_done_to_this_one() {
        let head = "#?RADIANCE\npcomb a.hdr\n\tEXPOSURE=4\n\tFORMAT=32-bit_rle_xyze\n";
        let mut bytes = format!("{head}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n").into_bytes();
        bytes.extend([128, 64, 0, 129]);
        let half = 1.0 / 256.0;
        assert_eq!(read(&bytes, 1).unwrap().pixels, [[1.0 + half, 0.5 + half, half]]);
        let lines = "#?RADIANCE\nEXPOSURE=1e-30\nEXPOSURE=1e-30\n\n-Y 1 +X 1\n";
        let (header, _) = Header::read(lines.as_bytes()).unwrap();
        assert_eq!(header.exposure, 1.0);
    }

    /// The mark of run lengths has 15 bits for the width.
    #[test]
    fn pictures_of_any_width_can_be_read_again() {
        for width in [1, 7, 8, 32_767, 32_768, 32_769] {
            let pixels = vec![[1.0, 0.5, 0.25]; 2 * width as usize];
            let mut bytes = Vec::new();
            write(&Picture { width, height: 2, pixels }, &mut bytes).unwrap();
            let back = read(&bytes, 1 << 20).unwrap();
            assert_eq!((back.width, back.height), (width, 2));
            let half = 1.0 / 256.0;
            assert!(back.pixels.iter().all(|p| *p == [1.0 + half, 0.5 + half, 0.25 + half]));
        }
    }

    #[test]
    fn what_is_not_read_is_named() {
        let error = |text: &str| read(text.as_bytes(), 100).unwrap_err().to_string();
        let head = "#?RADIANCE\nFORMAT=32-bit_rle_";
        assert!(error(&format!("{head}xyze\n\n-Y 1 +X 1\n")).contains("ra_xyze -r"));
        assert!(error(&format!("{head}spec\n\n-Y 1 +X 1\n")).contains("'32-bit_rle_spec'"));
        for size in ["-Y 1", "-Y 1 +Y 1", "-Y -1 +X 1", "-Y 0 +X 9", "+Z 1 -Y 1", "-Y 2 +X 2"] {
            let message = error(&format!("{head}rgbe\n\n{size}\n"));
            assert!(message.contains("damaged"), "{size}: {message}");
        }
        assert!(error(&format!("{head}rgbe\n\n-Y 11 +X 10\n")).contains("10 x 11"));
        assert!(error(head).contains("no end"));
    }
}
