//! Numbered jobs on a few threads.

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicU64, Ordering};

/// Calls `job` with each number, in order, on so many threads (at least one), until one breaks: those begun are ended.
///
/// Not rayon: a job that renders waits for a pool of its own, and a waiting worker would begin another job on its stack.
pub fn each(numbers: Range<u64>, threads: usize, job: &(dyn Fn(u64) -> ControlFlow<()> + Sync)) {
    let next = AtomicU64::new(numbers.start);
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= numbers.end {
                break;
            }
            if job(number).is_break() {
                next.store(numbers.end, Ordering::Relaxed);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(work);
        }
    });
}
