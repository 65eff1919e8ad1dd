use kiloray_core::network::PacketHeader;

/// Packets on links, and those that wait in the routers between. Their number is bounded by the credit of the links; what is freed is used again.
///
/// A packet that passes through a router stays where it is: the router buffers a ticket in place of its payload, which no router reads.
#[derive(Debug)]
pub(crate) struct Packets {
    /// Greatest packet \[bytes\].
    size: usize,
    bytes: Vec<u8>,
    entries: Vec<Entry>,
    free: Vec<u32>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Entry {
    len: u16,
    /// The link that it is on.
    link: u32,
}

/// The number of a packet, in place of its payload.
const TICKET: usize = size_of::<u32>();

impl Packets {
    /// None yet, of at most so many bytes each.
    pub(crate) fn new(size: u16) -> Self {
        let size = usize::from(size).max(PacketHeader::BYTES + TICKET);
        Self { size, bytes: Vec::new(), entries: Vec::new(), free: Vec::new() }
    }

    /// A packet that `write` writes, to leave by a link; `None` if it writes none. Of one that is not its maker's, `write` writes the ticket.
    pub(crate) fn make(
        &mut self,
        link: u32,
        is_maker: impl FnOnce(&PacketHeader) -> bool,
        write: impl FnOnce(&mut [u8]) -> Option<usize>,
    ) -> Option<u32> {
        let index = self.free.pop().unwrap_or_else(|| {
            self.bytes.resize(self.bytes.len() + self.size, 0);
            self.entries.push(Entry::default());
            (self.entries.len() - 1) as u32
        });
        let at = index as usize * self.size;
        let out = &mut self.bytes[at..at + self.size];
        let Some(len) = write(out) else {
            self.free.push(index);
            return None;
        };
        let (header, payload) =
            PacketHeader::split(&out[..len]).expect("routers send good packets");
        if header.kind == PacketHeader::DATA && !is_maker(&header) {
            let ticket =
                payload.try_into().map(u32::from_le_bytes).expect("what passes is a ticket");
            let to = ticket as usize * self.size;
            self.bytes.copy_within(at..at + PacketHeader::BYTES, to);
            self.entries[ticket as usize].link = link;
            self.free.push(index);
            return Some(ticket);
        }
        self.entries[index as usize] = Entry { len: len as u16, link };
        Some(index)
    }

    /// A copy of a packet.
    pub(crate) fn copy(&mut self, packet: u32) -> Option<u32> {
        let (original, link) = (self.get(packet).to_vec(), self.link(packet));
        self.make(
            link,
            |_| true,
            |out| {
                out[..original.len()].copy_from_slice(&original);
                Some(original.len())
            },
        )
    }

    /// A packet.
    pub(crate) fn get(&self, packet: u32) -> &[u8] {
        let at = packet as usize * self.size;
        &self.bytes[at..at + usize::from(self.entries[packet as usize].len)]
    }

    /// What a router is given of a packet that passes through: its header and its ticket.
    pub(crate) fn ticket(&self, packet: u32) -> [u8; PacketHeader::BYTES + TICKET] {
        let mut bytes = [0; PacketHeader::BYTES + TICKET];
        let (header, ticket) = bytes.split_at_mut(PacketHeader::BYTES);
        header.copy_from_slice(&self.get(packet)[..PacketHeader::BYTES]);
        ticket.copy_from_slice(&packet.to_le_bytes());
        bytes
    }

    /// The link that a packet is on.
    pub(crate) fn link(&self, packet: u32) -> u32 {
        self.entries[packet as usize].link
    }

    /// It is not needed any more.
    pub(crate) fn free(&mut self, packet: u32) {
        self.free.push(packet);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn a_packet_that_passes_keeps_its_payload_and_takes_the_new_header() {
        let mut packets = Packets::new(64);
        let header = |priority| PacketHeader { priority, from: 3, ..PacketHeader::zeroed() };
        let write = |header: PacketHeader, payload: Vec<u8>| {
            move |out: &mut [u8]| {
                let packet = [bytemuck::bytes_of(&header), &payload].concat();
                out[..packet.len()].copy_from_slice(&packet);
                Some(packet.len())
            }
        };
        let made = packets.make(7, |_| true, write(header(5), vec![9; 30])).unwrap();
        let other = packets.make(8, |_| true, write(header(6), vec![1; 10])).unwrap();
        let ticket = packets.ticket(made);
        let (before, ticket) = PacketHeader::split(&ticket).unwrap();
        assert_eq!(before, header(5));
        let passed = packets.make(9, |_| false, write(header(4), ticket.to_vec())).unwrap();
        assert_eq!((passed, packets.link(made), packets.link(other)), (made, 9, 8));
        let (after, payload) = PacketHeader::split(packets.get(made)).unwrap();
        assert_eq!((after, payload), (header(4), &[9; 30][..]));
        // What it was written to on the way is free again.
        assert_eq!(packets.make(7, |_| true, |_| None), None);
        assert_eq!(packets.entries.len(), 3);
    }
}
