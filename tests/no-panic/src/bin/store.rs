//! The arena, the block cache over a medium, queue and budget, used in any order.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::{BlockLimits, BlockSource, KiloView};
use kiloray_core::store::{
    Arena, BlockCache, Budget, Chunk, Claim, FetchedBlocks, Line, LineBudget, Queue,
};
use kiloray_no_panic::{any, any_bytes, any_room, entry, print};

#[inline(never)]
fn cache(mut cache: BlockCache<'_>) {
    for _ in 0..any::<u32>() {
        black_box((
            cache.residency(any()),
            cache.get(any()).is_some(),
            cache.incoming(any()).is_some(),
        ));
        let claim = if any::<u8>() == 0 { Claim::Demand } else { Claim::Prefetch };
        let _ = black_box(cache.reserve(any(), claim));
        black_box(cache.arrived(any()));
        cache.discard(any());
        black_box(cache.counts());
    }
}

#[inline(never)]
fn fetch(cache: BlockCache<'_>) {
    let Ok(file) = KiloView::parse(any_bytes()) else { return };
    let limits = BlockLimits { block_bytes: any(), blocks: any(), materials: any() };
    let mut blocks = FetchedBlocks::new(cache, file, limits);
    for _ in 0..any::<u32>() {
        match blocks.block(any()) {
            Ok(view) => {
                black_box(view);
            }
            Err(error) => print(&error),
        }
    }
}

#[inline(never)]
fn queue(arena: &mut Arena<'_>) {
    let Ok(line) = arena.carve::<u32>(any()) else { return };
    let mut queue = Queue::new(line);
    for _ in 0..any::<u32>() {
        black_box(queue.enqueue(any()));
        black_box((queue.front(), queue.len()));
        black_box(queue.dequeue());
    }
}

#[inline(never)]
fn budget() {
    let lines =
        [LineBudget::new(Line::Frames, any(), any()), LineBudget::new(Line::Tile, any(), any())];
    match Budget::new(any(), &lines) {
        Ok(mut budget) => {
            budget.note_peak(Line::Frames, any());
            black_box((budget.peak_bytes(), budget.line(Line::Tile)));
            print(&budget);
        }
        Err(error) => print(&error),
    }
}

entry!({
    let mut memory = [Chunk::ZERO; 8];
    let mut arena = Arena::new(any_room(&mut memory));
    if let Ok(made) = BlockCache::new(&mut arena, any(), any()) {
        cache(made);
    }
    match BlockCache::new(&mut arena, any(), any()) {
        Ok(made) => fetch(made),
        Err(error) => print(&error),
    }
    queue(&mut arena);
    budget();
});
