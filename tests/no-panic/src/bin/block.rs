//! The reader of a block, over any bytes, checked or not.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::format::{Child, is_order};
use kiloray_core::block::{BlockLimits, BlockView};
use kiloray_no_panic::{any, any_bytes, entry, print};

#[inline(never)]
fn parse() {
    let limits = BlockLimits { block_bytes: any(), blocks: any(), materials: any() };
    match BlockView::parse(any_bytes(), any(), &limits) {
        Ok(view) => read(&view),
        Err(error) => {
            print(&error);
        }
    }
}

#[inline(never)]
fn read(view: &BlockView<'_>) {
    black_box((view.header(), view.number(), view.nodes(), view.records(), view.vertices()));
    black_box((view.vertex_numbers(), view.normals(), view.refs()));
    if let Some(node) = view.node(any()) {
        black_box((node.order.map(is_order), node.child.map(Child::decode)));
    }
    black_box((view.leaf(any(), any()), view.vertex(any::<u16>().into()), view.normal(any())));
    black_box(view.reference(any()));
}

entry!({
    parse();
    read(&BlockView::trusted(any_bytes()));
});
