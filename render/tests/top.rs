//! The expanded top of a tree.

use kiloray_core::block::{ExpandedTop, KiloView};
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
