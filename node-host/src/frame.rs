/// What stands before the packets of a message on the network: which process has sent them, and for which one they are.
///
/// Packets that leave together for one neighbour are one message, each behind its length: a message costs several switches between
/// threads at both ends, a packet nothing.
///
/// A process that is replaced by another under the same name has another incarnation. What its neighbours sent to the last one, or the last one to
/// them, is dropped: routers count packets from the beginning of both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Incarnation of the sender.
    pub from: u32,
    /// Incarnation of the receiver.
    pub to: u32,
}

impl Frame {
    /// Its length \[bytes\].
    pub const BYTES: usize = 8;

    /// The bytes before the packets.
    #[must_use]
    pub fn bytes(self) -> [u8; Self::BYTES] {
        let ([a, b, c, d], [e, f, g, h]) = (self.from.to_le_bytes(), self.to.to_le_bytes());
        [a, b, c, d, e, f, g, h]
    }

    /// Adds a packet to a message.
    pub fn add(message: &mut Vec<u8>, packet: &[u8]) {
        let len = u16::try_from(packet.len()).unwrap_or(u16::MAX);
        message.extend_from_slice(&len.to_le_bytes());
        message.extend_from_slice(packet.get(..usize::from(len)).unwrap_or(packet));
    }

    /// The first packet of those of a message, and the others. `None` if there is none: the message has come to its end, or is broken.
    #[must_use]
    pub fn next(packets: &[u8]) -> Option<(&[u8], &[u8])> {
        let (len, rest) = packets.split_first_chunk()?;
        rest.split_at_checked(usize::from(u16::from_le_bytes(*len)))
    }

    /// Whether these are packets of at most so many bytes, and nothing else.
    #[must_use]
    pub fn is_whole(mut packets: &[u8], most: usize) -> bool {
        while let Some((packet, rest)) = Self::next(packets) {
            if packet.len() > most {
                return false;
            }
            packets = rest;
        }
        packets.is_empty()
    }

    /// Splits what has come into this and the packets; `None` if it is too short.
    #[must_use]
    pub fn split(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (from, rest) = bytes.split_first_chunk()?;
        let (to, packets) = rest.split_first_chunk()?;
        Some((Self { from: u32::from_le_bytes(*from), to: u32::from_le_bytes(*to) }, packets))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_two_little_endian_numbers() {
        let frame = Frame { from: 0x0403_0201, to: 0x0807_0605 };
        assert_eq!(frame.bytes(), [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(Frame::split(&[1, 2, 3, 4, 5, 6, 7, 8, 9]), Some((frame, &[9][..])));
        assert_eq!(Frame::split(&[1, 2, 3, 4, 5, 6, 7]), None);
    }

    #[test]
    fn packets_stand_behind_their_lengths() {
        let mut message = Vec::new();
        Frame::add(&mut message, &[7, 8, 9]);
        Frame::add(&mut message, &[]);
        Frame::add(&mut message, &[1]);
        assert_eq!(message, [3, 0, 7, 8, 9, 0, 0, 1, 0, 1]);
        let (first, rest) = Frame::next(&message).unwrap();
        assert_eq!((first, rest), (&[7, 8, 9][..], &message[5..]));
        let (second, rest) = Frame::next(rest).unwrap();
        let (third, rest) = Frame::next(rest).unwrap();
        assert_eq!((second, third, rest), (&[][..], &[1][..], &[][..]));
        assert_eq!(Frame::next(rest), None);
        assert!(Frame::is_whole(&message, 3) && Frame::is_whole(&[], 0));
        assert!(!Frame::is_whole(&message, 2), "a packet is too long");
        assert!(!Frame::is_whole(&message[..9], 3), "the last one is cut short");
        assert!(!Frame::is_whole(&message[..8], 3), "a length is cut short");
    }
}
