use std::cell::RefCell;

use kiloray_core::render::{Neighbours, Scratch};
use kiloray_core::trace::Cursor;

/// What all nodes share that take their steps on a thread.
#[derive(Debug, Clone, Copy)]
pub struct ThreadScratch {
    /// Rays that are alike are traced together.
    pub together: bool,
}

impl ThreadScratch {
    /// Room in which a thread traces the rays of its nodes: of one ray, and of rays together.
    pub const BYTES: usize = size_of::<Cursor>() + size_of::<Neighbours>();
}

thread_local! {
    static CURSOR: RefCell<Box<Cursor>> = RefCell::default();
    static NEIGHBOURS: RefCell<Box<Neighbours>> = RefCell::default();
}

impl Scratch for ThreadScratch {
    fn cursor<R>(&mut self, work: impl FnOnce(&mut Cursor) -> R) -> R {
        CURSOR.with_borrow_mut(|cursor| work(cursor))
    }

    fn neighbours<R>(&self, work: impl FnOnce(&mut Neighbours) -> R) -> Option<R> {
        self.together.then(|| NEIGHBOURS.with_borrow_mut(|neighbours| work(neighbours)))
    }
}
