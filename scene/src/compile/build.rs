//! The tree, from the root down: each node cuts its primitives three times.

use kiloray_core::block::format::{DEPTH_MAX, LEAF_RECORDS_MAX, RECORD_PRIMITIVES};

use super::bounds::{Bounds, Item};
use super::split::{cuts, halves, partition};
use super::tree::{Kid, Node};

/// Cost of a visit to a node, in tests of a record. On a million triangles 1, 1.5, 2 and 3 trace
/// equally fast within 2 %, and take 19.9, 18.1, 16.6 and 15.2 bytes per triangle; above 2 there are more
/// tests of records than visits saved.
const NODE_COST: f32 = 2.0;
/// Levels that cuts may make; the rest is left for leaves that are pushed down.
const LEVELS: usize = DEPTH_MAX - super::fit::LEVELS;

/// The tree over the items, which it reorders so that each leaf is a range of them. A node has a
/// lesser index than those below it.
///
/// `done` hears how many items lie in finished leaves.
pub(crate) fn build(items: &mut [Item], done: &mut dyn FnMut(u64)) -> Vec<Node> {
    let mut build = Build { nodes: Vec::new(), finished: 0, done };
    if items.is_empty() {
        // Rays that hit nothing visit a root, too.
        build.nodes.push(Node::EMPTY);
    } else {
        build.node(items, 0, LEVELS);
    }
    build.nodes
}

struct Build<'a> {
    nodes: Vec<Node>,
    finished: u64,
    done: &'a mut dyn FnMut(u64),
}

impl Build<'_> {
    /// Adds a node over the items, the first of which is number `first`, and all below it.
    /// Returns its index and its cost.
    fn node(&mut self, items: &mut [Item], first: usize, levels: usize) -> (u32, f32) {
        let (node, ends) = octants(items, levels);
        let index = self.nodes.len();
        self.nodes.push(node);
        let mut all = Bounds::EMPTY;
        let mut cost = 0.0;
        for slot in 0..8 {
            let begin = if slot == 0 { 0 } else { ends[slot - 1] };
            let part = &mut items[begin..ends[slot]];
            if part.is_empty() {
                continue;
            }
            let bounds = bounds(part);
            let (kid, kid_cost) = self.kid(part, first + begin, bounds, levels - 1);
            self.nodes[index].kids[slot] = kid;
            self.nodes[index].bounds[slot] = bounds;
            all.grow(&bounds.0);
            cost += kid_cost;
        }
        (index as u32, cost + NODE_COST * all.area())
    }

    /// A leaf, or a node where that is cheaper or needed.
    fn kid(&mut self, items: &mut [Item], first: usize, all: Bounds, levels: usize) -> (Kid, f32) {
        let count = items.len();
        let leaf = Kid::Leaf { first: first as u32, count: count as u32 };
        let cost = if count <= LEAF_RECORDS_MAX * RECORD_PRIMITIVES {
            let records = records(items);
            if records <= LEAF_RECORDS_MAX { all.area() * records as f32 } else { f32::INFINITY }
        } else {
            f32::INFINITY
        };
        if count > RECORD_PRIMITIVES {
            let len = self.nodes.len();
            let (node, node_cost) = self.node(items, first, levels);
            if node_cost < cost || cost == f32::INFINITY {
                return (Kid::Node(node), node_cost);
            }
            self.nodes.truncate(len);
        } else {
            self.finished += count as u64;
            if self.finished >> 14 != (self.finished - count as u64) >> 14 {
                (self.done)(self.finished);
            }
        }
        items.sort_unstable_by_key(|item| (item.group, item.primitive));
        (leaf, cost)
    }
}

/// Cuts the items into octants: the node without its kids, and where each octant ends.
fn octants(items: &mut [Item], levels: usize) -> (Node, [usize; 8]) {
    let mut node = Node::EMPTY;
    let mut ends = [items.len(); 8];
    let by_count = levels_needed(items.len()) >= levels;
    for level in 0..3 {
        let step = 4 >> level;
        // The parts before this cut: a slot at each multiple of 2 * step.
        let mut chosen = [None; 4];
        let mut cost = [0.0; 3];
        for (part, chosen) in chosen.iter_mut().enumerate().take(1 << level) {
            let slot = part * 2 * step;
            let begin = if slot == 0 { 0 } else { ends[slot - 1] };
            let part = &items[begin..ends[slot + 2 * step - 1]];
            // Slots are free: what takes two records is cut as long as there are any.
            if part.len() > RECORD_PRIMITIVES || records(part) > 1 {
                let cuts = if by_count { by_halves(part) } else { cuts(part) };
                for (cost, cut) in cost.iter_mut().zip(&cuts) {
                    *cost += cut.cost;
                }
                *chosen = Some((begin, slot, cuts));
            }
        }
        let axis = least(cost);
        node.axes[level] = axis as u8;
        for (begin, slot, cuts) in chosen.into_iter().flatten() {
            let end = ends[slot + 2 * step - 1];
            let below = partition(&mut items[begin..end], axis, cuts[axis]);
            for end in &mut ends[slot..slot + step] {
                *end = begin + below;
            }
        }
    }
    (node, ends)
}

/// Halves by count along the axis where the items spread most: the others cost more.
fn by_halves(items: &[Item]) -> [super::split::Cut; 3] {
    let all = bounds(items);
    let (lo, hi) = (all.lo(), all.hi());
    [0, 1, 2].map(|axis| {
        let mut cut = halves(items);
        cut.cost = lo[axis] - hi[axis];
        cut
    })
}

fn least(cost: [f32; 3]) -> usize {
    let mut axis = 0;
    for other in 1..3 {
        if cost[other] < cost[axis] {
            axis = other;
        }
    }
    axis
}

/// Levels of nodes that `count` items need when cut by count.
fn levels_needed(count: usize) -> usize {
    let mut levels = 1;
    let mut holds = 8 * RECORD_PRIMITIVES;
    while holds < count {
        holds *= 8;
        levels += 1;
    }
    levels
}

fn bounds(items: &[Item]) -> Bounds {
    let mut all = Bounds::EMPTY;
    for item in items {
        all.grow(item.lanes());
    }
    all
}

/// Records that a leaf of these items takes: each holds one group.
fn records(items: &[Item]) -> usize {
    let mut groups = [(0_u32, 0_usize); LEAF_RECORDS_MAX + 1];
    let mut len = 0;
    for item in items {
        let known = groups[..len].iter().position(|(group, _)| *group == item.group);
        match known {
            Some(at) => groups[at].1 += 1,
            None if len < groups.len() => {
                groups[len] = (item.group, 1);
                len += 1;
            }
            None => return usize::MAX,
        }
    }
    groups[..len].iter().map(|(_, count)| count.div_ceil(RECORD_PRIMITIVES)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(nodes: &[Node], node: usize) -> usize {
        let below = nodes[node].nodes().map(|(_, kid)| depth(nodes, kid as usize)).max();
        1 + below.unwrap_or(0)
    }

    #[test]
    fn no_tree_is_deeper_than_it_may_be() {
        // Each twice as large as the next: the heuristic cuts off the largest few.
        let items: Vec<Item> = (0..250_u16)
            .map(|i| {
                let size = 0.7f32.powi(i.into());
                Item::new(i.into(), 0, [0.0; 3], [size; 3])
            })
            .collect();
        let mut depths = Vec::new();
        for levels in 2..9 {
            let mut build = Build { nodes: Vec::new(), finished: 0, done: &mut |_| {} };
            let mut items = items.clone();
            build.node(&mut items, 0, levels);
            depths.push(depth(&build.nodes, 0));
            assert!(depths[levels - 2] <= levels, "{depths:?}");
            let mut names: Vec<u32> = items.iter().map(|item| item.primitive).collect();
            names.sort_unstable();
            assert!(names.into_iter().eq(0..250), "every item is still there");
        }
        assert!(depths.last() > Some(&5), "the limit was never felt: {depths:?}");
    }
}
