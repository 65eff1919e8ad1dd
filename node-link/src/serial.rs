use core::future::pending;

use embedded_io_async::{Read, Write};
use kiloray_core::node::{Receive, Transmit};

use crate::Tally;
use crate::frame::{Decoder, encode};

/// Bytes that are read at a time, at most.
const CHUNK: usize = 64;

/// The half of a serial link that packets come from.
///
/// What it writes a packet to must have [`CRC_BYTES`](crate::frame::CRC_BYTES) more room than the longest packet.
#[derive(Debug)]
pub struct Receiver<'t, R> {
    reader: R,
    decoder: Decoder,
    chunk: [u8; CHUNK],
    /// What of the chunk was not decoded yet.
    at: usize,
    end: usize,
    tally: &'t Tally,
}

impl<'t, R: Read> Receiver<'t, R> {
    /// Frames of a reader.
    pub const fn new(reader: R, tally: &'t Tally) -> Self {
        let decoder = Decoder::new();
        Self { reader, decoder, chunk: [0; CHUNK], at: 0, end: 0, tally }
    }

    /// Where it counts.
    pub(crate) const fn tally(&self) -> &'t Tally {
        self.tally
    }

    async fn byte(&mut self) -> u8 {
        loop {
            if let Some(&byte) = self.chunk.get(self.at..self.end).and_then(<[u8]>::first) {
                self.at = self.at.saturating_add(1);
                return byte;
            }
            match self.reader.read(&mut self.chunk).await {
                Ok(len) if len > 0 => {
                    (self.at, self.end) = (0, len);
                    self.tally.update(|counts| counts.received_bytes += len as u64);
                }
                _ => {
                    self.tally.update(|counts| counts.broken = true);
                    pending::<()>().await;
                }
            }
        }
    }
}

impl<R: Read> Receive for Receiver<'_, R> {
    async fn receive(&mut self, into: &mut [u8]) -> usize {
        loop {
            let byte = self.byte().await;
            match self.decoder.push(byte, into) {
                Some(Ok(len)) => {
                    self.tally.update(|counts| counts.received = counts.received.wrapping_add(1));
                    return len;
                }
                Some(Err(_)) => {
                    self.tally.update(|counts| counts.damaged = counts.damaged.wrapping_add(1));
                }
                None => {}
            }
        }
    }
}

/// The half of a serial link that takes packets.
#[derive(Debug)]
pub struct Sender<'t, W, B> {
    writer: W,
    room: B,
    tally: &'t Tally,
}

impl<'t, W: Write, B: AsMut<[u8]>> Sender<'t, W, B> {
    /// Frames to a writer, each made in `room`: [`frame_bytes`](crate::frame::frame_bytes) of the longest packet.
    pub const fn new(writer: W, room: B, tally: &'t Tally) -> Self {
        Self { writer, room, tally }
    }
}

impl<W: Write, B: AsMut<[u8]>> Transmit for Sender<'_, W, B> {
    async fn transmit(&mut self, packet: &[u8]) {
        // One that is too long for the room is lost, like a damaged one.
        let room = self.room.as_mut();
        let len = encode(packet, room).unwrap_or(0);
        let frame = room.get(..len).unwrap_or_default();
        let written = async {
            self.writer.write_all(frame).await?;
            self.writer.flush().await
        };
        let written = written.await;
        self.tally.update(|counts| match written {
            Ok(()) => {
                counts.sent = counts.sent.wrapping_add(1);
                counts.sent_bytes += len as u64;
            }
            Err(_) => counts.broken = true,
        });
    }
}
