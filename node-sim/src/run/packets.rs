use kiloray_core::network::{PacketHeader, Port};

/// A packet on a link, or in a router that it passes through.
#[derive(Debug, Clone)]
pub(crate) struct Packet {
    /// What it lies in may be longer than it is.
    room: Vec<u8>,
    len: usize,
}

impl Packet {
    /// What the far router receives.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.room[..self.len]
    }
}

/// The packets at a place: those that are about to arrive, and those that wait in its router. Their number is bounded by the credit of the links.
///
/// A packet that passes through a router stays where it is: the router buffers a ticket in place of its payload, which no router reads.
#[derive(Debug)]
pub(crate) struct Packets {
    /// Greatest packet \[bytes\].
    size: usize,
    here: Vec<Option<Incoming>>,
    free: Vec<u32>,
}

#[derive(Debug)]
struct Incoming {
    packet: Packet,
    /// The port that it comes by.
    port: Port,
}

/// Where packets are written. What they lay in is used again: one thread would allocate what another frees.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    /// As long as the greatest packet.
    scratch: Vec<u8>,
    /// Of small packets, and of large ones.
    spare: [Vec<Vec<u8>>; 2],
}

/// Packets up to this size are copied out of the scratch \[bytes\]: most are far smaller than the greatest.
const SMALL: usize = 512;

/// Most of what packets of a kind lay in that is kept for others.
const SPARE: usize = 32;

impl Buffers {
    /// What has been written to the scratch, so many bytes of it.
    fn take(&mut self, len: usize) -> Packet {
        let [small, large] = &mut self.spare;
        let room = if len <= SMALL {
            let mut room = small.pop().unwrap_or_default();
            room.clear();
            room.extend_from_slice(&self.scratch[..len]);
            room
        } else {
            std::mem::replace(&mut self.scratch, large.pop().unwrap_or_default())
        };
        Packet { room, len }
    }

    /// Takes back what a packet lay in, if it lacks some: more come to some parts of the mesh than leave them.
    pub(crate) fn recycle(&mut self, packet: Packet) {
        let [small, large] = &mut self.spare;
        let spare = if packet.len <= SMALL { small } else { large };
        if spare.len() < SPARE {
            spare.push(packet.room);
        }
    }
}

/// The room for packets grows by so many.
const PLACES: usize = 8;

/// The number of a packet, in place of its payload.
const TICKET: usize = size_of::<u32>();

impl Packets {
    /// None yet, of at most so many bytes each.
    pub(crate) fn new(size: u16) -> Self {
        let size = usize::from(size).max(PacketHeader::BYTES + TICKET);
        Self { size, here: Vec::new(), free: Vec::new() }
    }

    /// A packet that `write` writes, to leave this place; `None` if it writes none. Of one that is not its maker's, `write` writes the ticket.
    pub(crate) fn make(
        &mut self,
        buffers: &mut Buffers,
        is_maker: impl FnOnce(&PacketHeader) -> bool,
        write: impl FnOnce(&mut [u8]) -> Option<usize>,
    ) -> Option<Packet> {
        buffers.scratch.resize(self.size, 0);
        let len = write(&mut buffers.scratch)?;
        let bytes = &buffers.scratch[..len];
        let (header, payload) = PacketHeader::split(bytes).expect("routers send good packets");
        if header.kind != PacketHeader::DATA || is_maker(&header) {
            return Some(buffers.take(len));
        }
        let ticket = payload.try_into().map(u32::from_le_bytes).expect("what passes is a ticket");
        let mut packet = self.take(ticket);
        packet.room[..PacketHeader::BYTES].copy_from_slice(&bytes[..PacketHeader::BYTES]);
        Some(packet)
    }

    /// Takes in what comes by a port: its number here.
    pub(crate) fn enter(&mut self, packet: Packet, port: Port) -> u32 {
        let incoming = Some(Incoming { packet, port });
        match self.free.pop() {
            Some(index) => {
                self.here[index as usize] = incoming;
                index
            }
            None => {
                if self.here.len() == self.here.capacity() {
                    // There may be thousands of places: none takes more than it needs.
                    self.here.reserve_exact(PLACES);
                    self.free.reserve_exact(self.here.capacity());
                }
                self.here.push(incoming);
                (self.here.len() - 1) as u32
            }
        }
    }

    /// A packet that is here, and the port that it came by.
    pub(crate) fn get(&self, index: u32) -> (&[u8], Port) {
        let Incoming { packet, port } =
            self.here[index as usize].as_ref().expect("a packet is here until it is freed");
        (packet.bytes(), *port)
    }

    /// What a router is given of a packet that passes through: its header and its ticket.
    pub(crate) fn ticket(&self, index: u32) -> [u8; PacketHeader::BYTES + TICKET] {
        let mut bytes = [0; PacketHeader::BYTES + TICKET];
        let (header, ticket) = bytes.split_at_mut(PacketHeader::BYTES);
        header.copy_from_slice(&self.get(index).0[..PacketHeader::BYTES]);
        ticket.copy_from_slice(&index.to_le_bytes());
        bytes
    }

    /// Takes a packet away.
    pub(crate) fn take(&mut self, index: u32) -> Packet {
        let incoming = self.here[index as usize].take();
        self.free.push(index);
        incoming.expect("a packet is here until it is freed").packet
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn a_packet_that_passes_keeps_its_payload_and_takes_the_new_header() {
        let (mut packets, mut buffers) = (Packets::new(64), Buffers::default());
        let header = |priority| PacketHeader { priority, from: 3, ..PacketHeader::zeroed() };
        let write = |header: PacketHeader, payload: Vec<u8>| {
            move |out: &mut [u8]| {
                let packet = [bytemuck::bytes_of(&header), &payload].concat();
                out[..packet.len()].copy_from_slice(&packet);
                Some(packet.len())
            }
        };
        let [came, other] = [(5, 30), (6, 10)].map(|(priority, len)| {
            let made = packets.make(&mut buffers, |_| true, write(header(priority), vec![9; len]));
            packets.enter(made.unwrap(), Port(7))
        });
        let ticket = packets.ticket(came);
        let (before, ticket) = PacketHeader::split(&ticket).unwrap();
        assert_eq!(before, header(5));
        let passed =
            packets.make(&mut buffers, |_| false, write(header(4), ticket.to_vec())).unwrap();
        let (after, payload) = PacketHeader::split(passed.bytes()).unwrap();
        assert_eq!((after, payload), (header(4), &[9; 30][..]));
        // Its place is free again.
        assert!(packets.make(&mut buffers, |_| true, |_| None).is_none());
        assert_eq!(packets.enter(passed, Port(1)), came);
        assert_eq!((packets.get(came).1, packets.get(other).1), (Port(1), Port(7)));
        assert_eq!(packets.here.len(), 2);
    }
}
