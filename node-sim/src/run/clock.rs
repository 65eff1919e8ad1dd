use kiloray_core::node::{Lack, Work};

use crate::NodeTime;

/// What a place is doing, and what its time went to.
#[derive(Debug)]
pub(crate) struct PlaceState {
    /// What it is doing.
    pub(crate) phase: Phase,
    /// Since when.
    pub(crate) since: u64,
    /// A packet has come or gone since its last step.
    pub(crate) news: bool,
    /// It is to be called at this moment at the latest.
    pub(crate) until: u64,
    /// A call is entered for this moment.
    pub(crate) wake: u64,
    /// A look at overdue credit is entered for this moment.
    pub(crate) remind: u64,
    /// Questions for credit since the last packet left.
    pub(crate) reminders: u32,
    /// When the last packet left that was no question.
    pub(crate) left: u64,
    /// Rays that it holds for later.
    pub(crate) stored: u32,
    /// How long the present step takes, by what it is.
    pub(crate) step: NodeTime,
    /// Until when it is kept by packets that it has passed on, if it does nothing else from the end of its step on \[ns\].
    pub(crate) kept_until: u64,
    /// Until when it is at packets that it passes on \[ns\]: the next one waits so long.
    pub(crate) forwards_until: u64,
    /// Where its time went, the present step not counted.
    pub(crate) time: NodeTime,
    /// What it did.
    pub(crate) work: Work<u64>,
    /// Steps.
    pub(crate) steps: u64,
}

/// What a place is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// It works off a step, and can then go on or has to wait.
    Busy {
        /// For what it will wait; `None` if it can go on.
        then: Option<Lack>,
    },
    /// It waits.
    Idle(Lack),
    /// It is dead.
    Dead,
}

impl PlaceState {
    /// Idle from the beginning, to be called then.
    pub(crate) fn new() -> Self {
        Self {
            phase: Phase::Idle(Lack::Tiles),
            since: 0,
            news: true,
            until: 0,
            wake: u64::MAX,
            remind: u64::MAX,
            reminders: 0,
            left: 0,
            stored: 0,
            step: NodeTime::default(),
            kept_until: 0,
            forwards_until: 0,
            time: NodeTime::default(),
            work: Work::default(),
            steps: 0,
        }
    }

    /// A packet keeps it for so long, now or behind its step.
    pub(crate) fn keep(&mut self, now: u64, length: u64) {
        let free = match self.phase {
            Phase::Busy { .. } => self.since.saturating_add(self.step.busy()),
            Phase::Idle(_) | Phase::Dead => now,
        };
        self.kept_until = self.kept_until.max(free).saturating_add(length);
    }

    /// How long it has worked so far, and whether it still does: on its step, or on packets that it passes on.
    pub(crate) fn worked(&self, now: u64) -> (u64, bool) {
        let busy = matches!(self.phase, Phase::Busy { .. });
        let begun = if busy { now.saturating_sub(self.since) } else { 0 };
        (self.time.busy().saturating_add(begun), busy || self.forwards_until > now)
    }

    /// Enters time in which it did not work.
    pub(crate) fn add_rest(&mut self, length: u64) {
        *match self.phase {
            Phase::Busy { .. } => return,
            Phase::Idle(Lack::Data) => &mut self.time.idle_data,
            Phase::Idle(Lack::Answers) => &mut self.time.idle_answers,
            Phase::Idle(Lack::Credit) => &mut self.time.idle_credit,
            Phase::Idle(Lack::Master) => &mut self.time.idle_master,
            Phase::Idle(Lack::Tiles) => &mut self.time.idle_work,
            Phase::Dead => &mut self.time.dead,
        } += length;
    }
}
