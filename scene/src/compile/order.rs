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
/// References go on pointing to greater numbers. A subtree lies in the box of the one that refers to it, and so
/// does the greatest of a block: of two blocks the one that is referred to is not the larger, and if both are alike it had the greater number.
pub(crate) fn order(mut blocks: Blocks, nodes: &[Node], parents: &[u32]) -> Blocks {
    let count = blocks.nodes.len();
    let mut largest = vec![0.0_f32; count];
    for (index, &parent) in parents.iter().enumerate() {
        let here = blocks.places[index].0;
        if blocks.places.get(parent as usize).is_none_or(|place| place.0 != here) {
            let area = area(&nodes[index]);
            let largest = &mut largest[here as usize];
            *largest = largest.max(area);
        }
    }
    // The box of a node is made of rounded ones in no fixed order: what is above is made as large as what is below.
    for index in (1..parents.len()).rev() {
        let (here, above) = (blocks.places[index].0, blocks.places[parents[index] as usize].0);
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
