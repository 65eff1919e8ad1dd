//! The checks that no single block can pass alone: together the blocks are one tree.

use kiloray_core::block::format::Child;
use kiloray_core::block::{BlockError, FileError, KiloView};
use rayon::prelude::*;

/// Checks every block, and that the nodes of all blocks are one tree: none is the child of two
/// nodes, and levels and nesting are as the headers say. So no walk over the blocks takes more
/// steps than there are nodes, or goes deeper than it was told.
pub(super) fn check_blocks(view: &KiloView<'_>) -> Result<(), FileError> {
    // The first in the file that is wrong, whoever finds it first.
    (0..view.blocks())
        .into_par_iter()
        .map(|block| view.check_block(block).map(drop))
        .find_first(Result::is_err)
        .unwrap_or(Ok(()))?;
    check_tree(view)
}

/// Levels and blocks below a node, itself included; zero before it is known.
#[derive(Debug, Clone, Copy, Default)]
struct Below {
    levels: u8,
    nesting: u8,
    /// It is the child of a node.
    taken: bool,
}

fn check_tree(view: &KiloView<'_>) -> Result<(), FileError> {
    let mut first = Vec::with_capacity(view.blocks() as usize + 1);
    let mut nodes = 0;
    for block in 0..view.blocks() {
        first.push(nodes);
        nodes += view.trusted_block(block).map_or(0, |b| usize::from(b.header().nodes));
    }
    first.push(nodes);
    let mut below = vec![Below::default(); nodes];
    // Children have greater numbers: backwards, each is known before its parent.
    for block in (0..view.blocks()).rev() {
        let refused = |error| FileError::Block { block, error };
        let Some(content) = view.trusted_block(block) else { continue };
        let begin = first[block as usize];
        for (index, node) in content.nodes().enumerate().rev() {
            let (mut levels, mut nesting) = (1, 1);
            for (slot, &bits) in node.child.iter().enumerate() {
                let wrong = BlockError::Child { node: index as u16, slot: slot as u8 };
                let (kid, outside) = match Child::decode(bits) {
                    Child::Node(kid) => (begin + usize::from(kid), 0),
                    Child::Ref(r) => {
                        let target = content.reference(r).ok_or(refused(wrong))?;
                        let end = first.get(target.block as usize + 1).copied().unwrap_or(0);
                        let kid = first.get(target.block as usize).copied().unwrap_or(end)
                            + usize::from(target.node);
                        if kid >= end {
                            return Err(refused(BlockError::Ref { index: r }));
                        }
                        (kid, 1)
                    }
                    Child::Leaf { .. } | Child::Empty => continue,
                };
                let kid = &mut below[kid];
                if kid.taken {
                    return Err(refused(wrong));
                }
                kid.taken = true;
                levels = levels.max(kid.levels.saturating_add(1));
                nesting = nesting.max(kid.nesting.saturating_add(outside));
            }
            let header = content.header();
            if u16::from(levels) > header.height || u16::from(nesting) > header.nesting {
                return Err(refused(BlockError::Depth));
            }
            let node = &mut below[begin + index];
            (node.levels, node.nesting) = (levels, nesting);
        }
    }
    Ok(())
}
