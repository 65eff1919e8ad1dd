//! The tree, from the root down: a binary tree by the surface-area heuristic, of which nodes of eight children are made.
//!
//! Which parts of the binary tree become children of one node, and which of them leaves, is what costs least in all
//! (Ylitie, Karras, Laine: Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, 2017, section 3.1).

use kiloray_core::block::format::{DEPTH_MAX, order_of};

use super::binary::{Part, TOO_MANY, binary};
use super::bounds::Item;
use super::tree::{Kid, Node};

/// Cost of a visit to a node, in tests of a record.
const NODE_COST: f32 = 2.0;
/// Levels of nodes that are built; the rest is left for leaves that are pushed down.
const LEVELS: usize = DEPTH_MAX - super::fit::LEVELS;
/// Children of a node.
const KIDS: usize = 8;

/// The tree over the items, which it reorders so that each leaf is a range of them. A node has a
/// lesser index than those below it.
///
/// No leaf has more than `leaf_max` items. `done` hears how many items lie in finished leaves.
pub(crate) fn build(items: &mut [Item], leaf_max: usize, done: &mut dyn FnMut(u64)) -> Vec<Node> {
    if items.is_empty() {
        // Rays that hit nothing visit a root, too.
        return vec![Node::EMPTY];
    }
    let mut nodes = collapsed(&binary(items, leaf_max, KIDS.ilog2() as usize * LEVELS, done));
    if depth(&nodes) > LEVELS {
        // A node is at least one level of the binary tree.
        nodes = collapsed(&binary(items, leaf_max, LEVELS, done));
    }
    for node in &nodes {
        for (_, first, count) in node.leaves() {
            let items = &mut items[first as usize..][..count as usize];
            items.sort_unstable_by_key(|item| (item.group, item.primitive));
        }
    }
    nodes
}

/// What a part costs at least, in each form.
#[derive(Debug, Clone, Copy)]
struct Plan {
    /// As up to `i + 1` children of the node above.
    cost: [f32; KIDS - 1],
    /// How many of so many children lie below the cut; 0: fewer are as good.
    below: [u8; KIDS - 1],
    /// The same of its own eight children, if it is a node.
    own: u8,
    /// A single child is a leaf.
    leaf: bool,
}

/// Nodes of the parts, depth first.
fn collapsed(parts: &[Part]) -> Vec<Node> {
    let mut plans =
        vec![Plan { cost: [0.0; KIDS - 1], below: [0; KIDS - 1], own: 0, leaf: true }; parts.len()];
    for (index, part) in parts.iter().enumerate().rev() {
        plans[index] = plan(part, &plans);
    }
    let mut nodes = Vec::with_capacity(parts.len() / 6 + 1);
    Collapse { parts, plans: &plans, nodes: &mut nodes }.node(0);
    nodes
}

/// The plan of a part, from those of its own parts.
fn plan(part: &Part, plans: &[Plan]) -> Plan {
    let area = part.bounds.area();
    let leaf =
        if part.records == TOO_MANY { f32::INFINITY } else { area * f32::from(part.records) };
    let Some([low, high]) = part.cut() else {
        return Plan { cost: [leaf; KIDS - 1], below: [0; KIDS - 1], own: 0, leaf: true };
    };
    let (low, high) = (&plans[low as usize].cost, &plans[high as usize].cost);
    // The cheapest way to divide so many children between the two parts.
    let divide = |kids: usize| {
        let cost = |below: usize| low[below - 1] + high[kids - below - 1];
        let best =
            (2..kids).fold(1, |best, below| if cost(below) < cost(best) { below } else { best });
        (cost(best), best as u8)
    };
    let (kids, own) = divide(KIDS);
    let node = kids + NODE_COST * area;
    let mut plan =
        Plan { cost: [leaf.min(node); KIDS - 1], below: [0; KIDS - 1], own, leaf: leaf <= node };
    for kids in 2..KIDS {
        let (cost, below) = divide(kids);
        plan.cost[kids - 1] = plan.cost[kids - 2];
        if cost < plan.cost[kids - 1] {
            (plan.cost[kids - 1], plan.below[kids - 1]) = (cost, below);
        }
    }
    plan
}

struct Collapse<'a> {
    parts: &'a [Part],
    plans: &'a [Plan],
    nodes: &'a mut Vec<Node>,
}

impl Collapse<'_> {
    /// Adds the node of a part, and all below it; its index.
    fn node(&mut self, part: u32) -> u32 {
        let index = self.nodes.len() as u32;
        self.nodes.push(Node::EMPTY);
        let mut kids = Kids { parts: [0; KIDS], len: 0 };
        match self.parts[part as usize].cut() {
            Some([low, high]) => {
                let below = usize::from(self.plans[part as usize].own);
                self.gather(low, below, &mut kids);
                self.gather(high, KIDS - below, &mut kids);
            }
            None => kids.push(part),
        }
        self.nodes[index as usize].order = [0, 1, 2, 3].map(|signs| self.order(part, &kids, signs));
        for (slot, &kid) in kids.parts[..kids.len].iter().enumerate() {
            let Part { bounds, first, count, .. } = self.parts[kid as usize];
            let kid = if self.plans[kid as usize].leaf {
                Kid::Leaf { first, count }
            } else {
                Kid::Node(self.node(kid))
            };
            let node = &mut self.nodes[index as usize];
            (node.kids[slot], node.bounds[slot]) = (kid, bounds);
        }
        index
    }

    /// Adds a part as at most so many children.
    fn gather(&self, part: u32, at_most: usize, kids: &mut Kids) {
        let below = &self.plans[part as usize].below[..at_most];
        let choice = below.iter().rposition(|&below| below != 0);
        match (choice, self.parts[part as usize].cut()) {
            (Some(last), Some([low, high])) => {
                let below = usize::from(below[last]);
                self.gather(low, below, kids);
                self.gather(high, last + 1 - below, kids);
            }
            _ => kids.push(part),
        }
    }

    /// The order of the children of a part's node, front to back for rays that descend the axes of these bits.
    fn order(&self, part: u32, kids: &Kids, signs: u8) -> u32 {
        let mut slots = [0, 1, 2, 3, 4, 5, 6, 7];
        let mut len = 0;
        self.visit(part, kids, signs, &mut |slot| {
            slots[len] = slot;
            len += 1;
        });
        order_of(slots)
    }

    fn visit(&self, part: u32, kids: &Kids, signs: u8, to: &mut dyn FnMut(u8)) {
        let slot = kids.parts[..kids.len].iter().position(|&kid| kid == part);
        let Part { axis, .. } = self.parts[part as usize];
        match (slot, self.parts[part as usize].cut()) {
            (None, Some([low, high])) => {
                let descends = signs >> axis & 1 == 1;
                let (front, back) = if descends { (high, low) } else { (low, high) };
                self.visit(front, kids, signs, to);
                self.visit(back, kids, signs, to);
            }
            (slot, _) => to(slot.unwrap_or(0) as u8),
        }
    }
}

/// Parts that become children of one node.
struct Kids {
    parts: [u32; KIDS],
    len: usize,
}

impl Kids {
    fn push(&mut self, part: u32) {
        self.parts[self.len] = part;
        self.len += 1;
    }
}

/// Levels of nodes.
fn depth(nodes: &[Node]) -> usize {
    let mut below = vec![0_usize; nodes.len()];
    for (index, node) in nodes.iter().enumerate().rev() {
        below[index] = 1 + node.nodes().map(|(_, kid)| below[kid as usize]).max().unwrap_or(0);
    }
    below.first().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least cost of a part as at most so many children, of all ways to choose them.
    fn least(parts: &[Part], part: u32, kids: usize) -> f32 {
        let Part { bounds, records, .. } = parts[part as usize];
        let leaf =
            if records == TOO_MANY { f32::INFINITY } else { bounds.area() * f32::from(records) };
        if parts[part as usize].cut().is_none() {
            return leaf;
        }
        let single = leaf.min(divided(parts, part, KIDS) + NODE_COST * bounds.area());
        (2..=kids).map(|kids| divided(parts, part, kids)).fold(single, f32::min)
    }

    /// .. as exactly so many, of which both its parts have some.
    fn divided(parts: &[Part], part: u32, kids: usize) -> f32 {
        let [low, high] = parts[part as usize].cut().unwrap();
        let cost = |below| least(parts, low, below) + least(parts, high, kids - below);
        (1..kids).map(cost).fold(f32::INFINITY, f32::min)
    }

    fn cost(nodes: &[Node], node: usize) -> f32 {
        let all = nodes[node].all().area() * NODE_COST;
        nodes[node].kids.iter().zip(&nodes[node].bounds).fold(
            all,
            |sum, (kid, bounds)| match *kid {
                Kid::Empty => sum,
                Kid::Node(kid) => sum + cost(nodes, kid as usize),
                Kid::Leaf { count, .. } => sum + bounds.area() * count.div_ceil(4) as f32,
            },
        )
    }

    fn random_items(count: u32, size: f32) -> Vec<Item> {
        let mut state = 1_u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut item = |i| {
            let lo = [random(), random(), random()];
            Item::new(i, 0, lo, lo.map(|x| x + size * random()))
        };
        (0..count).map(&mut item).collect()
    }

    #[test]
    fn no_other_nodes_of_the_same_parts_cost_less() {
        for count in [5, 17, 30, 40] {
            let mut items = random_items(count, 0.2);
            let parts = binary(&mut items, 16, 90, &mut |_| {});
            let nodes = collapsed(&parts);
            let least = divided(&parts, 0, KIDS) + NODE_COST * parts[0].bounds.area();
            let found = cost(&nodes, 0);
            assert!((found - least).abs() <= 1e-4 * least, "{count}: {found} for {least}");
        }
    }

    #[test]
    fn orders_are_front_to_back() {
        // Points: the plane of a cut lies between all that it divides.
        let mut items = random_items(500, 0.0);
        let nodes = build(&mut items, 16, &mut |_| {});
        let mut compared = 0;
        for node in &nodes {
            for (signs, &order) in node.order.iter().enumerate() {
                let slots = (0..8).map(|place| (order >> (3 * place) & 7) as usize);
                let slots: Vec<usize> =
                    slots.filter(|&slot| node.kids[slot] != Kid::Empty).collect();
                for (at, &first) in slots.iter().enumerate() {
                    for &second in &slots[at + 1..] {
                        let (a, b) = (&node.bounds[first], &node.bounds[second]);
                        // Where all planes between two boxes lie one way, the order is that.
                        let ahead = |axis: usize| {
                            let (near, far) = if signs >> axis & 1 == 1 { (a, b) } else { (b, a) };
                            near.lo()[axis] >= far.hi()[axis]
                        };
                        let behind = |axis: usize| {
                            let (near, far) = if signs >> axis & 1 == 1 { (b, a) } else { (a, b) };
                            near.lo()[axis] >= far.hi()[axis]
                        };
                        let wrong = (0..3).any(behind) && !(0..3).any(ahead);
                        assert!(!wrong, "slot {first} before {second} for {signs:03b}: {node:?}");
                        compared += usize::from((0..3).any(ahead));
                    }
                }
            }
        }
        assert!(compared > 1000, "{compared}");
    }

    #[test]
    fn no_tree_is_deeper_than_it_may_be() {
        // Each much larger than the next, so that cuts take off one at a time.
        let items: Vec<Item> = (0..4000_u16)
            .map(|i| {
                let size = 0.98f32.powi(i.into()).max(1e-30);
                Item::new(i.into(), 0, [0.0; 3], [size; 3])
            })
            .collect();
        let mut sorted = items;
        let nodes = build(&mut sorted, 16, &mut |_| {});
        assert!(depth(&nodes) <= LEVELS);
        let mut names: Vec<u32> = sorted.iter().map(|item| item.primitive).collect();
        names.sort_unstable();
        assert!(names.into_iter().eq(0..4000), "every item is still there");
    }
}
