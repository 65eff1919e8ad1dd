//! An executor that sleeps with WFI.
//!
//! embassy's own for Cortex-M sleeps with WFE, at which QEMU does not halt: an idle board then takes most of a host core.

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::{Spawner, raw};
use static_cell::StaticCell;

static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();
/// A task was woken since the last poll.
static WOKEN: AtomicBool = AtomicBool::new(false);

/// Runs what `init` spawns, for ever.
pub(crate) fn run(init: impl FnOnce(Spawner)) -> ! {
    let executor = EXECUTOR.init(raw::Executor::new(ptr::null_mut()));
    init(executor.spawner());
    loop {
        WOKEN.store(false, Ordering::Release);
        // SAFETY: the executor was made in place, and only this loop polls it.
        unsafe { executor.poll() };
        // An interrupt that comes after the look at WOKEN stays pending, and ends the WFI at once.
        critical_section::with(|_| {
            if !WOKEN.load(Ordering::Acquire) {
                cortex_m::asm::wfi();
            }
        });
    }
}

/// embassy calls this when a task wakes.
#[unsafe(export_name = "__pender")]
fn pender(_context: *mut ()) {
    WOKEN.store(true, Ordering::Release);
}
