//! From radiance to what a screen shows.
//!
//! The luminance curve is the global operator of Reinhard et al., "Photographic Tone Reproduction
//! for Digital Images" (2002): equation 4, after a scaling that takes the logarithmic mean to 0.18
//! (equations 1 and 2).

use kiloray_picture::encode_srgb;

use super::{Picture, luminance};

/// Middle grey, to which the mean is taken.
const KEY: f64 = 0.18;
/// Scaled luminance that becomes white: what is brighter is clipped.
const WHITE: f64 = 4.0;

/// The power of two that takes the logarithmic mean of the luminance to middle grey; black pixels
/// and those that are no numbers do not count.
pub(crate) fn auto_exposure(picture: &Picture) -> f32 {
    let logs = picture.pixels.iter().map(|&p| luminance(p)).filter(|&l| l > 0.0 && l.is_finite());
    let (sum, count) = logs.fold((0.0, 0u64), |(sum, count), l| (sum + l.log2(), count + 1));
    if count == 0 {
        return 0.0;
    }
    let stops = KEY.log2() - sum / count as f64;
    // Tenths are enough, and can be typed again.
    let tenths = (stops * 10.0).round() + 0.0;
    (tenths / 10.0).clamp(-100.0, 100.0) as f32
}

/// The picture as 8-bit sRGB.
pub(crate) fn tone_mapped(picture: &Picture, stops: f32) -> Vec<u8> {
    let scale = f64::from(stops).exp2();
    let byte = |c: f64| (encode_srgb(c) * 255.0 + 0.5) as u8;
    picture
        .pixels
        .iter()
        .flat_map(|&pixel| {
            let l = scale * luminance(pixel).max(0.0);
            // Equation 4 over L.
            let curve = scale * (1.0 + l / (WHITE * WHITE)) / (1.0 + l);
            let curve = if curve.is_finite() { curve } else { scale / (WHITE * WHITE) };
            pixel.map(|c| byte(f64::from(c) * curve))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[f32]) -> Picture {
        let pixels = values.iter().map(|&v| [v; 3]).collect();
        Picture { width: values.len() as u32, height: 1, pixels }
    }

    #[test]
    fn the_mean_becomes_middle_grey() {
        // Geometric mean 4: log2(0.18 / 4) = -4.474.
        assert_eq!(auto_exposure(&grey(&[2.0, 8.0, 0.0, f32::NAN])), -4.5);
        assert_eq!(auto_exposure(&grey(&[0.0])), 0.0);
    }

    #[test]
    fn known_values() {
        // By hand: L = 1 gives (1 + 1/16) / 2 = 0.53125, in sRGB 0.7558, of 255: 192.7. White at L = 4.
        let mapped = tone_mapped(&grey(&[0.0, 1.0, 4.0, 1e30, f32::INFINITY, f32::NAN, -1.0]), 0.0);
        let first: Vec<_> = mapped.chunks(3).map(|p| p[0]).collect();
        assert_eq!(first, [0, 193, 255, 255, 255, 0, 0]);
    }
}
