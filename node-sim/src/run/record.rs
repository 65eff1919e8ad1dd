use kiloray_mesh::watch::Watch;

use super::journal::{Journal, Moment, Notes, Span};
use super::timeline::TimelineRecorder;
use crate::TraceEvent;

/// What is taken down of a run. It is behind the run by a round: one thread takes down the last one, while others go on.
#[derive(Debug)]
pub(crate) struct Record {
    /// What each node did when.
    pub(crate) trace: Vec<TraceEvent>,
    pub(crate) timeline: TimelineRecorder,
    pub(crate) watch: Watch,
    /// Rays that all nodes hold.
    stored: i64,
    /// Most events of the trace.
    trace_max: usize,
    /// What is still to be taken down, by part.
    parts: Vec<Notes>,
    /// The moments of all parts.
    moments: Vec<(u64, Moment)>,
    /// Their order in time: the time since the first, and which it is.
    order: Vec<u64>,
}

impl Record {
    /// Nothing yet, of so many parts.
    pub(crate) fn new(parts: usize, block_bytes: usize, trace_max: usize) -> Self {
        Self {
            trace: Vec::new(),
            timeline: TimelineRecorder::default(),
            watch: Watch::new(block_bytes, trace_max),
            stored: 0,
            trace_max,
            parts: (0..parts).map(|_| Notes::default()).collect(),
            moments: Vec::new(),
            order: Vec::new(),
        }
    }

    /// Takes over what places have noted in a round. What came before must be taken down.
    pub(crate) fn take(&mut self, journals: &mut [Journal]) {
        for (notes, journal) in self.parts.iter_mut().zip(journals) {
            std::mem::swap(notes, &mut journal.notes);
        }
    }

    /// Takes down what it has taken over.
    pub(crate) fn take_down(&mut self) {
        let Self { trace, timeline, watch, stored, trace_max, parts, moments, order } = self;
        parts.iter_mut().for_each(|part| moments.append(&mut part.moments));
        // A round is shorter than 2³² ns. Numbers are sorted faster than moments.
        let first = moments.iter().map(|(at, _)| *at).min().unwrap_or(0);
        let times = moments.iter().map(|(at, _)| at - first);
        order.extend(times.zip(0..).map(|(at, number): (u64, u64)| at << u32::BITS | number));
        order.sort_unstable();
        for number in order.drain(..) {
            let (at, moment) = moments[number as u32 as usize];
            match moment {
                Moment::Stored(more) => {
                    *stored += more;
                    timeline.stored(at, *stored as u64);
                }
                Moment::Pixels(pixels) => timeline.pixels(at, pixels),
                Moment::Seen(sight) => watch.see(at, sight),
            }
        }
        moments.clear();
        timeline.reach(parts.iter().filter_map(Notes::end).max().unwrap_or(0));
        // Behind what holds from a moment on: where the line grows, it goes on with that.
        for part in &mut *parts {
            for span in part.spans.drain(..) {
                match span {
                    Span::Busy { from, to, useful } => timeline.busy(from, to, useful),
                    Span::Waiting { from, to } => timeline.waiting(from, to),
                }
            }
            part.sent.drain(..).for_each(|(at, bytes)| timeline.bytes(at, bytes));
        }
        let before = trace.len();
        parts.iter_mut().for_each(|part| trace.append(&mut part.trace));
        trace[before..].sort_by_key(|event| event.start_ns);
        trace.truncate(*trace_max);
    }
}
