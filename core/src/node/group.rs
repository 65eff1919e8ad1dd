use crate::network::NodeId;
use bytemuck::{Pod, Zeroable};

/// What a sub-master knows of the nodes of its group: which of them wait for a tile, and how each was answered last.
///
/// Answers may be lost. Whoever asks again is told the same: another tile would leave the first with nobody, until the host finds it overdue.
#[derive(Debug)]
pub(super) struct Group<'a> {
    sub_master: NodeId,
    /// Those behind it, in their order.
    members: &'a mut [Member],
    /// The turn that was given last.
    turn: u32,
}

/// The last request of a node.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Member {
    number: u32,
    /// Who has the least is answered first; 0: it does not wait.
    turn: u32,
    /// Its answer: none yet; that there is no tile; or one, and by how much it is greater.
    answer: u32,
}

/// See [`Member::answer`].
const NO_TILE: u32 = 1;
const TILE: u32 = 2;

/// What becomes of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asked {
    /// It waits for a tile from now on.
    Waits,
    /// It was answered: with a tile, or that there is none.
    Answered(Option<u32>),
}

/// The first of a node's group of so many; `None` where there are no groups.
pub(super) fn sub_master(node: NodeId, group: u16) -> Option<NodeId> {
    let place = node.0.checked_rem(group)?;
    Some(NodeId(node.0.wrapping_sub(place)))
}

impl<'a> Group<'a> {
    /// How many nodes of a mesh are behind this one in its group, if it is their sub-master.
    pub(super) fn len_at(here: NodeId, group: u16, nodes: u16) -> usize {
        let behind = nodes.saturating_sub(here.0).min(group).saturating_sub(1);
        if sub_master(here, group) == Some(here) { behind.into() } else { 0 }
    }

    pub(super) fn new(sub_master: NodeId, members: &'a mut [Member]) -> Self {
        Self { sub_master, members, turn: 0 }
    }

    fn member(&mut self, node: NodeId) -> Option<&mut Member> {
        let place = node.0.checked_sub(self.sub_master.0)?.checked_sub(1)?;
        self.members.get_mut(usize::from(place))
    }

    /// A node has asked. Who has waited and asks again is told that there is no tile, so that it sees that its sub-master lives; so is a request that was
    /// overtaken by what came of it, as nobody waits for its answer, and one of a node in place of this one, which comes to the next number soon.
    pub(super) fn on_ask(&mut self, from: NodeId, number: u32) -> Asked {
        let turn = self.turn.wrapping_add(1).max(1);
        let Some(member) = self.member(from) else { return Asked::Answered(None) };
        let ahead = number.wrapping_sub(member.number).cast_signed();
        let has_asked = member.turn != 0 || member.answer != 0;
        if ahead > 0 || !has_asked {
            *member = Member { number, turn, answer: 0 };
            self.turn = turn;
            return Asked::Waits;
        }
        if ahead < 0 {
            return Asked::Answered(None);
        }
        if member.turn != 0 {
            (member.turn, member.answer) = (0, NO_TILE);
        }
        Asked::Answered(member.answer.checked_sub(TILE))
    }

    /// The request that has waited longest.
    pub(super) fn first_waiting(&self) -> Option<(NodeId, u32)> {
        let waiting = (1..).zip(self.members.iter()).filter(|(_, member)| member.turn != 0);
        let (place, member) = waiting.min_by_key(|(_, member)| member.turn)?;
        Some((NodeId(self.sub_master.0.saturating_add(place)), member.number))
    }

    /// A node that waits is given a tile.
    pub(super) fn answer(&mut self, node: NodeId, tile: u32) {
        if let Some(member) = self.member(node) {
            (member.turn, member.answer) = (0, tile.saturating_add(TILE));
        }
    }

    /// Answers it anew.
    pub(super) fn forget(&mut self, node: NodeId) {
        if let Some(member) = self.member(node) {
            *member = Member::zeroed();
        }
    }

    /// All of it, with turns as low as they can be.
    #[cfg(test)]
    pub(super) fn snapshot(&mut self, s: &mut crate::tests::snapshot::Snapshot) {
        let mut turns: std::vec::Vec<_> =
            self.members.iter_mut().map(|m| &mut m.turn).filter(|turn| **turn != 0).collect();
        turns.sort();
        turns.into_iter().zip(1..).for_each(|(place, turn)| *place = turn);
        s.all(self.members);
        self.turn = self.members.iter().map(|member| member.turn).max().unwrap_or(0);
    }
}
