//! Proof at link time that no entry point of `kiloray-core` can panic.
//!
//! Each program of `src/bin` calls one entry point with arguments that the compiler cannot know.
//! The panic handler calls a function that is nowhere defined, so a program links only if the
//! optimiser has shown every panic to be unreachable. A new entry point gets a new program:
//! `check` builds all of them.
//!
//! The proof is of optimised code, where integer overflow wraps; debug builds check for overflow
//! as well, and the tests run those.
#![no_std]

use core::hint::black_box;
use core::panic::PanicInfo;
use kiloray_core::network::{RouterSize, Site};
use kiloray_core::shade::Settings;

#[cfg(not(feature = "name-panics"))]
unsafe extern "C" {
    fn kiloray_core_must_not_panic() -> !;
}

#[cfg(feature = "name-panics")]
extern "C" fn kiloray_core_must_not_panic() -> ! {
    loop {
        black_box(());
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    // SAFETY: there is no such function: a program that could come here does not link.
    #[allow(unused_unsafe, reason = "with name-panics the function is a safe one")]
    unsafe {
        kiloray_core_must_not_panic()
    }
}

// The host's `memcpy` and its kin; on bare metal they come with the compiler.
#[cfg(not(target_os = "none"))]
#[link(name = "c")]
unsafe extern "C" {}

/// Bytes that the compiler knows nothing of: any content, any length.
#[inline(never)]
pub fn any_bytes() -> &'static [u8] {
    static BYTES: [u8; 64] = [0; 64];
    black_box(BYTES.as_slice())
}

/// A value that the compiler knows nothing of, made of any bytes.
#[inline(never)]
pub fn any<T: bytemuck::Zeroable>() -> T {
    black_box(T::zeroed())
}

/// Any settings of a picture's light.
pub fn any_shading() -> Settings {
    Settings { samples: any(), shadow_samples: any(), lights: any(), bounces: any(), seed: any() }
}

/// Any size of a router, also one that nobody has made.
pub fn any_router_size() -> RouterSize {
    let sites = [Site::Inside, Site::Entry, Site::Host];
    RouterSize {
        site: sites[any::<usize>() % 3],
        ports: any(),
        classes: any(),
        depth: any(),
        node_depth: any(),
        host_depth: any(),
        own: any(),
        payload: any(),
    }
}

/// Room to write to, of a length that the compiler does not know.
#[inline(never)]
pub fn any_room<T>(room: &mut [T]) -> &mut [T] {
    black_box(room)
}

/// Makes a function the program's entry.
#[macro_export]
macro_rules! entry {
    ($body:block) => {
        #[unsafe(no_mangle)]
        extern "C" fn _start() -> ! {
            $body
            loop {
                core::hint::black_box(());
            }
        }
    };
}

/// Writes a message, as a host would, to nowhere.
pub fn print(message: &dyn core::fmt::Display) {
    struct Nowhere;
    impl core::fmt::Write for Nowhere {
        fn write_str(&mut self, text: &str) -> core::fmt::Result {
            black_box(text);
            Ok(())
        }
    }
    let _ = core::fmt::Write::write_fmt(&mut Nowhere, format_args!("{message}"));
}
