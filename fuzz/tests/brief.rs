//! The seeds and a few thousand mutations of each: the same every time.

use kiloray_fuzz::{Run, Target, seeds};

fn brief(target: Target, inputs_max: u64) {
    assert!(!seeds(target).is_empty(), "{target:?} has no seeds");
    let report = Run { target, seed: 1, inputs_max, until: None }.run();
    if let Some(finding) = &report.finding {
        let text = String::from_utf8_lossy(&finding.input);
        panic!("{target:?}: {}\n{text}", finding.what);
    }
    assert!(report.inputs > inputs_max && report.answers > 1, "{target:?}: {report:?}");
}

#[test]
fn rad() {
    brief(Target::Rad, 2000);
}

#[test]
fn obj() {
    brief(Target::Obj, 2000);
}

#[test]
fn mtl() {
    brief(Target::Mtl, 2000);
}

#[test]
fn vf() {
    brief(Target::Vf, 2000);
}

#[test]
fn view() {
    brief(Target::View, 2000);
}

#[test]
fn kilo() {
    brief(Target::Kilo, 200);
}

#[test]
fn compile() {
    brief(Target::Compile, 100);
}

#[test]
fn packet() {
    brief(Target::Packet, 3000);
}

#[test]
fn ray() {
    brief(Target::Ray, 3000);
}

#[test]
fn node() {
    brief(Target::Node, 200);
}

#[test]
fn frame() {
    brief(Target::Frame, 3000);
}

#[test]
fn begin() {
    brief(Target::Begin, 300);
}

#[test]
fn start() {
    brief(Target::Start, 3000);
}

#[test]
fn wire() {
    brief(Target::Wire, 3000);
}

#[test]
fn identity() {
    brief(Target::Identity, 3000);
}

#[test]
fn report() {
    brief(Target::Report, 3000);
}

#[test]
fn config() {
    brief(Target::Config, 1000);
}

#[test]
fn exr() {
    brief(Target::Exr, 2000);
}

#[test]
fn hdr() {
    brief(Target::Hdr, 2000);
}

#[test]
fn png() {
    brief(Target::Png, 2000);
}

#[test]
fn profile() {
    brief(Target::Profile, 3000);
}

/// The seeds bring a node to all that it can do.
#[test]
fn a_node_renders_what_it_is_told_to() {
    let answers: Vec<_> =
        seeds(Target::Node).iter().map(|seed| Run::replay(Target::Node, seed).unwrap()).collect();
    for (answer, parts) in answers.iter().zip([
        ["tiles", "visitors", "evictions"],
        ["tiles", "unasked", "evictions"],
        ["tiles", "visitors", "home"],
    ]) {
        assert!(parts.iter().all(|part| answer.contains(part)), "{answers:?}");
    }
}
