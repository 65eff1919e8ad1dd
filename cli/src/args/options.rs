use std::{fmt, path::PathBuf, str::FromStr};

use clap::{Args, ValueEnum, ValueHint};
use kiloray_core::shade::Settings;
use serde::Serialize;

use super::size::parse_bytes;

/// Greatest width or height of a picture.
const SIDE_MAX: u32 = 65_536;
/// Most pixels of a picture.
const PIXELS_MAX: u64 = 1 << 28;

/// Least size of a block \[bytes\].
pub(crate) const BLOCK_MIN: u32 = 1 << 10;

/// Options of all commands that render.
#[derive(Debug, Clone, Args, Serialize)]
pub(crate) struct Common {
    /// Width of the picture in pixels [default: 512, or by the height and the view]
    #[arg(long, value_name = "PIXELS", value_parser = side, allow_hyphen_values = true, help_heading = "Picture")]
    pub(crate) width: Option<u32>,
    /// Height of the picture in pixels [default: by the width and the view]
    #[arg(long, value_name = "PIXELS", value_parser = side, allow_hyphen_values = true, help_heading = "Picture")]
    pub(crate) height: Option<u32>,
    /// A view of the scene by name or number (from 1), a .vf file, or its options ("-vp 0 0 1 -vd 0 1 0") [default: the first]
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true, help_heading = "Picture")]
    pub(crate) view: Option<ViewChoice>,
    /// Brightness of a PNG: 'auto', or the power of two that radiance is multiplied by
    #[arg(long, value_name = "STOPS", default_value_t = Exposure::Auto, allow_hyphen_values = true, help_heading = "Picture")]
    pub(crate) exposure: Exposure,

    /// Camera paths for each pixel
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = samples, allow_hyphen_values = true, help_heading = "Light")]
    pub(crate) samples: u32,
    /// Shadow rays for each light and point, at a distance of 4 times the light's side; more where it is nearer, up to 4096, always a power of two
    /// [default: as many as its size and distance ask for]
    #[arg(long, value_name = "N", value_parser = shadow_samples, allow_hyphen_values = true, help_heading = "Light")]
    pub(crate) shadow_samples: Option<u16>,
    /// About how many lights a point asks at most, where there are more: by chance, in proportion to what each would bring. Fewer are quicker, and noisier
    #[arg(long, value_name = "N", default_value_t = Settings::default().lights, value_parser = lights_per_point, allow_hyphen_values = true, help_heading = "Light")]
    pub(crate) lights_per_point: u16,
    /// Most reflections and refractions on a path
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = bounces, allow_hyphen_values = true, help_heading = "Light")]
    pub(crate) bounces: u32,
    /// Which light is computed
    #[arg(long, value_name = "KIND", value_enum, default_value_t = Lighting::Direct, help_heading = "Light")]
    pub(crate) lighting: Lighting,
    /// Where the random numbers begin: the same seed gives the same picture
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = seed,
        allow_hyphen_values = true,
        help_heading = "Light"
    )]
    pub(crate) seed: u64,

    /// Memory of the node, as in 64KiB: the scene stays in its file, blocks are fetched [default: no limit]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes, allow_hyphen_values = true, help_heading = "Machine")]
    pub(crate) memory: Option<u64>,
    /// Size of a block: 1KiB to 64KiB, a power of two [default: 4KiB below 512KiB of memory, else 16KiB]
    #[arg(long, value_name = "SIZE", value_parser = block, allow_hyphen_values = true, help_heading = "Machine")]
    pub(crate) block: Option<u32>,
    /// Threads to use [default: all cores; a node with --memory is one thread]
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true, help_heading = "Machine")]
    pub(crate) threads: Option<u32>,

    /// Write options, hash, counts and memory as JSON ('-' for the standard output)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Report")]
    pub(crate) json: Option<PathBuf>,
    /// Write a page about the run (index.html, report.json, the pictures) into this directory
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath, help_heading = "Report")]
    pub(crate) report: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long, help_heading = "Report")]
    pub(crate) quiet: bool,
}

/// Fewer camera rays than pixels.
#[derive(Debug, Clone, Args)]
pub(crate) struct Undersampling {
    /// Trace the corners of squares of so many pixels first (1, 2, 4, 8, 16 or 32), the pixels within only where corners differ, and interpolate the rest:
    /// quicker, with a small error; what is smaller than a square may be missed
    #[arg(long, value_name = "PIXELS", default_value_t = 1, value_parser = spacing, allow_hyphen_values = true, help_heading = "Picture")]
    pub(crate) pixel_spacing: u32,
    /// By how much the corners of a square may differ that is interpolated: a part of the darkest's brightness, or of the picture's usual one where that is more
    #[arg(long, value_name = "PART", default_value_t = 0.1, value_parser = part, requires = "pixel_spacing", allow_hyphen_values = true, help_heading = "Picture")]
    pub(crate) pixel_contrast: f64,
}

/// What light is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Lighting {
    /// From lights straight, by mirrors and through glass
    Direct,
}

/// Which view.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(crate) enum ViewChoice {
    /// By its place in the scene, from 1.
    Number(u32),
    /// By its name.
    Name(String),
    /// A `.vf` file, or the options that such a file holds.
    Options(String),
}

impl FromStr for ViewChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.starts_with('-') || text.to_ascii_lowercase().ends_with(".vf") {
            return Ok(Self::Options(text.into()));
        }
        match text.parse() {
            Ok(0) => Err("views are counted from 1".into()),
            Ok(number) => Ok(Self::Number(number)),
            Err(_) if text.is_empty() => Err("a view has a name".into()),
            Err(_) => Ok(Self::Name(text.into())),
        }
    }
}

/// Brightness of a picture for the eye.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged, into = "Option<f32>")]
pub(crate) enum Exposure {
    /// By the picture.
    Auto,
    /// Radiance times two to this power.
    Stops(f32),
}

impl From<Exposure> for Option<f32> {
    fn from(exposure: Exposure) -> Self {
        match exposure {
            Exposure::Auto => None,
            Exposure::Stops(stops) => Some(stops),
        }
    }
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse::<f32>() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(stops) if stops.abs() <= 100.0 => Ok(Self::Stops(stops)),
            _ => Err("write 'auto' or a number of stops from -100 to 100".into()),
        }
    }
}

impl fmt::Display for Exposure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Stops(stops) => write!(f, "{stops}"),
        }
    }
}

/// A picture's size that is possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Bounds {
    /// By what was asked for, and the ratio of width to height of the view.
    pub(crate) fn new(
        width: Option<u32>,
        height: Option<u32>,
        aspect: f64,
    ) -> Result<Self, String> {
        let round = |side: f64| (side.round() as u32).clamp(1, SIDE_MAX);
        let (width, height) = match (width, height) {
            (Some(width), Some(height)) => (width, height),
            (Some(width), None) => (width, round(f64::from(width) / aspect)),
            (None, Some(height)) => (round(f64::from(height) * aspect), height),
            // The longer side is 512.
            (None, None) if aspect >= 1.0 => (512, round(512.0 / aspect)),
            (None, None) => (round(512.0 * aspect), 512),
        };
        if u64::from(width) * u64::from(height) > PIXELS_MAX {
            return Err(format!(
                "a picture of {width} x {height} has more than the {PIXELS_MAX} pixels that are \
                 possible; make it smaller"
            ));
        }
        Ok(Self { width, height })
    }
}

pub(super) fn whole(text: &str, min: u32, max: u32) -> Result<u32, String> {
    text.parse()
        .ok()
        .filter(|n| (min..=max).contains(n))
        .ok_or_else(|| format!("write a whole number from {min} to {max}"))
}

pub(super) fn side(text: &str) -> Result<u32, String> {
    whole(text, 1, SIDE_MAX)
}

fn spacing(text: &str) -> Result<u32, String> {
    let most = kiloray_render::Undersampling::SPACING_MAX;
    text.parse()
        .ok()
        .filter(|n: &u32| n.is_power_of_two() && *n <= most)
        .ok_or_else(|| format!("write a power of two from 1 to {most}"))
}

fn samples(text: &str) -> Result<u32, String> {
    whole(text, 1, Settings::SAMPLES_MAX)
}

pub(super) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("write a whole number from 0 to {}", u64::MAX))
}

fn shadow_samples(text: &str) -> Result<u16, String> {
    whole(text, 1, Settings::BUNDLE_MAX).map(|n| n as u16)
}

fn lights_per_point(text: &str) -> Result<u16, String> {
    whole(text, 1, u16::MAX.into()).map(|n| n as u16)
}

pub(super) fn bounces(text: &str) -> Result<u32, String> {
    whole(text, 0, Settings::BOUNCES_MAX.into())
}

pub(super) fn threads(text: &str) -> Result<u32, String> {
    whole(text, 1, 1024)
}

pub(super) fn block(text: &str) -> Result<u32, String> {
    let bytes = parse_bytes(text)?;
    if bytes.is_power_of_two() && (BLOCK_MIN.into()..=1 << 16).contains(&bytes) {
        Ok(bytes as u32)
    } else {
        Err("a block is 1KiB, 2KiB, 4KiB, 8KiB, 16KiB, 32KiB or 64KiB".into())
    }
}

pub(super) fn lights(text: &str) -> Result<u32, String> {
    whole(text, 0, u32::MAX)
}

pub(super) fn part(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|x: &f64| (0.0..=1e9).contains(x))
        .ok_or_else(|| "write a number that is not negative, as in 0.05 for 5 %".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_given_follows_the_view() {
        let size = |w, h, aspect| Bounds::new(w, h, aspect).map(|b| (b.width, b.height));
        assert_eq!(size(None, None, 1.6), Ok((512, 320)));
        assert_eq!(size(None, None, 0.5), Ok((256, 512)));
        assert_eq!(size(Some(300), None, 1.5), Ok((300, 200)));
        assert_eq!(size(None, Some(300), 1.5), Ok((450, 300)));
        assert_eq!(size(Some(3), Some(7), 1.5), Ok((3, 7)));
        assert_eq!(size(Some(1), None, 1e9), Ok((1, 1)));
        assert!(size(Some(65_536), Some(65_536), 1.0).is_err());
    }

    #[test]
    fn blocks_are_powers_of_two() {
        assert_eq!(block("4KiB"), Ok(4096));
        for text in ["512", "5KiB", "128KiB", "0"] {
            assert!(block(text).is_err(), "{text}");
        }
    }

    #[test]
    fn exposures_are_auto_or_stops() {
        assert_eq!("auto".parse(), Ok(Exposure::Auto));
        assert_eq!("-1.5".parse(), Ok(Exposure::Stops(-1.5)));
        for text in ["NaN", "inf", "bright", "", "1000"] {
            assert!(text.parse::<Exposure>().is_err(), "{text}");
        }
    }
}
