use super::packets::{Buffers, Packet};
use super::timeline;
use crate::TraceEvent;
use kiloray_core::network::{NodeId, Port};
use kiloray_mesh::watch::Sight;

/// What places have done: what others must hear of when the window ends, and what is taken down when the round does. It goes from place to place.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    /// The last thing happened then \[ns\].
    pub(crate) now: u64,
    /// So many things have happened.
    pub(crate) events: u64,
    /// In the order of departure.
    pub(crate) departures: Vec<Departure>,
    pub(crate) notes: Notes,
    pub(crate) buffers: Buffers,
}

/// What is taken down when a round has ended.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    /// What must be taken down in the order of time.
    pub(crate) moments: Vec<(u64, Moment)>,
    /// What is summed up, in any order.
    pub(crate) spans: Vec<Span>,
    /// When bytes were sent, and how many: those of a step of the time line are one.
    pub(crate) sent: Vec<(u64, u64)>,
    pub(crate) trace: Vec<TraceEvent>,
}

impl Notes {
    /// A place sends so many bytes.
    pub(crate) fn sends(&mut self, at: u64, bytes: u64) {
        match self.sent.last_mut() {
            Some((last, sum)) if timeline::step_of(*last) == timeline::step_of(at) => *sum += bytes,
            _ => self.sent.push((at, bytes)),
        }
    }

    /// The end of the last span.
    pub(crate) fn end(&self) -> Option<u64> {
        let spans = self.spans.iter().map(|span| match *span {
            Span::Busy { to, .. } | Span::Waiting { to, .. } => to,
        });
        spans.chain(self.sent.iter().map(|(at, _)| at + 1)).max()
    }
}

/// A packet that is on its way to another place.
#[derive(Debug)]
pub(crate) struct Departure {
    pub(crate) from: NodeId,
    pub(crate) to: NodeId,
    /// By which port it comes.
    pub(crate) port: Port,
    /// When \[ns\].
    pub(crate) arrival: u64,
    pub(crate) packet: Packet,
}

/// What is so from a moment on.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Moment {
    /// The place holds so many rays more.
    Stored(i64),
    /// So many pixels are complete.
    Pixels(u64),
    /// A message was seen.
    Seen(Sight),
}

/// What a place did for a while.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Span {
    /// It worked; of that this part was tracing and shading.
    Busy { from: u64, to: u64, useful: f32 },
    /// It waited.
    Waiting { from: u64, to: u64 },
}
