//! Puts the board's memory map and the scene where the firmware's link and build find them.
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let map = if env::var_os("CARGO_FEATURE_LM3S6965").is_some() {
        root.join("memory/lm3s6965.x")
    } else {
        root.join("../memory.x")
    };
    put(&map, &out.join("memory.x"));
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");

    if env::var_os("CARGO_FEATURE_LINKS").is_some() {
        put(&root.join("memory/share.x"), &out.join("share.x"));
        println!("cargo:rustc-link-arg-bin=kiloray-node=-Tshare.x");
        if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
            println!("cargo:rustc-link-arg-bin=kiloray-node=-Tdefmt.x");
        }
        // Names of interrupts: all have the same handler.
        fs::write(out.join("device.x"), []).expect("OUT_DIR can be written");
        println!("cargo:rerun-if-env-changed=KILORAY_SHARE");
        let share = out.join("share.bin");
        match env::var_os("KILORAY_SHARE") {
            Some(file) if !file.is_empty() => put(Path::new(&file), &share),
            // It is put into the board's flash beside the firmware.
            _ => fs::write(&share, []).expect("OUT_DIR can be written"),
        }
        // Of what follows it needs nothing.
        return;
    }
    println!("cargo:rerun-if-env-changed=KILORAY_SCENE");
    if env::var_os("CARGO_FEATURE_MEASURE").is_some() {
        // The emulator puts it into the flash.
        fs::write(out.join("scene.kilo"), []).expect("OUT_DIR can be written");
        return;
    }
    let Some(scene) = env::var_os("KILORAY_SCENE") else {
        panic!("KILORAY_SCENE must name a .kilo file (`node-board/check` makes one)");
    };
    put(Path::new(&scene), &out.join("scene.kilo"));
}

fn put(from: &Path, to: &Path) {
    println!("cargo:rerun-if-changed={}", from.display());
    if let Err(error) = fs::copy(from, to) {
        panic!("{}: {error}", from.display());
    }
}
