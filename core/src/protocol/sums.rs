//! The sums of a tile on their way to the host: all channels take as many bytes as the greatest needs.
//!
//! Sums are 64-bit integers, so that a quarter of a million samples of the brightest radiance fit. Most pixels are far darker, and have few samples:
//! of 24 bytes 15 are left. All ways to the host end in two links.

use crate::shade::Sum;

/// Bytes of a channel that is left as it is.
pub const WIDTH_MAX: u8 = 8;

/// Packs sums where they lie, to the front: how many bytes a channel takes, 1 to [`WIDTH_MAX`].
pub fn pack(sums: &mut [Sum]) -> u8 {
    // With the sign.
    let bits = |x: i64| 65_u32.saturating_sub((x ^ (x >> 63)).leading_zeros());
    let most = sums.iter().flat_map(|sum| sum.0).map(bits).fold(1, u32::max);
    let width = most.div_ceil(8).min(WIDTH_MAX.into()) as usize;
    let channels = sums.len().saturating_mul(3);
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(sums);
    for channel in 0..channels {
        let wide = bytes.get(channel.saturating_mul(8)..).and_then(|bytes| bytes.first_chunk());
        let packed = i64::from_ne_bytes(wide.copied().unwrap_or_default()).to_le_bytes();
        let place = bytes.get_mut(channel.saturating_mul(width)..).unwrap_or_default();
        for (to, from) in place.iter_mut().zip(packed).take(width) {
            *to = from;
        }
    }
    width as u8
}

/// The sums in these bytes, of which each channel takes so many; `None` if there are no such sums.
pub fn unpack(bytes: &[u8], width: u8) -> Option<impl ExactSizeIterator<Item = Sum>> {
    let width = Some(width).filter(|width| (1..=WIDTH_MAX).contains(width))?;
    let sums = bytes.chunks_exact(3 * usize::from(width));
    sums.remainder().is_empty().then(|| {
        sums.map(move |sum| {
            let mut channels = sum.chunks_exact(width.into());
            Sum([(); 3].map(|()| channel(channels.next().unwrap_or_default())))
        })
    })
}

/// A number of up to eight bytes, with its sign.
fn channel(bytes: &[u8]) -> i64 {
    let sign = bytes.last().map_or(0, |&last| (last.cast_signed() >> 7).cast_unsigned());
    let mut wide = [sign; 8];
    for (to, from) in wide.iter_mut().zip(bytes) {
        *to = *from;
    }
    i64::from_le_bytes(wide)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn packed(sums: &[Sum]) -> (u8, std::vec::Vec<u8>) {
        let mut room = sums.to_vec();
        let width = pack(&mut room);
        let len = 3 * usize::from(width) * sums.len();
        (width, bytemuck::cast_slice(&room)[..len].to_vec())
    }

    proptest! {
        #[test]
        fn sums_come_as_they_were(
            sums in prop::collection::vec((any::<[i64; 3]>(), 0_u32..64), 0..40),
        ) {
            let sums: std::vec::Vec<_> = sums.iter().map(|(sum, by)| Sum(sum.map(|x| x >> by))).collect();
            let (width, bytes) = packed(&sums);
            prop_assert_eq!(unpack(&bytes, width).unwrap().collect::<std::vec::Vec<_>>(), sums);
        }
    }

    #[test]
    fn a_channel_takes_what_the_greatest_needs() {
        let cases = [(0, 1), (127, 1), (-128, 1), (128, 2), (-129, 2), (1 << 39, 6)];
        let cases = cases.into_iter().chain([((1 << 39) - 1, 5), (i64::MAX, 8), (i64::MIN, 8)]);
        for (x, width) in cases {
            let sums = [Sum([0, 1, -1]), Sum([-1, x, 0]), Sum::ZERO];
            assert_eq!(packed(&sums).0, width, "{x}");
        }
        assert_eq!(packed(&[Sum([1, -2, 300])]), (2, [1, 0, 254, 255, 44, 1].to_vec()));
        assert_eq!(packed(&[]), (1, std::vec::Vec::new()));
    }

    #[test]
    fn what_are_no_sums_is_refused() {
        for (len, width) in [(3, 0), (27, 9), (765, 255), (4, 1), (7, 2), (25, 8)] {
            assert!(unpack(&[0; 765][..len], width).is_none(), "{len} {width}");
        }
        assert_eq!(unpack(&[], 8).unwrap().len(), 0);
        assert_eq!(unpack(&[0; 48], 8).unwrap().len(), 2);
    }
}
