//! Whether lanes of AVX-512 are compiled: on x86-64, unless `KILORAY_AVX512=no`. All that traces is compiled once for each kind of lanes; tests of a
//! machine that has none of these are compiled in less time without.
use std::env;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=KILORAY_AVX512");
    println!("cargo:rustc-check-cfg=cfg(avx512)");
    let is_x86_64 = env::var("CARGO_CFG_TARGET_ARCH").as_deref() == Ok("x86_64");
    if is_x86_64 && env::var("KILORAY_AVX512").as_deref() != Ok("no") {
        println!("cargo:rustc-cfg=avx512");
    }
}
