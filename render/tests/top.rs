//! The expanded top of a tree.

use std::collections::BTreeSet;

use kiloray_core::block::{BlockView, ExpandedNode, ExpandedTop, KiloView};
use kiloray_render::Top;
use kiloray_scene::builtin;
use kiloray_scene::compile::{Options, compile};

#[test]
fn nodes_of_the_top_are_known_by_their_slots() {
    for (scene, block_bytes) in [
        ("colour-cube:6", 1 << 10),
        ("studio", 1 << 12),
        ("sinc:60", 1 << 14),
        ("sphereflake:3", 4096),
    ] {
        let model = builtin::build(scene).unwrap();
        let compiled = compile(&model, &Options::blocks_of(block_bytes), &mut ()).unwrap();
        let file = KiloView::parse(compiled.bytes()).unwrap();
        let top = Top::new(&file);
        let nodes = top.over(file).top.nodes();
        let mut found = vec![false; nodes.len()];
        let mut stack = vec![0_u32];
        while let Some(number) = stack.pop() {
            let node = &nodes[number as usize];
            assert!(!found[number as usize], "{scene}: {number} is below two nodes");
            found[number as usize] = true;
            for (slot, &child) in (0..).zip(&node.child) {
                let is_node = child < ExpandedTop::EMPTY;
                assert_eq!(is_node, node.nodes >> slot & 1 == 1, "{scene}: {number}");
                if is_node {
                    assert_eq!(child, node.first.wrapping_add(slot), "{scene}: {number}");
                    stack.push(child);
                }
            }
        }
        let used = found.iter().filter(|found| **found).count();
        assert!(
            used > 8 && nodes.len() <= used + used / 10 + 8,
            "{scene}: {used} of {}",
            nodes.len()
        );
    }
}

/// Lines of a block that vertices of a leaf lie in, those that are read ahead and all.
fn read_ahead(view: &BlockView<'_>, (at, count): (u16, u16), from: usize) -> (usize, usize) {
    let corners = view.leaf(at, count).iter().flat_map(|record| {
        let triangles = record.index.iter().filter(|[a, b, c]| a != b || b != c);
        triangles.flatten().map(|&corner| usize::from(record.base) + usize::from(corner))
    });
    // A header of 64 bytes, and 12 for a vertex.
    let lines: BTreeSet<_> =
        corners.flat_map(|v| [64 + 12 * v, 64 + 12 * v + 11]).map(|byte| byte / 64).collect();
    (lines.range(from..from + ExpandedNode::LINES).count(), lines.len())
}

#[test]
fn most_vertices_of_a_leaf_are_read_ahead() {
    let model = builtin::build("sinc:100").unwrap();
    for block_bytes in [1 << 12, 1 << 14] {
        let compiled = compile(&model, &Options::blocks_of(block_bytes), &mut ()).unwrap();
        let file = KiloView::parse(compiled.bytes()).unwrap();
        let top = Top::new(&file);
        let (mut ahead, mut all) = (0, 0);
        for node in top.over(file).top.nodes() {
            for (&child, &line) in node.child.iter().zip(&node.lines) {
                if child >> 30 != 0b10 {
                    assert_eq!(line, 0, "no leaf");
                    continue;
                }
                let view = file.trusted_block(child >> 14 & 0xffff).unwrap();
                let leaf = ((child & 0xfff) as u16, (child >> 12 & 3) as u16 + 1);
                let (of_leaf, lines) = read_ahead(&view, leaf, line.into());
                assert!(of_leaf > 0);
                (ahead, all) = (ahead + of_leaf, all + lines);
                let best = (0..256).map(|from| read_ahead(&view, leaf, from).0).max();
                assert_eq!(Some(of_leaf), best, "{leaf:?}");
            }
        }
        assert!(all > 3000 && ahead * 5 > all * 4, "{block_bytes}: {ahead} of {all}");
    }
}
