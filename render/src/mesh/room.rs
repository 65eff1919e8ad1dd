use std::cell::RefCell;

use kiloray_core::render::{Neighbours, Room};

/// A room for each thread.
#[derive(Debug, Clone, Copy)]
pub struct ThreadRoom;

thread_local! {
    static ROOM: RefCell<Box<Neighbours>> = RefCell::new(Box::new(Neighbours::new()));
}

impl Room for ThreadRoom {
    fn enter(&self, work: &mut dyn FnMut(&mut Neighbours)) {
        ROOM.with_borrow_mut(|room| work(room));
    }
}
