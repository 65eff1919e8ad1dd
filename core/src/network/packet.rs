use bytemuck::{Pod, Zeroable};

use super::{NodeId, Sequence};

/// Requests or replies. Each has its own buffers and credit on every link, so that a reply never
/// waits behind a request (the first rule of progress).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Channel {
    /// Asks for something: may be refused.
    Request = 0,
    /// Answers: what it needs at its end was reserved before the request left.
    Reply = 1,
}

impl Channel {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Request, Self::Reply];
}

/// Lanes of a link: two channels, each in up to two classes.
pub const LANES: usize = 4;

/// The buffers that a packet takes on a link: its channel, and the class of the hop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Lane(u8);

impl Lane {
    /// All lanes.
    pub const ALL: [Self; LANES] = [Self(0), Self(1), Self(2), Self(3)];

    /// The lane of a channel and a class below 2.
    #[must_use]
    pub const fn new(channel: Channel, class: u8) -> Self {
        Self((channel as u8) << 1 | class & 1)
    }

    /// The lane with this number.
    #[must_use]
    pub const fn from_u8(number: u8) -> Option<Self> {
        if (number as usize) < LANES { Some(Self(number)) } else { None }
    }

    /// The lane that a queue of a router is of.
    pub(super) const fn of_queue(queue: usize) -> Self {
        Self((queue % LANES) as u8)
    }

    /// Its number, below [`LANES`].
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// Its channel.
    #[must_use]
    pub const fn channel(self) -> Channel {
        if self.0 < 2 { Channel::Request } else { Channel::Reply }
    }

    /// Its class.
    #[must_use]
    pub const fn class(self) -> u8 {
        self.0 & 1
    }
}

/// What stands before the payload of a packet, little-endian, 24 bytes.
///
/// Every packet repeats the credit of the other direction. One of kind [`CONTROL`](Self::CONTROL) has no payload and takes no buffer:
/// it brings credit where nothing else travels, and in `number` the probes of a sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct PacketHeader {
    /// [`DATA`](Self::DATA) or [`CONTROL`](Self::CONTROL).
    pub kind: u8,
    /// The lane of a data packet.
    pub lane: u8,
    /// The lesser is sent first; it falls each time another packet goes before. Of a control packet: [`ASKS`](Self::ASKS), or 0.
    pub priority: u8,
    /// Zero.
    pub _zero: u8,
    /// Where it is to go.
    pub to: u16,
    /// Who has sent it.
    pub from: u16,
    /// Credit of the other direction, by lane.
    pub limits: [u16; LANES],
    /// Number of the last packet sent on each lane, this one included.
    pub sent: [u16; LANES],
}

impl PacketHeader {
    /// A packet with a payload.
    pub const DATA: u8 = 0;
    /// Credit and probes.
    pub const CONTROL: u8 = 1;
    /// The priority of a control packet that wants an answer.
    pub const ASKS: u8 = 1;
    /// Its length.
    pub const BYTES: usize = size_of::<Self>();

    /// Splits a packet; `None` if it is too short, or its kind or lane is unknown.
    #[must_use]
    pub fn split(packet: &[u8]) -> Option<(Self, &[u8])> {
        let (header, payload) = packet.split_at_checked(Self::BYTES)?;
        let header: Self = bytemuck::try_pod_read_unaligned(header).ok()?;
        let known = header.kind <= Self::CONTROL && Lane::from_u8(header.lane).is_some();
        let empty = header.kind == Self::DATA || payload.is_empty();
        (known && empty).then_some((header, payload))
    }

    /// Where it is to go.
    #[must_use]
    pub const fn to(&self) -> NodeId {
        NodeId(self.to)
    }

    /// Who has sent it.
    #[must_use]
    pub const fn from(&self) -> NodeId {
        NodeId(self.from)
    }

    /// The number of the last packet sent on a lane.
    pub(super) fn sent_on(&self, lane: Lane) -> Sequence {
        Sequence(self.sent.get(lane.index()).copied().unwrap_or_default())
    }
}
