use kiloray_core::network::{Mesh, NodeId, PacketHeader, Port};

use crate::{Link, LinkReport, Switching};

/// One direction of a link, as its sender keeps it.
#[derive(Debug)]
pub(crate) struct LinkState {
    /// Who receives; `None` where there is nobody: such a link is never used.
    pub(crate) to: Option<NodeId>,
    /// By which port.
    pub(crate) back: Port,
    /// It sends until then.
    pub(crate) busy_until: u64,
    /// The last packet that is not overtaken arrives then.
    pub(crate) last_arrival: u64,
    /// What has come by it has been passed on by then.
    pub(crate) enters: u64,
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

impl LinkState {
    /// The links that leave a place, one for each port. Nothing was sent yet.
    pub(crate) fn of(mesh: &Mesh, place: NodeId) -> Vec<Self> {
        let ports = (0..mesh.ports(place)).map(Port);
        let link = |port| Self {
            to: mesh.neighbour(place, port),
            back: mesh.reverse(place, port).unwrap_or(Port(0)),
            busy_until: 0,
            last_arrival: 0,
            enters: 0,
            awaited: false,
            packets: 0,
            control_packets: 0,
            bytes: 0,
            busy: 0,
        };
        ports.map(link).collect()
    }

    /// What it sent until a run's end, from a place by a port. `buffers` are the peak and the number of those at its end.
    pub(crate) fn report(
        &self,
        from: Option<u16>,
        to: Option<u16>,
        port: u16,
        (buffers_peak, buffers): (u32, u32),
        end: u64,
    ) -> LinkReport {
        // The last packet may not be through by then.
        let beyond = self.busy_until.saturating_sub(end);
        LinkReport {
            from,
            to,
            port,
            packets: self.packets,
            control_packets: self.control_packets,
            bytes: self.bytes,
            busy_ns: self.busy.saturating_sub(beyond),
            buffers_peak,
            buffers,
        }
    }
}

impl Link {
    /// No packet takes less: what leaves one place now changes nothing elsewhere before.
    pub(crate) fn least_travel(&self) -> u64 {
        self.latency.saturating_add(self.duration(PacketHeader::BYTES))
    }

    /// How long messages wait for others to the same node by default: twice as long as a packet is on its way to the next \[ns\].
    #[must_use]
    pub fn bundle_age(&self, packet: usize) -> u64 {
        self.latency.saturating_add(self.duration(packet)).saturating_mul(2)
    }

    /// How long a link is busy with so many bytes: at least 1 ns.
    pub(crate) fn duration(&self, bytes: usize) -> u64 {
        const SECOND: u64 = 1_000_000_000;
        (bytes as u64).saturating_mul(SECOND).div_ceil(self.bandwidth.max(1)).max(1)
    }

    /// What a link carries in a time \[bytes\].
    pub(crate) fn bytes_in(&self, ns: u64) -> u64 {
        let bytes = u128::from(ns) * u128::from(self.bandwidth) / 1_000_000_000;
        bytes.try_into().unwrap_or(u64::MAX)
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
