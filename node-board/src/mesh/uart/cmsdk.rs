//! The UARTs of the MPS2 boards (Arm's Cortex-M System Design Kit, chapter "APB UART"): UART1 to UART3. They have no FIFO.

use core::ptr::{read_volatile, write_volatile};

use super::Hardware;

const DATA: usize = 0x00;
const STATE: usize = 0x04;
const CTRL: usize = 0x08;
const INT_CLEAR: usize = 0x0c;
const BAUD_DIV: usize = 0x10;

const STATE_TX_FULL: u32 = 1 << 0;
const STATE_RX_FULL: u32 = 1 << 1;
const CTRL_TX: u32 = 1 << 0;
const CTRL_RX: u32 = 1 << 1;
const CTRL_TX_INTERRUPT: u32 = 1 << 2;
const CTRL_RX_INTERRUPT: u32 = 1 << 3;
const INT_TX: u32 = 1 << 0;
const INT_RX: u32 = 1 << 1;

/// 115,200 baud of the boards' 25 MHz.
const DIVISOR: u32 = 217;

/// UARTs that links are at.
pub(crate) const COUNT: usize = 3;

/// Interrupts, up to the last of these.
pub(super) const INTERRUPTS: usize = 20;

/// By UART: where its registers are, and its interrupts (receiver, transmitter).
pub(super) static UARTS: [Registers; COUNT] = [
    Registers { base: 0x4000_5000, interrupts: [2, 3] },
    Registers { base: 0x4000_6000, interrupts: [4, 5] },
    Registers { base: 0x4000_7000, interrupts: [18, 19] },
];

pub(super) struct Registers {
    base: usize,
    interrupts: [u16; 2],
}

impl Registers {
    fn read(&self, register: usize) -> u32 {
        // SAFETY: an aligned register of a UART.
        unsafe { read_volatile((self.base + register) as *const u32) }
    }

    fn write(&self, register: usize, value: u32) {
        // SAFETY: as in `read`.
        unsafe { write_volatile((self.base + register) as *mut u32, value) }
    }
}

impl Hardware for Registers {
    fn interrupts(&self) -> &[u16] {
        &self.interrupts
    }

    fn start(&self) {
        self.write(BAUD_DIV, DIVISOR);
        self.write(CTRL, CTRL_TX | CTRL_RX | CTRL_RX_INTERRUPT | CTRL_TX_INTERRUPT);
    }

    fn acknowledge(&self) {
        self.write(INT_CLEAR, INT_RX | INT_TX);
    }

    fn receive(&self) -> Option<u8> {
        (self.read(STATE) & STATE_RX_FULL != 0).then(|| self.read(DATA) as u8)
    }

    fn is_ready(&self) -> bool {
        self.read(STATE) & STATE_TX_FULL == 0
    }

    fn send(&self, byte: u8) {
        self.write(DATA, byte.into());
    }

    /// It interrupts whenever it becomes ready.
    fn waits(&self, _more: bool) {}
}
