use bytemuck::Zeroable;

use super::buffers::{ARRIVED, Place, RouterMemory, RouterSize, Slot};
use super::heads::Heads;
use super::packet::{Channel, LANES, Lane, PacketHeader};
use super::port::{ASK, PortState, TELL};
use super::{Arrival, Mesh, NodeId, Port, Sequence};
use crate::store::{Arena, ArenaFull};
use choice::{Sent, fresh};

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
/// consumes it. Lanes never wait for each other. Of the packets that want the same port, or the node itself, the most urgent goes first, and among equals
/// the queues take turns. Those that are passed over become more urgent, and stay so on the rest of their way: none waits for ever, and what has come
/// far is not held up anew at each hop by what is nearer. (With turns alone each hop on the way to a node that many ask halves what is left
/// for those behind it: Abts & Weisser 2007, "Age-based packet arbitration in large-radix k-ary n-cubes".)
#[derive(Debug)]
pub struct Router<'a> {
    mesh: Mesh,
    here: NodeId,
    size: RouterSize,
    memory: RouterMemory<'a>,
    /// Whether what is injected now is held back.
    holds: bool,
    /// Packets that are held back at the end of the node's own queues, by channel.
    held: [u8; Channel::ALL.len()],
    /// The queue after the one that was consumed last, by channel.
    turns: [u16; Channel::ALL.len()],
    /// Queues whose heads have arrived.
    arrived: Heads,
    /// See [`take_changed`](Self::take_changed).
    changed: u64,
    /// See [`take_news`](Self::take_news).
    news: bool,
    /// A broken rule: replies take the lanes of requests.
    #[cfg(test)]
    pub(crate) one_channel: bool,
}

impl<'a> Router<'a> {
    /// A router with empty buffers.
    ///
    /// # Errors
    /// [`ArenaFull`] if the arena has less than [`RouterSize::arena_bytes`].
    pub fn new(
        arena: &mut Arena<'a>,
        mesh: Mesh,
        here: NodeId,
        size: RouterSize,
    ) -> Result<Self, ArenaFull> {
        let memory = RouterMemory::carve(arena, &size)?;
        for (state, port) in memory.ports.iter_mut().zip((0..).map(Port)) {
            *state = PortState::new(&size, port, mesh.neighbour(here, port));
        }
        Ok(Self {
            mesh,
            here,
            size,
            memory,
            holds: false,
            held: [0; Channel::ALL.len()],
            turns: [0; Channel::ALL.len()],
            arrived: Heads::NONE,
            changed: 0,
            news: false,
            #[cfg(test)]
            one_channel: false,
        })
    }

    /// What it is a part of.
    #[must_use]
    pub const fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Where this router is.
    #[must_use]
    pub const fn here(&self) -> NodeId {
        self.here
    }

    /// Takes a packet of the node's own into the buffers. One for the node itself arrives at once. Priorities are 0 to 7, the most urgent first: each step is worth
    /// being passed over once.
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
        self.push_own(to, channel, priority, payload.len(), payload).map(drop)
    }

    /// The same for a payload of this length, which is to be written to where it lies then.
    ///
    /// # Errors
    /// As [`inject`](Self::inject).
    pub fn inject_room(
        &mut self,
        to: NodeId,
        channel: Channel,
        priority: u8,
        len: usize,
    ) -> Result<&mut [u8], Busy> {
        let place = self.push_own(to, channel, priority, len, &[])?;
        self.memory.bytes.get_mut(place..).and_then(|room| room.get_mut(..len)).ok_or(Busy)
    }

    fn push_own(
        &mut self,
        to: NodeId,
        channel: Channel,
        priority: u8,
        len: usize,
        payload: &[u8],
    ) -> Result<usize, Busy> {
        let queue = self.own_queue(channel);
        let place = self.push(queue, (to, self.here), fresh(priority), len, payload)?;
        if self.holds
            && let Some(held) = self.held.get_mut(channel as usize)
        {
            *held = held.saturating_add(1);
        }
        Ok(place)
    }

    /// Holds back what is injected from now on, as what a node makes can leave only when the node has done it.
    pub fn hold(&mut self) {
        self.holds = true;
    }

    /// Lets go what was held back.
    pub fn release(&mut self) {
        self.holds = false;
        for (channel, held) in Channel::ALL.into_iter().zip(core::mem::take(&mut self.held)) {
            if held > 0 {
                self.note_head(self.own_queue(channel));
            }
        }
    }

    /// Drops what was held back: the node has died before it had done it.
    pub fn discard(&mut self) {
        self.holds = false;
        for (channel, held) in Channel::ALL.into_iter().zip(core::mem::take(&mut self.held)) {
            let queue = self.own_queue(channel);
            if let Some(fifo) = self.memory.fifos.get_mut(queue) {
                fifo.len = fifo.len.saturating_sub(held);
            }
            self.note_head(queue);
        }
    }

    /// The ports by which something may leave that could not before the last call: bit `p % 64` for port `p`.
    /// Others need not be asked to [`transmit`](Self::transmit), apart from those that were left when their link was busy.
    pub fn take_changed(&mut self) -> u64 {
        core::mem::take(&mut self.changed)
    }

    /// Whether a packet for the node has come to the front of a queue since the last call: it can be consumed now. (When it came, it may have
    /// been behind others that had to leave first.)
    pub fn take_news(&mut self) -> bool {
        core::mem::take(&mut self.news)
    }

    /// Whether there is something to send by a port, with credit or without: a look at what most calls to [`transmit`](Self::transmit) end with.
    #[inline]
    #[must_use]
    pub fn may_send(&self, port: Port) -> bool {
        let state = self.memory.ports.get(usize::from(port.0));
        state.is_some_and(|state| !state.waiting.is_empty() || state.owes_credit())
    }

    /// Whether [`transmit`](Self::transmit) has something to send by a port now.
    #[cfg(test)]
    pub(crate) fn is_ready(&self, port: Port) -> bool {
        let state = self.memory.ports.get(usize::from(port.0)).filter(|state| state.is_joined());
        state.is_some_and(|state| self.next_for(port).is_some() || state.owes_credit())
    }

    /// Greatest payload of a packet of the node's own of a channel \[bytes\].
    #[must_use]
    pub fn payload_of(&self, channel: Channel) -> usize {
        self.place(self.own_queue(channel)).payload.into()
    }

    /// Packets that [`inject`](Self::inject) takes now.
    #[must_use]
    pub fn room(&self, channel: Channel) -> u16 {
        let len = self.memory.fifos.get(self.own_queue(channel)).map_or(u8::MAX, |f| f.len);
        self.size.own.saturating_sub(u16::from(len))
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
        let exists = self.mesh.contains(header.to());
        let queue = self.queue(usize::from(port.0), lane);
        if payload.len() > usize::from(self.place(queue).payload)
            || lane.class() >= self.size.classes
            || header.kind == PacketHeader::DATA && !exists
        {
            return Received::Bad;
        }
        let Some(state) = self.memory.ports.get_mut(usize::from(port.0)) else {
            return Received::Bad;
        };
        self.changed |= port_bit(port.0);
        for (sender, limit) in state.senders.iter_mut().zip(header.limits) {
            sender.grant(Sequence(limit));
        }
        if header.kind == PacketHeader::CONTROL {
            for (receiver, sent) in state.receivers.iter_mut().zip(header.sent) {
                receiver.probe(Sequence(sent));
            }
            if header.priority == PacketHeader::ASKS {
                state.control = state.control.max(TELL);
            }
            return Received::Control;
        }
        let Some(receiver) = state.receivers.get_mut(lane.index()) else { return Received::Bad };
        if let Arrival::Stale = receiver.receive(header.sent_on(lane)) {
            return Received::Stale;
        }
        if is_dead(header.to()) {
            receiver.release();
            return Received::Dead;
        }
        let ends = (header.to(), header.from());
        match self.push(queue, ends, header.priority, payload.len(), payload) {
            Ok(_) => Received::Buffered,
            // Credit was given for it: cannot be.
            Err(Busy) => Received::Bad,
        }
    }

    /// The most urgent packet of a channel that has arrived for this node: who has sent it, and what.
    #[must_use]
    pub fn arrived(&self, channel: Channel) -> Option<(NodeId, &[u8])> {
        let queue = self.arrived_queue(channel)?;
        let (slot, payload) = self.head(queue)?;
        Some((NodeId(slot.from), payload))
    }

    /// Frees the buffer of the packet that [`arrived`](Self::arrived) shows.
    pub fn consume(&mut self, channel: Channel) {
        let Some(queue) = self.arrived_queue(channel) else { return };
        if let Some(turn) = self.turns.get_mut(channel as usize) {
            *turn = queue.wrapping_add(1) as u16;
        }
        self.pass_over(self.arrived, (ARRIVED, Some(channel)), queue);
        self.pop(queue);
    }

    /// Writes the next packet for a link to `out`, and gives its length; `None` if nothing is to be sent, or nothing may be.
    ///
    /// `out` must hold a header and a payload.
    pub fn transmit(&mut self, port: Port, out: &mut [u8]) -> Option<usize> {
        let state = self.memory.ports.get(usize::from(port.0)).filter(|port| port.is_joined())?;
        // A question goes first: it is rare, and other lanes could keep the link busy for ever.
        let asks = state.control == ASK;
        match self.next_for(port).filter(|_| !asks) {
            Some(next) => self.send(port, next, out),
            None => self.control(port, out),
        }
    }

    /// To be called at intervals where packets can be lost or overtaken: asks for credit that is overdue, so that lost packets and lost credit heal.
    /// Gives whether any is; where not, there is no need to call again before the next packet leaves.
    pub fn remind(&mut self) -> bool {
        let mut any = false;
        for state in self.memory.ports.iter_mut().take(usize::from(self.size.ports)) {
            if state.is_credit_out() {
                state.control = ASK;
                self.changed = u64::MAX;
                any = true;
            }
        }
        any
    }

    /// Most packets that the buffers of a port ever held, lane by lane. The port after the last stands for the node's own packets.
    #[must_use]
    pub fn peak(&self, port: Port) -> u32 {
        let first = usize::from(port.0).saturating_mul(LANES);
        self.memory.fifos.iter().skip(first).take(LANES).map(|fifo| u32::from(fifo.peak)).sum()
    }

    /// The same of all ports and the node's own packets, as if they had been fullest together.
    #[must_use]
    pub fn packets_peak(&self) -> u32 {
        self.memory.fifos.iter().map(|fifo| u32::from(fifo.peak)).sum()
    }

    /// Packets that the buffers of a port can hold.
    #[must_use]
    pub fn buffers(&self, port: Port) -> u32 {
        let first = usize::from(port.0).saturating_mul(LANES);
        self.memory.places.iter().skip(first).take(LANES).map(|place| u32::from(place.depth)).sum()
    }

    /// Packets in all buffers.
    #[must_use]
    pub fn buffered(&self) -> u32 {
        self.memory.fifos.iter().take(self.size.queues()).map(|fifo| u32::from(fifo.len)).sum()
    }

    fn send(&mut self, port: Port, sent: Sent, out: &mut [u8]) -> Option<usize> {
        let Sent { queue, lane } = sent;
        let (slot, payload) = self.head(queue)?;
        let len = PacketHeader::BYTES + payload.len();
        let (head, body) = out.get_mut(..len)?.split_at_mut_checked(PacketHeader::BYTES)?;
        body.copy_from_slice(payload);
        let state = self.memory.ports.get_mut(usize::from(port.0))?;
        let _number = state.senders.get_mut(lane.index())?.take()?;
        state.turn = queue.wrapping_add(1) as u16;
        let header = PacketHeader {
            lane: lane.index() as u8,
            priority: slot.priority,
            to: slot.to,
            from: slot.from,
            ..state.header(PacketHeader::DATA)
        };
        state.control = 0;
        let waiting = state.waiting;
        head.copy_from_slice(bytemuck::bytes_of(&header));
        self.pass_over(waiting, (port.0, None), queue);
        self.pop(queue);
        Some(len)
    }

    fn control(&mut self, port: Port, out: &mut [u8]) -> Option<usize> {
        let state = self.memory.ports.get_mut(usize::from(port.0))?;
        if !state.owes_credit() {
            return None;
        }
        let header = PacketHeader {
            priority: if state.control == ASK { PacketHeader::ASKS } else { 0 },
            from: self.here.0,
            ..state.header(PacketHeader::CONTROL)
        };
        state.control = 0;
        out.get_mut(..PacketHeader::BYTES)?.copy_from_slice(bytemuck::bytes_of(&header));
        Some(PacketHeader::BYTES)
    }

    /// Whether the head of a queue is of a channel, if there is one.
    fn carries(&self, queue: usize, channel: Channel) -> bool {
        #[cfg(test)]
        if self.one_channel {
            return self.kind_at_head(queue) == Some(channel);
        }
        is_of(queue, channel)
    }

    /// On which channel the packets of a queue leave.
    fn channel_of(&self, queue: usize) -> Channel {
        #[cfg(test)]
        if self.one_channel {
            return Channel::Request;
        }
        queue_lane(queue).channel()
    }

    fn queue(&self, port: usize, lane: Lane) -> usize {
        port * LANES + lane.index()
    }

    /// The node's own packets begin in class 0 of a port of their own.
    fn own_queue(&self, channel: Channel) -> usize {
        self.queue(usize::from(self.size.ports), Lane::new(channel, 0))
    }

    fn slot_at_head(&self, queue: usize) -> Option<&Slot> {
        let fifo = self.memory.fifos.get(queue).filter(|fifo| fifo.len > 0)?;
        self.memory.slots.get(self.place(queue).slot(fifo.first.into()))
    }

    fn head(&self, queue: usize) -> Option<(Slot, &[u8])> {
        let slot = *self.slot_at_head(queue)?;
        let first = self.memory.fifos.get(queue)?.first;
        let at = self.place(queue).byte(first.into());
        Some((slot, self.memory.bytes.get(at..at.checked_add(usize::from(slot.len))?)?))
    }

    /// Whether all packets of a queue are held back.
    fn is_held(&self, queue: usize) -> bool {
        let lane = queue_lane(queue);
        let held = self.held.get(lane.channel() as usize).copied().unwrap_or(0);
        let len = self.memory.fifos.get(queue).map_or(0, |fifo| fifo.len);
        queue / LANES == usize::from(self.size.ports) && len <= held
    }

    /// Puts a packet of this length at the end of a queue, with what is known of its bytes: where it lies.
    fn push(
        &mut self,
        queue: usize,
        (to, from): (NodeId, NodeId),
        priority: u8,
        len: usize,
        payload: &[u8],
    ) -> Result<usize, Busy> {
        let hop = self.mesh.route(self.here, to);
        if hop.is_none() && to != self.here {
            return Err(Busy);
        }
        let slot = Slot {
            to: to.0,
            from: from.0,
            len: len.min(usize::from(u16::MAX)) as u16,
            port: hop.map_or(ARRIVED, |hop| hop.port.0),
            class: hop.map_or(0, |hop| hop.class),
            priority,
        };
        let lies = self.place(queue);
        let depth = usize::from(lies.depth);
        let fifo = self.memory.fifos.get(queue).copied().ok_or(Busy)?;
        if usize::from(fifo.len) >= depth || len > usize::from(lies.payload) {
            return Err(Busy);
        }
        // Less than twice the depth: the head lies below it, and fewer packets than that are here.
        let place = usize::from(fifo.first) + usize::from(fifo.len);
        let place = if place < depth { place } else { place - depth };
        let at = lies.byte(place);
        let room = self.memory.bytes.get_mut(at..).and_then(|room| room.get_mut(..len));
        if let Some(known) = room.ok_or(Busy)?.get_mut(..payload.len()) {
            known.copy_from_slice(payload);
        }
        *self.memory.slots.get_mut(lies.slot(place)).ok_or(Busy)? = slot;
        if let Some(fifo) = self.memory.fifos.get_mut(queue) {
            fifo.len += 1;
            fifo.peak = fifo.peak.max(fifo.len);
            if fifo.len == 1 {
                self.note_head(queue);
            }
        }
        Ok(at)
    }

    /// Frees the head of a queue, and gives its credit back to the link it came by.
    fn pop(&mut self, queue: usize) {
        let depth = usize::from(self.place(queue).depth);
        let Some(fifo) = self.memory.fifos.get_mut(queue).filter(|fifo| fifo.len > 0) else {
            return;
        };
        fifo.len -= 1;
        let next = usize::from(fifo.first) + 1;
        // An empty queue begins at its first place again, which lies in a processor's caches rather than the others.
        fifo.first = if next < depth && fifo.len > 0 { next as u8 } else { 0 };
        let fifo_len = fifo.len;
        // The node's own queue is behind the last port: it has no link.
        if let Some(state) = self.memory.ports.get_mut(queue / LANES)
            && queue / LANES < usize::from(self.size.ports)
            && let Some(receiver) = state.receivers.get_mut(queue % LANES)
        {
            receiver.release();
            self.changed |= port_bit((queue / LANES) as u16);
        } else if let Some(held) = self.held.get_mut(queue_lane(queue).channel() as usize) {
            // The node has consumed a packet of its own to itself.
            *held = fifo_len.min(*held);
        }
        self.note_head(queue);
    }

    /// A queue has a new head, or none: its port has something to send, or the node something to consume.
    fn note_head(&mut self, queue: usize) {
        let head = self.slot_at_head(queue).copied();
        if let Some(fifo) = self.memory.fifos.get_mut(queue) {
            let (before, after) = fifo.set_head(head.as_ref());
            if before != after {
                let Self { memory: RouterMemory { fifos, ports, .. }, arrived, .. } = self;
                let goes = |at: usize| fifos.get(at).is_some_and(|fifo| fifo.port == before);
                if let Some(waiting) = waiting(ports, arrived, before) {
                    waiting.remove(queue, fifos.len(), goes);
                }
                if let Some(waiting) = waiting(ports, arrived, after) {
                    waiting.insert(queue);
                }
            }
        }
        match head {
            Some(slot) if slot.port == ARRIVED => self.news = true,
            Some(slot) => self.changed |= port_bit(slot.port),
            None => {}
        }
    }

    /// Where the packets of a queue lie.
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    fn place(&self, queue: usize) -> Place {
        self.memory.places.get(queue).copied().unwrap_or(Place::zeroed())
    }
}

mod choice;
mod gone;
#[cfg(test)]
mod state;

/// The queues whose heads are to go there.
fn waiting<'r>(
    ports: &'r mut [PortState],
    arrived: &'r mut Heads,
    port: u16,
) -> Option<&'r mut Heads> {
    if port == ARRIVED {
        return Some(arrived);
    }
    ports.get_mut(usize::from(port)).map(|state| &mut state.waiting)
}

fn port_bit(port: u16) -> u64 {
    1 << (port % 64)
}

fn is_of(queue: usize, channel: Channel) -> bool {
    queue_lane(queue).channel() == channel
}

fn queue_lane(queue: usize) -> Lane {
    Lane::of_queue(queue)
}
