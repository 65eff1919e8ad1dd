//! A packet as bytes of a line.

use std::vec::Vec;

use proptest::prelude::*;

use crate::frame::{CRC_BYTES, Damaged, Decoder, encode, frame_bytes};

/// Longest packet of the tests.
const PACKET: usize = 600;

fn framed(packet: &[u8]) -> Vec<u8> {
    let mut frame = vec![0xaa; frame_bytes(packet.len())];
    let len = encode(packet, &mut frame).expect("there is room");
    frame.truncate(len);
    frame
}

/// All that a stream of bytes brings, packet by packet.
fn heard(stream: &[u8], room: usize) -> Vec<Result<Vec<u8>, Damaged>> {
    let (mut decoder, mut into) = (Decoder::new(), vec![0; room]);
    let mut all = Vec::new();
    for &byte in stream {
        let end = decoder.push(byte, &mut into);
        all.extend(end.map(|end| end.map(|len| into[..len].to_vec())));
    }
    all
}

#[test]
fn a_frame_is_the_packet_and_its_checksum_without_zeros() {
    // CRC-32 of "123456789" is 0xcbf43926 (the check value of the catalogue of parametrised CRC algorithms).
    let frame = framed(b"123456789");
    assert_eq!(frame, *b"\x0e123456789\x26\x39\xf4\xcb\x00");
    // CRC-32 of a zero byte is 0xd202ef8d: the zero becomes a distance.
    assert_eq!(framed(&[0]), [1, 5, 0x8d, 0xef, 0x02, 0xd2, 0]);
}

fn packets() -> impl Strategy<Value = Vec<Vec<u8>>> {
    // Zeros and long runs without them are what matters.
    let byte = prop_oneof![2 => Just(0_u8), 1 => Just(0xff), 4 => any::<u8>()];
    let some = prop::collection::vec(byte, 0..PACKET);
    let full = prop::collection::vec(1_u8.., 240..PACKET);
    prop::collection::vec(prop_oneof![some, full], 0..4)
}

proptest! {
    #[test]
    fn packets_arrive_as_they_were_sent(packets in packets()) {
        let stream: Vec<u8> = packets.iter().flat_map(|packet| framed(packet)).collect();
        for packet in &packets {
            let frame = framed(packet);
            prop_assert!(frame.len() <= frame_bytes(packet.len()));
            prop_assert_eq!(frame.iter().position(|&b| b == 0), Some(frame.len() - 1));
        }
        let expected: Vec<_> = packets.into_iter().map(Ok).collect();
        prop_assert_eq!(heard(&stream, PACKET + CRC_BYTES), expected);
    }

    #[test]
    fn too_little_room_is_no_frame(packet in prop::collection::vec(any::<u8>(), 0..PACKET), less in 1_usize..40) {
        let len = framed(&packet).len();
        prop_assert_eq!(encode(&packet, &mut vec![0; len.saturating_sub(less)]), None);
    }

    #[test]
    fn a_frame_that_is_too_long_is_damaged_and_the_next_is_not(
        packet in prop::collection::vec(any::<u8>(), 1..PACKET), less in 1_usize..40,
    ) {
        let less = less.min(packet.len());
        let mut stream = framed(&packet);
        stream.extend(framed(&[]));
        let room = packet.len() + CRC_BYTES - less;
        prop_assert_eq!(heard(&stream, room), [Err(Damaged), Ok(Vec::new())]);
    }

    #[test]
    fn noise_costs_no_more_than_the_frames_it_touches(
        packets in packets(), noise in prop::collection::vec(any::<u8>(), 1..8), seed: u64,
    ) {
        let frames: Vec<Vec<u8>> = packets.iter().map(|packet| framed(packet)).collect();
        let mut stream = frames.concat();
        let at = (seed % (stream.len() as u64 + 1)) as usize;
        // Written over what was sent, or between two bytes of it.
        if seed & 1 << 40 == 0 {
            stream.splice(at..at, noise.iter().copied());
        } else {
            let end = stream.len().min(at + noise.len());
            stream.splice(at..end, noise.iter().copied());
        }
        let heard: Vec<_> = heard(&stream, PACKET + CRC_BYTES);
        let sound: Vec<_> = heard.into_iter().filter_map(Result::ok).collect();
        // Those that end before the noise, and those that begin behind the first zero after it.
        let touched = |begin: usize, len: usize| begin + len > at && begin <= at + noise.len();
        let mut begin = 0;
        let mut untouched = Vec::new();
        for (packet, frame) in packets.iter().zip(&frames) {
            if !touched(begin, frame.len()) {
                untouched.push(packet.clone());
            }
            begin += frame.len();
        }
        // The frame behind the noise may be joined to it, where its end was lost: one more at most is missing.
        let missing = untouched.iter().filter(|packet| !sound.contains(packet)).count();
        prop_assert!(missing <= 1, "{missing} of {} are missing", untouched.len());
        // And nothing was made up.
        prop_assert!(sound.iter().all(|packet| packets.contains(packet) || packet.is_empty()));
    }
}
