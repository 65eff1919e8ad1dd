//! Kiloray's core on a Cortex-M: renders the scene in flash in a fixed arena, and prints the
//! picture's hash over semihosting. `node-board/check` builds it, runs it under QEMU and compares.
#![no_std]
#![no_main]

mod scene;
mod stack;

use cortex_m_rt::entry;
use semihosting::{println, process};

#[entry]
fn main() -> ! {
    stack::paint();
    println!("scene {} bytes", scene::bytes().len());
    println!("stack {} bytes", stack::used_bytes());
    process::exit(0);
}
