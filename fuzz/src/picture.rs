//! Files that the command reads beside scenes: pictures to compare, and profiles of machines.

use kiloray_picture::{Picture, read, write_exr, write_hdr, write_png};
use kiloray_sim::Profile;

/// Small enough that a picture is read in milliseconds.
const PIXELS_MAX: u64 = 1 << 18;

fn picture(width: u32, height: u32) -> Picture {
    let pixel = |i: u32| [i % width, i / width, i].map(|c| c as f32 / 7.0);
    Picture { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// What `kiloray render` writes, and other kinds of lines.
pub(crate) fn exrs() -> Vec<Vec<u8>> {
    let sizes = [(1, 1), (9, 40), (70, 33)];
    sizes.map(|(w, h)| write_exr(&picture(w, h)).expect("it can be written")).to_vec()
}

/// With lines that are packed and such that are not, in two orientations.
pub(crate) fn hdrs() -> Vec<Vec<u8>> {
    let written = [(3, 2), (40, 9)].map(|(width, height)| {
        let mut bytes = Vec::new();
        write_hdr(&picture(width, height), &mut bytes).expect("it can be written");
        bytes
    });
    let mut turned = b"#?RGBE\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n+X 2 -Y 3\n".to_vec();
    turned.extend([9, 8, 7, 130, 1, 1, 1, 2, 4, 5, 6, 128, 1, 1, 1, 2]);
    [&written[..], &[turned]].concat()
}

/// Of eight bits, as all that is written.
pub(crate) fn pngs() -> Vec<Vec<u8>> {
    let bytes = |width: u32, height: u32| {
        let rgb: Vec<u8> = (0..width * height * 3).map(|i| (i * 7) as u8).collect();
        let mut bytes = Vec::new();
        write_png(width, height, &rgb, &mut bytes).expect("it can be written");
        bytes
    };
    vec![bytes(1, 1), bytes(30, 17)]
}

/// Any bytes are a picture within its limit, or an error in one line.
pub(crate) fn feed(input: &[u8]) -> String {
    match read(input, PIXELS_MAX) {
        Ok(picture) => {
            let pixels = u64::from(picture.width) * u64::from(picture.height);
            assert_eq!(picture.pixels.len() as u64, pixels);
            assert!(pixels <= PIXELS_MAX);
            "a picture".into()
        }
        Err(error) => kind(&error.to_string()),
    }
}

/// The same with sums of checks that are right: what is behind them is seldom reached else.
pub(crate) fn feed_png(input: &[u8]) -> String {
    let mut mended = input.to_vec();
    let mut rest = mended.get_mut(8..).unwrap_or_default();
    while let Some((length, after)) = rest.split_first_chunk_mut::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        let Some((chunk, after)) = after.split_at_mut_checked(length.saturating_add(4)) else {
            break;
        };
        let Some((sum, after)) = after.split_first_chunk_mut::<4>() else { break };
        *sum = crc(chunk).to_be_bytes();
        rest = after;
    }
    format!("{} {}", feed(input), feed(&mended))
}

/// The CRC of PNG.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 }
        })
    })
}

/// An answer up to what it names or counts.
fn kind(answer: &str) -> String {
    let end = |c: char| c.is_ascii_digit() || "'\"`".contains(c);
    answer.split(end).next().unwrap_or_default().to_owned()
}

/// The profiles that are built in.
pub(crate) fn profiles() -> Vec<Vec<u8>> {
    let text = |profile| serde_json::to_vec_pretty(profile).expect("it can be written");
    Profile::ALL.iter().map(text).collect()
}

/// Any bytes are a profile, or an error; what is one can be written again.
pub(crate) fn feed_profile(input: &[u8]) -> String {
    match serde_json::from_slice::<Profile>(input) {
        Ok(profile) => {
            let text = serde_json::to_vec(&profile).expect("it can be written");
            // Not the same to the bit: numbers of sixteen figures are read to the last but one.
            let again = serde_json::from_slice::<Profile>(&text);
            assert!(again.is_ok_and(|again| again.name == profile.name));
            "a profile".into()
        }
        Err(error) => kind(&error.to_string()),
    }
}
