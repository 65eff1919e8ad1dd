use kiloray_core::network::{HOST, Mesh, NodeId, PacketHeader, Port};

use crate::{Link, LinkReport, Switching};

/// One direction of a link.
#[derive(Debug)]
pub(crate) struct LinkState {
    /// Who sends, by place.
    pub(crate) from: u32,
    /// By which port.
    pub(crate) port: Port,
    /// Who receives, by place.
    pub(crate) to: u32,
    /// By which port.
    pub(crate) back: Port,
    /// It sends until then.
    pub(crate) busy_until: u64,
    /// The last packet that is not overtaken arrives then.
    pub(crate) last_arrival: u64,
    /// An event is entered for the end of what it sends.
    pub(crate) awaited: bool,
    /// Packets sent, control packets not counted.
    pub(crate) packets: u64,
    /// Packets sent that bring credit only.
    pub(crate) control_packets: u64,
    /// Bytes sent.
    pub(crate) bytes: u64,
    /// Time in which it sent.
    pub(crate) busy: u64,
}

/// All links of a mesh, by the place they leave, then by port.
#[derive(Debug)]
pub(crate) struct Links {
    all: Vec<LinkState>,
    /// The first link of each place.
    first: Vec<u32>,
}

impl Links {
    /// Nothing was sent yet.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let nodes = u32::from(mesh.nodes());
        let place = |id: NodeId| if id == HOST { nodes } else { u32::from(id.0) };
        let (mut all, mut first) = (Vec::new(), vec![0]);
        for id in (0..mesh.nodes()).map(NodeId).chain([HOST]) {
            for port in (0..mesh.ports(id)).map(Port) {
                // A port without a neighbour leads nowhere: its link is never used.
                let far = mesh.neighbour(id, port);
                all.push(LinkState {
                    from: place(id),
                    port,
                    to: far.map_or(u32::MAX, place),
                    back: mesh.reverse(id, port).unwrap_or(Port(0)),
                    busy_until: 0,
                    last_arrival: 0,
                    awaited: false,
                    packets: 0,
                    control_packets: 0,
                    bytes: 0,
                    busy: 0,
                });
            }
            first.push(all.len() as u32);
        }
        Self { all, first }
    }

    /// The links that leave a place, by number: one for each port.
    pub(crate) fn of(&self, place: u32) -> std::ops::Range<u32> {
        self.first[place as usize]..self.first[place as usize + 1]
    }

    /// A link.
    pub(crate) fn get(&mut self, link: u32) -> &mut LinkState {
        &mut self.all[link as usize]
    }

    /// What they sent. `buffers` gives the peak and the number of the buffers at a place and port.
    pub(crate) fn report(&self, buffers: impl Fn(u32, Port) -> (u32, u32)) -> Vec<LinkReport> {
        let nodes = self.first.len() as u32 - 2;
        let id = |place: u32| (place < nodes).then_some(place as u16);
        let used = self.all.iter().filter(|link| link.to != u32::MAX);
        used.map(|link| {
            let (buffers_peak, buffers) = buffers(link.to, link.back);
            LinkReport {
                from: id(link.from),
                to: id(link.to),
                port: link.port.0,
                packets: link.packets,
                control_packets: link.control_packets,
                bytes: link.bytes,
                busy_ns: link.busy,
                buffers_peak,
                buffers,
            }
        })
        .collect()
    }
}

impl Link {
    /// How long a link is busy with so many bytes: at least 1 ns.
    pub(crate) fn duration(&self, bytes: usize) -> u64 {
        const SECOND: u64 = 1_000_000_000;
        (bytes as u64).saturating_mul(SECOND).div_ceil(self.bandwidth.max(1)).max(1)
    }

    /// From the departure of a packet's first byte to the moment when the far router can use it.
    ///
    /// With cut-through the header is enough to send it on. A link is as fast as the next, so that the rest is there in time; who sends the
    /// packet on cannot overtake it. At its end all of it must be there.
    pub(crate) fn travel(&self, header: &PacketHeader, bytes: usize, ends: bool) -> u64 {
        let cut_through = self.switching == Switching::CutThrough;
        let passes = header.kind == PacketHeader::DATA && !ends;
        let needed = if cut_through && passes { PacketHeader::BYTES } else { bytes };
        self.latency.saturating_add(self.duration(needed))
    }
}
