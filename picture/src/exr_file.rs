//! OpenEXR, 32-bit floats.

use std::io::{self, Cursor};

use exr::{
    meta::MetaData,
    prelude::{
        Encoding, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, SpecificChannels,
        WritableImage, read as reader,
    },
};

use super::{
    Picture,
    read::{Error, black},
};

/// The bytes of an `.exr` file: red, green and blue, compressed without loss.
///
/// # Errors
/// A picture that cannot be in such a file.
pub fn write(picture: &Picture) -> io::Result<Vec<u8>> {
    let size = (picture.width as usize, picture.height as usize);
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
        let [r, g, b] = picture.pixels[at.y() * picture.width as usize + at.x()];
        (r, g, b)
    });
    let layer =
        Layer::new(size, LayerAttributes::named("radiance"), Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}

/// Reads the first layer with red, green and blue.
pub(crate) fn read(bytes: &[u8], pixels_max: u64) -> Result<Picture, Error> {
    let damaged = |error: exr::error::Error| Error::Damaged(error.to_string());
    // Before there is memory for any layer.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(damaged)?;
    for header in &meta.headers {
        let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
        let (width, height) = (side(header.layer_size.width()), side(header.layer_size.height()));
        if u64::from(width) * u64::from(height) > pixels_max {
            return Err(Error::Size { width, height });
        }
    }
    let image = reader()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| black(size.width() as u32, size.height() as u32, pixels_max),
            |picture: &mut Result<Picture, Error>, at, (r, g, b): (f32, f32, f32)| {
                if let Ok(picture) = picture {
                    picture.pixels[at.y() * picture.width as usize + at.x()] = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(damaged)?;
    image.layer_data.channel_data.pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_survive() {
        let values = [1.0, -0.0, 1e-40, 3.4e38, f32::INFINITY, 0.1];
        let pixels = (0..35).map(|i| [values[i % 6], values[i / 6], i as f32]).collect();
        let picture = Picture { width: 7, height: 5, pixels };
        let back = read(&write(&picture).unwrap(), 35).unwrap();
        assert_eq!((back.width, back.height), (7, 5));
        let bits =
            |p: &Picture| -> Vec<_> { p.pixels.iter().flatten().map(|c| c.to_bits()).collect() };
        assert_eq!(bits(&back), bits(&picture));
    }

    #[test]
    fn damage_is_an_error() {
        let picture = Picture { width: 9, height: 9, pixels: vec![[0.5; 3]; 81] };
        let bytes = write(&picture).unwrap();
        for end in [0, 3, 20, bytes.len() / 2] {
            assert!(matches!(read(&bytes[..end], 81), Err(Error::Damaged(_))));
        }
        assert_eq!(read(&bytes, 80), Err(Error::Size { width: 9, height: 9 }));
    }
}
