/// What stands before a packet on the network: which process has sent it, and for which one it is.
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

    /// The bytes before a packet.
    #[must_use]
    pub fn bytes(self) -> [u8; Self::BYTES] {
        let ([a, b, c, d], [e, f, g, h]) = (self.from.to_le_bytes(), self.to.to_le_bytes());
        [a, b, c, d, e, f, g, h]
    }

    /// Splits what has come into this and the packet; `None` if it is too short.
    #[must_use]
    pub fn split(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (from, rest) = bytes.split_first_chunk()?;
        let (to, packet) = rest.split_first_chunk()?;
        Some((Self { from: u32::from_le_bytes(*from), to: u32::from_le_bytes(*to) }, packet))
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
}
