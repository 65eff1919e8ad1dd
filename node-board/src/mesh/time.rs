//! The clock: milliseconds counted by SysTick, as embassy's time driver and as the node's clock.

use core::cell::{Cell, RefCell};
use core::future::pending;
use core::task::Waker;

use cortex_m::peripheral::Peripherals;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;
use critical_section::Mutex;
use embassy_time::{Instant, Timer};
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;
use kiloray_core::node::{Clock, Time};

/// The processor's clock: by it the length of a millisecond.
#[cfg(feature = "mps2")]
const CLOCK_HZ: u32 = 25_000_000;
#[cfg(not(feature = "mps2"))]
const CLOCK_HZ: u32 = 12_000_000;

const TICK_NS: u64 = 1_000_000;

struct SysTickDriver {
    now: Mutex<Cell<u64>>,
    queue: Mutex<RefCell<Queue>>,
}

embassy_time_driver::time_driver_impl!(static DRIVER: SysTickDriver = SysTickDriver {
    now: Mutex::new(Cell::new(0)),
    queue: Mutex::new(RefCell::new(Queue::new())),
});

impl Driver for SysTickDriver {
    fn now(&self) -> u64 {
        critical_section::with(|cs| self.now.borrow(cs).get())
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|cs| {
            self.queue.borrow(cs).borrow_mut().schedule_wake(at, waker);
        });
    }
}

/// Begins to count. Once: later calls do nothing.
pub(crate) fn start() {
    let Some(Peripherals { SYST: mut syst, .. }) = Peripherals::take() else { return };
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(CLOCK_HZ / 1000 - 1);
    syst.clear_current();
    syst.enable_counter();
    syst.enable_interrupt();
}

#[exception]
fn SysTick() {
    critical_section::with(|cs| {
        let now = DRIVER.now.borrow(cs).get() + 1;
        DRIVER.now.borrow(cs).set(now);
        // Wakes what is due. When the next is due is not asked: each tick looks again.
        let _ = DRIVER.queue.borrow(cs).borrow_mut().next_expiration(now);
    });
}

/// The node's clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ticks;

impl Clock for Ticks {
    fn now(&self) -> Time {
        Time(Instant::now().as_ticks() * TICK_NS)
    }

    async fn wait(&self, until: Time) {
        if until == Time::NEVER {
            pending::<()>().await;
        }
        Timer::at(Instant::from_ticks(until.0.div_ceil(TICK_NS))).await;
    }
}
