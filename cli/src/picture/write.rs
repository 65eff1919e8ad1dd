use std::{io, path::Path};

use kiloray_picture::{write_exr, write_hdr, write_png};

use super::{Picture, auto_exposure, tone_mapped};
use crate::{
    args::Exposure,
    failure::{Failure, Outcome},
    output::Output,
};

/// The kinds of picture file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    /// For the eye.
    Png,
    /// Radiance RGBE.
    Hdr,
    /// OpenEXR, 32-bit floats.
    Exr,
}

/// What became of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Saved {
    /// Stops, where the format has them.
    pub(crate) exposure: Option<f32>,
}

impl Saved {
    /// What is said of it behind the samples.
    pub(crate) fn said(&self) -> String {
        self.exposure.map_or_else(String::new, |stops| format!(", exposure {stops}"))
    }
}

impl Format {
    /// By the extension of the name.
    pub(crate) fn of(path: &Path) -> Outcome<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("hdr" | "pic") => Ok(Self::Hdr),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Failure::usage(format_args!(
                "{}: a picture's name ends in .png, .hdr or .exr",
                path.display()
            ))),
        }
    }
}

/// Writes a picture.
pub(crate) fn save(
    picture: &Picture,
    format: Format,
    exposure: Exposure,
    output: Output,
) -> Outcome<Saved> {
    match format {
        Format::Png => {
            let stops = match exposure {
                Exposure::Auto => auto_exposure(picture),
                Exposure::Stops(stops) => stops,
            };
            let pixels = tone_mapped(picture, stops);
            output.write_with(|out| write_png(picture.width, picture.height, &pixels, out))?;
            Ok(Saved { exposure: Some(stops) })
        }
        Format::Hdr => {
            output.write_with(|out| write_hdr(picture, out))?;
            Ok(Saved { exposure: None })
        }
        Format::Exr => {
            let bytes = write_exr(picture).map_err(Failure::new)?;
            output.write(&bytes)?;
            Ok(Saved { exposure: None })
        }
    }
}

/// A PNG file of 8-bit RGB.
pub(crate) fn png_bytes(width: u32, height: u32, rgb: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_png(width, height, rgb, &mut bytes)?;
    Ok(bytes)
}
