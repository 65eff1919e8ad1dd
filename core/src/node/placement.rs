use crate::network::NodeId;
use core::num::NonZeroU64;

/// Which node owns which block: a formula, so that no node keeps a table of all blocks.
///
/// The first `top` blocks, those nearest to the root, lie with every node. The others are dealt out; with `replicas` above 1 each lies
/// with so many nodes in all, evenly spread over the mesh, so that a crash in one corner takes one copy.
///
/// The compiler numbers blocks depth first, so a range of numbers is a set of subtrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Placement {
    /// How blocks are dealt out.
    pub dealing: Dealing,
    /// Blocks of the scene.
    pub blocks: u32,
    /// Nodes of the mesh.
    pub nodes: u16,
    /// Blocks that every node has.
    pub top: u32,
    /// Copies of each other block, at least 1.
    pub replicas: u16,
}

/// How blocks are dealt out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Dealing {
    /// Ranges of equal length: whole subtrees.
    Subtrees,
    /// One block to each in turn.
    RoundRobin,
}

impl Placement {
    /// The node that holds copy `copy` of a block; `None` if every node has it, or the scene has not.
    #[must_use]
    pub fn owner(&self, block: u32, copy: u16) -> Option<NodeId> {
        let index = block.checked_sub(self.top)?;
        let dealt = self.dealt();
        let nodes = self.shares();
        if index >= dealt {
            return None;
        }
        let first = match self.dealing {
            // Block `i` of `n` for `k` nodes: floor(i k / n).
            Dealing::Subtrees => (u64::from(index) * nodes.get()).checked_div(u64::from(dealt))?,
            Dealing::RoundRobin => u64::from(index) % nodes,
        };
        Some(NodeId((first.wrapping_add(self.shift(copy)) % nodes) as u16))
    }

    /// Where copies are ranges: the first block of this copy that a node holds, and the one behind the last.
    #[must_use]
    pub fn range(&self, node: NodeId, copy: u16) -> Option<(u32, u32)> {
        if self.dealing != Dealing::Subtrees || node.0 >= self.nodes {
            return None;
        }
        let place = self.place(node, copy);
        // Block `i` of `n` goes to floor(i k / n): node `p` begins at ceil(p n / k).
        let nodes = self.shares().get();
        let begin = |place: u64| place.saturating_mul(u64::from(self.dealt())).div_ceil(nodes);
        let block = |index: u64| (index as u32).saturating_add(self.top);
        Some((block(begin(place)), block(begin(place.wrapping_add(1)))))
    }

    /// Whether a node has a block without fetching it.
    #[must_use]
    pub fn holds(&self, node: NodeId, block: u32) -> bool {
        block < self.top.min(self.blocks)
            || (0..self.copies()).any(|copy| self.owner(block, copy) == Some(node))
    }

    /// Blocks that a node has without fetching them.
    #[must_use]
    pub fn held(&self, node: NodeId) -> u32 {
        let dealt = (0..self.copies()).map(|copy| self.before(node, copy, self.blocks));
        dealt.fold(self.top.min(self.blocks), u32::saturating_add)
    }

    /// Blocks before this one of which a node has this copy, the top apart.
    pub(super) fn before(&self, node: NodeId, copy: u16, block: u32) -> u32 {
        match self.range(node, copy) {
            Some((first, end)) => block.min(end).saturating_sub(first),
            None if node.0 >= self.nodes => 0,
            // Of those that are dealt out it has `p`, `p + k`, `p + 2 k`, ..
            None => {
                let dealt = block.saturating_sub(self.top);
                let behind = dealt.saturating_sub(self.place(node, copy) as u32);
                u64::from(behind).div_ceil(self.shares().get()) as u32
            }
        }
    }

    /// Which node's share a node has as this copy.
    fn place(&self, node: NodeId, copy: u16) -> u64 {
        let nodes = self.shares();
        u64::from(node.0).wrapping_add(nodes.get()).wrapping_sub(self.shift(copy)) % nodes
    }

    /// Copies of each block that is dealt out.
    #[must_use]
    pub fn copies(&self) -> u16 {
        self.replicas.clamp(1, self.nodes.max(1))
    }

    /// Most blocks that any node holds, the top included: what its read-only memory takes.
    #[must_use]
    pub fn most_blocks(&self) -> u32 {
        let each = u64::from(self.dealt()).div_ceil(self.shares().get());
        let all = each.saturating_mul(u64::from(self.copies()));
        (all.min(u64::from(self.dealt())) as u32).saturating_add(self.top.min(self.blocks))
    }

    /// The same with fewer blocks at the top, if it must be, so that no node holds more than `most`.
    ///
    /// # Errors
    /// What a node would hold at least, where not even the root's block alone can lie with all.
    pub fn within(self, most: u32) -> Result<Self, u32> {
        let tops = (self.top.min(1)..=self.top).rev().map(|top| Self { top, ..self });
        let mut least = u32::MAX;
        for placement in tops {
            let held = placement.most_blocks();
            if held <= most {
                return Ok(placement);
            }
            least = least.min(held);
        }
        Err(least)
    }

    /// Blocks that are dealt out.
    fn dealt(&self) -> u32 {
        self.blocks.saturating_sub(self.top)
    }

    /// Nodes that the others are dealt out to.
    fn shares(&self) -> NonZeroU64 {
        at_least_one(self.nodes)
    }

    /// How far behind the first owner the one of this copy is.
    fn shift(&self, copy: u16) -> u64 {
        let copies = at_least_one(self.copies());
        (u64::from(copy) % copies).saturating_mul(self.shares().get()) / copies
    }
}

/// What may be divided by, as the compiler sees too.
fn at_least_one(count: u16) -> NonZeroU64 {
    NonZeroU64::new(u64::from(count)).unwrap_or(NonZeroU64::MIN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_block_has_its_copies_at_different_nodes_and_none_holds_too_many(
            blocks in 0_u32..400, nodes in 1_u16..40, top in 0_u32..20, replicas in 1_u16..5, robin: bool,
        ) {
            let dealing = if robin { Dealing::RoundRobin } else { Dealing::Subtrees };
            let placement = Placement { dealing, blocks, nodes, top, replicas };
            let holders = |block| (0..nodes).filter(|&n| placement.holds(NodeId(n), block)).count();
            for block in 0..blocks {
                let expected = if block < top { nodes } else { replicas.min(nodes) };
                prop_assert_eq!(holders(block), usize::from(expected));
                let owner = placement.owner(block, 0);
                prop_assert_eq!(owner.is_none(), block < top);
                prop_assert!(owner.is_none_or(|o| o.0 < nodes && placement.holds(o, block)));
            }
            prop_assert_eq!(placement.owner(blocks.max(top), 0), None);
            for (node, copy) in (0..nodes).flat_map(|n| (0..placement.copies()).map(move |c| (n, c))) {
                let Some((first, end)) = placement.range(NodeId(node), copy) else { break };
                for block in top..blocks {
                    let owns = placement.owner(block, copy) == Some(NodeId(node));
                    prop_assert_eq!((first..end).contains(&block), owns);
                }
            }
            for node in 0..nodes {
                let held = (0..blocks).filter(|&b| placement.holds(NodeId(node), b)).count();
                prop_assert_eq!(placement.held(NodeId(node)), held as u32);
                prop_assert!(held as u32 <= placement.most_blocks());
            }
        }

        #[test]
        fn no_node_holds_more_than_the_limit_and_the_top_gives_way_no_further_than_it_must(
            blocks in 1_u32..400, nodes in 1_u16..40, top in 1_u32..20, replicas in 1_u16..5, robin: bool, most in 0_u32..300,
        ) {
            let dealing = if robin { Dealing::RoundRobin } else { Dealing::Subtrees };
            let wanted = Placement { dealing, blocks, nodes, top, replicas };
            let fits = |top| Placement { top, ..wanted }.most_blocks() <= most;
            match wanted.within(most) {
                Ok(placement) => {
                    prop_assert_eq!(placement, Placement { top: placement.top, ..wanted });
                    prop_assert!((0..nodes).all(|n| placement.held(NodeId(n)) <= most));
                    prop_assert!((placement.top + 1..=top).all(|top| !fits(top)));
                }
                Err(least) => {
                    prop_assert!(least > most && (1..=top).all(|top| !fits(top)));
                    prop_assert!(wanted.within(least).is_ok());
                }
            }
        }
    }
}
