//! Nodes that fit a block.
//!
//! A node lies in one block with all its leaves. Eight full leaves of triangles that share no
//! vertex are longer than the least block; so leaves are pushed down into nodes of their own until
//! each node fits. A node with one leaf does: leaves have no more items than [`leaf_max`].

use kiloray_core::block::format::{
    BlockHeader, LEAF_RECORDS_MAX, Node as StoredNode, RECORD_PRIMITIVES, Record, order_of,
};

use super::bounds::Bounds;
use super::layout::{Layout, PADDING_MAX, Source};
use super::surfaces::Surfaces;
use super::tree::{Kid, Node};

/// Levels that a push may add: to a pair of leaves, then to one of them.
pub(crate) const LEVELS: usize = 2;

/// Items of a leaf, at most: whatever they are, a node with one such leaf fits a block.
pub(crate) fn leaf_max(block_bytes: usize) -> usize {
    let fits = |items: &usize| {
        size_of::<BlockHeader>() + size_of::<StoredNode>() + leaf_bytes(*items) + PADDING_MAX
            <= block_bytes
    };
    (RECORD_PRIMITIVES..=LEAF_RECORDS_MAX * RECORD_PRIMITIVES)
        .take_while(fits)
        .last()
        .unwrap_or(RECORD_PRIMITIVES)
}

/// What a leaf of so many items of one kind takes at most: triangles that share no vertex, with normals.
const fn leaf_bytes(items: usize) -> usize {
    items.div_ceil(RECORD_PRIMITIVES) * size_of::<Record>() + items * 3 * (12 + 4)
}

/// Pushes leaves down where needed, and puts the nodes into depth-first order again.
pub(crate) fn fit(nodes: &mut Vec<Node>, surfaces: &Surfaces, block_bytes: usize) {
    let mut layout = Layout::default();
    let before = nodes.len();
    let mut index = 0;
    // New nodes come last, and are looked at in their turn.
    while index < nodes.len() {
        while !fits(&mut layout, nodes, surfaces, block_bytes, index) {
            let next = nodes.len() as u32;
            let Some(below) = push_down(&mut nodes[index], next) else { break };
            nodes.push(below);
        }
        index += 1;
    }
    if nodes.len() > before {
        *nodes = depth_first(nodes);
    }
}

fn fits(
    layout: &mut Layout,
    nodes: &[Node],
    surfaces: &Surfaces,
    block_bytes: usize,
    index: usize,
) -> bool {
    let items: u32 = nodes[index].leaves().map(|(_, _, count)| count).sum();
    // A record and three vertices with normals for each, and the node with eight references.
    let at_most = 68 + size_of::<StoredNode>() + 64 + items as usize * (16 + 3 * 16);
    if at_most <= block_bytes {
        return true;
    }
    layout.clear();
    layout.try_add(Source { nodes, surfaces, block_bytes }, index as u32, false)
}

/// Moves the largest pair of neighbouring leaves, or the largest leaf, into a new node, which will
/// have the given index. `None` if there is no leaf.
fn push_down(node: &mut Node, index: u32) -> Option<Node> {
    let count = |kid: Kid| match kid {
        Kid::Leaf { count, .. } => Some(count),
        _ => None,
    };
    let pair = |slot: usize| Some(count(node.kids[slot])? + count(node.kids[slot + 1])?);
    let leaves = node.leaves().count();
    let largest_pair = (0..8)
        .step_by(2)
        .filter_map(|slot| Some((pair(slot)?, slot)))
        .max_by_key(|&(count, slot)| (count, 8 - slot));
    let largest = (0..8)
        .filter_map(|slot| Some((count(node.kids[slot])?, slot)))
        .max_by_key(|&(count, slot)| (count, 8 - slot));
    let mut below = Node::EMPTY;
    // A pair alone would only be copied.
    let slot = match (largest_pair, largest) {
        (Some((_, slot)), _) if leaves > 2 => {
            below.order = node.order.map(|order| pair_order(order, slot));
            below.kids[..2].copy_from_slice(&node.kids[slot..slot + 2]);
            below.bounds[..2].copy_from_slice(&node.bounds[slot..slot + 2]);
            node.kids[slot + 1] = Kid::Empty;
            node.bounds[slot + 1] = Bounds::EMPTY;
            slot
        }
        (_, Some((_, slot))) => {
            below.kids[0] = node.kids[slot];
            below.bounds[0] = node.bounds[slot];
            slot
        }
        _ => return None,
    };
    node.kids[slot] = Kid::Node(index);
    node.bounds[slot] = below.all();
    Some(below)
}

/// The order of a pair of slots, as the first two of a node, from the order that they had.
fn pair_order(order: u32, slot: usize) -> u32 {
    let slots = (0..8).map(|place| (order >> (3 * place) & 7) as usize);
    let first = slots.into_iter().find(|&other| other == slot || other == slot + 1);
    order_of(if first == Some(slot) { [0, 1, 2, 3, 4, 5, 6, 7] } else { [1, 0, 2, 3, 4, 5, 6, 7] })
}

fn depth_first(nodes: &[Node]) -> Vec<Node> {
    let mut sorted: Vec<Node> = Vec::with_capacity(nodes.len());
    // Where the index of a node is to be entered, and the node.
    let mut stack = vec![(None, 0)];
    while let Some((from, node)) = stack.pop() {
        let index = sorted.len() as u32;
        if let Some((parent, slot)) = from {
            let parent: &mut Node = &mut sorted[parent as usize];
            parent.kids[slot] = Kid::Node(index);
        }
        let node: &Node = &nodes[node as usize];
        sorted.push(node.clone());
        stack.extend(node.nodes().rev().map(|(slot, kid)| (Some((index, slot)), kid)));
    }
    sorted
}
