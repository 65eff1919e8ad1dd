//! The pages of runs and of sweeps, in a browser.

use std::{path::Path, process::Command};

use crate::support::Folder;

/// A browser of this machine.
fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    names.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok())
}

/// Opens a page of a folder, in light or in dark, and gives its pixels.
fn screenshot(browser: &str, folder: &Folder, page: &Path, is_dark: bool) -> image::RgbImage {
    let path = folder.path().join("screenshot.png");
    let profile = folder.path().join("profile");
    let ended = Command::new(browser)
        // As root, as in a container, a browser has no sandbox.
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"])
        .args(["--disable-background-networking", "--no-first-run", "--window-size=1100,4000"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--screenshot={}", path.display()))
        .args(is_dark.then_some("--blink-settings=preferredColorScheme=0"))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser runs");
    let told = String::from_utf8_lossy(&ended.stderr);
    let picture = image::open(&path).unwrap_or_else(|error| panic!("{error}: {told}"));
    std::fs::remove_file(path).expect("the picture is removed");
    picture.into_rgb8()
}

/// Runs a command, and looks for colours on the page that it writes to the folder `page`, on the paper of a page in light and in dark.
fn shows(line: &str, colours: &[[u8; 3]]) {
    let Some(browser) = browser() else {
        eprintln!("skipped: there is no chromium on this machine (apt-get install chromium)");
        return;
    };
    let folder = Folder::new();
    folder.run(line).done();
    let page = folder.path().join("page/index.html");
    for is_dark in [false, true] {
        let picture = screenshot(browser, &folder, &page, is_dark);
        // Of the pixels some, all over the page.
        let pixels = || picture.chunks_exact(3).step_by(7);
        let near = |a: &[u8], b: [u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 8);
        let share = |colour: [u8; 3]| {
            let all = pixels().filter(|pixel| near(pixel, colour)).count();
            all as f64 / pixels().count() as f64
        };
        let paper = if is_dark { [0x16, 0x16, 0x18] } else { [0xfd, 0xfd, 0xfc] };
        assert!(share(paper) > 0.5, "paper {} (dark: {is_dark})", share(paper));
        for &colour in colours {
            assert!(share(colour) > 1e-4, "{colour:?} {} (dark: {is_dark})", share(colour));
        }
    }
}

#[test]
fn a_browser_shows_the_maps_in_light_and_in_dark() {
    let line =
        "sim glass --topology mesh:4x4 --memory 64KiB --width 48 --samples 1 --report page --quiet";
    // The dark and the bright end of the maps, and the bar of useful time.
    shows(line, &[[0x44, 0x01, 0x54], [0xfd, 0xe7, 0x25], [0x00, 0x9e, 0x73]]);
}

#[test]
fn a_browser_shows_the_plots_of_a_sweep_in_light_and_in_dark() {
    let line = "sweep cornell --over nodes=1..4 --over schedule=hybrid,data --width 16 --samples 1 -o page --quiet";
    // A line for each schedule.
    shows(line, &[[0x1f, 0x83, 0xc4], [0xe6, 0x7e, 0x22]]);
}
