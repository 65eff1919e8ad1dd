use super::{Node, World};

/// The rules that keep a mesh free of deadlock in fixed memory, by number; each is named where it is kept.
///
/// Those that a test can break, one by one, to see that the checker misses them. The others hold by what things are: two channels with buffers and credit
/// of their own (1, [`Router`](crate::network::Router)), routes (2, [`Topology`](crate::network::Topology)), requests that are taken or refused where they lie (4, 5), a tail
/// call that needs no slot (9), shadow rays that can always be run at home (10), one block at a time (12, [`Trail`](crate::trace::Trail)), the dead
/// (16, [`signal`](super::signal)). `ARCHITECTURE.md` lists all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Rule {
    /// 3: a reply is consumed at once; what follows from it waits in a record, not in a link buffer.
    ConsumeReplies,
    /// 6: what is bundled leaves when the node has nothing to run.
    Flush,
    /// 7: a ray takes a slot only if others stay free for the times that it may split.
    Reserve,
    /// 7: one for each time, not one for all.
    ReserveByDepth,
    /// 8: after so many refusals a ray is run at home.
    RefusalLimit,
    /// 8: a refused ray has its slot: it needs no other.
    HomeSlot,
    /// 11: the frame of a block is reserved before its request leaves.
    FrameFirst,
    /// 13: nothing holds a frame while it waits: by the types, so that only a test can break it.
    #[cfg(test)]
    FrameFree,
    /// 14: an answer is accepted by the name of its ray, not by its slot alone.
    AnswerByKey,
    /// 14: the answer of a name is all that its ray brings, whoever gives it, so that a late one is a right one.
    WholeAnswer,
    /// 14: a request for tiles has one answer, however often it comes: a tile that went with another would be missed.
    OneAnswer,
    /// 15: the time limit of what is open always runs.
    Timer,
}

impl<W: World> Node<'_, W> {
    /// Whether a rule is kept: always, but in tests that break one.
    #[cfg_attr(not(test), expect(clippy::unused_self, reason = "tests have a field for it"))]
    #[inline]
    pub(super) fn keeps(&self, rule: Rule) -> bool {
        #[cfg(test)]
        return self.broken != Some(rule);
        #[cfg(not(test))]
        {
            let _ = rule;
            true
        }
    }
}
