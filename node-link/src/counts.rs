use core::cell::Cell;

/// What a link has carried: both halves of it count in the same place.
#[derive(Debug, Default)]
pub struct Tally(Cell<LinkCounts>);

/// What a link has carried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LinkCounts {
    /// Frames sent.
    pub sent: u32,
    /// Bytes of them.
    pub sent_bytes: u64,
    /// Sound frames received.
    pub received: u32,
    /// Bytes received, of any kind.
    pub received_bytes: u64,
    /// Frames that were damaged, or longer than any packet: dropped.
    pub damaged: u32,
    /// A version of the [`Setup`](kiloray_core::node::Setup) that is not ours, which the far end has asked for.
    pub other_version: Option<u32>,
    /// The reader or the writer has failed, or come to its end: nothing comes any more.
    pub broken: bool,
}

impl LinkCounts {
    const NONE: Self = Self {
        sent: 0,
        sent_bytes: 0,
        received: 0,
        received_bytes: 0,
        damaged: 0,
        other_version: None,
        broken: false,
    };
}

impl Tally {
    /// Nothing counted yet.
    #[must_use]
    pub const fn new() -> Self {
        Self(Cell::new(LinkCounts::NONE))
    }

    /// The counts now.
    #[must_use]
    pub fn get(&self) -> LinkCounts {
        self.0.get()
    }

    pub(crate) fn update(&self, change: impl FnOnce(&mut LinkCounts)) {
        let mut counts = self.0.get();
        change(&mut counts);
        self.0.set(counts);
    }
}
