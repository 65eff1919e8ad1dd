use std::fs;
use std::path::PathBuf;

use kiloray_scene::builtin;
use kiloray_scene::compile::{Options, compile};
use kiloray_scene::kilo::KiloFile;

use crate::{Target, host, link, mesh, node, picture};

/// The seeds of a target: the files of `corpus/TARGET` by name, for what is binary made of a built-in scene and all messages.
#[must_use]
pub fn seeds(target: Target) -> Vec<Vec<u8>> {
    match target {
        Target::Kilo => compiled(),
        Target::Compile => files("rad"),
        Target::Packet => mesh::packets(),
        Target::Ray => mesh::rays(),
        Target::Node => node::streams(),
        Target::Frame => link::streams(),
        Target::Begin => link::beginnings(),
        Target::Start => link::starts(),
        Target::Wire => host::wires(),
        Target::Identity => host::identities(),
        Target::Exr => picture::exrs(),
        Target::Hdr => picture::hdrs(),
        Target::Png => picture::pngs(),
        Target::Profile => picture::profiles(),
        _ => files(target.name()),
    }
}

fn files(name: &str) -> Vec<Vec<u8>> {
    let dir = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
    let mut paths: Vec<_> =
        fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths.into_iter().filter_map(|path| fs::read(path).ok()).collect()
}

/// Made anew, so that they are of the current version.
fn compiled() -> Vec<Vec<u8>> {
    let model = builtin::build("cornell");
    let model = model.expect("the Cornell box is built in");
    let file =
        compile(&model, &Options::default(), &mut |_, _, _| {}).expect("the Cornell box compiles");
    vec![KiloFile::from_compiled(file).bytes().to_vec()]
}
