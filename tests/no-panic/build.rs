//! The programs have no start-up code: their entry is the thing under proof.
fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        println!("cargo:rustc-link-arg-bins=--gc-sections");
    } else {
        println!("cargo:rustc-link-arg-bins=-nostartfiles");
    }
}
