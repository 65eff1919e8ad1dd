//! The board's UARTs as byte streams: received and sent by interrupt, through a buffer for each direction.
//!
//! A board's driver is a file with [`driver::UARTS`], the number of interrupts, and a [`driver::Registers`] that has [`Hardware`].

#[cfg_attr(feature = "mps2", path = "cmsdk.rs")]
#[cfg_attr(not(feature = "mps2"), path = "pl011.rs")]
mod driver;

use core::array;
use core::convert::Infallible;

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;
use cortex_m_rt::exception;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;
use embedded_io_async::{ErrorType, Read, Write};

pub(crate) use driver::COUNT;
use driver::{INTERRUPTS, UARTS};

/// Bytes that may come while the node is busy; more are lost, and the frame with them.
const RECEIVED_BYTES: usize = 1024;
const SENDING_BYTES: usize = 128;

/// The registers of a UART.
trait Hardware {
    /// Its interrupts.
    fn interrupts(&self) -> &[u16];

    /// Switches it on, with an interrupt for what is received.
    fn start(&self);

    /// An interrupt has come, and is being served.
    fn acknowledge(&self);

    /// The next byte received.
    fn receive(&self) -> Option<u8>;

    /// Whether it takes a byte to send.
    fn is_ready(&self) -> bool;

    /// Takes a byte to send.
    fn send(&self, byte: u8);

    /// There is, or is not, more to send: whether it shall interrupt when it is ready.
    fn waits(&self, more: bool);
}

struct Buffers {
    received: Pipe<CriticalSectionRawMutex, RECEIVED_BYTES>,
    sending: Pipe<CriticalSectionRawMutex, SENDING_BYTES>,
}

static BUFFERS: [Buffers; COUNT] =
    [const { Buffers { received: Pipe::new(), sending: Pipe::new() } }; COUNT];

/// A UART, by its place in [`UARTS`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Uart(usize);

/// Switches all on.
pub(crate) fn start() -> [Uart; COUNT] {
    for uart in &UARTS {
        uart.start();
        for &number in uart.interrupts() {
            // SAFETY: no critical section here is one of masked interrupts.
            unsafe { NVIC::unmask(Interrupt(number)) };
        }
    }
    array::from_fn(Uart)
}

impl Uart {
    fn buffers(self) -> &'static Buffers {
        &BUFFERS[self.0]
    }

    /// Moves all bytes that can be moved.
    fn serve(self) {
        let (uart, Buffers { received, sending }) = (&UARTS[self.0], self.buffers());
        critical_section::with(|_| {
            while let Some(byte) = uart.receive() {
                // Full: it is lost, and the checksum of its frame tells.
                let _ = received.try_write(&[byte]);
            }
            while uart.is_ready() {
                let mut byte = [0];
                match sending.try_read(&mut byte) {
                    Ok(_) => uart.send(byte[0]),
                    Err(_) => break,
                }
            }
            uart.waits(!sending.is_empty());
        });
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl Read for Uart {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        Ok(self.buffers().received.read(bytes).await)
    }
}

impl Write for Uart {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let len = self.buffers().sending.write(bytes).await;
        self.serve();
        Ok(len)
    }

    /// What is written leaves by itself.
    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

#[derive(Debug, Clone, Copy)]
struct Interrupt(u16);

// SAFETY: the numbers are those of the board's UARTs.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self.0
    }
}

unsafe extern "C" {
    fn DefaultHandler();
}

/// The part of the vector table behind the processor's own: as short as it can be.
#[used]
#[unsafe(no_mangle)]
#[unsafe(link_section = ".vector_table.interrupts")]
static __INTERRUPTS: [unsafe extern "C" fn(); INTERRUPTS] = [DefaultHandler; INTERRUPTS];

/// The UARTs' are all interrupts that are unmasked.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    for (index, uart) in UARTS.iter().enumerate() {
        if uart.interrupts().iter().any(|&own| i16::try_from(own) == Ok(number)) {
            uart.acknowledge();
            Uart(index).serve();
        }
    }
}
