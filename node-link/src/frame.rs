//! A packet as a frame: the packet and its CRC-32 (ISO-HDLC, little-endian), without zeros by consistent overhead byte stuffing (Cheshire & Baker
//! 1999), and a zero at the end.
//!
//! A zero is nothing but the end of a frame, so whoever begins to listen in the midst of one, or hears noise, is in step again at the next zero.

use cobs::{CobsEncoder, DecodeResult, DecoderState};
use kiloray_core::block::checksum;

/// What a decoded frame holds behind its packet: room for it must be given too.
pub const CRC_BYTES: usize = 4;

/// Greatest length of the frame of a packet of so many bytes.
#[must_use]
pub const fn frame_bytes(packet_bytes: usize) -> usize {
    let content = packet_bytes + CRC_BYTES;
    // One byte for each 254 begun, and the zero.
    content + content.div_ceil(254) + 1
}

/// Writes the frame of a packet, and gives its length; `None` if there is too little room.
#[must_use]
pub fn encode(packet: &[u8], into: &mut [u8]) -> Option<usize> {
    let (_, room) = into.split_last_mut()?;
    let mut encoder = CobsEncoder::new(room);
    encoder.push(packet).ok()?;
    encoder.push(&checksum(packet).to_le_bytes()).ok()?;
    let len = encoder.finalize();
    match into.get_mut(len) {
        Some(last) => *last = 0,
        None => return None,
    }
    Some(len.saturating_add(1))
}

/// Reads frames from bytes that come one by one.
#[derive(Debug, Default)]
pub struct Decoder {
    state: DecoderState,
    len: usize,
    /// Longer than the room for it: the rest of it is skipped.
    too_long: bool,
}

/// A frame that is not what was sent, or none of ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Damaged;

impl Decoder {
    /// Before the first byte.
    #[must_use]
    pub const fn new() -> Self {
        Self { state: DecoderState::Idle, len: 0, too_long: false }
    }

    /// Takes the next byte. At the end of a frame its packet lies in `into`, of which the same must be given for all bytes of a frame: the packet's
    /// length, which is at most that of `into` less [`CRC_BYTES`].
    pub fn push(&mut self, byte: u8, into: &mut [u8]) -> Option<Result<usize, Damaged>> {
        match self.state.feed(byte) {
            Ok(DecodeResult::NoData) => None,
            Ok(DecodeResult::DataStart) => {
                (self.len, self.too_long) = (0, false);
                None
            }
            Ok(DecodeResult::DataContinue(byte)) => {
                match into.get_mut(self.len) {
                    Some(place) => *place = byte,
                    None => self.too_long = true,
                }
                self.len = self.len.saturating_add(1);
                None
            }
            Ok(DecodeResult::DataComplete) => Some(self.packet(into)),
            Err(_) => Some(Err(Damaged)),
        }
    }

    fn packet(&self, into: &[u8]) -> Result<usize, Damaged> {
        let content = into.get(..self.len).filter(|_| !self.too_long).ok_or(Damaged)?;
        let (packet, crc) = content.split_last_chunk::<CRC_BYTES>().ok_or(Damaged)?;
        if u32::from_le_bytes(*crc) != checksum(packet) {
            return Err(Damaged);
        }
        Ok(packet.len())
    }
}
