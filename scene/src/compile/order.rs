//! The numbers of blocks: the top of the tree first, then depth first.
//!
//! A mesh gives the first blocks to every node, and deals out the others in ranges: a range is then a set of subtrees.

use super::bounds::Bounds;
use super::pack::Blocks;
use super::tree::Node;

/// One block of so many is of the top.
const TOP_PART: usize = 32;
/// Blocks of the top, at most.
const TOP_MAX: usize = 1024;

/// Numbers the blocks anew: those that most rays enter first, which are those of the largest subtrees, the others as they were.
///
/// References go on pointing to greater numbers: a block counts as large as the largest that it refers to, by way of whatever blocks, so of the two the
/// one that is referred to is not the larger, and if both are alike it had the greater number.
pub(crate) fn order(mut blocks: Blocks, nodes: &[Node], parents: &[u32]) -> Blocks {
    let count = blocks.nodes.len();
    let mut largest = vec![0.0_f32; count];
    // Which block refers to which, and the one that is referred to first.
    let mut refs = Vec::new();
    for (index, &parent) in parents.iter().enumerate() {
        let here = blocks.places[index].0;
        let above = blocks.places.get(parent as usize).map(|place| place.0);
        if above != Some(here) {
            let largest = &mut largest[here as usize];
            *largest = largest.max(area(&nodes[index]));
            refs.extend(above.map(|above| (here, above)));
        }
    }
    // The last block first: what is beyond it has been added to it.
    refs.sort_unstable_by(|a, b| b.cmp(a));
    for (here, above) in refs {
        let area = largest[here as usize];
        let above = &mut largest[above as usize];
        *above = above.max(area);
    }
    let mut top: Vec<usize> = (0..count).collect();
    top.sort_by(|&a, &b| largest[b].total_cmp(&largest[a]).then(a.cmp(&b)));
    top.truncate((count / TOP_PART).min(TOP_MAX));
    let mut is_top = vec![false; count];
    for &block in &top {
        is_top[block] = true;
    }
    let rest = (0..count).filter(|&block| !is_top[block]);
    let order: Vec<usize> = top.iter().copied().chain(rest).collect();
    let mut numbers = vec![0_u32; count];
    for (number, &block) in order.iter().enumerate() {
        numbers[block] = number as u32;
    }
    for place in &mut blocks.places {
        place.0 = numbers[place.0 as usize];
    }
    blocks.nodes = order.iter().map(|&block| std::mem::take(&mut blocks.nodes[block])).collect();
    blocks
}

/// Half the surface of a node's box.
fn area(node: &Node) -> f32 {
    let mut all = Bounds::EMPTY;
    for bounds in &node.bounds {
        all.grow(&bounds.0);
    }
    if all.is_empty() { 0.0 } else { all.area() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::tree::Kid;

    /// A tree of nodes dealt out to blocks at random, several subtrees to a block, each reference ahead.
    fn random_blocks(seed: u64) -> (Blocks, Vec<Node>, Vec<u32>) {
        let mut state = seed;
        let mut below = move |n: usize| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % n
        };
        let mut nodes = vec![Node::EMPTY];
        let mut parents = vec![u32::MAX];
        let mut sizes = vec![1.0_f32];
        while nodes.len() < 600 {
            // Depth first is not asked for: only that parents come first.
            let parent = below(nodes.len());
            let slot = below(8);
            if nodes[parent].kids[slot] != Kid::Empty {
                continue;
            }
            let size = sizes[parent] * (0.2 + 0.01 * below(80) as f32);
            nodes[parent].kids[slot] = Kid::Node(nodes.len() as u32);
            nodes[parent].bounds[slot] = Bounds([0.0, 0.0, 0.0, 0.0, -size, -size, -size, 0.0]);
            parents.push(parent as u32);
            sizes.push(size);
            nodes.push(Node::EMPTY);
        }
        for (node, size) in nodes.iter_mut().zip(&sizes) {
            // As large as it is said to be.
            node.bounds[7] = Bounds([0.0, 0.0, 0.0, 0.0, -size, -size, -size, 0.0]);
        }
        let count = 200;
        let mut blocks =
            Blocks { places: vec![(0, 0); nodes.len()], nodes: vec![vec![]; count], used: 0 };
        for index in 0..nodes.len() {
            let above = parents
                .get(index)
                .and_then(|&p| blocks.places.get(p as usize))
                .map_or(0, |p| p.0 as usize);
            let block = if index == 0 || below(3) == 0 {
                above
            } else {
                (above + 1 + below(20)).min(count - 1)
            };
            blocks.places[index] = (block as u32, blocks.nodes[block].len() as u16);
            blocks.nodes[block].push(index as u32);
        }
        (blocks, nodes, parents)
    }

    #[test]
    fn references_go_on_pointing_ahead() {
        let mut moved = 0;
        for seed in 0..300 {
            let (blocks, nodes, parents) = random_blocks(seed);
            let before = blocks.places.clone();
            let after = order(blocks, &nodes, &parents);
            for (index, &parent) in parents.iter().enumerate().skip(1) {
                let (above, here) = (after.places[parent as usize].0, after.places[index].0);
                let apart = before[parent as usize].0 != before[index].0;
                assert!(
                    if apart { above < here } else { above == here },
                    "seed {seed}, node {index}"
                );
            }
            moved += usize::from(after.places != before);
        }
        assert!(moved > 200, "{moved}");
    }
}
