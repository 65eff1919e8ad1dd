//! The UARTs of the LM3S6965 (Arm PrimeCell PL011): UART0 to UART2, through their FIFOs.

use core::ptr::{read_volatile, write_volatile};

use super::Hardware;

const DATA: usize = 0x00;
const FLAGS: usize = 0x18;
const BAUD_INTEGER: usize = 0x24;
const BAUD_FRACTION: usize = 0x28;
const LINE_CONTROL: usize = 0x2c;
const CONTROL: usize = 0x30;
const INT_MASK: usize = 0x38;
const INT_CLEAR: usize = 0x44;

const FLAG_RX_EMPTY: u32 = 1 << 4;
const FLAG_TX_FULL: u32 = 1 << 5;
/// 8 bits, FIFOs on.
const LINE_8_FIFO: u32 = 3 << 5 | 1 << 4;
const CONTROL_ON: u32 = 1 | 1 << 8 | 1 << 9;
const INT_RX: u32 = 1 << 4;
const INT_TX: u32 = 1 << 5;
const INT_RX_TIMEOUT: u32 = 1 << 6;

/// 115,200 baud of 12 MHz: 6 + 33 / 64.
const DIVISOR: [u32; 2] = [6, 33];

/// Clock gates of the UARTs and of the pins' ports (system control, RCGC1 and RCGC2).
const CLOCKS_UART: usize = 0x400f_e104;
const CLOCKS_GPIO: usize = 0x400f_e108;
const GPIO_ALTERNATE: usize = 0x420;
const GPIO_DIGITAL: usize = 0x51c;

/// UARTs that links are at.
pub(crate) const COUNT: usize = 3;

/// Interrupts, up to the last of these.
pub(super) const INTERRUPTS: usize = 34;

/// By UART: where its registers are, its interrupt, and its pins.
pub(super) static UARTS: [Registers; COUNT] = [
    Registers {
        base: 0x4000_c000,
        interrupts: [5],
        gpio: 0x4000_4000,
        bits: 0b0011,
        clock: 0,
        port: 0,
    },
    Registers {
        base: 0x4000_d000,
        interrupts: [6],
        gpio: 0x4000_7000,
        bits: 0b1100,
        clock: 1,
        port: 3,
    },
    Registers {
        base: 0x4000_e000,
        interrupts: [33],
        gpio: 0x4002_6000,
        bits: 0b0011,
        clock: 2,
        port: 6,
    },
];

pub(super) struct Registers {
    base: usize,
    interrupts: [u16; 1],
    /// The port with its two pins, and which of its pins they are.
    gpio: usize,
    bits: u32,
    /// Their bits of the clock gates.
    clock: u32,
    port: u32,
}

fn read(register: usize) -> u32 {
    // SAFETY: an aligned register.
    unsafe { read_volatile(register as *const u32) }
}

fn write(register: usize, value: u32) {
    // SAFETY: an aligned register of a UART, or of its clock and pins.
    unsafe { write_volatile(register as *mut u32, value) }
}

fn set(register: usize, bits: u32) {
    write(register, read(register) | bits);
}

impl Hardware for Registers {
    fn interrupts(&self) -> &[u16] {
        &self.interrupts
    }

    fn start(&self) {
        set(CLOCKS_UART, 1 << self.clock);
        set(CLOCKS_GPIO, 1 << self.port);
        set(self.gpio + GPIO_ALTERNATE, self.bits);
        set(self.gpio + GPIO_DIGITAL, self.bits);
        write(self.base + BAUD_INTEGER, DIVISOR[0]);
        write(self.base + BAUD_FRACTION, DIVISOR[1]);
        write(self.base + LINE_CONTROL, LINE_8_FIFO);
        write(self.base + INT_MASK, INT_RX | INT_RX_TIMEOUT);
        write(self.base + CONTROL, CONTROL_ON);
    }

    fn acknowledge(&self) {
        write(self.base + INT_CLEAR, INT_RX | INT_RX_TIMEOUT | INT_TX);
    }

    fn receive(&self) -> Option<u8> {
        (read(self.base + FLAGS) & FLAG_RX_EMPTY == 0).then(|| read(self.base + DATA) as u8)
    }

    fn is_ready(&self) -> bool {
        read(self.base + FLAGS) & FLAG_TX_FULL == 0
    }

    fn send(&self, byte: u8) {
        write(self.base + DATA, byte.into());
    }

    fn waits(&self, more: bool) {
        let sends = if more { INT_TX } else { 0 };
        write(self.base + INT_MASK, INT_RX | INT_RX_TIMEOUT | sends);
    }
}
