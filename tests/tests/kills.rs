//! A few of the random runs of `kills`; its command runs as many as there is time for.

use std::path::Path;

use kiloray_tests::kills::all;

#[test]
fn killed_and_frozen_processes_cost_no_pixel() {
    let program = Path::new(env!("CARGO_BIN_EXE_kills"));
    if let Err(failure) = all(program, 1, 0..3, &|| ()) {
        panic!("{failure}");
    }
}
