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
    /// A look at overdue credit is entered.
    pub(crate) reminded: bool,
    /// Questions for credit since the last packet left.
    pub(crate) reminders: u32,
    /// Rays that it holds for later.
    pub(crate) stored: u32,
    /// How long the present step takes, by what it is.
    pub(crate) step: NodeTime,
    /// Time that it owes to packets that it has passed on, as of `owed_since`: it has it while it waits, or after its step \[ns\].
    pub(crate) owed: u64,
    pub(crate) owed_since: u64,
    /// Where its time went, the present step not counted.
    pub(crate) time: NodeTime,
    /// What it did.
    pub(crate) work: Work,
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
            reminded: false,
            reminders: 0,
            stored: 0,
            step: NodeTime::default(),
            owed: 0,
            owed_since: 0,
            time: NodeTime::default(),
            work: Work::default(),
            steps: 0,
        }
    }

    /// What it owes by now to packets that it has passed on.
    pub(crate) fn owes(&mut self, now: u64) -> &mut u64 {
        if let Phase::Idle(_) = self.phase {
            self.owed = self.owed.saturating_sub(now - self.owed_since);
        }
        self.owed_since = now;
        &mut self.owed
    }

    /// Enters time in which it did not work.
    pub(crate) fn add_rest(&mut self, length: u64) {
        *match self.phase {
            Phase::Busy { .. } => return,
            Phase::Idle(Lack::Data) => &mut self.time.idle_data,
            Phase::Idle(Lack::Answers) => &mut self.time.idle_answers,
            Phase::Idle(Lack::Credit) => &mut self.time.idle_credit,
            Phase::Idle(Lack::Tiles) => &mut self.time.idle_work,
            Phase::Dead => &mut self.time.dead,
        } += length;
    }
}
