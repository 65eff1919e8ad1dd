use bytemuck::{Pod, Zeroable};

use super::packet::{Channel, LANES, Lane, PacketHeader};
use super::{Arrival, CreditReceiver, CreditSender, NodeId, Port, Sequence, Topology};

/// How much a router is lent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RouterSize {
    /// Ports of the node, used or not.
    pub ports: u16,
    /// Classes of the topology.
    pub classes: u8,
    /// Packets in each buffer queue: of each lane and port, and of each channel for the node's own.
    pub depth: u16,
    /// Greatest payload of a packet \[bytes\].
    pub payload: u16,
}

impl RouterSize {
    /// The size for a topology.
    #[must_use]
    pub fn new(topology: &Topology, depth: u16, payload: u16) -> Self {
        Self {
            ports: topology.ports(),
            classes: topology.classes(),
            depth: depth.clamp(1, 255),
            payload,
        }
    }

    /// Queues of packets: of the ports, and of the node itself.
    #[must_use]
    pub fn queues(&self) -> usize {
        (usize::from(self.ports) + 1) * LANES
    }

    /// [`Slot`]s to lend.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.queues() * usize::from(self.depth)
    }

    /// Bytes to lend for payloads. Lanes of a class that the topology does not have take none.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.slots() / LANES * self.lanes_used() * usize::from(self.payload)
    }

    fn lanes_used(&self) -> usize {
        Channel::ALL.len() * usize::from(self.classes.clamp(1, 2))
    }
}

/// A packet in a buffer; its payload lies apart.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Slot {
    to: u16,
    from: u16,
    len: u16,
    /// The port of its next hop; [`ARRIVED`] if it stays here.
    port: u16,
    /// The class of its next hop.
    class: u8,
    priority: u8,
}

/// In [`Slot::port`]: no hop any more.
const ARRIVED: u16 = u16::MAX;

/// A first-in first-out queue of slots.
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Fifo {
    first: u8,
    len: u8,
}

/// The two directions of a link, by lane.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PortState {
    senders: [CreditSender; LANES],
    receivers: [CreditReceiver; LANES],
    /// The queue after the one that was served last.
    turn: u16,
    /// Credit has come free that the far end does not know of, or it is time to repeat it.
    owes_credit: u8,
    _zero: u8,
}

/// What a router is lent: slices of its [`RouterSize`], their content does not matter.
#[derive(Debug)]
pub struct RouterMemory<'a> {
    /// [`RouterSize::slots`].
    pub slots: &'a mut [Slot],
    /// [`RouterSize::queues`].
    pub fifos: &'a mut [Fifo],
    /// [`RouterSize::ports`].
    pub ports: &'a mut [PortState],
    /// [`RouterSize::bytes`].
    pub bytes: &'a mut [u8],
}

/// What became of a packet that came over a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Received {
    /// It brought credit only.
    Control,
    /// It lies in a buffer, for the node or to be sent on.
    Buffered,
    /// Seen before, or overtaken.
    Stale,
    /// No packet of ours: too short or too long, of an unknown kind or lane, or for a node that does not exist.
    Bad,
    /// It was for a node that is known to be dead: dropped, its buffer is free.
    Dead,
}

/// A buffer that the node itself fills is full: try again when the router has sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Busy;

/// The packets of a node: those that pass through, that have arrived, and that leave.
///
/// A packet lies in a buffer of the link and lane it came by until the next link has credit for it, or the node
/// consumes it. Lanes never wait for each other. Of the packets that could leave by a port the most urgent goes first, and among equals
/// the queues take turns.
#[derive(Debug)]
pub struct Router<'a> {
    topology: Topology,
    here: NodeId,
    size: RouterSize,
    memory: RouterMemory<'a>,
}

impl<'a> Router<'a> {
    /// A router with empty buffers. `None` if a slice is shorter than `size` says.
    #[must_use]
    pub fn new(
        topology: Topology,
        here: NodeId,
        size: RouterSize,
        memory: RouterMemory<'a>,
    ) -> Option<Self> {
        let fits = memory.slots.len() >= size.slots()
            && memory.fifos.len() >= size.queues()
            && memory.ports.len() >= usize::from(size.ports)
            && memory.bytes.len() >= size.bytes();
        if !fits {
            return None;
        }
        memory.fifos.fill(Fifo::default());
        memory.ports.fill(PortState {
            senders: [CreditSender::new(size.depth); LANES],
            receivers: [CreditReceiver::new(size.depth); LANES],
            turn: 0,
            owes_credit: 0,
            _zero: 0,
        });
        Some(Self { topology, here, size, memory })
    }

    /// Where this router is.
    #[must_use]
    pub const fn here(&self) -> NodeId {
        self.here
    }

    /// Takes a packet of the node's own into the buffers. One for the node itself arrives at once.
    ///
    /// # Errors
    /// [`Busy`] if the buffers of that channel are full; also, for ever, for a payload longer than a packet's or a node that
    /// does not exist.
    pub fn inject(
        &mut self,
        to: NodeId,
        channel: Channel,
        priority: u8,
        payload: &[u8],
    ) -> Result<(), Busy> {
        self.push(self.own_queue(channel), (to, self.here), priority, payload)
    }

    /// Packets that [`inject`](Self::inject) takes now.
    #[must_use]
    pub fn room(&self, channel: Channel) -> u16 {
        let len = self.memory.fifos.get(self.own_queue(channel)).map_or(u8::MAX, |f| f.len);
        self.size.depth.saturating_sub(u16::from(len))
    }

    /// A packet has come over a link.
    pub fn receive(
        &mut self,
        port: Port,
        packet: &[u8],
        is_dead: impl Fn(NodeId) -> bool,
    ) -> Received {
        let Some((header, payload)) = PacketHeader::split(packet) else { return Received::Bad };
        let Some(lane) = Lane::from_u8(header.lane) else { return Received::Bad };
        let exists = header.to < self.topology.nodes();
        if payload.len() > usize::from(self.size.payload)
            || lane.class() >= self.size.classes
            || header.kind == PacketHeader::DATA && !exists
        {
            return Received::Bad;
        }
        let queue = self.queue(usize::from(port.0), lane);
        let Some(state) = self.memory.ports.get_mut(usize::from(port.0)) else {
            return Received::Bad;
        };
        for (sender, limit) in state.senders.iter_mut().zip(header.limits) {
            sender.grant(Sequence(limit));
        }
        if header.kind == PacketHeader::CONTROL {
            for (receiver, sent) in state.receivers.iter_mut().zip(header.sent) {
                receiver.probe(Sequence(sent));
            }
            return Received::Control;
        }
        let Some(receiver) = state.receivers.get_mut(lane.index()) else { return Received::Bad };
        if let Arrival::Stale = receiver.receive(header.sent_on(lane)) {
            return Received::Stale;
        }
        if is_dead(header.to()) {
            receiver.release();
            state.owes_credit = 1;
            return Received::Dead;
        }
        match self.push(queue, (header.to(), header.from()), header.priority, payload) {
            Ok(()) => Received::Buffered,
            // Credit was given for it: cannot be.
            Err(Busy) => Received::Bad,
        }
    }

    /// The oldest of the most urgent packets of a channel that have arrived for this node: who has sent it, and what.
    #[must_use]
    pub fn arrived(&self, channel: Channel) -> Option<(NodeId, &[u8])> {
        let queue = self.arrived_queue(channel)?;
        let (slot, payload) = self.head(queue)?;
        Some((NodeId(slot.from), payload))
    }

    /// Frees the buffer of the packet that [`arrived`](Self::arrived) shows.
    pub fn consume(&mut self, channel: Channel) {
        if let Some(queue) = self.arrived_queue(channel) {
            self.pop(queue);
        }
    }

    /// Writes the next packet for a link to `out`, and gives its length; `None` if nothing is to be sent, or nothing may be.
    ///
    /// `out` must hold a header and a payload.
    pub fn transmit(&mut self, port: Port, out: &mut [u8]) -> Option<usize> {
        let far = self.topology.neighbour(self.here, port)?;
        debug_assert!(far != self.here);
        match self.next_for(port) {
            Some((queue, lane)) => self.send(port, queue, lane, out),
            None => self.control(port, out),
        }
    }

    /// To be called at intervals: repeats credit and probes on every link, so that lost ones heal.
    pub fn remind(&mut self) {
        for state in self.memory.ports.iter_mut() {
            state.owes_credit = 1;
        }
    }

    /// Drops all packets for a node that is known to be dead, and gives their credit back.
    pub fn forget(&mut self, dead: NodeId) -> u32 {
        let mut dropped = 0;
        for queue in 0..self.size.queues() {
            let len = self.memory.fifos.get(queue).map_or(0, |fifo| fifo.len);
            for _ in 0..len {
                let Some((slot, _)) = self.head(queue) else { break };
                if slot.to == dead.0 {
                    self.pop(queue);
                    dropped += 1;
                } else {
                    self.rotate(queue);
                }
            }
        }
        dropped
    }

    /// Packets in all buffers.
    #[must_use]
    pub fn buffered(&self) -> u32 {
        self.memory.fifos.iter().take(self.size.queues()).map(|fifo| u32::from(fifo.len)).sum()
    }

    fn send(&mut self, port: Port, queue: usize, lane: Lane, out: &mut [u8]) -> Option<usize> {
        let (slot, payload) = self.head(queue)?;
        let len = PacketHeader::BYTES + payload.len();
        let (head, body) = out.get_mut(..len)?.split_at_mut_checked(PacketHeader::BYTES)?;
        body.copy_from_slice(payload);
        let state = self.memory.ports.get_mut(usize::from(port.0))?;
        let _number = state.senders.get_mut(lane.index())?.take()?;
        state.turn = queue.wrapping_add(1) as u16;
        let header = PacketHeader {
            kind: PacketHeader::DATA,
            lane: lane.index() as u8,
            priority: slot.priority,
            _zero: 0,
            to: slot.to,
            from: slot.from,
            limits: state.receivers.map(|r| r.limit().0),
            sent: state.senders.map(|s| s.probe().0),
        };
        state.owes_credit = 0;
        head.copy_from_slice(bytemuck::bytes_of(&header));
        self.pop(queue);
        Some(len)
    }

    fn control(&mut self, port: Port, out: &mut [u8]) -> Option<usize> {
        let state = self.memory.ports.get_mut(usize::from(port.0))?;
        if state.owes_credit == 0 {
            return None;
        }
        state.owes_credit = 0;
        let header = PacketHeader {
            kind: PacketHeader::CONTROL,
            lane: 0,
            priority: 0,
            _zero: 0,
            to: 0,
            from: self.here.0,
            limits: state.receivers.map(|r| r.limit().0),
            sent: state.senders.map(|s| s.probe().0),
        };
        out.get_mut(..PacketHeader::BYTES)?.copy_from_slice(bytemuck::bytes_of(&header));
        Some(PacketHeader::BYTES)
    }

    /// The queue whose head leaves by this port next, and the lane it takes there.
    fn next_for(&self, port: Port) -> Option<(usize, Lane)> {
        let state = self.memory.ports.get(usize::from(port.0))?;
        let queues = self.size.queues();
        let mut best: Option<(u8, usize, Lane)> = None;
        for k in 0..queues {
            let queue = (usize::from(state.turn) + k).checked_rem(queues)?;
            let Some((slot, _)) = self.head(queue) else { continue };
            let lane = Lane::new(queue_lane(queue).channel(), slot.class);
            let credit = state.senders.get(lane.index()).map_or(0, CreditSender::available);
            let earlier = best.is_none_or(|(priority, ..)| slot.priority < priority);
            if slot.port == port.0 && credit > 0 && earlier {
                best = Some((slot.priority, queue, lane));
            }
        }
        best.map(|(_, queue, lane)| (queue, lane))
    }

    fn arrived_queue(&self, channel: Channel) -> Option<usize> {
        let mut best: Option<(u8, usize)> = None;
        for queue in (0..self.size.queues()).filter(|&q| queue_lane(q).channel() == channel) {
            let Some((slot, _)) = self.head(queue) else { continue };
            let earlier = best.is_none_or(|(priority, _)| slot.priority < priority);
            if slot.port == ARRIVED && earlier {
                best = Some((slot.priority, queue));
            }
        }
        best.map(|(_, queue)| queue)
    }

    fn queue(&self, port: usize, lane: Lane) -> usize {
        port * LANES + lane.index()
    }

    /// The node's own packets begin in class 0 of a port of their own.
    fn own_queue(&self, channel: Channel) -> usize {
        self.queue(usize::from(self.size.ports), Lane::new(channel, 0))
    }

    fn head(&self, queue: usize) -> Option<(Slot, &[u8])> {
        let fifo = self.memory.fifos.get(queue)?;
        if fifo.len == 0 {
            return None;
        }
        let slot = *self.memory.slots.get(self.slot(queue, usize::from(fifo.first)))?;
        let at = self.bytes_at(queue, usize::from(fifo.first));
        Some((slot, self.memory.bytes.get(at..at.checked_add(usize::from(slot.len))?)?))
    }

    fn push(
        &mut self,
        queue: usize,
        (to, from): (NodeId, NodeId),
        priority: u8,
        payload: &[u8],
    ) -> Result<(), Busy> {
        let hop = self.topology.route(self.here, to);
        if hop.is_none() && to != self.here {
            return Err(Busy);
        }
        let slot = Slot {
            to: to.0,
            from: from.0,
            len: payload.len().min(usize::from(u16::MAX)) as u16,
            port: hop.map_or(ARRIVED, |hop| hop.port.0),
            class: hop.map_or(0, |hop| hop.class),
            priority,
        };
        let depth = usize::from(self.size.depth);
        let fifo = self.memory.fifos.get(queue).copied().ok_or(Busy)?;
        if usize::from(fifo.len) >= depth || payload.len() > usize::from(self.size.payload) {
            return Err(Busy);
        }
        let place = (usize::from(fifo.first) + usize::from(fifo.len)).checked_rem(depth);
        let place = place.ok_or(Busy)?;
        let at = self.bytes_at(queue, place);
        let bytes =
            at.checked_add(payload.len()).and_then(|end| self.memory.bytes.get_mut(at..end));
        bytes.ok_or(Busy)?.copy_from_slice(payload);
        let index = self.slot(queue, place);
        *self.memory.slots.get_mut(index).ok_or(Busy)? = slot;
        if let Some(fifo) = self.memory.fifos.get_mut(queue) {
            fifo.len += 1;
        }
        Ok(())
    }

    /// Frees the head of a queue, and gives its credit back to the link it came by.
    fn pop(&mut self, queue: usize) {
        let Some(fifo) = self.memory.fifos.get_mut(queue).filter(|fifo| fifo.len > 0) else {
            return;
        };
        fifo.len -= 1;
        fifo.first = u16::from(fifo.first + 1).checked_rem(self.size.depth).unwrap_or(0) as u8;
        // The node's own queue is behind the last port: it has no link.
        if let Some(state) = self.memory.ports.get_mut(queue / LANES)
            && queue / LANES < usize::from(self.size.ports)
            && let Some(receiver) = state.receivers.get_mut(queue % LANES)
        {
            receiver.release();
            state.owes_credit = 1;
        }
    }

    /// Puts the head of a queue at its end.
    fn rotate(&mut self, queue: usize) {
        let depth = usize::from(self.size.depth);
        let Some(fifo) = self.memory.fifos.get(queue).copied().filter(|f| f.len > 0) else {
            return;
        };
        let (first, len) = (usize::from(fifo.first), usize::from(fifo.len));
        let Some(last) = (first + len).checked_rem(depth) else { return };
        if last != first {
            let (from, to) = (self.slot(queue, first), self.slot(queue, last));
            let slot = self.memory.slots.get(from).copied();
            if let (Some(slot), Some(place)) = (slot, self.memory.slots.get_mut(to)) {
                *place = slot;
            }
            // Byte by byte: this is rare, and `copy_within` can panic where an index has 32 bits.
            let (from, to) = (self.bytes_at(queue, first), self.bytes_at(queue, last));
            for i in 0..usize::from(self.size.payload) {
                let byte = self.memory.bytes.get(from.saturating_add(i)).copied();
                let place = self.memory.bytes.get_mut(to.saturating_add(i));
                if let (Some(byte), Some(place)) = (byte, place) {
                    *place = byte;
                }
            }
        }
        if let Some(fifo) = self.memory.fifos.get_mut(queue) {
            fifo.first = (first + 1).checked_rem(depth).unwrap_or(0) as u8;
        }
    }

    fn slot(&self, queue: usize, place: usize) -> usize {
        queue * usize::from(self.size.depth) + place
    }

    fn bytes_at(&self, queue: usize, place: usize) -> usize {
        let lane = queue_lane(queue);
        let used = usize::from(self.size.classes.clamp(1, 2));
        let lane = lane.channel() as usize * used + usize::from(lane.class()).min(used - 1);
        let queue = queue / LANES * self.size.lanes_used() + lane;
        (queue * usize::from(self.size.depth) + place) * usize::from(self.size.payload)
    }
}

fn queue_lane(queue: usize) -> Lane {
    Lane::from_u8((queue % LANES) as u8).unwrap_or(Lane::ALL[0])
}
