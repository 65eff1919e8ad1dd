//! OpenEXR, 32-bit floats.

use std::io::{self, Cursor};

use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, SpecificChannels,
    WritableImage, read as reader,
};

use super::Picture;

/// The bytes of an `.exr` file: red, green and blue, compressed without loss.
pub(super) fn write(picture: &Picture) -> io::Result<Vec<u8>> {
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
pub(super) fn read(bytes: &[u8]) -> Result<Picture, String> {
    let image = reader()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Picture {
                width: size.width() as u32,
                height: size.height() as u32,
                pixels: vec![[0.0; 3]; size.area()],
            },
            |picture: &mut Picture, at, (r, g, b): (f32, f32, f32)| {
                picture.pixels[at.y() * picture.width as usize + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    Ok(image.layer_data.channel_data.pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_survive() {
        let values = [1.0, -0.0, 1e-40, 3.4e38, f32::INFINITY, 0.1];
        let pixels = (0..35).map(|i| [values[i % 6], values[i / 6], i as f32]).collect();
        let picture = Picture { width: 7, height: 5, pixels };
        let back = read(&write(&picture).unwrap()).unwrap();
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
            assert!(read(&bytes[..end]).is_err());
        }
    }
}
