//! The processor's clock: SysTick, which every Cortex-M has, with the times it went round.
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;

const RELOAD: u32 = 0xff_ffff;

static ROUNDS: AtomicU32 = AtomicU32::new(0);

/// Starts it.
pub(crate) fn start() {
    let Some(Peripherals { mut SYST, .. }) = Peripherals::take() else { return };
    SYST.set_clock_source(SystClkSource::Core);
    SYST.set_reload(RELOAD);
    SYST.clear_current();
    SYST.enable_interrupt();
    SYST.enable_counter();
}

/// Ticks since it was started.
pub(crate) fn now() -> u64 {
    loop {
        let rounds = ROUNDS.load(Ordering::Relaxed);
        let left = SYST::get_current();
        if ROUNDS.load(Ordering::Relaxed) == rounds {
            return u64::from(rounds) * u64::from(RELOAD + 1) + u64::from(RELOAD - left);
        }
    }
}

#[exception]
fn SysTick() {
    ROUNDS.store(ROUNDS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
}
