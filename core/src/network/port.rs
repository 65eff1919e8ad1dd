use bytemuck::{Pod, Zeroable};

use super::heads::Heads;
use super::packet::{LANES, Lane, PacketHeader};
use super::{CreditReceiver, CreditSender, NodeId, Port, RouterSize, Sequence};

/// The two directions of a link, by lane.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct PortState {
    /// Queues whose heads leave by this port next: of most ports there is none to look for.
    pub(super) waiting: Heads,
    pub(super) senders: [CreditSender; LANES],
    pub(super) receivers: [CreditReceiver; LANES],
    /// The limits that the far end was last told.
    told: [Sequence; LANES],
    /// The queue after the one that was served last.
    pub(super) turn: u16,
    /// Why a control packet is to be sent: 0, [`TELL`] or [`ASK`].
    pub(super) control: u8,
    /// 1 if a link is joined to it.
    joined: u8,
}

/// The far end has asked, or one that is new to it has been accounted for.
pub(super) const TELL: u8 = 1;
/// It is time to ask the far end for credit.
pub(super) const ASK: u8 = 2;

impl PortState {
    /// A port with a link to another place, or without one.
    pub(super) fn new(size: &RouterSize, port: Port, far: Option<NodeId>) -> Self {
        let depth = |lane: Lane| size.buffers(port.0.into(), lane.channel()).0;
        let receivers = Lane::ALL.map(|lane| CreditReceiver::new(depth(lane)));
        let far_depth = |lane: Lane| far.map_or(0, |far| size.depth_at(far, lane.channel()));
        Self {
            waiting: Heads::NONE,
            senders: Lane::ALL.map(|lane| CreditSender::new(far_depth(lane))),
            receivers,
            told: receivers.map(|receiver| receiver.limit()),
            turn: 0,
            control: 0,
            joined: u8::from(far.is_some()),
        }
    }

    /// Whether a link is joined to it.
    pub(super) const fn is_joined(&self) -> bool {
        self.joined != 0
    }

    /// Whether credit of any lane has not come back.
    pub(super) fn is_credit_out(&self) -> bool {
        !self.senders.iter().all(CreditSender::is_full)
    }

    /// Takes so much off all numbers of packets that leave by a lane, or come by it.
    #[cfg(test)]
    pub(super) fn rebase(&mut self, lane: usize, leaves: u16, comes: u16) {
        self.senders[lane].rebase(leaves);
        self.receivers[lane].rebase(comes);
        self.told[lane].0 = self.told[lane].0.wrapping_sub(comes);
    }

    /// Whether the far end should hear of its credit: it has asked, or half of a lane's buffers are free that it takes for full.
    /// It has credit left in the other case, so that none waits for ever.
    pub(super) fn owes_credit(&self) -> bool {
        let lanes = self.receivers.iter().zip(&self.told);
        lanes.fold(self.control != 0, |owes, (receiver, told)| {
            let half = receiver.capacity().div_ceil(2);
            owes | (receiver.limit().ahead_of(*told) >= half as i16)
        })
    }

    /// The header of the next packet, which tells all credit.
    pub(super) fn header(&mut self, kind: u8) -> PacketHeader {
        self.told = self.receivers.map(|receiver| receiver.limit());
        PacketHeader {
            kind,
            lane: 0,
            priority: 0,
            _zero: 0,
            to: 0,
            from: 0,
            limits: self.told.map(|limit| limit.0),
            sent: self.senders.map(|sender| sender.probe().0),
        }
    }
}
