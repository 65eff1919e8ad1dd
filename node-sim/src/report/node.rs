use std::ops::AddAssign;

use kiloray_core::node::{Counts, Work};
use kiloray_core::store::LineBudget;
use serde::Serialize;

/// A node of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NodeReport {
    /// Its number.
    pub node: u16,
    /// How many times longer its work took than the profile says.
    pub slow: f64,
    /// When it died \[ns\].
    pub crashed_ns: Option<u64>,
    /// Where its time went: the parts sum up to the run's virtual time.
    pub time: NodeTime,
    /// Steps of the actor.
    pub steps: u64,
    /// What it did.
    pub counts: Counts,
    /// Its operations.
    pub work: Work<u64>,
    /// Bytes that it was given.
    pub memory: usize,
    /// Bytes in use when each line was fullest: no less than were ever in use at once.
    pub peak_bytes: usize,
    /// The lines of its memory.
    pub lines: Vec<LineReport>,
    /// Blocks it owns, the replicated top included.
    pub owned_blocks: u32,
}

/// Where the time of a node went \[ns\].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct NodeTime {
    /// Boxes and triangles, blocks entered, rays begun.
    pub trace: u64,
    /// Materials, lights, and the rays that follow.
    pub shade: u64,
    /// Bundles clipped against the tree.
    pub clip: u64,
    /// Messages read and written.
    pub messages: u64,
    /// Bytes copied.
    pub copies: u64,
    /// Arrived blocks checked.
    pub checks: u64,
    /// Packets of others passed on, as far as there was no time for it while it waited.
    pub forwards: u64,
    /// Idle, as blocks were awaited.
    pub idle_data: u64,
    /// Idle, as answers to rays were awaited.
    pub idle_answers: u64,
    /// Idle, as there was no room to send.
    pub idle_credit: u64,
    /// Idle, as the master had not answered.
    pub idle_master: u64,
    /// Idle without work.
    pub idle_work: u64,
    /// After its death.
    pub dead: u64,
}

impl NodeTime {
    /// At work.
    #[must_use]
    pub fn busy(&self) -> u64 {
        // Steps can be longer than all time, where a node is slow enough.
        self.work().into_iter().fold(0, u64::saturating_add)
    }

    const fn work(&self) -> [u64; 7] {
        let &Self { trace, shade, clip, messages, copies, checks, forwards, .. } = self;
        [trace, shade, clip, messages, copies, checks, forwards]
    }

    /// What it would have been if a node had not been slower by a factor: its work, not its waits.
    #[must_use]
    pub fn at_full_speed(self, slow: f64) -> Self {
        let part = |ns: u64| (ns as f64 / slow) as u64;
        Self {
            trace: part(self.trace),
            shade: part(self.shade),
            clip: part(self.clip),
            messages: part(self.messages),
            copies: part(self.copies),
            checks: part(self.checks),
            forwards: part(self.forwards),
            ..self
        }
    }

    /// The part of its work that one node would have to do as well: tracing and shading.
    pub(crate) fn useful(&self) -> f32 {
        (self.trace + self.shade) as f32 / self.busy().max(1) as f32
    }

    /// Idle, for whatever reason.
    #[must_use]
    pub fn idle(&self) -> u64 {
        self.idle_data + self.idle_answers + self.idle_credit + self.idle_master + self.idle_work
    }

    /// Of work, the first so many ns, each part in its share.
    pub(crate) fn first(&self, ns: u64) -> Self {
        let all = self.work().map(u128::from).iter().sum::<u128>().max(1);
        let share = |part: u64| (u128::from(part) * u128::from(ns) / all) as u64;
        let mut first = Self {
            trace: share(self.trace),
            shade: share(self.shade),
            clip: share(self.clip),
            messages: share(self.messages),
            copies: share(self.copies),
            checks: share(self.checks),
            forwards: share(self.forwards),
            ..Self::default()
        };
        first.trace += ns.saturating_sub(first.busy());
        first
    }

    /// All of it, by name.
    #[must_use]
    pub fn parts(&self) -> [(&'static str, u64); 13] {
        [
            ("trace", self.trace),
            ("shade", self.shade),
            ("clip", self.clip),
            ("messages", self.messages),
            ("copies", self.copies),
            ("checks", self.checks),
            ("forwards", self.forwards),
            ("idle_data", self.idle_data),
            ("idle_answers", self.idle_answers),
            ("idle_credit", self.idle_credit),
            ("idle_master", self.idle_master),
            ("idle_work", self.idle_work),
            ("dead", self.dead),
        ]
    }
}

impl AddAssign for NodeTime {
    fn add_assign(&mut self, other: Self) {
        self.trace += other.trace;
        self.shade += other.shade;
        self.clip += other.clip;
        self.messages += other.messages;
        self.copies += other.copies;
        self.checks += other.checks;
        self.forwards += other.forwards;
        self.idle_data += other.idle_data;
        self.idle_answers += other.idle_answers;
        self.idle_credit += other.idle_credit;
        self.idle_master += other.idle_master;
        self.idle_work += other.idle_work;
        self.dead += other.dead;
    }
}

/// A line of a node's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct LineReport {
    /// What it is for.
    pub name: &'static str,
    /// Items it can hold.
    pub capacity: usize,
    /// Bytes it takes.
    pub bytes: usize,
    /// Most items it ever held.
    pub peak: usize,
    /// Their bytes.
    pub peak_bytes: usize,
}

impl From<&LineBudget> for LineReport {
    fn from(line: &LineBudget) -> Self {
        Self {
            name: line.line.name(),
            capacity: line.capacity,
            bytes: line.bytes,
            peak: line.peak,
            peak_bytes: line.peak_bytes(),
        }
    }
}
