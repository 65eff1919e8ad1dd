use bytemuck::{Pod, Zeroable};

use super::packet::{Channel, LANES, Lane};
use super::port::PortState;
use super::{HOST, Mesh, NodeId};
use crate::store::{Arena, ArenaFull};

/// How much a router is lent.
///
/// Most requests are short and many, most replies are blocks: where packets are large, those of requests are smaller, and more of them fit
/// a buffer. So a short packet does not take the place of a long one, and requests do not wait for a place at every hop.
///
/// What the host sends is shorter still, and all of it comes in by two links: where it has more memory than a node, the buffers at the near ends of those take as many
/// short packets as there is room for in the bytes of long ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RouterSize {
    /// Where it is, if the host has more memory.
    pub site: Site,
    /// Ports of the node, used or not.
    pub ports: u16,
    /// Classes of the topology.
    pub classes: u8,
    /// Packets in the buffer of each lane and port, of replies; see [`depth_of`](Self::depth_of).
    pub depth: u16,
    /// The same of nodes.
    pub node_depth: u16,
    /// The same of the host, which may have more memory: all nodes send to it.
    pub host_depth: u16,
    /// Packets of the node's own that can wait, for each channel.
    pub own: u16,
    /// Greatest payload of a packet, of replies \[bytes\]; see [`payload_of`](Self::payload_of).
    pub payload: u16,
}

/// Where a router is in a [`Mesh`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Site {
    /// Among nodes.
    Inside,
    /// At a node whose last port leads to the host.
    Entry,
    /// At the host.
    Host,
}

/// Greatest reply of the host \[bytes\].
pub const HOST_REPLY_MAX: usize = 32;
/// Greatest payload of a packet of the host's replies \[bytes\]: two of them at least.
const HOST_PAYLOAD: u16 = 2 * HOST_REPLY_MAX as u16;
/// Such packets in a buffer, at most.
const ENTRY_DEPTH: u16 = 16;
/// Greatest payload of a packet of requests \[bytes\]: some fetches, or two rays; half of it where buffers would hold one, as two on a link keep it busier.
const REQUEST_PAYLOAD: u16 = 512;
/// Such packets in a buffer, at most.
const REQUEST_DEPTH: u16 = 8;

impl RouterSize {
    /// The size at a place of a mesh.
    #[must_use]
    pub fn new(mesh: &Mesh, here: NodeId, depth: u16, payload: u16) -> Self {
        let depth = depth.clamp(1, 255);
        let (ports, classes) = (mesh.ports(here), mesh.classes());
        let [node_depth, host_depth] = [depth; 2];
        let site = Site::Inside;
        Self { site, ports, classes, depth, node_depth, host_depth, own: depth, payload }
    }

    /// The same where the host's buffers hold so many packets, if that is more.
    #[must_use]
    pub fn with_host(self, mesh: &Mesh, here: NodeId, depth: u16) -> Self {
        let host_depth = depth.min(255);
        if host_depth <= self.node_depth {
            return self;
        }
        if here == HOST {
            let (depth, own) = (host_depth, host_depth);
            return Self { site: Site::Host, depth, host_depth, own, ..self };
        }
        let is_entry = mesh.attached().contains(&here);
        let site = if is_entry { Site::Entry } else { Site::Inside };
        Self { site, host_depth, ..self }
    }

    /// The same with room for more packets of the node's own.
    #[must_use]
    pub fn with_own(self, own: u16) -> Self {
        Self { own: own.clamp(1, 255), ..self }
    }

    /// Queues of packets: of the ports, and of the node itself.
    #[must_use]
    pub fn queues(&self) -> usize {
        (usize::from(self.ports) + 1) * LANES
    }

    /// Greatest payload of a packet of this channel \[bytes\].
    #[must_use]
    pub fn payload_of(&self, channel: Channel) -> u16 {
        match channel {
            Channel::Request => self.payload.min(self.request_payload()),
            Channel::Reply => self.payload,
        }
    }

    /// Packets in the buffer of each lane of this channel and port: those of requests take half of the bytes of replies, or less.
    #[must_use]
    pub fn depth_of(&self, channel: Channel) -> u16 {
        let half = self.depth.saturating_mul(self.payload / 2 / self.request_payload());
        match channel {
            Channel::Request => half.min(REQUEST_DEPTH).max(self.depth),
            Channel::Reply => self.depth,
        }
    }

    /// The same wherever it is: both ends of a link agree.
    fn request_payload(&self) -> u16 {
        if self.node_depth == 1 { REQUEST_PAYLOAD / 2 } else { REQUEST_PAYLOAD }
    }

    /// Packets in each such buffer at the far end of a link.
    pub(super) fn depth_at(&self, far: NodeId, channel: Channel) -> u16 {
        let depth = if far == HOST { self.host_depth } else { self.node_depth };
        let far = Self { depth, ..*self };
        match channel {
            Channel::Reply if self.is_at(Site::Host) => far.entry_depth(),
            _ => far.depth_of(channel),
        }
    }

    /// The buffers of a port for a lane of this channel, or of the node itself, behind the last: how many packets, and of how much payload \[bytes\].
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub(super) fn buffers(&self, port: usize, channel: Channel) -> (u16, u16) {
        let payload = self.payload_of(channel);
        let is_reply = channel == Channel::Reply;
        if port >= usize::from(self.ports) {
            let is_short = is_reply && self.is_at(Site::Host);
            return (self.own, if is_short { self.host_payload() } else { payload });
        }
        if is_reply && port == self.plain_ports() {
            return (self.entry_depth(), self.host_payload());
        }
        (self.depth_of(channel), payload)
    }

    /// Packets of replies in the buffers by which the host's come in.
    fn entry_depth(&self) -> u16 {
        let short = self.depth.saturating_mul(self.payload / HOST_PAYLOAD);
        short.min(ENTRY_DEPTH).max(self.depth)
    }

    /// Greatest payload of the host's replies.
    fn host_payload(&self) -> u16 {
        self.payload.min(HOST_PAYLOAD)
    }

    /// Where there are no bundles there is none but small hosts.
    fn is_at(&self, site: Site) -> bool {
        cfg!(feature = "bundles") && self.site == site
    }

    /// Ports that are alike: all but one by which the host's packets come in, the last.
    fn plain_ports(&self) -> usize {
        usize::from(self.ports).saturating_sub(usize::from(self.is_at(Site::Entry)))
    }

    /// Packets that it can hold: those of lanes that the topology has.
    #[must_use]
    pub fn packets(&self) -> usize {
        self.all(packets)
    }

    /// What a router takes of an arena \[bytes\].
    #[must_use]
    pub fn arena_bytes(&self) -> usize {
        Arena::bytes_of::<Slot>(self.packets())
            .saturating_add(Arena::bytes_of::<Fifo>(self.queues()))
            .saturating_add(Arena::bytes_of::<Place>(self.queues()))
            .saturating_add(Arena::bytes_of::<PortState>(usize::from(self.ports)))
            .saturating_add(Arena::bytes_of::<u8>(self.bytes()))
    }

    /// Bytes of payloads.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.all(bytes)
    }

    /// What all queues take.
    fn all(&self, of: fn((u16, u16)) -> usize) -> usize {
        let plain = self.plain_ports();
        let others = (plain..=self.ports.into()).map(|port| self.of_port(port, of));
        plain * self.of_port(0, of) + others.sum::<usize>()
    }

    /// What the queues of a port take, or those of the node itself, behind the last.
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    fn of_port(&self, port: usize, of: fn((u16, u16)) -> usize) -> usize {
        Lane::ALL.iter().map(|&lane| of(self.lane(port, lane))).sum()
    }

    /// The buffers of a lane; none where there is no such lane.
    fn lane(&self, port: usize, lane: Lane) -> (u16, u16) {
        let classes = if port < usize::from(self.ports) { self.classes } else { 1 };
        let exists = lane.class() < classes.clamp(1, 2);
        if exists { self.buffers(port, lane.channel()) } else { (0, 0) }
    }
}

fn packets((depth, _): (u16, u16)) -> usize {
    depth.into()
}

fn bytes((depth, payload): (u16, u16)) -> usize {
    usize::from(depth) * usize::from(payload)
}

/// A packet in a buffer; its payload lies apart.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Slot {
    pub(super) to: u16,
    pub(super) from: u16,
    pub(super) len: u16,
    /// The port of its next hop; [`ARRIVED`] if it stays here.
    pub(super) port: u16,
    /// The class of its next hop.
    pub(super) class: u8,
    pub(super) priority: u8,
}

/// Where the packets of a queue lie.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Place {
    /// The first of its slots.
    pub(super) slots: u32,
    /// The first byte of the first payload.
    pub(super) bytes: u32,
    /// Packets that it can hold.
    pub(super) depth: u16,
    /// Greatest payload of one of them \[bytes\].
    pub(super) payload: u16,
}

impl Place {
    /// A slot.
    pub(super) const fn slot(self, at: usize) -> usize {
        self.slots as usize + at
    }

    /// The first byte of the payload of a slot.
    pub(super) const fn byte(self, at: usize) -> usize {
        self.bytes as usize + at * self.payload as usize
    }
}

/// As a port: no hop any more.
pub(super) const ARRIVED: u16 = u16::MAX;
/// As a port: there is no packet.
const NONE: u16 = u16::MAX - 1;

/// A first-in first-out queue of slots, and where its head goes: all that the choice of the next packet has to read.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Fifo {
    pub(super) first: u8,
    pub(super) len: u8,
    /// Most that it ever held.
    pub(super) peak: u8,
    /// Of the head.
    pub(super) priority: u8,
    /// The port of the head's next hop; [`ARRIVED`] if it stays here, [`NONE`] if there is no head.
    pub(super) port: u16,
    /// The class of the head's next hop.
    pub(super) class: u8,
    _zero: u8,
}

impl Fifo {
    /// It has a new head, or none. Gives where the last one was to go, and this one.
    pub(super) fn set_head(&mut self, head: Option<&Slot>) -> (u16, u16) {
        let before = self.port;
        match head {
            Some(slot) => {
                (self.port, self.class, self.priority) = (slot.port, slot.class, slot.priority);
            }
            None => self.port = NONE,
        }
        (before, self.port)
    }
}

impl Default for Fifo {
    /// Empty.
    fn default() -> Self {
        Self { first: 0, len: 0, peak: 0, priority: 0, port: NONE, class: 0, _zero: 0 }
    }
}

/// The buffers of a router: slices of its [`RouterSize`].
#[derive(Debug)]
pub(super) struct RouterMemory<'a> {
    /// [`RouterSize::packets`].
    pub(super) slots: &'a mut [Slot],
    /// [`RouterSize::queues`].
    pub(super) fifos: &'a mut [Fifo],
    /// Likewise.
    pub(super) places: &'a mut [Place],
    /// [`RouterSize::ports`].
    pub(super) ports: &'a mut [PortState],
    /// [`RouterSize::bytes`].
    pub(super) bytes: &'a mut [u8],
}

impl<'a> RouterMemory<'a> {
    /// Empty buffers; of the ports the state is not set.
    pub(super) fn carve(arena: &mut Arena<'a>, size: &RouterSize) -> Result<Self, ArenaFull> {
        let memory = Self {
            slots: arena.carve(size.packets())?,
            fifos: arena.carve(size.queues())?,
            places: arena.carve(size.queues())?,
            ports: arena.carve(usize::from(size.ports))?,
            bytes: arena.carve(size.bytes())?,
        };
        memory.fifos.fill(Fifo::default());
        let (mut slots, mut bytes) = (0, 0);
        for (place, queue) in memory.places.iter_mut().zip(0..) {
            let (depth, payload) = size.lane(queue / LANES, Lane::of_queue(queue));
            *place = Place { slots, bytes, depth, payload };
            slots += u32::from(depth);
            bytes += u32::from(depth) * u32::from(payload);
        }
        Ok(memory)
    }
}
