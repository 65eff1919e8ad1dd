//! `kiloray compare` against measures that numpy computed (`data/pictures.py`).

use std::path::Path;

use crate::support::Folder;

/// Image, pixels that count, and: their number, mean ratio (all, red, green, blue), RMSE, relative
/// RMSE, percentiles 50, 90, 99, greatest. Printed by the script.
#[rustfmt::skip]
const EXPECTED: [(&str, &str, [f64; 11]); 4] = [
    ("image.exr", "all", [1.200000000e+03, 1.007829334e+00, 1.002569119e+00, 1.011169213e+00, 1.015127657e+00, 2.253761791e-01, 2.045289928e-01, 3.320643629e-02, 8.326284719e-02, 1.307597324e-01, 4.537502446e+01]),
    ("image.exr", "smooth", [1.082000000e+03, 1.009207271e+00, 1.008376988e+00, 1.009570080e+00, 1.012476356e+00, 4.897024431e-02, 6.693225501e-02, 3.408286781e-02, 8.390222025e-02, 1.311138782e-01, 4.537502446e+01]),
    ("image.hdr", "all", [1.200000000e+03, 1.007766074e+00, 1.002651434e+00, 1.010996961e+00, 1.014892382e+00, 2.262328322e-01, 2.053064059e-01, 3.178875917e-02, 8.235679503e-02, 1.325755328e-01, 4.555227065e+01]),
    ("image.hdr", "smooth", [1.082000000e+03, 1.009151656e+00, 1.008341703e+00, 1.009490200e+00, 1.012391697e+00, 4.900266294e-02, 6.697656462e-02, 3.246527112e-02, 8.281252582e-02, 1.328124550e-01, 4.555227065e+01]),
];

fn data(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    path.to_str().expect("a path that is text").to_owned()
}

#[test]
fn measures_agree_with_numpy() {
    let folder = Folder::new();
    for (image, kind, expected) in EXPECTED {
        let line =
            format!("compare {} {} --json m.json --quiet", data("reference.exr"), data(image));
        assert_eq!(folder.run(&line).done().out(), "");
        let text = std::fs::read_to_string(folder.path().join("m.json")).unwrap();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        let m = &json["measures"][kind];
        let rgb = &m["mean_ratio_rgb"];
        let found = [
            &m["pixels"],
            &m["mean_ratio"],
            &rgb[0],
            &rgb[1],
            &rgb[2],
            &m["rmse"],
            &m["relative_rmse"],
            &m["p50"],
            &m["p90"],
            &m["p99"],
            &m["max"],
        ]
        .map(|v| v.as_f64().unwrap());
        for (i, (found, expected)) in found.into_iter().zip(expected).enumerate() {
            let off = (found - expected).abs() / expected;
            assert!(off < 2e-7, "{image} {kind} {i}: {found}, not {expected}");
        }
    }
}

#[test]
fn a_picture_equals_itself() {
    let folder = Folder::new();
    let name = data("reference.exr");
    let line = format!("compare {name} {name} -o difference.png --fail-above 0");
    let out = folder.run(&line).done().out();
    assert!(out.contains("all") && out.contains("smooth") && out.contains("1.000000"), "{out}");
    assert_eq!(folder.names(), ["difference.png"]);
}

#[test]
fn a_limit_on_the_error_sets_the_exit_code() {
    let folder = Folder::new();
    let pair = format!("compare {} {}", data("reference.exr"), data("image.exr"));
    folder.run(&format!("{pair} --fail-above 0.21")).done();
    folder.run(&format!("{pair} --fail-above 0.20")).refused(1, &["image.exr", "0.2045"]);
}

#[test]
fn a_mask_selects() {
    let folder = Folder::new();
    let (reference, image) = (data("reference.exr"), data("image.exr"));
    // The reference is brighter than one half right of column 13, but for what is black.
    let out = folder.run(&format!("compare {reference} {image} --mask {reference}")).done().out();
    let row = out.lines().find(|line| line.starts_with("mask")).unwrap();
    let pixels: u32 = row.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert_eq!(pixels, 27 * 30);
}

#[test]
fn the_difference_shows_where_it_is() {
    let folder = Folder::new();
    let line = format!("compare {} {} -o d.png --quiet", data("reference.exr"), data("image.exr"));
    folder.run(&line).done();
    // Column 3 of row 21 is 45 times off: the brightest colour. What is black in both is darkest.
    let out = folder.run("compare d.png d.png --json -").done().out();
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((json["width"].as_u64(), json["height"].as_u64()), (Some(40), Some(30)));
}

#[test]
fn a_picture_for_the_eye_beside_radiance_is_noted() {
    let folder = Folder::new();
    let (reference, image) = (data("reference.exr"), data("image.exr"));
    folder.run(&format!("compare {reference} {image} -o d.png --quiet")).done();
    let notes = |pair: &str| folder.run(&format!("compare {pair}")).done().err();
    for pair in [format!("{reference} d.png"), format!("d.png {image}")] {
        let told = notes(&pair);
        assert!(told.starts_with("note: d.png: a PNG is made for the eye"), "{pair}: {told}");
    }
    for pair in ["d.png d.png".into(), format!("{reference} {image} --mask d.png")] {
        assert_eq!(notes(&pair), "", "{pair}");
    }
    assert_eq!(notes(&format!("{reference} d.png --quiet")), "");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = Folder::new();
    let reference = data("reference.exr");
    folder.file("text.exr", "not a picture");
    folder.file("cut.exr", &std::fs::read(&reference).unwrap()[..700]);
    folder.file("cut.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 900000 +X 900000\n");
    folder.file("one.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x80");
    folder.file("xyz.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\0\0\0\0");
    let run = |image: &str| folder.run(&format!("compare {reference} {image}"));
    run("xyz.hdr").refused(1, &["xyz.hdr", "XYZ", "ra_xyze -r"]);
    run("missing.exr").refused(1, &["missing.exr", "no such file"]);
    run("text.exr").refused(1, &["text.exr", ".exr, .hdr or .png"]);
    run("cut.exr").refused(1, &["cut.exr", "damaged"]);
    run("cut.hdr").refused(1, &["cut.hdr", "900000 x 900000", "smaller"]);
    run("one.hdr").refused(1, &["one.hdr", "1 x 1", "40 x 30"]);
    run("one.hdr -o x.jpg").refused(2, &["x.jpg", ".png"]);
    run("").refused(2, &["IMAGE"]);
    for option in ["--edge", "--fail-above"] {
        run(&format!("one.hdr {option} -1")).refused(2, &[option, "not negative"]);
    }
    assert_eq!(folder.names().len(), 5, "something is left behind");
}
